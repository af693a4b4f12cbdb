//! The bounds of every loop and stage, beside what a search over the phases of the clocks finds.

use foveasim_models::{Durations, Emission, LossSpec, ScanDirection};
use foveasim_pipeline::{FrameStart, Missed};

use super::*;
use crate::{Chain, HeadSampling};

const MS: i64 = 1_000_000;

/// 100 Hz, one millisecond of blanking after the picture; 250 Hz tracker; frames of 6 ms.
fn chain(sync: SyncMode, change: impl FnOnce(&mut Chain)) -> Chain {
    let mut display = presets::display("lg-w2363d").unwrap();
    display.scan.rate = Rate::from_hz("f", 100.0).unwrap();
    (display.scan.active_lines, display.scan.total_lines) = (9, 10);
    (display.scan.lines_to_end, display.scan.rows) = (9, 90);
    let mut tracker = presets::tracker("tx300").unwrap();
    tracker.rate = Rate::from_hz("f", 250.0).unwrap();
    let mut chain = Chain::new(display, tracker, sync);
    chain.host_rate = Rate::from_hz("f", 97.0).unwrap();
    chain.render = "6".parse().unwrap();
    change(&mut chain);
    chain
}

fn lead(ms: f64) -> impl Fn(&mut Chain) {
    move |c| c.runtime.lead = Nanos::from_ms(ms)
}

fn law(text: &'static str) -> impl Fn(&mut Chain) {
    move |c| c.render = text.parse().unwrap()
}

/// Every loop and every stage, at least once.
fn chains() -> Vec<(&'static str, Chain)> {
    use SyncMode::{Tearing, Vsync, VsyncFree};
    let warp = |missed: Missed| {
        move |c: &mut Chain| {
            (c.runtime.lead, c.runtime.warp) = (Nanos(3 * MS), Some(Nanos(2 * MS)));
            c.runtime.missed = missed;
        }
    };
    let in_flight = |n: u32, render: &'static str| {
        move |c: &mut Chain| {
            c.runtime.in_flight = n;
            c.render = render.parse().unwrap();
        }
    };
    let just_in_time = |render: &'static str, reserve: f64| {
        move |c: &mut Chain| {
            c.render = render.parse().unwrap();
            c.runtime.lead = Nanos(MS);
            let reserve = Nanos::from_ms(reserve);
            c.runtime.start = FrameStart::JustInTime { reserve };
        }
    };
    vec![
        ("tearing", chain(Tearing, |_| ())),
        ("tearing, long frames", chain(Tearing, law("13.7"))),
        (
            "tearing, uneven frames",
            chain(Tearing, law("uniform:4..12.3")),
        ),
        ("tearing, 2 in flight", chain(Tearing, in_flight(2, "13.7"))),
        ("tearing, 3 in flight", chain(Tearing, in_flight(3, "6"))),
        (
            "tearing, late latch",
            chain(Tearing, |c| c.runtime.gaze_latch = Nanos(5 * MS)),
        ),
        (
            "tearing, upwards",
            chain(Tearing, |c| c.display.scan.direction = ScanDirection::Up),
        ),
        ("free, lead", chain(VsyncFree, lead(2.5))),
        ("free, uneven", chain(VsyncFree, law("uniform:4..12.3"))),
        ("free, 3 in flight", chain(VsyncFree, in_flight(3, "13.7"))),
        ("free, warp", chain(VsyncFree, warp(Missed::Repeat))),
        ("blocked", chain(Vsync, |_| ())),
        ("blocked, lead makes it miss", chain(Vsync, lead(4.5))),
        ("blocked, uneven", chain(Vsync, law("uniform:4..12.3"))),
        ("blocked, 3 refreshes", chain(Vsync, law("21.2"))),
        (
            "blocked, half rate",
            chain(Vsync, |c| {
                c.runtime.missed = Missed::HalfRate;
                c.render = "21.2".parse().unwrap();
            }),
        ),
        ("blocked, 2 in flight", chain(Vsync, in_flight(2, "6"))),
        (
            "blocked, 3 in flight, uneven",
            chain(Vsync, in_flight(3, "uniform:4..9.5")),
        ),
        ("blocked, warp", chain(Vsync, warp(Missed::Repeat))),
        (
            "blocked, reprojected",
            chain(Vsync, |c| {
                warp(Missed::Reproject)(c);
                c.render = "18".parse().unwrap();
            }),
        ),
        ("just in time", chain(Vsync, just_in_time("6", 6.0))),
        (
            "just in time, margin",
            chain(Vsync, just_in_time("uniform:4..6", 7.5)),
        ),
        (
            "just in time, too long",
            chain(Vsync, just_in_time("13", 14.0)),
        ),
        (
            "just in time, missed",
            chain(Vsync, just_in_time("8.5", 7.0)),
        ),
        (
            "late pose latch",
            chain(Vsync, |c| {
                c.runtime.pose_latch = Nanos(4 * MS);
                c.head = HeadSampling {
                    rate: Some(Rate::from_hz("f", 800.0).unwrap()),
                    delay: Nanos(MS),
                };
            }),
        ),
        (
            "buffered, global, strobed",
            chain(Vsync, |c| {
                c.display.scan.buffered_frames = 3;
                c.display.response.emission = Emission::Global;
                c.display.response.strobe_delay = Nanos(MS / 2);
                c.display.response.to_counted_light = Nanos(MS);
            }),
        ),
        (
            "transport and losses",
            chain(Vsync, |c| {
                c.tracker.transport = Durations::uniform("t", [0.5, 1.5]).unwrap();
                c.tracker.processing = Durations::uniform("p", [1.0, 2.0]).unwrap();
            }),
        ),
        (
            "a display whose period is no whole number",
            chain(Vsync, |c| {
                c.display.scan.rate = Rate::from_hz("f", 119.88).unwrap();
                c.runtime.lead = Nanos(MS);
            }),
        ),
    ]
}

