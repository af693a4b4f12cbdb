//! Rows below the header of a GazeBase file.
#![no_main]

use foveasim_traces::{ReadOptions, info, read_labelled};

const HEADER: &[u8] = b"n,x,y,xT,yT\n";

libfuzzer_sys::fuzz_target!(|rows: &[u8]| {
    let file = [HEADER, rows].concat();
    if let Ok((recording, _)) = read_labelled(file.as_slice(), "fuzz", &ReadOptions::default()) {
        info(&recording);
    }
});
