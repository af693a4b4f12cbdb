use foveasim_assets::volume_named;
use foveasim_mask::{Interpolation, MaskSpec};
use foveasim_models::RayDensity;
use glam::UVec2;

use super::*;
use crate::reproduce::{Paper, check_published};

fn masks(size: u32) -> BruderMasks {
    let size = UVec2::splat(size);
    let build = |density: RayDensity, interpolation: Interpolation| {
        let spec = MaskSpec {
            interpolation,
            ..MaskSpec::new(size, density, 1)
        };
        Mask::build(&spec, &|_| {}).unwrap()
    };
    let gaussian = RayDensity::gaussian_of_fraction(0.12, size.as_dvec2()).unwrap();
    let mar = RayDensity::of_parts(1.5, 8.0).unwrap();
    BruderMasks {
        masks: Interpolation::ALL.map(|interpolation| build(mar, interpolation)),
        gaussian: build(gaussian, Interpolation::Natural),
    }
}

fn volume(name: &str) -> BruderVolume {
    let volume = volume_named(name, 1).unwrap();
    let transfer = TransferFunction::of_volume(&volume);
    BruderVolume {
        name: name.into(),
        volume,
        transfer,
    }
}

/// A clock that moves by a millisecond whenever it is looked at: everything takes a millisecond.
fn clock() -> impl FnMut() -> Duration {
    let mut now = Duration::ZERO;
    move || {
        now += Duration::from_millis(1);
        now
    }
}

#[test]
fn all_is_measured_and_written() {
    let volumes = [volume("jet:24"), volume("shells:24")];
    let run = || {
        let asked = Bruder2019::quick();
        asked.run(&volumes, &masks(64), &mut clock(), &|_, done| {
            assert!((0.0..=1.0 + 1e-12).contains(&done));
        })
    };
    let found = run().unwrap();
    assert_eq!(found, run().unwrap());
    assert_eq!(found.volumes.len(), 2);
    for v in &found.volumes {
        assert_eq!(v.times.rows.len(), 4);
        for row in &v.times.rows {
            assert_eq!((row.full_ms, row.foveated_ms()), (1.0, 2.0));
            let [full, foveated, equal] = row.work;
            assert_eq!(full.rays, 64 * 64);
            assert!(foveated.rays == equal.rays && foveated.rays < full.rays / 2);
            assert!(foveated.steps <= equal.steps && equal.steps < full.steps);
        }
        assert_eq!(v.errors.rings.len(), 28);
        let bias = |way| v.errors.at(way, 1).unwrap().bias.abs();
        assert!(bias("natural") < 3.0, "{:?}", v.errors);
        // The fovea is at full rate.
        let inner = v.errors.at("natural, equal steps", 0).unwrap();
        assert!(inner.psnr_db > 45.0, "{inner:?}");
        let ring = |way| v.errors.at(way, 2).unwrap().psnr_db;
        assert!(ring("natural") > ring("nearest"));
    }
    // The masks of this test have more rays than the paper's.
    let mut numbers = found.published();
    numbers.retain(|p| !p.quantity.starts_with("rays"));
    check_published(&numbers, Paper::Bruder2019, 1, 1, 3);
    let files = found.reproduction().unwrap().files();
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert!(names.contains(&"report.html") && names.contains(&"volume-2.png"));
    assert_eq!(found.table_1().rows().len(), 2);
    assert_eq!(found.gazes().rows().len(), 8);
}

#[test]
fn counts_are_checked() {
    let asked = Bruder2019 {
        gazes: 0,
        ..Bruder2019::quick()
    };
    let refused = asked.run(&[], &masks(64), &mut clock(), &|_, _| {});
    assert!(refused.unwrap_err().to_string().starts_with("gazes = 0"));
}
