//! Text and binary STL.
#![no_main]

use foveasim_assets::{LoadOptions, NoSideFiles, load_bytes};

const START: &[u8] = b"solid s\nfacet normal 0 0 1\nouter loop\n";

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = load_bytes(data, "fuzz.stl", &NoSideFiles, &LoadOptions::default());
    let file = [START, data].concat();
    let _ = load_bytes(&file, "fuzz.stl", &NoSideFiles, &LoadOptions::default());
});
