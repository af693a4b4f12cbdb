//! What holds for every chain.

use foveasim_models::Durations;
use foveasim_pipeline::{FrameStart, Missed};
use proptest::prelude::*;

use super::*;
use crate::{Anomaly, Chain, HeadSampling, PARTS, Part};

/// How long frames render: always the same, more or less, or with a long tail.
fn any_law() -> impl Strategy<Value = Durations> {
    let rounded = |ms: f64| (ms * 1e3).round() / 1e3;
    (0u32..3, 0.0f64..22.0, 0.0f64..9.0).prop_map(move |(kind, ms, spread)| {
        let (ms, spread) = (rounded(ms), rounded(spread));
        match kind {
            0 => Durations::fixed(Nanos::from_ms(ms)),
            1 => Durations::uniform("r", [ms, ms + spread]).unwrap(),
            _ => format!("normal:{ms},{}", spread / 4.0).parse().unwrap(),
        }
    })
}

/// A host's clock: locked to the display or not, at its rate or another.
fn any_clock() -> impl Strategy<Value = (Option<f64>, f64, [f64; 2])> {
    let rates = [0.0, 0.0, 30.0, 45.0, 60.0, 75.0, 80.0, 120.0, 144.0, 97.531];
    let drift = prop_oneof![4 => Just([0.0; 2]), 1 => [-200.0f64..200.0, -200.0..200.0]];
    (
        prop::option::of(0.0f64..1.0),
        prop::sample::select(rates.to_vec()),
        drift,
    )
}

