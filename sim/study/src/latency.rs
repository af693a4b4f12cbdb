//! How long from a movement of the eye, or of the head, to the light that answers it: Monte Carlo over
//! the phases of all clocks, beside exact bounds.
//!
//! The set-up of Guenter 2012, §4.1, unrounded: gaze steps at a uniformly random time; the first
//! exposure to *start* afterwards sees it; the first frame to read the gaze after delivery uses it. The
//! head moves at the same time. Every run is a run of [`Pipeline`] with its own phases, the same chain
//! that replays recordings.

mod band;
mod charts;
mod frame;
mod histogram;
mod knob;
mod observer;
mod partial;
mod quantity;
mod reading;
mod result;
mod sensitivity;

use foveasim_models::{
    Display, DrawnCost, Durations, FixedCost, FrameCost, ModelError, Nanos, Role, Stream, Tracker,
};
use foveasim_pipeline::{
    BoundKind, Interval, Movement, Phases, Pipeline, Sensed, Setup, Stage, StageBounds, SyncMode,
};
use rayon::prelude::*;
use thiserror::Error;

pub use band::Band;
pub use charts::tornado;
pub use histogram::Histogram;
pub use knob::{KNOBS, Knob};
pub use quantity::{QUANTITIES, Quantity, ROWS, Rows};
pub use reading::{FIG5_READINGS, Fig5Reading, Fig5Result};
pub use result::LatencyResult;
pub use sensitivity::{Budget, Sensitivity, sensitivity_table};

use crate::Chain;
use frame::Frame;
use observer::Observer;
use partial::Partial;

/// Why a latency study cannot be made.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum LatencyError {
    /// A number outside what the study can use.
    #[error("{field} = {value}: must be {valid}")]
    OutOfRange {
        /// What, with its unit.
        field: &'static str,
        /// The value given.
        value: String,
        /// What would be valid.
        valid: String,
    },
    /// The simulation and the bounds of one chain contradict each other: one of the two is wrong.
    #[error(
        "the simulation of {quantity} came to {found}, outside its bounds {bound} ms: one of the two is wrong"
    )]
    OutsideBounds {
        /// As in tables.
        quantity: &'static str,
        /// From and to \[ms\].
        found: String,
        /// Likewise.
        bound: String,
    },
    /// Parts of the chain that do not fit each other.
    #[error(transparent)]
    Chain(#[from] ModelError),
}

/// The longest rendering time of a study.
const MAX_RENDER: Nanos = Nanos(10_000_000_000);

/// The most runs of a study: its counts stay exact, and it ends.
pub const MAX_RUNS: u64 = 1_000_000_000;

/// Runs begin in one of so many refreshes, of those in which clocks meet differently.
const MOST_REFRESHES: i64 = 1 << 20;

/// Runs simulated by one thread before the next chunk is handed out.
const CHUNK: u64 = 1 << 14;

/// A valid study: a chain, and where to look.
#[derive(Debug, Clone, PartialEq)]
pub struct LatencyStudy {
    /// Its reported gaze is exact: accuracy does not change latency.
    chain: Chain,
    band: Band,
}

/// What one run measured, in the order of [`QUANTITIES`].
pub type LatencySample = [Nanos; QUANTITIES.len()];

/// Where one run's clocks stand. Gaze steps at time 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunStart {
    /// Phases of the clocks.
    pub phases: Phases,
    /// When the simulation begins, at or before 0: the first frame starts with the first tick from
    /// here on.
    pub begin: Nanos,
    /// From the head's movement, at 0 too, to the next head sample.
    pub head_wait: Nanos,
    /// How far behind the display's clock a host that is locked to it, and that frames always overrun, has
    /// fallen already.
    pub behind: Nanos,
}

