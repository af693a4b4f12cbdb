//! The bounds of every loop and stage, beside what a search over the phases of the clocks finds.

use foveasim_models::{Durations, Emission, FrameCost, LossSpec, ScanDirection, Stream};
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
    let locked = |render: &'static str, after: f64| {
        move |c: &mut Chain| {
            c.host_rate = c.display.scan.rate;
            c.runtime.host_lock = Some(Nanos::from_ms(after));
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
        // Frames in flight that are late: the renderer never rests, and blanks meet it in turns.
        (
            "blocked, 2 in flight, late",
            chain(Vsync, in_flight(2, "14")),
        ),
        (
            "blocked, 3 in flight, late",
            chain(Vsync, in_flight(3, "12.5")),
        ),
        (
            "blocked, 3 in flight, very late",
            chain(Vsync, in_flight(3, "26")),
        ),
        (
            "blocked, 2 in flight, too long for the lead",
            chain(Vsync, |c| {
                in_flight(2, "8")(c);
                c.runtime.lead = Nanos(13 * MS / 2);
            }),
        ),
        (
            "blocked, 2 in flight, late and uneven",
            chain(Vsync, in_flight(2, "uniform:11..16")),
        ),
        (
            "blocked, 2 in flight, now and then late",
            chain(Vsync, in_flight(2, "uniform:7..16")),
        ),
        (
            "blocked, 3 in flight, uneven, with a lead",
            chain(Vsync, |c| {
                in_flight(3, "uniform:6..14")(c);
                c.runtime.lead = Nanos(2 * MS);
            }),
        ),
        (
            "free, locked, uneven",
            chain(VsyncFree, locked("uniform:4..9.5", 3.0)),
        ),
        (
            "free, locked, never in time",
            chain(VsyncFree, locked("uniform:7.5..9.5", 3.0)),
        ),
        ("tearing, locked", chain(Tearing, locked("6", 3.0))),
        (
            "tearing, locked, uneven",
            chain(Tearing, locked("uniform:4..9.5", 3.0)),
        ),
        (
            "tearing, locked, within the rows",
            chain(Tearing, locked("uniform:2..3", 0.5)),
        ),
        (
            "blocked, half rate, uneven",
            chain(Vsync, |c| {
                c.runtime.missed = Missed::HalfRate;
                c.render = "uniform:8..12".parse().unwrap();
            }),
        ),
        (
            "blocked, half rate, very uneven",
            chain(Vsync, |c| {
                c.runtime.missed = Missed::HalfRate;
                c.render = "uniform:12..23".parse().unwrap();
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
    let starts = match (varies, frame.turn > Nanos::ZERO) {
        (false, false) => 12,
        _ => 10,
    };
    for seed in 0..starts {
        let mut stream = Stream::new(seed, Role::RenderTime, 0);
        let mut frames = Chosen::draw(law, &mut stream);
        let mut start = study.draw_within(&frame, seed, 0);
        let mut here = value(start, &frames);
        let mut step = Nanos(2 * MS);
        while step >= Nanos(250) {
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
    use rayon::prelude::*;
    let wrong: Vec<String> = chains()
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
    // Frames that keep up: what each waits for inside is left open.
    let queue = kinds(|c| c.runtime.in_flight = 2);
    assert_eq!(queue, [Exact, Outer, Exact]);
}

#[test]
fn no_sample_of_any_chain_leaves_its_bounds_and_stages_add_up() {
    let mut chains = chains();
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
