use foveasim_models::{
    FixedCost, GazeDirection, GazeSeries, HeadPredictor, Pose, Sample, Series, presets,
};
use foveasim_pipeline::SyncMode;

use super::*;

mod streamed;

const MS: i64 = 1_000_000;

/// Gaze that moves steadily to the right, 10° a second, from `start`; every `ms` milliseconds.
fn drift(start: i64, ms: i64, n: i64, provenance: Provenance, late: i64) -> GazeSeries {
    let sample = |i: i64| Sample {
        t: Nanos(start + i * ms * MS),
        value: Some(GazeDirection::new((i * ms - late) as f64 * 0.01 - 5.0, 0.0)),
    };
    Series::new((0..n).map(sample).collect(), provenance).unwrap()
}

fn recording(gaze: GazeSeries) -> Recording {
    Recording {
        source: "test".into(),
        gaze: Some(gaze),
        ..Recording::default()
    }
}

fn lg() -> (Display, Tracker) {
    let tracker = presets::tracker("tx300").unwrap();
    let exact = Tracker {
        bias_deg: 0.0,
        precision_deg: 0.0,
        ..tracker
    };
    (presets::display("lg-w2363d").unwrap(), exact)
}

fn play(recording: &Recording, options: &ReplayOptions) -> Replay {
    let (display, tracker) = lg();
    replay(
        recording,
        &display,
        &tracker,
        &FixedCost(Nanos::from_ms(5.0)),
        options,
    )
    .unwrap()
}

#[test]
fn error_of_a_steady_drift_is_speed_times_age() {
    for sync in SyncMode::ALL {
        let options = ReplayOptions {
            sync,
            ..Default::default()
        };
        let out = play(
            &recording(drift(0, 2, 1000, Provenance::Truth, 0)),
            &options,
        );
        assert!(out.frames.len() > 235);
        for f in out.frames.iter().filter(|f| f.state == GazeState::Tracked) {
            let Some(error) = f.gaze_error_deg() else {
                continue;
            };
            let want = f.gaze_age().unwrap().as_ms() * 0.01;
            assert!((error - want).abs() < 1e-9, "{error} {want}");
        }
    }
}

#[test]
fn a_recorded_delay_is_not_applied_twice() {
    // The same eye, once as the truth, and once as a tracker reported it 20 ms later.
    let delay = Nanos(20 * MS);
    let reported = drift(0, 2, 1000, Provenance::TrackerOutput { delay }, 20);
    let out = play(&recording(reported), &ReplayOptions::default());
    let truth = play(
        &recording(drift(0, 2, 1000, Provenance::Truth, 0)),
        &ReplayOptions::default(),
    );
    let at = |r: &Replay, i: usize| r.frames[i].true_gaze.unwrap().azimuth_deg;
    for i in 20..200 {
        assert!(
            (at(&out, i) - at(&truth, i)).abs() < 1e-9,
            "the truth is the same"
        );
    }
    for f in &out.frames[20..200] {
        let gaze = f.frame.gaze.unwrap();
        // Read at most one sample period after it was delivered, and not a tracker later.
        let age = f.frame.start - gaze.middle();
        assert!(age >= delay && age < delay + Nanos(2 * MS), "{age}");
        let want = f.gaze_age().unwrap().as_ms() * 0.01;
        assert!((f.gaze_error_deg().unwrap() - want).abs() < 1e-9);
    }
}

#[test]
fn a_loss_is_held_then_given_up() {
    let gaze = drift(0, 2, 1000, Provenance::Truth, 0);
    let lose = |s: &Sample<GazeDirection>| {
        let lost = (600 * MS..1400 * MS).contains(&s.t.0);
        Sample {
            value: s.value.filter(|_| !lost),
            ..*s
        }
    };
    let samples = gaze.samples().iter().map(lose).collect();
    let out = play(
        &recording(Series::new(samples, Provenance::Truth).unwrap()),
        &ReplayOptions::default(),
    );
    let state = |ms: i64| {
        out.frames
            .iter()
            .find(|f| f.frame.start.0 >= ms * MS)
            .unwrap()
            .state
    };
    assert_eq!(state(500), GazeState::Tracked);
    assert_eq!(state(650), GazeState::Held);
    assert_eq!(state(840), GazeState::Held);
    assert_eq!(state(860), GazeState::Lost, "250 ms old");
    assert_eq!(state(1450), GazeState::Tracked);
    let summary = out.summary();
    assert_eq!(summary.states.iter().sum::<u64>(), summary.scans);
    assert!(
        summary.truth_unknown > 90 && summary.states[2] > 60,
        "{summary:?}"
    );
    for f in out.frames.iter().filter(|f| f.state == GazeState::Lost) {
        assert_eq!(f.fovea, GazeDirection::AHEAD);
    }
}

#[test]
fn absolute_time_gives_the_same_table() {
    let epoch = 1_700_000_000_123_456_789;
    let table = |start| {
        play(
            &recording(drift(start, 2, 400, Provenance::Truth, 0)),
            &ReplayOptions::default(),
        )
        .table()
    };
    assert_eq!(table(0).csv(), table(epoch).csv());
}

