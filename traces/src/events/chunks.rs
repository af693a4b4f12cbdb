use std::ops::Range;

use foveasim_models::{GazeDirection, GazeSeries, Nanos, Rate};

use super::GazeEvent;
use crate::EventKind;
use crate::interval::usual_interval_ms;

/// A hole of more than this many intervals ends a chunk.
const HOLE: f64 = 4.0;

/// The samples that have a value, and the stretches of them without a loss or a hole.
#[derive(Debug)]
pub(super) struct Chunks {
    pub(super) t: Vec<Nanos>,
    pub(super) gaze: Vec<GazeDirection>,
    pub(super) ranges: Vec<Range<usize>>,
    interval_ms: f64,
}

impl Chunks {
    /// Of samples taken at the `stated` rate, or else one that the median interval gives.
    pub(super) fn new(series: &GazeSeries, stated: Option<Rate>) -> Self {
        let samples = series.samples();
        let interval_ms = usual_interval_ms(series, stated);
        let mut chunks = Self {
            t: Vec::with_capacity(samples.len()),
            gaze: Vec::with_capacity(samples.len()),
            ranges: Vec::new(),
            interval_ms,
        };
        let mut begin = 0;
        let mut lost = false;
        for sample in samples {
            let Some(value) = sample.value else {
                lost = true;
                continue;
            };
            match chunks.t.last() {
                // Of equal times the later sample counts.
                Some(last) if *last == sample.t && !lost => {
                    if let Some(gaze) = chunks.gaze.last_mut() {
                        *gaze = value;
                    }
                    continue;
                }
                Some(last) if lost || (sample.t - *last).as_ms() > HOLE * interval_ms => {
                    chunks.ranges.push(begin..chunks.t.len());
                    begin = chunks.t.len();
                }
                _ => {}
            }
            lost = false;
            chunks.t.push(sample.t);
            chunks.gaze.push(value);
        }
        if chunks.t.len() > begin {
            chunks.ranges.push(begin..chunks.t.len());
        }
        chunks
    }

    /// How many samples have a value.
    pub(super) fn samples(&self) -> usize {
        self.t.len()
    }

    /// Usual interval \[ms\]; NaN for fewer than two times of no stated rate.
    pub(super) fn interval_ms(&self) -> f64 {
        self.interval_ms
    }

    /// The event over these samples, both included.
    pub(super) fn event(
        &self,
        kind: EventKind,
        samples: std::ops::RangeInclusive<usize>,
        speeds: &[f64],
    ) -> GazeEvent {
        let (first, last) = (*samples.start(), *samples.end());
        let (from, to) = (self.gaze[first], self.gaze[last]);
        GazeEvent {
            kind,
            start: self.t[first],
            end: self.t[last],
            from: Some(from),
            to: Some(to),
            amplitude_deg: from.angle_to_deg(to),
            peak_deg_per_s: speeds[samples].iter().copied().fold(0.0, f64::max),
        }
    }
}
