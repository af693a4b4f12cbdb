//! Any bytes: a recording or an error, never a panic.
#![no_main]

use foveasim_traces::{ReadOptions, info, read};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    if let Ok(recording) = read(data, "fuzz", &ReadOptions::default()) {
        info(&recording);
    }
});
