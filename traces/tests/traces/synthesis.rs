use foveasim_models::math::{mean, sqrt};
use foveasim_models::{GazeDirection, Nanos, Recording, Sample};
use foveasim_traces::{SynthSpec, default_recording, info, synth, with_synthetic_gaze};

/// Eyes alone, sampled finely, without blinks.
fn eyes(seed: u64, seconds: i64, rate: f64) -> Recording {
    synth(&SynthSpec {
        seed,
        duration: Nanos(seconds * 1_000_000_000),
        gaze_rate_hz: rate,
        pose_rate_hz: 1.0,
        blinks_per_minute: 0.0,
        head_yaw_deg: 0.0,
        head_sway_m: 0.0,
        ..SynthSpec::default()
    })
    .unwrap()
}

fn samples(r: &Recording) -> &[Sample<GazeDirection>] {
    r.gaze.as_ref().unwrap().samples()
}

#[test]
fn the_same_seed_moves_the_same_at_any_rate() {
    let (slow, fast) = (eyes(3, 5, 250.0), eyes(3, 5, 1000.0));
    assert_eq!(slow, eyes(3, 5, 250.0));
    assert_eq!(samples(&slow).len(), 1250);
    for (s, f) in samples(&slow).iter().zip(samples(&fast).iter().step_by(4)) {
        assert_eq!(s, f);
    }
    assert_ne!(samples(&slow)[1000], samples(&eyes(4, 5, 250.0))[1000]);
}

#[test]
fn saccades_are_on_the_main_sequence() {
    let r = eyes(11, 120, 2000.0);
    let dt = 0.5e-3;
    let speeds: Vec<f64> = samples(&r)
        .windows(2)
        .map(|w| {
            let (a, b) = (w[0].value.unwrap(), w[1].value.unwrap());
            (b.azimuth_deg - a.azimuth_deg).hypot(b.elevation_deg - a.elevation_deg) / dt
        })
        .collect();
    // Runs above 30 °/s, the usual threshold, are saccades. With the minimum-jerk profile a movement
    // of A in D lasts D · (1 − 2 s) above it, where 30 s²(1 − s)² · A/D = 30.
    let mut found = Vec::new();
    let mut i = 0;
    while i < speeds.len() {
        let end = (i..speeds.len())
            .find(|&j| speeds[j] <= 30.0)
            .unwrap_or(speeds.len());
        if end > i {
            let (a, b) = (
                samples(&r)[i].value.unwrap(),
                samples(&r)[end].value.unwrap(),
            );
            let amplitude =
                (b.azimuth_deg - a.azimuth_deg).hypot(b.elevation_deg - a.elevation_deg);
            let peak = speeds[i..end].iter().copied().fold(0.0, f64::max);
            found.push((amplitude, (end - i) as f64 * dt * 1e3, peak));
        }
        i = end + 1;
    }
    let large: Vec<_> = found.iter().filter(|(a, _, _)| *a > 3.0).collect();
    assert!(
        large.len() > 150,
        "{} saccades over 3° in two minutes",
        large.len()
    );
    for (amplitude, ms, peak) in large {
        let duration = 2.2 * amplitude + 21.0;
        // Peak velocity 1.875 A/D; the part cut off below the threshold is a few per cent of A.
        let expected = 1.875e3 * amplitude / duration;
        assert!(
            (peak / expected - 1.0).abs() < 0.06,
            "{amplitude}°: {peak} against {expected} °/s"
        );
        assert!(
            (0.72..1.02).contains(&(ms / duration)),
            "{amplitude}°: {ms} of {duration} ms"
        );
    }
    // Fixations and saccades of the mean amplitude take some 0.25 + 0.035 s together.
    let per_second = found.len() as f64 / 120.0;
    assert!(
        (2.8..4.3).contains(&per_second),
        "{per_second} saccades per second"
    );
    let deepest = samples(&r)
        .iter()
        .map(|s| s.value.unwrap().azimuth_deg.abs())
        .fold(0.0, f64::max);
    // Field 20°, a fixation's drift below 5 s × 1 °/s, tremor.
    assert!((15.0..21.5).contains(&deepest), "{deepest}");
}

#[test]
fn eyes_hold_their_target_while_the_head_turns() {
    let r = synth(&SynthSpec {
        duration: Nanos(20_000_000_000),
        pose_rate_hz: 1000.0,
        blinks_per_minute: 0.0,
        ..SynthSpec::default()
    })
    .unwrap();
    let poses = r.pose.as_ref().unwrap().samples();
    let world: Vec<_> = samples(&r)
        .iter()
        .zip(poses)
        .map(|(g, p)| p.value.unwrap().direction(g.value.unwrap().vector()))
        .collect();
    let speed = |a: glam::DVec3, b: glam::DVec3| a.cross(b).length().asin().to_degrees() * 1e3;
    let mut speeds: Vec<_> = world.windows(2).map(|w| speed(w[0], w[1])).collect();
    speeds.sort_by(f64::total_cmp);
    // Tremor of 0.004° at 90 Hz on two axes moves at up to 3.2 °/s; drift adds little.
    let median = speeds[speeds.len() / 2];
    assert!(
        median < 4.0,
        "gaze in the world stands still half of the time: {median} °/s"
    );
    let mut head: Vec<_> = poses
        .windows(2)
        .map(|w| w[0].value.unwrap().angle_to_deg(w[1].value.unwrap()) * 1e3)
        .collect();
    head.sort_by(f64::total_cmp);
    assert!(
        head[head.len() / 2] > 4.0,
        "while the head turns: {} °/s",
        head[head.len() / 2]
    );
}

