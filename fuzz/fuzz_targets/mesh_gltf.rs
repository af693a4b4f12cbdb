//! The JSON of a GLB file that has a buffer of 64 bytes.
#![no_main]

use foveasim_assets::{LoadOptions, NoSideFiles, load_bytes};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    // Longer ones take the fuzzer's time without reaching anything else.
    let json = &data[..data.len().min(1 << 16)];
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((28 + json.len() as u32 + 64).to_le_bytes());
    file.extend((json.len() as u32).to_le_bytes());
    file.extend(b"JSON");
    file.extend(json);
    file.extend(64u32.to_le_bytes());
    file.extend(b"BIN\0");
    file.extend([0x3f; 64]);
    let _ = load_bytes(&file, "fuzz.glb", &NoSideFiles, &LoadOptions::default());
});
