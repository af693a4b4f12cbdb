//! How long from a movement of the eye to the light that answers it: Monte Carlo over the phases of
//! all clocks, beside exact bounds.
//!
//! The set-up of Guenter 2012, §4.1, unrounded: gaze steps at a uniformly random time; the first
//! exposure to *start* afterwards sees it; the first frame to start after delivery uses it. Every run
//! is a run of [`Pipeline`] with its own phases, the same chain that replays recordings.

mod band;
mod charts;
mod histogram;
mod observer;
mod quantity;

use foveasim_models::{Display, FixedCost, GazeDirection, Nanos, Role, Stream, Tracker};
use foveasim_pipeline::{
    GazeInput, Interval, Phases, Pipeline, STAGES, Setup, Stage, StageBounds, SyncMode,
};
use foveasim_reports::{Cell, Table};
use rayon::prelude::*;
use thiserror::Error;

pub use band::Band;
pub use histogram::Histogram;
pub use quantity::{QUANTITIES, Quantity};

use observer::Observer;

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
}

/// The longest rendering time of a study.
const MAX_RENDER: Nanos = Nanos(10_000_000_000);

/// The most runs of a study: its counts stay exact, and it ends.
pub const MAX_RUNS: u64 = 1_000_000_000;

/// Runs simulated by one thread before the next chunk is handed out.
const CHUNK: u64 = 1 << 14;

/// A valid study: a display, a tracker, how they are coupled, and what to look at.
#[derive(Debug, Clone, PartialEq)]
pub struct LatencyStudy {
    display: Display,
    /// Its reported gaze is exact: accuracy does not change latency.
    tracker: Tracker,
    sync: SyncMode,
    render: Nanos,
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
}

