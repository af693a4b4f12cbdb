//! Any bytes, by the name of each format: a volume or an error, never a panic.
#![no_main]

use foveasim_assets::{NoSideFiles, load_volume_bytes};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some((kind, bytes)) = data.split_first() else {
        return;
    };
    let names = ["a.nii", "a.nrrd", "a.mha", "a.vti", "index.json", "a.toml"];
    let name = names[usize::from(*kind) % names.len()];
    let _ = load_volume_bytes(bytes, name, usize::from(kind >> 4), &NoSideFiles);
});
