//! Rows below the header of a EuRoC trajectory.
#![no_main]

use foveasim_traces::{ReadOptions, info, read_labelled};

const HEADER: &[u8] = b"#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\n";

libfuzzer_sys::fuzz_target!(|rows: &[u8]| {
    let file = [HEADER, rows].concat();
    if let Ok((recording, _)) = read_labelled(file.as_slice(), "fuzz", &ReadOptions::default()) {
        info(&recording);
    }
});
