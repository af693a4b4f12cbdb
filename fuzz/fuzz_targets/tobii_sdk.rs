//! Rows below the header of a Tobii SDK file.
#![no_main]

use foveasim_traces::{ReadOptions, info, read_labelled};

const HEADER: &[u8] =
    b"Time\tLGazePos2dx\tLGazePos2dy\tLValidity\tRGazePos2dx\tRGazePos2dy\tRValidity\n";

libfuzzer_sys::fuzz_target!(|rows: &[u8]| {
    let file = [HEADER, rows].concat();
    if let Ok((recording, _)) = read_labelled(file.as_slice(), "fuzz", &ReadOptions::default()) {
        info(&recording);
    }
});
