//! Chains in which a nanosecond of rounding, a frame a refresh early, or a queue that fills slowly decides.

use crate::ChainSpec;

use super::*;

/// A chain of presets with what `change` makes of it.
fn chain(
    devices: [&str; 2],
    sync: SyncMode,
    render: Option<&str>,
    change: impl FnOnce(&mut ChainSpec),
) -> LatencyStudy {
    let display = presets::display(devices[0]).unwrap();
    let tracker = presets::tracker(devices[1]).unwrap();
    let a_refresh = Durations::fixed(display.scan.rate.period());
    let render = render.map_or(a_refresh, |law| law.parse().unwrap());
    let mut spec = ChainSpec::default();
    change(&mut spec);
    let chain = spec.resolve(display, tracker, sync, render).unwrap();
    LatencyStudy::of(chain, None).unwrap()
}

/// Runs keep their bounds (else there is no result), and come within a tenth of the range of both ends of the whole.
fn assert_bounds_are_met(name: &str, study: &LatencyStudy) {
    let result = study.run(20_000, 1, &|_| ()).expect(name);
    let index = Quantity::Gaze(Rows::Gaze).index();
    let (h, bound) = (&result.histograms[index], result.bounds[index]);
    let slack = Nanos(bound.width().0 / 10 + 1000);
    if result.bound_kinds[index] == BoundKind::Exact {
        assert!(
            h.min() - bound.min <= slack,
            "{name}: {} {bound:?}",
            h.min()
        );
        assert!(
            bound.max - h.max() <= slack,
            "{name}: {} {bound:?}",
            h.max()
        );
    }
}

fn start(text: &str) -> impl FnOnce(&mut ChainSpec) + use<> {
    let text = text.to_owned();
    move |s| s.start = Some(text)
}

const GUENTER: [&str; 2] = ["lg-w2363d", "tx300"];

#[test]
fn frames_that_start_just_in_time_for_what_is_no_whole_refresh() {
    for (reserve, render) in [
        ("just-in-time:4", None),
        ("just-in-time:7", Some("8")),
        ("just-in-time:2.169", Some("8.193404")),
        ("just-in-time:20", Some("2")),
    ] {
        let study = chain(GUENTER, SyncMode::Vsync, render, start(reserve));
        assert_bounds_are_met(reserve, &study);
    }
}

/// Reserve less the shortest frame is more than a refresh: it flips a blank early.
#[test]
fn a_frame_that_is_a_refresh_shorter_than_its_reserve_flips_a_blank_early() {
    let study = chain(
        GUENTER,
        SyncMode::Vsync,
        Some("normal:5.7,1.2"),
        start("just-in-time"),
    );
    let (least, _) = bound(&study, Quantity::Gaze(Rows::First));
    let refresh = study.chain.display.scan.rate.period().as_ms();
    let reserve = study.chain.render.max().as_ms();
    let always = {
        let mut study = study.clone();
        study.chain.render = Durations::fixed(study.chain.render.max());
        bound(&study, Quantity::Gaze(Rows::First)).0
    };
    assert!(reserve - study.chain.render.min().as_ms() > refresh);
    assert!((always - least - refresh).abs() < 1e-5, "{always} {least}");
    assert!(study.run(100_000, 1, &|_| ()).is_ok());
    // Fixed frames that flip two blanks early do so always.
    let early = chain(
        GUENTER,
        SyncMode::Vsync,
        Some("2"),
        start("just-in-time:20"),
    );
    let late = chain(
        GUENTER,
        SyncMode::Vsync,
        Some("2"),
        start("just-in-time:3.3333334"),
    );
    let of = |s: &LatencyStudy| bound(s, Quantity::Gaze(Rows::First)).0;
    assert!((of(&early) - of(&late)).abs() < 1e-5);
}

#[test]
fn hosts_locked_between_nanoseconds() {
    let lock = |ms: f64| move |s: &mut ChainSpec| s.host_lock_ms = Some(ms);
    let tearing = chain(GUENTER, SyncMode::Tearing, None, lock(4.166_666_7));
    assert_bounds_are_met("tearing", &tearing);
    // Whether the beam has just passed the row is up to how a blank is rounded.
    let kinds = tearing.bound_kinds();
    assert_eq!(kinds[Quantity::Gaze(Rows::Gaze).index()], BoundKind::Outer);
    assert_eq!(kinds[Quantity::Gaze(Rows::Last).index()], BoundKind::Exact);
    let dk2 = chain(["dk2", "tx300"], SyncMode::Tearing, None, lock(11.0));
    assert_bounds_are_met("dk2", &dk2);
    let varjo = ["varjo-xr-4", "vive-pro-eye"];
    let at_75 = chain(varjo, SyncMode::VsyncFree, None, |s| {
        (s.host_lock_ms, s.host_hz) = (Some(1.0), Some(75.0));
    });
    assert_bounds_are_met("at 75 Hz", &at_75);
    let late = chain(["quest-3", "varjo"], SyncMode::VsyncFree, Some("15"), |s| {
        (s.host_lock_ms, s.frames_in_flight) = (Some(10.1), Some(2));
    });
    assert_bounds_are_met("late, 2 in flight", &late);
}