/// The same chain with every draw at its least or its most.
fn at_extreme(chain: &Chain, longest: bool) -> Chain {
    let pin = |law: &Durations| Durations::fixed(if longest { law.max() } else { law.min() });
    let mut chain = chain.clone();
    chain.render = pin(&chain.render);
    chain.tracker.processing = pin(&chain.tracker.processing);
    chain.tracker.transport = pin(&chain.tracker.transport);
    chain
}

/// Moves the clocks one after the other, in the order of the chain: each move delays (or hastens) what
/// comes after it, until a sample or a frame misses its turn.
fn moved(start: RunStart, what: usize, by: Nanos) -> RunStart {
    let RunStart {
        mut phases,
        mut begin,
        mut head_wait,
    } = start;
    if what == 0 {
        phases.exposure += by;
    }
    if what == 1 {
        head_wait = (head_wait + by).max(Nanos::ZERO);
    }
    if what <= 2 {
        phases.host += by;
        begin += by;
    }
    phases.vblank += by;
    RunStart {
        phases,
        begin: begin.min(Nanos::ZERO),
        head_wait,
    }
}

/// The extreme that a pattern search from many random clocks finds.
fn searched(study: &LatencyStudy, quantity: Quantity, longest: bool) -> Nanos {
    let mut pipeline = Pipeline::new();
    let longest_wait = study.chain.head.rate.map_or(Nanos::ZERO, |r| r.period());
    let frame = Frame::new(study);
    let mut value = |start: RunStart| {
        if start.head_wait > longest_wait {
            return Nanos(if longest { i64::MIN } else { i64::MAX });
        }
        study.simulate_within(&frame, &mut pipeline, 1, 0, start).0[quantity.index()]
    };
    let better = |a: Nanos, b: Nanos| if longest { a > b } else { a < b };
    let mut best = Nanos(if longest { i64::MIN } else { i64::MAX });
    for seed in 0..12 {
        let mut start = study.draw_within(&frame, seed, 0);
        let mut here = value(start);
        let mut step = Nanos(2 * MS);
        while step >= Nanos(100) {
            let mut improved = false;
            for what in 0..4 {
                for by in [step, -step] {
                    let next = moved(start, what, by);
                    let there = value(next);
                    if better(there, here) {
                        (start, here, improved) = (next, there, true);
                    }
                }
            }
            if !improved {
                step = Nanos(step.0 / 2);
            }
        }
        if better(here, best) {
            best = here;
        }
    }
    best
}

#[test]
fn bounds_are_the_extremes_that_a_search_finds() {
    for (name, chain) in chains() {
        let study = LatencyStudy::of(chain.clone(), None).unwrap();
        let bounds = study.bounds();
        for longest in [false, true] {
            let extreme = LatencyStudy::of(at_extreme(&chain, longest), None).unwrap();
            for quantity in [
                Quantity::Gaze(Rows::First),
                Quantity::Gaze(Rows::Gaze),
                Quantity::Gaze(Rows::Last),
                Quantity::Gaze(Rows::CompletePass),
                Quantity::Motion(Rows::Gaze),
                Quantity::Motion(Rows::Last),
            ] {
                let found = searched(&extreme, quantity, longest);
                let bound = bounds[quantity.index()];
                let want = if longest { bound.max } else { bound.min };
                assert!(
                    bound.contains(found),
                    "{name}: {quantity:?}: {found} outside {bound:?}"
                );
                assert!(
                    (found - want).0.abs() <= 1000,
                    "{name}: {quantity:?}: found {found}, bound {want}"
                );
            }
        }
    }
}