#[test]
fn head_prediction_is_judged_at_the_light() {
    // A head turning at a steady 40 degrees a second is predicted exactly, and lags without.
    let turn = |i: i64| Sample {
        t: Nanos(i * MS),
        value: Some(Pose::new(
            glam::DVec3::ZERO,
            glam::DQuat::from_rotation_y(0.04_f64.to_radians() * i as f64),
        )),
    };
    let pose = Series::new((0..1000).map(turn).collect(), Provenance::Truth).unwrap();
    let recording = Recording {
        pose: Some(pose),
        ..recording(drift(0, 2, 500, Provenance::Truth, 0))
    };
    let display = presets::display("quest-pro").unwrap();
    let (_, tracker) = lg();
    let error = |predictor| {
        let options = ReplayOptions {
            predictor,
            ..Default::default()
        };
        let cost = FixedCost(Nanos::from_ms(5.0));
        let out = replay(&recording, &display, &tracker, &cost, &options).unwrap();
        // The first frame does not know yet how long a frame takes.
        let errors: Vec<f64> = out.frames[2..]
            .iter()
            .filter_map(|f| f.head_error_deg)
            .collect();
        assert!(errors.len() > 60);
        errors.into_iter().fold(0.0, f64::max)
    };
    assert!(
        error(HeadPredictor::AngularVelocity) < 1e-3,
        "{}",
        error(HeadPredictor::AngularVelocity)
    );
    assert!(error(HeadPredictor::Constant) > 0.5);
}

#[test]
fn a_fixed_fovea_needs_no_gaze() {
    let no_gaze = Recording {
        gaze: None,
        ..recording(drift(0, 2, 9, Provenance::Truth, 0))
    };
    let (display, tracker) = lg();
    let cost = FixedCost(Nanos::ZERO);
    let with = |r: &Recording, gaze_mode| {
        let options = ReplayOptions {
            gaze_mode,
            ..Default::default()
        };
        replay(r, &display, &tracker, &cost, &options)
    };
    assert!(matches!(
        with(&no_gaze, GazeMode::Tracked),
        Err(ReplayError::Empty { .. })
    ));
    let still = |i: i64| Sample {
        t: Nanos(i * 10 * MS),
        value: Some(Pose::IDENTITY),
    };
    let pose = Series::new((0..20).map(still).collect(), Provenance::Truth).unwrap();
    let head_only = Recording {
        pose: Some(pose),
        ..no_gaze
    };
    assert!(matches!(
        with(&head_only, GazeMode::Tracked),
        Err(ReplayError::NoGaze { .. })
    ));
    // On a headset the head's motion is worth replaying; every frame is drawn as after a loss.
    let headset = presets::display("quest-pro").unwrap();
    let out = replay(
        &head_only,
        &headset,
        &tracker,
        &cost,
        &ReplayOptions::default(),
    )
    .unwrap();
    assert!(
        out.frames
            .iter()
            .all(|f| f.state == GazeState::Lost && f.true_gaze.is_none())
    );
    assert!(
        out.notes.iter().any(|n| n.contains("no gaze was recorded")),
        "{:?}",
        out.notes
    );
    let out = with(&head_only, GazeMode::Fixed).unwrap();
    assert!(
        out.frames
            .iter()
            .all(|f| f.state == GazeState::Fixed && f.fovea == GazeDirection::AHEAD)
    );
    let lost = |i: i64| Sample {
        t: Nanos(i * 10 * MS),
        value: None,
    };
    let all_lost = recording(Series::new((0..20).map(lost).collect(), Provenance::Truth).unwrap());
    assert!(matches!(
        with(&all_lost, GazeMode::Tracked),
        Err(ReplayError::NoGaze { .. })
    ));
}

#[test]
fn useless_durations_are_refused() {
    let (display, tracker) = lg();
    let refused = |t: &[i64]| {
        let sample = |t: &i64| Sample {
            t: Nanos(*t),
            value: Some(GazeDirection::AHEAD),
        };
        let gaze = Series::new(t.iter().map(sample).collect(), Provenance::Truth).unwrap();
        let cost = FixedCost(Nanos::ZERO);
        replay(
            &recording(gaze),
            &display,
            &tracker,
            &cost,
            &ReplayOptions::default(),
        )
        .unwrap_err()
    };
    assert!(matches!(refused(&[0]), ReplayError::Duration { .. }));
    assert!(matches!(refused(&[0, MS]), ReplayError::Duration { .. }));
    assert!(matches!(
        refused(&[0, 1_000_000_000_000_000]),
        ReplayError::Duration { .. }
    ));
    assert!(matches!(
        refused(&[i64::MIN, i64::MAX]),
        ReplayError::Time { .. }
    ));
}

#[test]
fn a_frame_that_takes_longer_is_shown_again() {
    let (display, tracker) = lg();
    let cost = FixedCost(Nanos::from_ms(10.0));
    let r = recording(drift(0, 2, 1000, Provenance::Truth, 0));
    let out = replay(&r, &display, &tracker, &cost, &ReplayOptions::default()).unwrap();
    let summary = out.summary();
    assert!(summary.repeated * 2 >= summary.scans - 2, "{summary:?}");
    assert_eq!(summary.torn, 0);
    let options = ReplayOptions {
        sync: SyncMode::Tearing,
        ..Default::default()
    };
    let torn = replay(&r, &display, &tracker, &cost, &options)
        .unwrap()
        .summary();
    assert!(torn.torn > torn.scans / 2, "{torn:?}");
}
