//! Values below a PLY header: text if the first byte is even, else binary.
#![no_main]

use foveasim_assets::{LoadOptions, NoSideFiles, load_bytes};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let format = ["ascii", "binary_little_endian"][usize::from(data.first().is_some_and(|b| b % 2 == 1))];
    let header = format!(
        "ply\nformat {format} 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
         property float z\nelement face 2\nproperty list uchar uint vertex_indices\nend_header\n"
    );
    let file = [header.as_bytes(), data.get(1..).unwrap_or_default()].concat();
    let _ = load_bytes(&file, "fuzz.ply", &NoSideFiles, &LoadOptions::default());
});
