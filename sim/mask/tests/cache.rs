//! Masks kept in files: the same when loaded, and found out when damaged.

use std::fs;

use foveasim_mask::{Cache, Mask, MaskError, MaskSpec};
use foveasim_models::RayDensity;
use glam::UVec2;

fn spec(seed: u64) -> MaskSpec {
    MaskSpec::new(UVec2::new(40, 30), RayDensity::gaussian(9.0).unwrap(), seed)
}

#[test]
fn masks_are_kept_and_loaded() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path().join("of/masks"));
    let get = |spec: &MaskSpec| cache.get(spec, &|_| {}).unwrap();
    let built = get(&spec(1));
    assert!(!built.loaded && built.replaced.is_none() && built.not_kept.is_none());
    let loaded = get(&spec(1));
    assert!(loaded.loaded);
    assert_eq!(loaded.mask, built.mask);
    assert!(!get(&spec(2)).loaded);
    assert!(get(&spec(1)).loaded && get(&spec(2)).loaded);
    // Nothing but the masks is left.
    assert_eq!(
        fs::read_dir(folder.path().join("of/masks"))
            .unwrap()
            .count(),
        2
    );
}

/// Any bit that changes, any byte that is missing or too many, another version, another mask: built anew, and said.
#[test]
fn damaged_files_are_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path());
    let mask = cache.get(&spec(1), &|_| {}).unwrap().mask;
    let path = cache.path(&spec(1));
    let sound = fs::read(&path).unwrap();
    let load = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        Mask::load(&path, &spec(1))
    };
    for at in (0..sound.len())
        .step_by(sound.len() / 97)
        .chain([0, 20, 81, sound.len() - 1])
    {
        let mut bytes = sound.clone();
        bytes[at] ^= 0x10;
        assert!(
            matches!(load(&bytes), Err(MaskError::Damaged { .. })),
            "byte {at}"
        );
    }
    for length in [0, 1, 16, 80, 127, 128, sound.len() / 2, sound.len() - 1] {
        assert!(
            matches!(load(&sound[..length]), Err(MaskError::Damaged { .. })),
            "{length}"
        );
    }
    let longer = [&sound[..], b"x"].concat();
    assert!(matches!(load(&longer), Err(MaskError::Damaged { .. })));
    // Lengths that would not fit into memory.
    let mut huge = sound.clone();
    huge[80..88].copy_from_slice(&u64::MAX.to_le_bytes());
    assert!(matches!(load(&huge), Err(MaskError::Damaged { .. })));
    fs::copy(cache.path(&spec(1)), folder.path().join("x")).unwrap();
    cache.get(&spec(2), &|_| {}).unwrap();
    fs::copy(cache.path(&spec(2)), &path).unwrap();
    let again = cache.get(&spec(1), &|_| {}).unwrap();
    assert!(!again.loaded);
    let said = again.replaced.unwrap().to_string();
    assert!(said.contains("another specification"), "{said}");
    assert_eq!(again.mask, mask);
    assert_eq!(fs::read(&path).unwrap(), sound);
}

/// A cache that cannot be written costs time, not the mask.
#[test]
fn masks_that_cannot_be_kept_are_still_built() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, b"").unwrap();
    let cached = Cache::new(file.join("masks"))
        .get(&spec(1), &|_| {})
        .unwrap();
    assert!(cached.not_kept.is_some() && !cached.mask.sites().is_empty());
}
