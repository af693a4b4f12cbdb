//! Any bytes: a scene or an error, never a panic.
#![no_main]

use foveasim_assets::{LoadOptions, NoSideFiles, load_bytes};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = load_bytes(data, "fuzz", &NoSideFiles, &LoadOptions::default());
});
