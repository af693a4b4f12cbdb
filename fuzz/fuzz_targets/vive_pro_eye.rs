//! Rows below the header of a Vive Pro Eye file.
#![no_main]

use foveasim_traces::{ReadOptions, info, read_labelled};

const HEADER: &[u8] = b"time(100ns);eye_valid_L;eye_valid_R;gaze_direct_L.x;gaze_direct_L.y;gaze_direct_L.z;\
gaze_direct_R.x;gaze_direct_R.y;gaze_direct_R.z;helmet_pos_x;helmet_pos_y;helmet_pos_z;helmet_rot_x;helmet_rot_y;helmet_rot_z\r\n";

libfuzzer_sys::fuzz_target!(|rows: &[u8]| {
    let file = [HEADER, rows].concat();
    if let Ok((recording, _)) = read_labelled(file.as_slice(), "fuzz", &ReadOptions::default()) {
        info(&recording);
    }
});