fn any_chain() -> impl Strategy<Value = Chain> {
    let devices = (
        prop::sample::select(vec!["quest-3", "quest-pro", "lg-w2363d", "dk2", "psvr2"]),
        prop::sample::select(vec!["quest-pro", "tx300", "fove-0"]),
    );
    let sync = prop::sample::select(SyncMode::ALL.to_vec());
    let times = (any_law(), 0.0f64..4.0, 0.0f64..3.0, 0u32..=4);
    let latches = (prop::option::of(0.0f64..1.0), prop::option::of(0.0f64..1.0));
    let composed = (prop::option::of(0.0f64..0.4), any::<bool>(), 0usize..3);
    let start = (1u32..=3, prop::option::of(0.0f64..2.0));
    let head = prop::option::of(20.0f64..1000.0);
    let all = (
        devices,
        sync,
        times,
        latches,
        composed,
        start,
        any_clock(),
        head,
    );
    all.prop_map(
        |(devices, sync, times, latches, composed, start, clock, head)| {
            let mut display = presets::display(devices.0).unwrap();
            let (render, transport, settle, buffered) = times;
            let (lock, hz, [host, ppm]) = clock;
            display.scan.rate = display.scan.rate.drifted("d", ppm).unwrap();
            let refresh = display.scan.rate.period().as_ms();
            let mut chain = Chain::new(display, presets::tracker(devices.1).unwrap(), sync);
            let shortest = render.min().as_ms();
            chain.render = render;
            chain.tracker.transport = Durations::uniform("t", [0.0, transport]).unwrap();
            chain.display.response.settle = Nanos::from_ms(settle);
            chain.display.response.to_counted_light = Nanos::from_ms(settle / 2.0);
            chain.display.scan.buffered_frames = buffered;
            chain.head = HeadSampling {
                rate: head.map(|hz| Rate::from_hz("h", hz).unwrap()),
                delay: Nanos::from_ms(transport),
            };
            let runtime = &mut chain.runtime;
            let [gaze, pose] =
                [latches.0, latches.1].map(|l| Nanos::from_ms(l.unwrap_or(0.0) * shortest));
            (runtime.gaze_latch, runtime.pose_latch) = (gaze, pose);
            let (lead, warped, missed) = composed;
            if sync != SyncMode::Tearing {
                runtime.lead = Nanos::from_ms(lead.unwrap_or(0.0) * refresh);
                runtime.warp = warped.then_some(runtime.lead);
                runtime.missed = match (warped, missed) {
                    (true, 0) => Missed::Reproject,
                    _ => Missed::Repeat,
                };
            }
            let (in_flight, reserve) = start;
            match (sync, reserve) {
                (SyncMode::Vsync, Some(part)) => {
                    let reserve = Nanos::from_ms(part * chain.render.max().as_ms());
                    runtime.start = FrameStart::JustInTime { reserve };
                }
                _ => runtime.in_flight = in_flight,
            }
            if sync != SyncMode::Vsync {
                runtime.host_lock = lock.map(|part| Nanos::from_ms(part * refresh));
                if hz > 0.0 {
                    chain.host_rate = Rate::from_hz("h", hz).unwrap();
                }
                chain.host_rate = chain.host_rate.drifted("h", host).unwrap();
            } else if missed == 1 && runtime.in_flight == 1 && runtime.start == FrameStart::AtVblank
            {
                runtime.missed = Missed::HalfRate;
            }
            chain.check().unwrap();
            chain
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Neither bounds nor means nor 95th percentiles rise, but for what [`Anomaly`] names: the last two to the error
    /// of 1500 runs each.
    #[test]
    fn switching_a_part_off_never_raises_a_latency(chain in any_chain()) {
        const RUNS: u64 = 1500;
        let study = LatencyStudy::of(chain.clone(), None).unwrap();
        let before = run(&study, RUNS);
        for part in PARTS {
            let anomalies = chain.anomalies_without(part);
            let other = chain.clone().without(part);
            if other == chain {
                continue;
            }
            let after = run(&LatencyStudy::of(other, None).unwrap(), RUNS);
            for q in [Quantity::Gaze(Rows::Gaze), Quantity::Gaze(Rows::Last), Quantity::Motion(Rows::Gaze)] {
                if q.is_motion() && anomalies.contains(&Anomaly::WarpRhythm) {
                    continue;
                }
                let (a, b) = (after.bounds[q.index()], before.bounds[q.index()]);
                // Sums of rounded periods: each may be a nanosecond more than its rate says.
                let rounded = Nanos(4);
                let best = a.min <= b.min + rounded || anomalies.contains(&Anomaly::BestCase);
                // An outer bound says no more than that it holds.
                let worst = a.max <= b.max + rounded || after.bound_kinds[q.index()] == BoundKind::Outer;
                prop_assert!(best && worst, "{part}: {q:?}: {a:?} {b:?}");
                // Five standard errors of the difference of two means; a 95th percentile has 2.1 times that of the
                // mean of a normal distribution.
                let sd = b.width().min(a.width()).as_ms() / 3.46;
                let slack = 5.0 * sd * (2.0 / RUNS as f64).sqrt() + 0.01;
                let (a, b) = (after.histogram(q), before.histogram(q));
                prop_assert!(a.mean_ms() <= b.mean_ms() + slack, "{part}: {q:?}: {} {}", a.mean_ms(), b.mean_ms());
                let (a, b) = (a.quantile_ms(0.95), b.quantile_ms(0.95));
                prop_assert!(a <= b + 2.1 * slack, "{part}: {q:?}: {a} {b}");
            }
        }
    }

    /// With the clocks and draws of a run held, each part that is off leaves no answer later, as long as
    /// frames keep up with the display.
    #[test]
    fn switching_a_part_off_delays_no_single_run(chain in any_chain(), seed in any::<u64>()) {
        let refresh = chain.display.scan.rate.period();
        prop_assume!(chain.render.max() + chain.runtime.lead <= refresh);
        prop_assume!(chain.host_rate == chain.display.scan.rate);
        prop_assume!(chain.reserve().is_none_or(|reserve| reserve >= chain.render.max()));
        let study = LatencyStudy::of(chain.clone(), None).unwrap();
        let mut pipeline = Pipeline::new();
        for i in 0..8 {
            let start = study.draw(seed, i);
            let (with, _) = study.simulate(&mut pipeline, seed, i, start);
            for part in PARTS {
                let off = LatencyStudy::of(chain.clone().without(part), None).unwrap();
                let (without, _) = off.simulate(&mut pipeline, seed, i, start);
                let uneven = chain.anomalies_without(part).contains(&Anomaly::WarpRhythm);
                for q in [Quantity::Gaze(Rows::Gaze), Quantity::Motion(Rows::Gaze)] {
                    if q.is_motion() && uneven {
                        continue;
                    }
                    prop_assert!(
                        without[q.index()] <= with[q.index()],
                        "{part}: {q:?}: {} {}", without[q.index()], with[q.index()]
                    );
                }
            }
        }
    }

    /// Without a queue no answer is later, whether frames keep up or not, if each takes the same time: else
    /// runs with more frames draw others.
    #[test]
    fn without_a_queue_no_single_run_is_later(
        chain in any_chain(),
        render in 0.0f64..40.0,
        in_flight in 2u32..=3,
        seed in any::<u64>(),
    ) {
        let mut chain = chain;
        chain.render = Durations::fixed(Nanos::from_ms(render));
        (chain.runtime.start, chain.runtime.in_flight) = (FrameStart::AtVblank, in_flight);
        (chain.runtime.gaze_latch, chain.runtime.pose_latch) = (Nanos::ZERO, Nanos::ZERO);
        prop_assume!(chain.check().is_ok());
        let anomalies = chain.anomalies_without(Part::Queue);
        prop_assume!(!anomalies.contains(&Anomaly::BestCase));
        let study = LatencyStudy::of(chain.clone(), None).unwrap();
        let off = LatencyStudy::of(chain.without(Part::Queue), None).unwrap();
        let mut pipeline = Pipeline::new();
        for i in 0..8 {
            let start = study.draw(seed, i);
            let (with, _) = study.simulate(&mut pipeline, seed, i, start);
            let (without, _) = off.simulate(&mut pipeline, seed, i, start);
            for q in [Quantity::Gaze(Rows::Gaze), Quantity::Motion(Rows::Gaze), Quantity::Stage(Stage::FrameQueue)] {
                if q.is_motion() && anomalies.contains(&Anomaly::WarpRhythm) {
                    continue;
                }
                prop_assert!(without[q.index()] <= with[q.index()], "{q:?}: {} {}", without[q.index()], with[q.index()]);
            }
            prop_assert_eq!(without[Quantity::Stage(Stage::FrameQueue).index()], Nanos::ZERO);
        }
    }

    /// A host that is blocked on the swap gains nothing from frames that are finished sooner, as long as
    /// they need the same refreshes; one that starts just in time gains all of it.
    #[test]
    fn only_just_in_time_gains_from_faster_rendering(
        phases in [0i64..8_333_333, 0..8_333_333, 0..8_333_333],
        short in 0.0f64..8.0,
        more in 0.0f64..8.0,
    ) {
        let long = (short + more).min(8.3);
        let at = |ms: f64, just_in_time: bool| {
            let mut s = study(SyncMode::Vsync);
            s.chain.render = Durations::fixed(Nanos::from_ms(ms));
            if just_in_time {
                let reserve = s.chain.render.max();
                s.chain.runtime.start = FrameStart::JustInTime { reserve };
            }
            s
        };
        let photon = |s: &LatencyStudy| {
            let [exposure, host, vblank] = phases.map(Nanos);
            let phases = Phases {
                exposure,
                host,
                vblank,
                ..Phases::default()
            };
            let start = RunStart { phases, begin: Nanos(-30_000_000), head_wait: Nanos::ZERO, behind: Nanos::ZERO };
            s.simulate(&mut Pipeline::new(), 1, 1, start).0[Quantity::Gaze(Rows::Gaze).index()]
        };
        prop_assert_eq!(photon(&at(short, false)), photon(&at(long, false)));
        let (fast, slow) = (at(short, true), at(long, true));
        let best = |s: &LatencyStudy| s.bounds()[Quantity::Gaze(Rows::Gaze).index()];
        let gain = Nanos::from_ms(long) - Nanos::from_ms(short);
        prop_assert_eq!(best(&slow).min - best(&fast).min, gain);
        prop_assert_eq!(best(&slow).max - best(&fast).max, gain);
    }
}
