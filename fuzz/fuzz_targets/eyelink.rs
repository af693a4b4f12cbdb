//! Lines inside a block of an EyeLink ASC file.
#![no_main]

use foveasim_traces::{ReadOptions, info, read_labelled};

const HEADER: &[u8] = b"** CONVERTED\nMSG\t1 GAZE_COORDS 0 0 1279 1023\nSTART\t1 LEFT RIGHT SAMPLES EVENTS\nSAMPLES GAZE LEFT RIGHT RATE 500\n";

libfuzzer_sys::fuzz_target!(|rows: &[u8]| {
    let file = [HEADER, rows].concat();
    if let Ok((recording, _)) = read_labelled(file.as_slice(), "fuzz", &ReadOptions::default()) {
        info(&recording);
    }
});
