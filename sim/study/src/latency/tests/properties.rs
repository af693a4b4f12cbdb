//! What holds for every chain.

use foveasim_models::Durations;
use foveasim_pipeline::{FrameStart, Missed};
use proptest::prelude::*;

use super::*;
use crate::{Chain, HeadSampling, PARTS, Part};

fn any_chain() -> impl Strategy<Value = Chain> {
    let sync = prop::sample::select(SyncMode::ALL.to_vec());
    let times = (0.0f64..9.0, 0.0f64..6.0, 0.0f64..4.0, 0.0f64..3.0);
    let loops = (
        0.0f64..3.0,
        1u32..=3,
        0u32..=4,
        any::<bool>(),
        any::<bool>(),
    );
    (sync, times, loops).prop_map(|(sync, times, loops)| {
        let (render, spread, transport, settle) = times;
        let (lead, in_flight, buffered, warped, hurried) = loops;
        let display = presets::display("quest-3").unwrap();
        let mut chain = Chain::new(display, presets::tracker("quest-pro").unwrap(), sync);
        chain.render = Durations::uniform("r", [render, render + spread]).unwrap();
        chain.tracker.transport = Durations::uniform("t", [0.0, transport]).unwrap();
        chain.display.response.settle = Nanos::from_ms(settle);
        chain.display.response.to_counted_light = Nanos::from_ms(settle / 2.0);
        chain.display.scan.buffered_frames = buffered;
        chain.head = HeadSampling {
            rate: None,
            delay: Nanos::from_ms(transport),
        };
        let runtime = &mut chain.runtime;
        if sync != SyncMode::Tearing {
            runtime.lead = Nanos::from_ms(lead);
            runtime.warp = warped.then_some(runtime.lead);
            runtime.missed = if warped {
                Missed::Reproject
            } else {
                Missed::Repeat
            };
        }
        if sync == SyncMode::Vsync && hurried {
            let reserve = chain.render.max();
            runtime.start = FrameStart::JustInTime { reserve };
        } else {
            runtime.in_flight = in_flight;
        }
        chain
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Bounds never rise, whatever the chain. Means do not either, to the error of 400 runs each.
    #[test]
    fn switching_a_part_off_never_raises_a_latency(chain in any_chain()) {
        let study = LatencyStudy::of(chain.clone(), None).unwrap();
        let (with, before) = (study.bounds(), run(&study, 400));
        for part in PARTS {
            let off = LatencyStudy::of(chain.clone().without(part), None).unwrap();
            let after = run(&off, 400);
            for q in [Quantity::Gaze(Rows::Gaze), Quantity::Gaze(Rows::Last), Quantity::Motion(Rows::Gaze)] {
                let (a, b) = (off.bounds()[q.index()], with[q.index()]);
                prop_assert!(a.min <= b.min && a.max <= b.max, "{part}: {q:?}: {a:?} {b:?}");
                // Five standard errors of the difference of two means.
                let sd = b.width().as_ms() / 4.0;
                let slack = 5.0 * sd * (2.0f64 / 400.0).sqrt();
                let (a, b) = (after.histogram(q).mean_ms(), before.histogram(q).mean_ms());
                prop_assert!(a <= b + slack, "{part}: {q:?}: {a} {b}");
            }
        }
    }

    /// With the clocks and draws of a run held, each part that is off leaves no answer later, as long as
    /// frames keep up with the display.
    #[test]
    fn switching_a_part_off_delays_no_single_run(chain in any_chain(), seed in any::<u64>()) {
        let refresh = chain.display.scan.rate.period();
        prop_assume!(chain.render.max() + chain.runtime.lead <= refresh);
        let study = LatencyStudy::of(chain.clone(), None).unwrap();
        let mut pipeline = Pipeline::new();
        for i in 0..8 {
            let start = study.draw(seed, i);
            let (with, _) = study.simulate(&mut pipeline, seed, i, start);
            for part in PARTS {
                let off = LatencyStudy::of(chain.clone().without(part), None).unwrap();
                let (without, _) = off.simulate(&mut pipeline, seed, i, start);
                for q in [Quantity::Gaze(Rows::Gaze), Quantity::Motion(Rows::Gaze)] {
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
        let study = LatencyStudy::of(chain.clone(), None).unwrap();
        let off = LatencyStudy::of(chain.without(Part::Queue), None).unwrap();
        let mut pipeline = Pipeline::new();
        for i in 0..8 {
            let start = study.draw(seed, i);
            let (with, _) = study.simulate(&mut pipeline, seed, i, start);
            let (without, _) = off.simulate(&mut pipeline, seed, i, start);
            for q in [Quantity::Gaze(Rows::Gaze), Quantity::Motion(Rows::Gaze), Quantity::Stage(Stage::FrameQueue)] {
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
