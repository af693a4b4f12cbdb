//! Rows below a first TUM row.
#![no_main]

use foveasim_traces::{ReadOptions, info, read};

const HEADER: &[u8] = b"# t x y z qx qy qz qw\n0.5 0 0 0 0 0 0 1\n";

libfuzzer_sys::fuzz_target!(|rows: &[u8]| {
    let file = [HEADER, rows].concat();
    if let Ok(recording) = read(file.as_slice(), "fuzz", &ReadOptions::default()) {
        info(&recording);
    }
});
