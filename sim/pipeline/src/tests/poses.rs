//! What becomes of head poses on their way into frames.

use foveasim_models::{
    Emission, FixedCost, HeadPredictor, Nanos, Pose, PoseSeries, Provenance, Rate, Sample, Series,
    presets,
};
use glam::{DQuat, DVec3};

use super::{ms, panel, record, tracker};
use crate::*;

/// A head that moves 1 m/s to the right, with samples at these times [ms]; `false`: a missing one.
fn walk(samples: &[(i64, bool)]) -> PoseSeries {
    let sample = |&(t, there): &(i64, bool)| Sample {
        t: ms(t),
        value: there.then(|| Pose::new(DVec3::X * (t as f64 / 1e3), DQuat::IDENTITY)),
    };
    Series::new(samples.iter().map(sample).collect(), Provenance::Truth).unwrap()
}

/// How far each frame's pose is ahead of the newest sample [mm], by the frame's start [ms]: frames
/// start every 10 ms and their middle row is lit 10 + 4.5 + 3 = 17.5 ms later.
fn ahead(poses: &PoseSeries, end: i64) -> Vec<(i64, f64)> {
    let (head, predictor) = (HeadSampling::default(), HeadPredictor::AngularVelocity);
    ahead_with(poses, end, head, predictor)
}

/// As [`ahead`], for a head sampled like this.
fn ahead_with(
    poses: &PoseSeries,
    end: i64,
    head: HeadSampling,
    predictor: HeadPredictor,
) -> Vec<(i64, f64)> {
    let (scan, response) = panel(Emission::Rolling);
    let tracker = tracker([1_000_000; 2]);
    let cost = FixedCost(ms(4));
    let mut setup = Setup::new(scan, response, &tracker, SyncMode::Vsync, &cost);
    setup.pose = Some(poses.into());
    (setup.head, setup.predictor) = (head, predictor);
    let ahead = |f: &Rendered| {
        let stamp = f.pose?;
        assert_eq!(stamp.predicted_for, f.start + Nanos(17_500_000));
        let newest = stamp.sampled.as_ms();
        let mm = stamp.pose.position.x * 1e3 - newest;
        Some((f.start.0 / 1_000_000, (mm * 1e6).round() / 1e6))
    };
    let frames = record(&setup, ms(end)).rendered;
    frames.iter().filter_map(ahead).collect()
}

#[test]
fn poses_are_not_extrapolated_through_a_hole() {
    // Every 10 ms until 20 ms and again from 3 s on.
    let times: Vec<_> = (0..=2).chain(300..=302).map(|i| (i * 10, true)).collect();
    for (start, mm) in ahead(&walk(&times), 3025) {
        let want = match start {
            0 | 3000 => 0.0, // one sample alone has no velocity
            10 | 20 | 3010 | 3020 => 17.5,
            // Going on for as long as a hole may last (75 ms), and held after that.
            30..=90 => (start - 20) as f64 + 17.5,
            _ => 0.0,
        };
        assert_eq!(mm, want, "frame at {start} ms");
    }
}

#[test]
fn poses_are_held_through_a_loss() {
    let times: Vec<_> = (0..8).map(|i| (i * 10, i != 3 && i != 4)).collect();
    let want = [0.0, 17.5, 17.5, 0.0, 0.0, 0.0, 17.5, 17.5];
    let got: Vec<_> = ahead(&walk(&times), 75).into_iter().map(|f| f.1).collect();
    assert_eq!(got, want);
}

#[test]
fn poses_at_equal_times_keep_their_velocity() {
    let times = [0, 10, 10, 20, 20, 20, 30].map(|t| (t, true));
    let got: Vec<_> = ahead(&walk(&times), 35).into_iter().map(|f| f.1).collect();
    assert_eq!(got, [0.0, 17.5, 17.5, 17.5]);
}

