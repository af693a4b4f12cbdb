//! Rows below our own header; what reads must read the same after being written.
#![no_main]

use foveasim_traces::{ReadOptions, read, write};

const HEADER: &[u8] = b"# foveasim-trace 1\nt_ns,gaze_azimuth_deg,gaze_elevation_deg,\
position_x_m,position_y_m,position_z_m,orientation_x,orientation_y,orientation_z,orientation_w\n";

libfuzzer_sys::fuzz_target!(|rows: &[u8]| {
    let file = [HEADER, rows].concat();
    let Ok(first) = read(file.as_slice(), "fuzz", &ReadOptions::default()) else { return };
    let mut bytes = Vec::new();
    write(&first, &mut bytes).expect("writing to memory");
    let second = read(bytes.as_slice(), "fuzz", &ReadOptions::default()).expect("what was written");
    assert_eq!((first.gaze, first.pose), (second.gaze, second.pose));
});
