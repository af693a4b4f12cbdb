//! Rows below a screen-centred header.
#![no_main]

use foveasim_traces::{ReadOptions, info, read};

const HEADER: &[u8] = b"timestamp\tleft_x\tleft_y\tright_x\tright_y\n";

libfuzzer_sys::fuzz_target!(|rows: &[u8]| {
    let file = [HEADER, rows].concat();
    if let Ok(recording) = read(file.as_slice(), "fuzz", &ReadOptions::default()) {
        info(&recording);
    }
});
