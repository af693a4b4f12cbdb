use foveasim_models::math::sin;
use foveasim_models::{Provenance, Sample, Series, exp_so3, math};
use glam::DVec3;

use super::*;

/// 60 s of a turn of 20°·sin 2πt at 1 kHz, shown at 60 Hz.
fn turning() -> Scanlines {
    let pose = |k: i64| {
        let t = Nanos(k * 1_000_000);
        let angle = math::to_rad(20.0) * sin(std::f64::consts::TAU * t.as_secs());
        let pose = Pose::new(DVec3::ZERO, exp_so3(DVec3::Y * angle));
        Sample {
            t,
            value: Some(pose),
        }
    };
    let recording = Recording {
        pose: Some(Series::new((0..=61_000).map(pose).collect(), Provenance::Truth).unwrap()),
        ..Recording::default()
    };
    let study = ScanlineStudy {
        refresh: Rate::from_hz("refresh", 62.5).unwrap(),
        predictor: HeadPredictor::AngularVelocity,
        max_gap: Nanos(100_000_000),
    };
    study.run(&recording).unwrap()
}

#[test]
fn plain_and_warped_images_age_as_the_closed_form_says() {
    let out = turning();
    // Frames of 16 ms, whole numbers of samples, so that the newest sample is of the very tick.
    let of = |kind| {
        &out.errors
            .iter()
            .find(|e| e.kind == kind)
            .unwrap()
            .rotation_deg
    };
    let held = |age_s: f64| {
        20.0 * std::f64::consts::SQRT_2 * sin(0.5 * std::f64::consts::TAU * age_s).abs()
    };
    for (i, (plain, warped)) in of(ImageKind::Plain)
        .iter()
        .zip(of(ImageKind::Warped))
        .enumerate()
    {
        let age = 0.016 * share(i);
        // A thousandth: frames do not fill whole periods.
        assert!(
            (plain - held(0.016 + age)).abs() < 2e-3 * held(0.032),
            "{i}: {plain}"
        );
        assert!(
            (warped - held(age)).abs() < 2e-3 * held(0.032),
            "{i}: {warped}"
        );
    }
    assert!(of(ImageKind::Warped)[0] < 1e-9);
    let last = ROWS - 1;
    // E1 > E2 > E3, and what is predicted later is better.
    let e = [
        ImageKind::Plain,
        ImageKind::Warped,
        ImageKind::Rolling,
        ImageKind::RollingWarp,
    ];
    assert!(e.windows(2).all(|w| of(w[0])[last] > of(w[1])[last]));
    // The content is right for the middle of the frame alone.
    let content = of(ImageKind::RollingWarpContent);
    assert!(content[last / 2] < 0.3 * content[last] && content[last / 2] < 0.3 * content[0]);
}

#[test]
fn a_clock_that_was_set_is_passed_over() {
    let still = |t: i64| Sample {
        t: Nanos(t),
        value: Some(Pose::IDENTITY),
    };
    let second = |from: i64| (0..100).map(move |k| still(from + k * 10_000_000));
    let samples = second(0).chain(second(4_000_000_000_000_000_000)).collect();
    let recording = Recording {
        pose: Some(Series::new(samples, Provenance::Truth).unwrap()),
        ..Recording::default()
    };
    let study = ScanlineStudy {
        refresh: Rate::from_hz("refresh", 90.0).unwrap(),
        predictor: HeadPredictor::Constant,
        max_gap: Nanos(100_000_000),
    };
    let out = study.run(&recording).unwrap();
    assert!((170..=178).contains(&out.frames), "{}", out.frames);
    assert!(
        out.errors
            .iter()
            .all(|e| e.rotation_deg.iter().all(|deg| *deg == 0.0))
    );
}

#[test]
fn frames_without_truth_are_not_judged() {
    let still = |k: i64| Sample {
        t: Nanos(k * 500_000_000),
        value: Some(Pose::IDENTITY),
    };
    let recording = Recording {
        pose: Some(Series::new((0..4).map(still).collect(), Provenance::Truth).unwrap()),
        ..Recording::default()
    };
    let study = ScanlineStudy {
        refresh: Rate::from_hz("refresh", 60.0).unwrap(),
        predictor: HeadPredictor::Constant,
        max_gap: Nanos(100_000_000),
    };
    let out = study.run(&recording).unwrap();
    assert_eq!(out.frames, 0);
    assert_eq!(out.table().rows()[0][4], Cell::Empty);
}
