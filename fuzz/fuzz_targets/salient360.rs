//! Rows below the header of a Salient360 file, which may glue two fields.
#![no_main]

use foveasim_traces::{ReadOptions, info, read_labelled};

const HEADER: &[u8] =
    b"oculoTS,cam_pitch,cam_yaw,cam_roll,leftGazeDir.x,leftGazeDir.y,leftGazeDir.z,rightGazeDir.x,\
rightGazeDir.y,rightGazeDir.z,binPor.y,Lval,Rval\r\n";

libfuzzer_sys::fuzz_target!(|rows: &[u8]| {
    let file = [HEADER, rows].concat();
    if let Ok((recording, _)) = read_labelled(file.as_slice(), "fuzz", &ReadOptions::default()) {
        info(&recording);
    }
});
