//! Rows below the headers of Pupil Invisible: gaze if the first byte is even, else the IMU.
#![no_main]

use foveasim_traces::{ReadOptions, info, read_labelled};

const GAZE: &[u8] = b"timestamp [ns],worn,fixation id,blink id,azimuth [deg],elevation [deg]\n";
const IMU: &[u8] =
    b"timestamp [ns],gyro x [deg/s],gyro y [deg/s],gyro z [deg/s],quaternion w,quaternion x,\
quaternion y,quaternion z\n";

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let header = [GAZE, IMU][usize::from(data.first().is_some_and(|b| b % 2 == 1))];
    let file = [header, data.get(1..).unwrap_or_default()].concat();
    if let Ok((recording, _)) = read_labelled(file.as_slice(), "fuzz", &ReadOptions::default()) {
        info(&recording);
    }
});
