//! Statements below the vertices of an OBJ file.
#![no_main]

use foveasim_assets::{LoadOptions, NoSideFiles, load_bytes};

const START: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let file = [START, data].concat();
    let _ = load_bytes(&file, "fuzz.obj", &NoSideFiles, &LoadOptions::default());
});
