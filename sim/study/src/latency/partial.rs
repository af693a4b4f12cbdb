use foveasim_models::Nanos;
use foveasim_pipeline::Pipeline;

use super::{Histogram, LatencySample, Quantity, Rows};

/// What some of the runs of a study found.
pub(super) struct Partial {
    pub(super) histograms: Vec<Histogram>,
    pub(super) pipeline: Pipeline,
    /// Fastest and slowest, of gaze and of motion.
    pub(super) extremes: [[Option<Extreme>; 2]; 2],
    pub(super) events: u64,
}

/// A run that is faster, or slower, than all others; of equals, the first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extreme {
    pub(super) time: Nanos,
    pub(super) run: u64,
    pub(super) sample: LatencySample,
}

impl Partial {
    pub(super) fn see(&mut self, run: u64, sample: &LatencySample) {
        for (pair, of) in self
            .extremes
            .iter_mut()
            .zip([Quantity::Gaze, Quantity::Motion])
        {
            let time = sample[of(Rows::Gaze).index()];
            for (slowest, best) in pair.iter_mut().enumerate() {
                let beaten = best.is_none_or(|b| match slowest {
                    0 => (time, run) < (b.time, b.run),
                    _ => (-time, run) < (-b.time, b.run),
                });
                if beaten {
                    let sample = *sample;
                    *best = Some(Extreme { time, run, sample });
                }
            }
        }
    }

    pub(super) fn merge(mut self, other: Self) -> Self {
        for (mine, theirs) in self.histograms.iter_mut().zip(&other.histograms) {
            mine.merge(theirs);
        }
        self.events += other.events;
        for pair in other.extremes {
            for extreme in pair.into_iter().flatten() {
                self.see(extreme.run, &extreme.sample);
            }
        }
        self
    }
}
