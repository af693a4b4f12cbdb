//! Fixations, saccades and blinks: known ones, and those of recordings that others labelled.

use foveasim_models::{
    GazeDirection, GazeSeries, Nanos, Provenance, Rate, Recording, Sample, Series,
};
use foveasim_traces::{
    Agreement, EventKind, EventMethod, EventOptions, ReadOptions, agreement, decimate_gaze,
    find_events, info, main_sequence, read_labelled_path, target_agreement, vendor_agreement,
};

use crate::real::find;

/// Gaze whose saccades are known: their onsets and ends, and blinks'.
struct Known {
    gaze: GazeSeries,
    saccades: Vec<(Nanos, Nanos)>,
    blinks: Vec<(Nanos, Nanos)>,
}

/// Fixations of 250 ms and saccades of minimum jerk, 21 ms + 2.2 ms/deg long, amplitudes of 2 to 17
/// degrees to alternate sides; a loss of 120 ms every tenth fixation; noise of ±`noise` on each axis.
fn known(rate_hz: f64, noise: f64, saccades: usize) -> Known {
    let mut state = 9u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        noise * (2.0 * (state >> 11) as f64 / (1u64 << 53) as f64 - 1.0)
    };
    let amplitude =
        |k: usize| (2.0 + (k * 7 % 16) as f64) * if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    let onset = |k: usize| 0.3 * (k as f64 + 1.0);
    let length = |k: usize| 0.021 + 0.0022 * amplitude(k).abs();
    let blink = |k: usize| (k % 10 == 5).then(|| (onset(k) + 0.12, onset(k) + 0.24));
    let mut samples = Vec::new();
    for n in 0..(onset(saccades) * rate_hz) as usize {
        let t = n as f64 / rate_hz;
        let mut azimuth = 0.0;
        let mut lost = false;
        for k in 0..saccades {
            let x = ((t - onset(k)) / length(k)).clamp(0.0, 1.0);
            azimuth += amplitude(k) * x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
            lost |= blink(k).is_some_and(|(from, to)| t > from && t < to);
        }
        let value = GazeDirection::new(azimuth + random(), 5.0 + random());
        samples.push(Sample {
            t: Nanos::from_secs(t),
            value: (!lost).then_some(value),
        });
    }
    let span = |(a, b): (f64, f64)| (Nanos::from_secs(a), Nanos::from_secs(b));
    Known {
        gaze: Series::new(samples, Provenance::Truth).unwrap(),
        saccades: (0..saccades)
            .map(|k| span((onset(k), onset(k) + length(k))))
            .collect(),
        blinks: (0..saccades).filter_map(blink).map(span).collect(),
    }
}

fn compared(known: &Known, options: &EventOptions) -> (Agreement, Agreement) {
    let events = find_events(&known.gaze, None, options).unwrap();
    let spans = |kind| -> Vec<_> { events.of(kind).map(|e| (e.start, e.end)).collect() };
    // Nothing overlaps but at the sample that both have.
    assert!(events.events.windows(2).all(|w| w[0].end <= w[1].start));
    (
        agreement(
            EventKind::Saccade,
            "known",
            &spans(EventKind::Saccade),
            &known.saccades,
        ),
        agreement(
            EventKind::Blink,
            "known",
            &spans(EventKind::Blink),
            &known.blinks,
        ),
    )
}

#[test]
fn known_saccades_and_blinks_are_found() {
    for (rate, noise) in [
        (1000.0, 0.0),
        (1000.0, 0.05),
        (500.0, 0.05),
        (300.0, 0.02),
        (120.0, 0.02),
    ] {
        let known = known(rate, noise, 60);
        let (saccades, blinks) = compared(&known, &EventOptions::default());
        assert!(saccades.f1() > 0.99, "{rate} Hz, ±{noise}: {saccades:?}");
        assert_eq!(
            (blinks.matched, blinks.found),
            (6, 6),
            "{rate} Hz, ±{noise}: {blinks:?}"
        );
        // Half of the window and one interval either way.
        let bound = 5.0 + 1.5e3 / rate;
        assert!(
            saccades.onset.median_ms < bound,
            "{rate} Hz, ±{noise}: {saccades:?}"
        );
        assert!(
            blinks.onset.p95_ms < bound && blinks.offset.p95_ms < bound,
            "{blinks:?}"
        );
    }
}

