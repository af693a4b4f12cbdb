//! The bounds of every loop and stage, beside what a search over the phases of the clocks finds.

use foveasim_models::{Durations, FrameCost, LossSpec, Stream};

use super::chains::{chain, chains, crowded};
use super::*;
use crate::Chain;

const MS: i64 = 1_000_000;

/// The same chain with every draw of the tracker at its least or its most.
fn at_extreme(chain: &Chain, longest: bool) -> Chain {
    let pin = |law: &Durations| Durations::fixed(if longest { law.max() } else { law.min() });
    let mut chain = chain.clone();
    chain.tracker.processing = pin(&chain.tracker.processing);
    chain.tracker.transport = pin(&chain.tracker.transport);
    chain
}

/// Chosen frames: each takes one of these times, in turns.
const CHOSEN: usize = 7;

#[derive(Clone, Copy)]
struct Chosen([Nanos; CHOSEN]);

impl FrameCost for Chosen {
    fn duration(&self, input: &foveasim_models::FrameInput) -> Nanos {
        self.0[input.id as usize % CHOSEN]
    }
}

impl Chosen {
    fn draw(law: &Durations, stream: &mut Stream) -> Self {
        // Extremes are where frames are shortest or longest, more often than not.
        Self(std::array::from_fn(|_| match stream.below(3) {
            0 => law.min(),
            1 => law.max(),
            _ => law.min() + Nanos(stream.below((law.max() - law.min()).0 as u64 + 1) as i64),
        }))
    }

    fn with(self, i: usize, t: Nanos, law: &Durations) -> Self {
        let mut times = self.0;
        times[i] = t.max(law.min()).min(law.max());
        Self(times)
    }
}

/// Moves the clocks one after the other, in the order of the chain: each move delays (or hastens) what
/// comes after it, until a sample or a frame misses its turn.
fn moved(start: RunStart, what: usize, by: Nanos) -> RunStart {
    let RunStart {
        mut phases,
        mut begin,
        mut head_wait,
        behind,
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
        behind,
    }
}