impl LatencyStudy {
    /// A study of `display` and `tracker`. Frames render for `render`, or without it for one refresh
    /// period, rounded down to the nanosecond so that a blocked host meets every vertical blank.
    ///
    /// # Errors
    /// If `render` is negative or beyond 10 s, or the band is not on the display.
    pub fn new(
        display: Display,
        tracker: Tracker,
        sync: SyncMode,
        render: Option<Nanos>,
        band: Option<Band>,
    ) -> Result<Self, LatencyError> {
        let render = render.unwrap_or(display.scan.rate.period());
        if !(Nanos::ZERO..=MAX_RENDER).contains(&render) {
            let valid = format!("from 0 to {}", MAX_RENDER.as_ms());
            let value = render.as_ms().to_string();
            return Err(LatencyError::OutOfRange {
                field: "render time [ms]",
                value,
                valid,
            });
        }
        let render = Durations::fixed(render);
        Self::of(
            Chain {
                render,
                ..Chain::new(display, tracker, sync)
            },
            band,
        )
    }

    /// A study of a whole chain.
    ///
    /// # Errors
    /// If its parts do not fit each other, or the band is not on the display.
    pub fn of(chain: Chain, band: Option<Band>) -> Result<Self, LatencyError> {
        chain.check()?;
        let rows = chain.display.scan.rows;
        let band = band.unwrap_or(Band::about(rows / 2, rows));
        band.check(rows)?;
        let tracker = chain.tracker.clone().exact();
        let chain = Chain { tracker, ..chain };
        Ok(Self { chain, band })
    }

    /// The chain, with a tracker that makes no errors.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// The rows looked at.
    pub fn band(&self) -> Band {
        self.band
    }

    fn stage_bounds(&self, movement: Movement) -> StageBounds {
        let chain = &self.chain;
        let none = FixedCost(Nanos::ZERO);
        let setup = chain.setup(&none, Phases::default());
        let row = chain.scan().row_offset(self.band.gaze);
        StageBounds::new(&setup, chain.render_range(), row, movement)
    }

    fn edges(&self) -> band::Edges {
        let response = self.chain.display.response;
        self.band.edges(self.chain.scan(), response)
    }

    /// The shortest and longest time of every quantity, by interval analysis.
    pub fn bounds(&self) -> Vec<Interval> {
        Frame::new(self).all
    }

    /// Whether those bounds are reached, or only hold; see [`StageBounds`].
    pub fn bound_kinds(&self) -> Vec<BoundKind> {
        Frame::new(self).kinds
    }

    /// Draws the clocks of run number `run`: independent and uniform.
    pub fn draw(&self, seed: u64, run: u64) -> RunStart {
        self.draw_within(&Frame::new(self), seed, run)
    }

    fn draw_within(&self, frame: &Frame, seed: u64, run: u64) -> RunStart {
        let [bounds, head] = &frame.bounds;
        let mut stream = Stream::new(seed, Role::Phase, run);
        let mut within = |span: Nanos| Nanos(stream.below(span.0 as u64) as i64);
        let phases = Phases {
            exposure: within(frame.exposures),
            host: within(frame.host_period),
            vblank: within(bounds.refresh),
            ..Phases::default()
        };
        // A scan must be going on when gaze steps; and a host that overruns its clock keeps the phase
        // it began with: that must be uniform too.
        let begin = -bounds.refresh - within(bounds.host_cycle) - frame.settling;
        let head_wait = match head.get(Stage::TrackerWait).max {
            Nanos::ZERO => Nanos::ZERO,
            longest => within(longest),
        };
        // Frames in flight that are late take turns: runs begin at any of them.
        let begin = match frame.turn {
            Nanos::ZERO => begin,
            turn => begin - within(turn),
        };
        // So does a host that meets the display's clock in turns.
        let beat = &bounds.beat;
        let mut one_of = |n: u64| match n {
            1 => 0,
            n => stream.below(n) as i64,
        };
        let passed = one_of(beat.refreshes.min(MOST_REFRESHES) as u64);
        let behind = beat.overrun * one_of(beat.overruns());
        let phases = Phases {
            vblank: phases.vblank - self.chain.display.scan.rate.tick(passed),
            ..phases
        };
        RunStart {
            phases,
            begin,
            head_wait,
            behind,
        }
    }