#[test]
fn dispersion_finds_them_too() {
    let options = EventOptions {
        method: EventMethod::Dispersion,
        ..EventOptions::default()
    };
    let (saccades, _) = compared(&known(500.0, 0.05, 60), &options);
    // Those next to a blink have a fixation of less than 100 ms on one side, and are not joined.
    assert!(
        saccades.precision() == 1.0 && saccades.matched >= 48,
        "{saccades:?}"
    );
    assert!(saccades.onset.p95_ms < 20.0, "{saccades:?}");
}

#[test]
fn the_limit_follows_the_noise() {
    let limit = |noise| {
        let found = find_events(
            &known(500.0, noise, 60).gaze,
            None,
            &EventOptions::default(),
        )
        .unwrap();
        (
            found.limits.unwrap().peak_deg_per_s,
            found.of(EventKind::Saccade).count(),
        )
    };
    let (quiet, _) = limit(0.0);
    assert_eq!(quiet, EventOptions::default().floor_deg_per_s);
    let (noisy, saccades) = limit(0.3);
    assert!(
        noisy > 60.0 && (55..=75).contains(&saccades),
        "{noisy} {saccades}"
    );
}

#[test]
fn main_sequence_of_minimum_jerk() {
    let events = find_events(
        &known(1000.0, 0.01, 120).gaze,
        None,
        &EventOptions::default(),
    )
    .unwrap();
    let fit = main_sequence(&events).unwrap();
    // Their peak is 1.875·A/(21 ms + 2.2 ms/deg·A), which saturates at 852 deg/s.
    for a in [4.0, 8.0, 16.0] {
        let want = 1.875e3 * a / (21.0 + 2.2 * a);
        assert!(
            (fit.peak(a) / want - 1.0).abs() < 0.08,
            "{a}: {} {want}",
            fit.peak(a)
        );
    }
    // The window widens them by some milliseconds, and the slope is theirs.
    assert!(
        (fit.duration_ms_per_deg.value - 2.2).abs() < 0.35,
        "{fit:?}"
    );
    assert!((15.0..30.0).contains(&fit.duration_ms.value), "{fit:?}");
    assert!(
        main_sequence(
            &find_events(&known(1000.0, 0.0, 5).gaze, None, &EventOptions::default()).unwrap()
        )
        .is_none()
    );
}

#[test]
fn too_little_and_options_out_of_range() {
    let short = known(1000.0, 0.0, 1).gaze;
    let two = Series::new(short.samples()[..2].to_vec(), Provenance::Truth).unwrap();
    let error = find_events(&two, None, &EventOptions::default()).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("2 samples with a value; events need 3")
    );
    let options = EventOptions {
        dispersion_deg: f64::NAN,
        ..EventOptions::default()
    };
    let error = find_events(&short, None, &options).unwrap_err().to_string();
    assert!(error.starts_with("dispersion_deg = NaN"), "{error}");
    assert!(
        "velocty"
            .parse::<EventMethod>()
            .unwrap_err()
            .to_string()
            .contains("did you mean `velocity`")
    );
    // Samples of one time have no speed.
    let same = Sample {
        t: Nanos(5),
        value: Some(GazeDirection::AHEAD),
    };
    let same = Series::new(vec![same; 9], Provenance::Truth).unwrap();
    assert!(find_events(&same, None, &EventOptions::default()).is_err());
}

#[test]
fn a_track_lost_for_long_is_no_blink() {
    let mut samples = known(500.0, 0.0, 20).gaze.samples().to_vec();
    for s in &mut samples[500..1200] {
        s.value = None;
    }
    let gaze = Series::new(samples, Provenance::Truth).unwrap();
    let events = find_events(&gaze, None, &EventOptions::default()).unwrap();
    assert!(
        events
            .of(EventKind::Blink)
            .all(|b| b.duration() < Nanos::from_ms(300.0))
    );
}