#[test]
fn a_scan_gives_the_view_its_picture_was_drawn_for() {
    let poses = walk(&(0..8).map(|i| (i * 10, true)).collect::<Vec<_>>());
    let (scan, response) = panel(Emission::Rolling);
    let (tracker, cost) = (tracker([1_000_000; 2]), FixedCost(ms(4)));
    let mut setup = Setup::new(scan, response, &tracker, SyncMode::Vsync, &cost);
    setup.pose = Some((&poses).into());
    let display = presets::display("quest-pro").unwrap();
    let left = display.primary();
    let (mut dark, mut seen) = (0, Vec::new());
    for scan in record(&setup, ms(75)).displayed {
        match (scan.at_row(0), scan.view(left, 0)) {
            (None, None) => dark += 1,
            (Some(shown), Some(view)) => {
                let head = shown.frame.pose.unwrap().pose;
                assert_eq!(view.poses, [head.then(left.head_from_eye); 2]);
                assert_eq!((view.eye, view.optics), (left.eye, left.viewport));
                seen.push(view.poses[0].position.x);
            }
            other => panic!("{other:?}"),
        }
    }
    assert!(
        dark == 1 && seen.len() > 3 && seen.windows(2).all(|w| w[0] < w[1]),
        "{dark} {seen:?}"
    );
}

#[test]
fn every_predictor_follows_a_steady_walk() {
    let poses = walk(&(0..60).map(|i| (i * 10, true)).collect::<Vec<_>>());
    for predictor in HeadPredictor::ALL {
        let last = *ahead_with(&poses, 595, HeadSampling::default(), predictor)
            .last()
            .unwrap();
        let (want, within) = match predictor {
            HeadPredictor::Constant => (0.0, 0.0),
            // A filter has yet to settle.
            HeadPredictor::Kalman(_) => (17.5, 0.05),
            _ => (17.5, 1e-5),
        };
        assert!((last.1 - want).abs() <= within, "{predictor:?}: {last:?}");
    }
}

#[test]
fn filters_hold_their_own_estimate_through_a_loss() {
    // At 15 ms from the last sample, but lost: no predictor goes on.
    let mut times: Vec<_> = (0..20).map(|i| (i * 10, true)).collect();
    times.push((200, false));
    for predictor in HeadPredictor::ALL {
        let got = ahead_with(&walk(&times), 205, HeadSampling::default(), predictor);
        let (frame, mm) = *got.last().unwrap();
        assert!(frame == 200 && mm.abs() < 0.5, "{predictor:?}: {got:?}");
    }
}

#[test]
fn a_delayed_head_is_older_and_no_worse_predicted() {
    let poses = walk(&(0..12).map(|i| (i * 10, true)).collect::<Vec<_>>());
    let head = HeadSampling {
        rate: None,
        delay: Nanos(13_000_000),
    };
    // The newest sample known at 50 ms is that of 30 ms.
    let got = ahead_with(&poses, 95, head, HeadPredictor::AngularVelocity);
    assert_eq!(got[0], (20, 0.0)); // one sample alone
    assert!(
        got[1..].iter().all(|(_, mm)| *mm == 37.5) && got.len() > 5,
        "{got:?}"
    );
}

#[test]
fn a_head_is_sampled_at_its_own_rate() {
    let poses = walk(&(0..12).map(|i| (i * 10, true)).collect::<Vec<_>>());
    let head = HeadSampling {
        rate: Some(Rate::from_hz("rate", 250.0).unwrap()),
        delay: ms(5),
    };
    // Samples every 4 ms, known 5 ms later: at 50 ms that of 44 ms, at 60 ms that of 52 ms.
    let got = ahead_with(&poses, 95, head, HeadPredictor::AngularVelocity);
    let (six, eight) = (6.0 + 17.5, 8.0 + 17.5);
    for (start, mm) in got.into_iter().filter(|(start, _)| *start >= 20) {
        let want = if start % 20 == 10 { six } else { eight };
        assert_eq!(mm, want, "frame at {start} ms");
    }
}