    /// Simulates run number `run` of `seed` from `start`; also returns how many events that took.
    pub fn simulate(
        &self,
        pipeline: &mut Pipeline,
        seed: u64,
        run: u64,
        start: RunStart,
    ) -> (LatencySample, u64) {
        self.simulate_within(&Frame::new(self), pipeline, seed, run, start)
    }

    fn simulate_within(
        &self,
        frame: &Frame,
        pipeline: &mut Pipeline,
        seed: u64,
        run: u64,
        start: RunStart,
    ) -> (LatencySample, u64) {
        let cost = DrawnCost {
            law: &self.chain.render,
            seed,
            run,
        };
        self.simulate_cost(frame, pipeline, &cost, [seed, run], start)
    }

    /// Simulates one run whose frames take what `cost` says.
    fn simulate_cost(
        &self,
        frame: &Frame,
        pipeline: &mut Pipeline,
        cost: &dyn FrameCost,
        [seed, run]: [u64; 2],
        start: RunStart,
    ) -> (LatencySample, u64) {
        let mut setup = Setup {
            seed,
            run,
            // Frames that overrun by little would fill the queue for longer than runs can wait.
            filled: self.chain.never_keeps_up(),
            ..self.chain.setup(cost, start.phases)
        };
        if let Some(lock) = setup.runtime.host_lock
            && start.behind > Nanos::ZERO
        {
            // Frames follow each other without end: when the first began is all that its clock decides.
            setup.phases.host = setup.phases.vblank + lock - start.behind;
            setup.runtime.host_lock = None;
        }
        let sampled = start.head_wait;
        let known = sampled + self.chain.head.delay;
        let head = Sensed {
            times: [sampled, sampled, sampled, known],
        };
        let mut observer = Observer::new(
            Nanos::ZERO,
            head,
            frame.edges,
            setup.sync == SyncMode::Tearing,
        );
        let counts = pipeline.run(&setup, start.begin, frame.end, &mut observer);
        let sample = observer
            .sample()
            .expect("the bounds leave time for every answer");
        (sample, counts.events)
    }

    /// Simulates `runs` runs on all threads of the current rayon pool. `progress` hears how many runs
    /// were just finished. The result does not depend on the number of threads: all sums are of whole
    /// numbers.
    ///
    /// # Errors
    /// If `runs` is 0 or above [`MAX_RUNS`], or a run leaves its bounds.
    pub fn run(
        &self,
        runs: u64,
        seed: u64,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<LatencyResult, LatencyError> {
        check_runs(runs)?;
        let frame = Frame::new(self);
        let bounds = frame.all.clone();
        let empty = || Partial {
            histograms: bounds.iter().map(|b| Histogram::new(*b)).collect(),
            pipeline: Pipeline::new(),
            extremes: [[None; 2]; 2],
            events: 0,
        };
        let Partial {
            histograms,
            events,
            extremes,
            ..
        } = (0..runs.div_ceil(CHUNK))
            .into_par_iter()
            .fold(empty, |mut partial, chunk| {
                let first = chunk * CHUNK;
                let last = (first + CHUNK).min(runs);
                for run in first..last {
                    let start = self.draw_within(&frame, seed, run);
                    let (sample, events) =
                        self.simulate_within(&frame, &mut partial.pipeline, seed, run, start);
                    partial.events += events;
                    partial.see(run, &sample);
                    for (histogram, t) in partial.histograms.iter_mut().zip(sample) {
                        histogram.add(t);
                    }
                }
                progress(last - first);
                partial
            })
            .reduce(empty, Partial::merge);
        let result = LatencyResult {
            histograms,
            bounds,
            bound_kinds: frame.kinds.clone(),
            extremes: extremes
                .map(|pair| pair.map(|run| run.expect("there was at least one run").sample)),
            events,
        };
        result.check()?;
        Ok(result)
    }
}

fn check_runs(runs: u64) -> Result<(), LatencyError> {
    match runs {
        1..=MAX_RUNS => Ok(()),
        _ => Err(LatencyError::OutOfRange {
            field: "runs",
            value: runs.to_string(),
            valid: format!("from 1 to {MAX_RUNS}"),
        }),
    }
}

#[cfg(test)]
mod tests;
