//! Rows below the header of an Aria trajectory.
#![no_main]

use foveasim_traces::{ReadOptions, info, read_labelled};

const HEADER: &[u8] =
    b"tracking_timestamp_us,tx_world_device,ty_world_device,tz_world_device,qx_world_device,\
qy_world_device,qz_world_device,qw_world_device\n";

libfuzzer_sys::fuzz_target!(|rows: &[u8]| {
    let file = [HEADER, rows].concat();
    if let Ok((recording, _)) = read_labelled(file.as_slice(), "fuzz", &ReadOptions::default()) {
        info(&recording);
    }
});