/// Frames overrun by so little that a queue takes hundreds of them to fill: runs begin when it is.
#[test]
fn a_queue_that_fills_slowly_is_full() {
    let by_a_little = chain(
        ["bigscreen-beyond", "fove-0"],
        SyncMode::Tearing,
        Some("uniform:13.41223..14.21223"),
        |s| (s.frames_in_flight, s.host_hz) = (Some(3), Some(75.0)),
    );
    assert_bounds_are_met("0.08 ms a frame", &by_a_little);
    let by_drift = chain(["quest-pro", "tx300"], SyncMode::VsyncFree, None, |s| {
        (s.frames_in_flight, s.lead_ms, s.warp_ms) = (Some(2), Some(3.293), Some(1.1));
        s.gaze_latch_ms = Some(0.8);
        (s.drift_ppm.tracker, s.drift_ppm.host, s.drift_ppm.display) = (-14.0, 1.0, 194.0);
    });
    assert_bounds_are_met("2 µs a frame", &by_drift);
}

/// Clocks of different drift meet in more places than a machine word counts.
#[test]
fn locked_clocks_that_drift_apart_have_an_answer() {
    let drifting = |sync, lock, [tracker, host, display]: [f64; 3]| {
        chain(["varjo-xr-4", "tx300"], sync, None, |s| {
            s.host_lock_ms = Some(lock);
            (s.drift_ppm.tracker, s.drift_ppm.host, s.drift_ppm.display) = (tracker, host, display);
        })
    };
    for (sync, lock, drift) in [
        (SyncMode::VsyncFree, 10.611_338, [0.0, 191.0, 188.0]),
        (SyncMode::Tearing, 3.0, [0.0, 33.0, 11.0]),
        (SyncMode::Tearing, 3.0, [0.0, 194.0, -64.0]),
        (SyncMode::Tearing, 1.9, [-94.0, 194.0, -64.0]),
    ] {
        assert_bounds_are_met(&format!("{sync} {drift:?}"), &drifting(sync, lock, drift));
    }
}

/// What a frame reads late it reads as late without its rendering.
#[test]
fn input_is_read_as_late_without_rendering() {
    let of = |change: fn(&mut ChainSpec)| {
        let study = chain(GUENTER, SyncMode::Vsync, None, change);
        let result = run(&study, 20_000);
        let mean = |q| result.histogram(q).mean_ms();
        [
            mean(Quantity::Gaze(Rows::Gaze)),
            mean(Quantity::Motion(Rows::Gaze)),
        ]
    };
    let on = of(|s| (s.gaze_latch_ms, s.pose_latch_ms) = (Some(3.0), Some(2.0)));
    let off = of(|s| {
        (s.gaze_latch_ms, s.pose_latch_ms) = (Some(3.0), Some(2.0));
        s.off = vec!["render".into()];
    });
    let never = of(|s| s.off = vec!["render".into()]);
    for ((on, off), (never, latch)) in on
        .into_iter()
        .zip(off)
        .zip(never.into_iter().zip([3.0, 2.0]))
    {
        assert!(off <= on + 1e-3, "{off} {on}");
        assert!((never - off - latch).abs() < 0.15, "{never} {off}");
    }
}

/// A late latch leaves less of a frame to come, but the frame as long: it meets the beam anywhere.
#[test]
fn overrunning_frames_meet_the_beam_anywhere_however_late_they_read() {
    let scan_wait = |latch: Option<f64>| {
        let study = chain(
            ["quest-3", "quest-pro"],
            SyncMode::Tearing,
            Some("15.266"),
            |s| {
                (s.host_lock_ms, s.gaze_latch_ms) = (Some(6.319_862), latch);
            },
        );
        run(&study, 20_000)
            .histogram(Quantity::Stage(Stage::ScanWait))
            .mean_ms()
    };
    // Half a refresh at 90 Hz.
    for latch in [None, Some(14.8)] {
        assert!(
            (scan_wait(latch) - 5.556).abs() < 0.1,
            "{latch:?}: {}",
            scan_wait(latch)
        );
    }
}

/// Frames in flight that take turns for longer than they are followed: runs begin anywhere in them, so that a lead
/// less costs nothing.
#[test]
fn long_turns_are_seen_from_everywhere() {
    let mean = |off: &'static str| {
        let study = chain(
            ["psvr2", "quest-pro"],
            SyncMode::Vsync,
            Some("15.807"),
            |s| {
                (s.lead_ms, s.frames_in_flight) = (Some(0.283_705), Some(2));
                s.off = off.split_terminator(',').map(str::to_owned).collect();
            },
        );
        run(&study, 4000)
            .histogram(Quantity::Gaze(Rows::Gaze))
            .mean_ms()
    };
    assert!(
        mean("lead") <= mean("") + 0.3,
        "{} {}",
        mean("lead"),
        mean("")
    );
}