/// The distributions found by a study.
#[derive(Debug, Clone, PartialEq)]
pub struct LatencyResult {
    /// One for each of [`QUANTITIES`].
    pub histograms: Vec<Histogram>,
    /// Exact bounds, in the same order.
    pub bounds: Vec<Interval>,
    /// How many events were simulated.
    pub events: u64,
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
        let band = band.unwrap_or(Band::about(display.scan.rows / 2, display.scan.rows));
        band.check(display.scan.rows)?;
        let tracker = Tracker {
            bias_deg: 0.0,
            precision_deg: 0.0,
            ..tracker
        };
        Ok(Self {
            display,
            tracker,
            sync,
            render,
            band,
        })
    }

    /// The rows looked at.
    pub fn band(&self) -> Band {
        self.band
    }

    /// How long every frame renders.
    pub fn render(&self) -> Nanos {
        self.render
    }

    fn setup<'a>(&'a self, cost: &'a FixedCost, phases: Phases) -> Setup<'a> {
        let Display { scan, response, .. } = &self.display;
        let gaze = GazeInput::Constant(GazeDirection::AHEAD);
        let setup = Setup::new(*scan, *response, &self.tracker, self.sync, cost);
        Setup {
            phases,
            gaze,
            gaze_max_age: Nanos::MAX,
            ..setup
        }
    }

    fn stage_bounds(&self) -> StageBounds {
        let cost = FixedCost(self.render);
        let row = self.display.scan.row_offset(self.band.gaze);
        StageBounds::new(&self.setup(&cost, Phases::default()), self.render, row)
    }

    /// The exact shortest and longest time of every quantity, by interval arithmetic: the clocks'
    /// phases are independent, so extremes of the parts are extremes of the whole.
    pub fn bounds(&self) -> Vec<Interval> {
        let stages = self.stage_bounds();
        let edges = self.band.edges(&self.display);
        QUANTITIES
            .iter()
            .map(|q| q.bounds(&stages, &edges, self.sync))
            .collect()
    }

    /// Draws the clocks of run number `run`: independent and uniform.
    pub fn draw(&self, seed: u64, run: u64) -> RunStart {
        let bounds = self.stage_bounds();
        self.draw_within(&bounds, seed, run)
    }

    fn draw_within(&self, bounds: &StageBounds, seed: u64, run: u64) -> RunStart {
        let mut stream = Stream::new(seed, Role::Phase, run);
        let mut within = |span: Nanos| Nanos(stream.below(span.0 as u64) as i64);
        let phases = Phases {
            exposure: within(bounds.get(Stage::TrackerWait).max),
            host: within(bounds.refresh),
            vblank: within(bounds.refresh),
        };
        // A scan must be going on when gaze steps; and a host that overruns its clock keeps the phase
        // it began with: that must be uniform too.
        RunStart {
            phases,
            begin: -bounds.refresh - within(bounds.host_cycle),
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
        let cost = FixedCost(self.render);
        let setup = Setup {
            seed,
            run,
            ..self.setup(&cost, start.phases)
        };
        let mut observer = Observer::new(Nanos::ZERO, frame.edges);
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
    /// If `runs` is 0 or above [`MAX_RUNS`].
    pub fn run(
        &self,
        runs: u64,
        seed: u64,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<LatencyResult, LatencyError> {
        if !(1..=MAX_RUNS).contains(&runs) {
            let valid = format!("from 1 to {MAX_RUNS}");
            return Err(LatencyError::OutOfRange {
                field: "runs",
                value: runs.to_string(),
                valid,
            });
        }
        let bounds = self.bounds();
        let frame = Frame::new(self);
        let empty = || Partial {
            histograms: bounds.iter().map(|b| Histogram::new(*b)).collect(),
            pipeline: Pipeline::new(),
            events: 0,
        };
        let Partial {
            histograms, events, ..
        } = (0..runs.div_ceil(CHUNK))
            .into_par_iter()
            .fold(empty, |mut partial, chunk| {
                let first = chunk * CHUNK;
                let last = (first + CHUNK).min(runs);
                for run in first..last {
                    let start = self.draw_within(&frame.bounds, seed, run);
                    let (sample, events) =
                        self.simulate_within(&frame, &mut partial.pipeline, seed, run, start);
                    partial.events += events;
                    for (histogram, t) in partial.histograms.iter_mut().zip(sample) {
                        histogram.add(t);
                    }
                }
                progress(last - first);
                partial
            })
            .reduce(empty, Partial::merge);
        Ok(LatencyResult {
            histograms,
            bounds,
            events,
        })
    }
}

/// What all runs of a study share.
struct Frame {
    bounds: StageBounds,
    edges: band::Edges,
    /// By then every quantity has been seen.
    end: Nanos,
}

impl Frame {
    fn new(study: &LatencyStudy) -> Self {
        let bounds = study.stage_bounds();
        let edges = study.band.edges(&study.display);
        // The last answer comes at most two scans after the first flip, plus the end of its scan.
        let end = bounds.total().max + bounds.refresh * 4;
        Self { bounds, edges, end }
    }
}

struct Partial {
    histograms: Vec<Histogram>,
    pipeline: Pipeline,
    events: u64,
}

impl Partial {
    fn merge(mut self, other: Self) -> Self {
        for (mine, theirs) in self.histograms.iter_mut().zip(&other.histograms) {
            mine.merge(theirs);
        }
        self.events += other.events;
        self
    }
}

impl LatencyResult {
    /// The distribution of one quantity.
    pub fn histogram(&self, quantity: Quantity) -> &Histogram {
        &self.histograms[quantity.index()]
    }

    /// The first quantity, if any, that was measured outside its bounds: then one of the two is wrong.
    pub fn outside_bounds(&self) -> Option<Quantity> {
        QUANTITIES.into_iter().find(|q| {
            let (h, b) = (self.histogram(*q), self.bounds[q.index()]);
            !(b.contains(h.min()) && b.contains(h.max()))
        })
    }

    /// One row per quantity: quantiles and mean of the simulation, then the exact bounds.
    pub fn table(&self) -> Table {
        let mut table = Table::new([
            "stage",
            "min_ms",
            "p5_ms",
            "p50_ms",
            "mean_ms",
            "p95_ms",
            "p99_ms",
            "max_ms",
            "bound_min_ms",
            "bound_max_ms",
        ]);
        for (quantity, bound) in QUANTITIES.into_iter().zip(&self.bounds) {
            let h = self.histogram(quantity);
            let values = [
                h.min().as_ms(),
                h.quantile_ms(0.05),
                h.quantile_ms(0.5),
                h.mean_ms(),
                h.quantile_ms(0.95),
                h.quantile_ms(0.99),
                h.max().as_ms(),
                bound.min.as_ms(),
                bound.max.as_ms(),
            ];
            let row = std::iter::once(quantity.name().into());
            table.push(row.chain(values.map(Cell::from)).collect());
        }
        table
    }

    /// All histograms, for drawing: `bins` equal bins over each quantity's bounds, with the fraction
    /// of the runs in each.
    pub fn histogram_table(&self, bins: usize) -> Table {
        let mut table = Table::new(["stage", "from_ms", "to_ms", "fraction"]);
        for quantity in QUANTITIES {
            for (from, to, fraction) in self.histogram(quantity).coarse(bins) {
                table.push(vec![
                    quantity.name().into(),
                    from.into(),
                    to.into(),
                    fraction.into(),
                ]);
            }
        }
        table
    }
}

const _: () = assert!(QUANTITIES.len() == STAGES.len() + 4);

#[cfg(test)]
mod tests;