#[test]
fn head_motion_has_the_asked_size_and_is_smooth() {
    let spec = SynthSpec {
        duration: Nanos(600_000_000_000),
        gaze_rate_hz: 1.0,
        pose_rate_hz: 100.0,
        ..SynthSpec::default()
    };
    let r = synth(&spec).unwrap();
    let poses: Vec<_> = r
        .pose
        .as_ref()
        .unwrap()
        .samples()
        .iter()
        .map(|s| s.value.unwrap())
        .collect();
    let rms = |v: Vec<f64>| sqrt(mean(&v.iter().map(|x| x * x).collect::<Vec<_>>()));
    let sway = rms(poses.iter().map(|p| p.position.x).collect());
    assert!(
        (sway / 0.03 - 1.0).abs() < 0.05,
        "{sway} m over ten minutes"
    );
    let yaw = rms(poses
        .iter()
        .map(|p| GazeDirection::from_vector(p.direction(glam::DVec3::NEG_Z)).azimuth_deg)
        .collect());
    assert!((yaw / 12.0 - 1.0).abs() < 0.05, "{yaw}°");
    // Second differences of a sum of sines below 0.8 Hz: no more than amplitude · ω² · dt².
    let bound = 5.0 * 0.03 * 1.5 * (2.0 * std::f64::consts::PI * 0.8 * 0.01f64).powi(2);
    for w in poses.windows(3) {
        assert!((w[0].position - 2.0 * w[1].position + w[2].position).length() < bound);
    }
}

#[test]
fn blinks_come_as_often_as_asked() {
    let spec = SynthSpec {
        duration: Nanos(600_000_000_000),
        gaze_rate_hz: 200.0,
        pose_rate_hz: 1.0,
        ..SynthSpec::default()
    };
    let r = synth(&spec).unwrap();
    let blinks = samples(&r)
        .windows(2)
        .filter(|w| w[0].value.is_some() && w[1].value.is_none())
        .count();
    // 12 per minute for ten minutes: Poisson of 120 minus those that a blink hides, four deviations.
    assert!((76..=164).contains(&blinks), "{blinks}");
    let about = info(&r).gaze.unwrap();
    let share = about.missing as f64 / about.samples as f64;
    assert!((0.015..0.05).contains(&share), "{share}");
    assert!(
        about.longest_loss <= Nanos::from_ms(450.0),
        "{}",
        about.longest_loss
    );
}

#[test]
fn numbers_out_of_range_are_named() {
    let with = |change: fn(&mut SynthSpec)| {
        let mut spec = SynthSpec::default();
        change(&mut spec);
        synth(&spec).unwrap_err().to_string()
    };
    assert!(with(|s| s.duration = Nanos(0)).starts_with("duration_s = 0"));
    assert!(with(|s| s.duration = Nanos(-1)).starts_with("duration_s"));
    assert!(with(|s| s.gaze_rate_hz = f64::NAN).starts_with("gaze_rate_hz = NaN"));
    assert!(with(|s| s.field_deg = [5.0, f64::INFINITY]).starts_with("field_deg = inf"));
    assert!(with(|s| s.head_sway_m = -1.0).starts_with("head_sway_m = -1"));
    let long = with(|s| {
        s.duration = Nanos(86_400_000_000_000);
        s.gaze_rate_hz = 10_000.0
    });
    assert!(
        long.starts_with("gaze_rate_hz = 10000: must be at most 231"),
        "{long}"
    );
}

#[test]
fn the_default_recording() {
    let r = default_recording();
    assert_eq!(samples(&r).len(), 10_000);
    assert_eq!(r.pose.as_ref().unwrap().samples().len(), 5_000);
}

#[test]
fn synthetic_gaze_on_a_recorded_head() {
    let head = synth(&SynthSpec {
        seed: 9,
        pose_rate_hz: 72.0,
        ..SynthSpec::default()
    })
    .unwrap();
    let head = Recording { gaze: None, ..head };
    let spec = SynthSpec {
        seed: 2,
        blinks_per_minute: 0.0,
        ..SynthSpec::default()
    };
    let r = with_synthetic_gaze(&head, &spec).unwrap();
    assert_eq!(r.pose, head.pose);
    assert_eq!(
        (
            r.gaze.as_ref().unwrap().start(),
            r.pose.as_ref().unwrap().start()
        ),
        (Nanos(0), Nanos(0))
    );
    let (end, last) = (
        r.gaze.as_ref().unwrap().end(),
        r.pose.as_ref().unwrap().end(),
    );
    assert!(
        end <= last && last - end < Nanos::from_ms(1.001),
        "{end} {last}"
    );
    assert!(
        r.notes
            .iter()
            .any(|n| n.contains("gaze is synthetic, seed 2"))
    );
    assert!(
        with_synthetic_gaze(&Recording::default(), &spec).is_err(),
        "needs a head"
    );
}
