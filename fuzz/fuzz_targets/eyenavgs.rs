//! Rows below an EyeNavGS header.
#![no_main]

use foveasim_traces::{ReadOptions, info, read};

const HEADER: &[u8] = b"ViewIndex,FOV1,FOV2,FOV3,FOV4,PositionX,PositionY,PositionZ,QuaternionX,\
QuaternionY,QuaternionZ,QuaternionW,GazePosX,GazePosY,GazePosZ,GazeQX,GazeQY,GazeQZ,GazeQW,Timestamp\n";

libfuzzer_sys::fuzz_target!(|rows: &[u8]| {
    let file = [HEADER, rows].concat();
    if let Ok(recording) = read(file.as_slice(), "fuzz", &ReadOptions::default()) {
        info(&recording);
    }
});