#[test]
fn a_rate_that_the_file_states_goes_before_the_median_interval() {
    // Of an excerpt most intervals are where samples were left out.
    let gaze = known(1000.0, 0.01, 4).gaze;
    let kept = gaze
        .samples()
        .iter()
        .enumerate()
        .filter(|(i, _)| i % 16 < 2 || *i < 200);
    let excerpt: Vec<_> = kept.filter(|(i, _)| i % 3 > 0).map(|(_, s)| *s).collect();
    let gaze = Series::new(excerpt, Provenance::Truth).unwrap();
    let stated = Some(Rate::from_hz("rate", 1000.0).unwrap());
    for rate in [stated, None] {
        let recording = Recording {
            gaze: Some(gaze.clone()),
            gaze_rate: rate,
            ..Recording::default()
        };
        let events = find_events(&gaze, rate, &EventOptions::default()).unwrap();
        let described = info(&recording).gaze.unwrap().rate_hz;
        assert_eq!(events.rate_hz, described, "{rate:?}");
        assert_eq!(described == 1000.0, rate.is_some(), "{described}");
        let as_fast = Rate::from_hz("rate", described).unwrap();
        let error = decimate_gaze(&recording, as_fast, Nanos(100_000_000)).unwrap_err();
        let want = format!("below the {described:.1} Hz");
        assert!(error.to_string().contains(&want), "{error}");
    }
}

#[test]
fn eyelink_s_own_events() {
    for (name, eyes) in [("both_eyes.asc", 2), ("left_eye.asc", 1)] {
        let Some(path) = find(&format!("gaze/eyelink_asc/{name}")) else {
            return;
        };
        let (recording, labels) = read_labelled_path(&path, &ReadOptions::default()).unwrap();
        let events = find_events(
            recording.gaze.as_ref().unwrap(),
            recording.gaze_rate,
            &EventOptions::default(),
        )
        .unwrap();
        let all = vendor_agreement(&events, &labels);
        assert_eq!(all.len(), 3 * eyes, "{name}");
        for a in all {
            let least = if a.kind == EventKind::Blink {
                0.94
            } else {
                0.965
            };
            assert!(a.f1() >= least, "{name}: {a:?}");
            assert!(a.onset.median_ms <= 8.0, "{name}: {a:?}");
            if a.kind == EventKind::Saccade {
                assert!(a.onset.p95_ms <= 12.0 && a.recall() == 1.0, "{name}: {a:?}");
            }
        }
    }
}

#[test]
fn known_targets() {
    // Onsets are found before 5 % of the way is gone: by 10 to 13 ms, and at 120 Hz by three intervals.
    for (name, least, lead_ms) in [
        ("EyeLink_1000+_binocular_1000Hz.tsv", 1.0, 15.0),
        ("EyeLink_1000+_right_1000Hz.tsv", 1.0, 15.0),
        ("Tobii_Spectrum_1200Hz.tsv", 0.94, 15.0),
        ("Tobii_Spectrum_120Hz.tsv", 1.0, 40.0),
        // A tracker whose noise is taken for saccades of a degree now and then.
        ("SMI_RED500_500Hz.tsv", 0.4, 15.0),
    ] {
        let Some(path) = find(&format!("gaze/etdq_tsv/{name}")) else {
            return;
        };
        let (recording, labels) = read_labelled_path(&path, &ReadOptions::default()).unwrap();
        let gaze = recording.gaze.as_ref().unwrap();
        let events = find_events(gaze, recording.gaze_rate, &EventOptions::default()).unwrap();
        let a = target_agreement(gaze, &events, &labels.targets).unwrap();
        assert!(a.f1() >= least && a.recall() == 1.0, "{name}: {a:?}");
        assert!(
            a.onset.mean_ms < 0.0 && a.onset.p95_ms < lead_ms,
            "{name}: {a:?}"
        );
        assert_eq!(events.shapes_reliable, !name.contains("120Hz"));
    }
}