#[test]
fn no_sample_of_any_chain_leaves_its_bounds_and_stages_add_up() {
    let mut chains = chains();
    chains.push((
        "saturated queue",
        chain(SyncMode::Vsync, |c| {
            c.runtime.in_flight = 2;
            c.runtime.lead = Nanos(2 * MS);
            c.render = "uniform:7..16".parse().unwrap();
        }),
    ));
    chains.push((
        "uneven half rate",
        chain(SyncMode::Vsync, |c| {
            c.runtime.missed = Missed::HalfRate;
            c.render = "uniform:8..12".parse().unwrap();
        }),
    ));
    chains.push((
        "blinks",
        chain(SyncMode::Vsync, |c| {
            let spec = foveasim_models::TrackerSpec {
                dropouts: Some(LossSpec {
                    per_minute: 600.0,
                    lasts_ms: [3.0, 30.0],
                }),
                blinks: Some(LossSpec {
                    per_minute: 200.0,
                    lasts_ms: [50.0, 80.0],
                }),
                ..presets::tracker_spec("tx300").unwrap()
            };
            c.tracker = spec.try_into().unwrap();
        }),
    ));
    for (name, chain) in chains {
        let study = LatencyStudy::of(chain, None).unwrap();
        let result = run(&study, 3000);
        if let Some(q) = result.outside_bounds() {
            let h = result.histogram(q);
            let bound = result.bounds[q.index()];
            panic!(
                "{name}: {q:?}: {} to {} outside {bound:?}",
                h.min(),
                h.max()
            );
        }
        let mut pipeline = Pipeline::new();
        for i in 0..200 {
            let (sample, _) = study.simulate(&mut pipeline, 3, i, study.draw(3, i));
            let get = |q: Quantity| sample[q.index()];
            let sum = |of: fn(Stage) -> Quantity| STAGES.iter().map(|s| get(of(*s)).0).sum::<i64>();
            assert_eq!(
                sum(Quantity::Stage),
                get(Quantity::Gaze(Rows::Gaze)).0,
                "{name}"
            );
            assert_eq!(
                sum(Quantity::MotionStage),
                get(Quantity::Motion(Rows::Gaze)).0,
                "{name}"
            );
            assert!(
                sample.iter().all(|t| *t >= Nanos::ZERO),
                "{name}: {sample:?}"
            );
        }
    }
}

#[test]
fn the_longest_loss_is_in_the_bound() {
    // Exposures every 4 ms; of 30 ms, at worst, those after 4, 8 … 32 ms are hidden.
    let mut chain = chain(SyncMode::Tearing, |_| ());
    let spec = foveasim_models::TrackerSpec {
        rate_hz: 250.0,
        dropouts: Some(LossSpec {
            per_minute: 50_000.0,
            lasts_ms: [30.0, 30.0],
        }),
        ..presets::tracker_spec("tx300").unwrap()
    };
    chain.tracker = spec.try_into().unwrap();
    let study = LatencyStudy::of(chain, None).unwrap();
    let bound = study.bounds()[Quantity::Stage(Stage::TrackerWait).index()];
    assert_eq!(bound.max, Nanos(36 * MS));
    let result = run(&study, 20_000);
    assert_eq!(result.outside_bounds(), None);
    let longest = result.histogram(Quantity::Stage(Stage::TrackerWait)).max();
    assert!(bound.max - longest < Nanos(MS / 2), "{longest}");
}

#[test]
fn a_locked_host_always_flips_at_the_same_row() {
    // Guenter's set-up, rendering locked so that the flip meets the beam at the inner layer: the lower
    // envelope over the phase between rendering and scan-out, by an independent computation.
    let s = study(SyncMode::Tearing);
    let first = s.edges().first;
    let mut chain = s.chain.clone();
    let refresh = chain.display.scan.rate.period();
    chain.runtime.host_lock = Some((first + refresh - chain.render.max()).min(refresh));
    let study = LatencyStudy::of(chain, None).unwrap();
    let result = run(&study, 200_000);
    assert_eq!(result.outside_bounds(), None);
    let h = result.histogram(Quantity::Gaze(Rows::CompletePass));
    let want = [
        (h.mean_ms(), 27.343_21),
        (h.quantile_ms(0.05), 23.073_35),
        (h.quantile_ms(0.5), 27.343_21),
        (h.quantile_ms(0.95), 31.613_07),
        (h.quantile_ms(0.99), 32.682_74),
    ];
    for (got, want) in want {
        assert!((got - want).abs() < 0.05, "{got} {want}");
    }
    let (low, high) = bound(&study, Quantity::Gaze(Rows::CompletePass));
    assert!((low - 20.509_877).abs() < 1e-3 && (high - 34.176_543).abs() < 1e-3);
}

#[test]
fn a_tracker_that_always_takes_as_long() {
    // As Guenter's text gives 6.6 ms at best: processing always takes 3.3 ms. By an independent
    // computation.
    let s = study(SyncMode::Tearing);
    let mut chain = s.chain.clone();
    chain.tracker.processing = "3.3".parse().unwrap();
    let study = LatencyStudy::of(chain, None).unwrap();
    let h = run(&study, 200_000);
    let h = h.histogram(Quantity::Gaze(Rows::CompletePass));
    for (q, want) in [
        (0.05, 26.629_81),
        (0.5, 32.509_877),
        (0.95, 38.389_943),
        (0.99, 40.106_127),
    ] {
        let got = h.quantile_ms(q);
        assert!((got - want).abs() < 0.05, "{q}: {got} {want}");
    }
    let (low, high) = bound(&study, Quantity::Gaze(Rows::CompletePass));
    assert!((low - 22.509_877).abs() < 1e-3 && (high - 42.509_877).abs() < 1e-3);
}