/// The extreme that a pattern search finds from many random clocks and, where they vary, times of frames.
fn searched(study: &LatencyStudy, quantity: Quantity, longest: bool) -> Nanos {
    let mut pipeline = Pipeline::new();
    let longest_wait = study.chain.head.rate.map_or(Nanos::ZERO, |r| r.period());
    let frame = Frame::new(study);
    let law = &study.chain.render;
    let varies = law.min() != law.max();
    let none = Nanos(if longest { i64::MIN } else { i64::MAX });
    let mut value = |start: RunStart, frames: &Chosen| {
        let settled = start.begin <= -frame.settling;
        if start.head_wait > longest_wait || !settled {
            return none;
        }
        study
            .simulate_cost(&frame, &mut pipeline, frames, [1, 0], start)
            .0[quantity.index()]
    };
    let better = |a: Nanos, b: Nanos| if longest { a > b } else { a < b };
    let mut best = none;
    // What takes turns, or varies, has more places to begin at.
    let beat = frame.bounds[0].beat;
    // Frames that begin where earlier ones let them.
    let locked = study.chain.runtime.host_lock.is_some() && !study.chain.runtime.overlapped;
    let spreads = varies && locked && law.max() > study.chain.host_rate.period();
    let crowded = spreads && study.chain.runtime.in_flight > 1;
    let starts = match (varies, frame.turn > Nanos::ZERO) {
        _ if crowded => 6,
        _ if beat.refreshes > 1 || beat.overruns() > 1 => 24,
        (false, false) => 12,
        _ => 10,
    };
    // Where each of several frames must be just so long, what is left of the steps adds up.
    let finest = Nanos(if crowded { 60 } else { 250 });
    for seed in 0..starts {
        let mut stream = Stream::new(seed, Role::RenderTime, 0);
        let mut frames = Chosen::draw(law, &mut stream);
        let mut start = study.draw_within(&frame, seed, 0);
        let mut here = value(start, &frames);
        // The best of many to begin with.
        for i in (1..1500).filter(|_| spreads) {
            let others = Chosen::draw(law, &mut stream);
            let clocks = study.draw_within(&frame, seed, i);
            let there = value(clocks, &others);
            if better(there, here) {
                (start, frames, here) = (clocks, others, there);
            }
        }
        let mut step = Nanos(2 * MS);
        while step >= finest {
            let mut improved = false;
            for what in 0..4 {
                for by in [step, -step] {
                    let next = moved(start, what, by);
                    let there = value(next, &frames);
                    if better(there, here) {
                        (start, here, improved) = (next, there, true);
                    }
                }
            }
            for i in (0..CHOSEN).filter(|_| varies) {
                let t = frames.0[i];
                for t in [t + step, t - step, law.min(), law.max()] {
                    let next = frames.with(i, t, law);
                    let there = value(start, &next);
                    if better(there, here) {
                        (frames, here, improved) = (next, there, true);
                    }
                }
            }
            // What a frame takes moves all that follow, against the display as well: two frames, or one, and
            // the clocks.
            let pairs = (0..CHOSEN * CHOSEN).map(|k| (k / CHOSEN, k % CHOSEN));
            for (i, j) in pairs.filter(|_| spreads) {
                for by in [step, -step] {
                    let mut next = frames.with(i, frames.0[i] - by, law);
                    if i != j {
                        next = next.with(j, next.0[j] + by, law);
                    }
                    let clocks = moved(start, 2, by);
                    let there = value(clocks, &next);
                    if better(there, here) {
                        (start, frames, here, improved) = (clocks, next, there, true);
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
    all_are_found(chains(), |_| true);
}

/// Every frame of a few whole units of time is tried beside the sets that these bounds come from
/// (`foveasim_pipeline`); here a search has them all the way to the light, of what cannot be told from the rest.
#[test]
fn bounds_of_crowded_hosts_are_the_extremes_that_a_search_finds() {
    all_are_found(crowded(), |quantity| {
        matches!(quantity, Quantity::Gaze(Rows::Gaze | Rows::Last))
    });
}

/// Compares bounds and search of these quantities.
fn all_are_found(chains: Vec<(&'static str, Chain)>, of: fn(&Quantity) -> bool) {
    use rayon::prelude::*;
    let wrong: Vec<String> = chains
        .into_par_iter()
        .flat_map_iter(|(name, chain)| {
            let study = LatencyStudy::of(chain.clone(), None).unwrap();
            let (bounds, kinds) = (study.bounds(), study.bound_kinds());
            let mut quantities = vec![
                Quantity::Gaze(Rows::First),
                Quantity::Gaze(Rows::Gaze),
                Quantity::Gaze(Rows::Last),
                Quantity::Gaze(Rows::CompletePass),
                Quantity::Motion(Rows::Gaze),
                Quantity::Motion(Rows::Last),
            ];
            for q in &quantities {
                assert_eq!(kinds[q.index()], BoundKind::Exact, "{name}: {q:?}");
            }
            let stages = [Stage::FrameQueue, Stage::FlipWait, Stage::ScanWait];
            let stages = stages.map(Quantity::Stage).into_iter();
            quantities.extend(stages.filter(|q| kinds[q.index()] == BoundKind::Exact));
            quantities.retain(of);
            let mut wrong = Vec::new();
            for longest in [false, true] {
                let extreme = LatencyStudy::of(at_extreme(&chain, longest), None).unwrap();
                for &quantity in &quantities {
                    let bound = bounds[quantity.index()];
                    if bound.width() <= Nanos(4) {
                        continue;
                    }
                    let found = searched(&extreme, quantity, longest);
                    let want = if longest { bound.max } else { bound.min };
                    if !bound.contains(found) || (found - want).0.abs() > 1000 {
                        wrong.push(format!("{name}: {quantity:?}: found {found}, bound {want}"));
                    }
                }
            }
            wrong
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn bounds_that_need_not_be_reached_say_so() {
    let kinds = |change: fn(&mut Chain)| {
        let study = LatencyStudy::of(chain(SyncMode::Vsync, change), None).unwrap();
        let kinds = study.bound_kinds();
        [
            Quantity::Gaze(Rows::Gaze),
            Quantity::Stage(Stage::FlipWait),
            Quantity::Stage(Stage::PixelResponse),
        ]
        .map(|q| kinds[q.index()])
    };
    use BoundKind::{Exact, Outer};
    assert_eq!(kinds(|_| ()), [Exact; 3]);
    // Ten million frames pass before blanks meet the renderer as they did.
    let long = kinds(|c| {
        c.runtime.in_flight = 2;
        c.render = "12.345679".parse().unwrap();
    });
    assert_eq!(long, [Outer, Outer, Exact]);
    // Frames that keep up: how the first were late is forgotten, or never is.
    let queue = kinds(|c| c.runtime.in_flight = 2);
    assert_eq!(queue, [Exact; 3]);
    let never = kinds(|c| {
        c.runtime.in_flight = 2;
        c.render = "10".parse().unwrap();
    });
    assert_eq!(never, [Exact; 3]);
    let slowly = kinds(|c| {
        c.runtime.in_flight = 2;
        c.render = "9.99".parse().unwrap();
    });
    assert_eq!(slowly, [Exact, Outer, Exact]);
    // Some frames start at the host's ticks, and some where earlier ones end: by how many are in work. Frames
    // that fill the queue nanosecond by nanosecond take too many to follow.
    let mixed = |render: &'static str, in_flight: u32| {
        let chain = chain(SyncMode::VsyncFree, |c| {
            c.host_rate = c.display.scan.rate;
            c.runtime.host_lock = Some(Nanos(3 * MS));
            c.render = render.parse().unwrap();
            c.runtime.in_flight = in_flight;
        });
        let study = LatencyStudy::of(chain, None).unwrap();
        study.bound_kinds()[Quantity::Gaze(Rows::Gaze).index()]
    };
    assert_eq!([1, 2, 3].map(|n| mixed("uniform:8..14", n)), [Exact; 3]);
    assert_eq!(mixed("uniform:9.999999..10.000001", 2), Outer);
}

#[test]
fn no_sample_of_any_chain_leaves_its_bounds_and_stages_add_up() {
    let mut chains = [chains(), crowded()].concat();
    chains.push((
        "a queue whose turns take too long to follow",
        chain(SyncMode::Vsync, |c| {
            c.runtime.in_flight = 2;
            c.render = "12.345679".parse().unwrap();
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
