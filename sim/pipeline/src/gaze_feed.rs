use std::collections::VecDeque;

use foveasim_models::{GazeDirection, Nanos, Provenance, Role, Sample, Stream, Ticks, Tracker};

use crate::{Cursor, GazeInput, GazeStamp, Setup};

/// Makes gaze samples: when to measure next, what is measured, and when it is delivered.
#[derive(Debug)]
pub(crate) enum GazeFeed<'a> {
    /// Nobody measures.
    Off,
    /// The simulated tracker.
    Simulated(Box<Simulated<'a>>),
    /// A recorded tracker's own output.
    Recorded {
        samples: &'a [Sample<GazeDirection>],
        delay: Nanos,
    },
}

#[derive(Debug)]
pub(crate) struct Simulated<'a> {
    tracker: &'a Tracker,
    truth: Truth<'a>,
    max_gap: Nanos,
    starts: Ticks,
    phase: Nanos,
    processing: Stream,
    noise: Stream,
    /// When the sample before is delivered: samples do not overtake.
    delivered: Nanos,
}

#[derive(Debug)]
enum Truth<'a> {
    Constant(GazeDirection),
    Series(Cursor<'a, GazeDirection>),
}

impl<'a> GazeFeed<'a> {
    /// The feed of `setup` from `begin` on.
    pub(crate) fn new(setup: &Setup<'a>, begin: Nanos) -> Self {
        let truth = match setup.gaze {
            GazeInput::None => return Self::Off,
            GazeInput::Constant(value) => Truth::Constant(value),
            GazeInput::Series(series) => match series.provenance() {
                Provenance::Truth => Truth::Series(Cursor::new(series)),
                Provenance::TrackerOutput { delay } => {
                    let first = series.samples().partition_point(|s| s.t < begin);
                    return Self::Recorded {
                        samples: &series.samples()[first..],
                        delay,
                    };
                }
            },
        };
        let rate = setup.tracker.rate;
        let phase = setup.phases.exposure;
        Self::Simulated(Box::new(Simulated {
            tracker: setup.tracker,
            truth,
            max_gap: setup.max_gap,
            starts: rate.ticks(rate.first_at_or_after(begin - phase)),
            phase,
            processing: Stream::new(setup.seed, Role::Tracker, setup.run),
            noise: Stream::new(setup.seed, Role::GazeNoise, setup.run),
            delivered: begin,
        }))
    }

    /// When the next measurement is made; `None` if there is no more.
    pub(crate) fn next_time(&mut self) -> Option<Nanos> {
        match self {
            Self::Off => None,
            Self::Simulated(s) => s.starts.next().map(|t| s.phase + t),
            Self::Recorded { samples, .. } => samples.first().map(|s| s.t),
        }
    }

    /// Makes the measurement due at `now`, if anything is seen.
    pub(crate) fn measure(&mut self, now: Nanos) -> Option<GazeStamp> {
        match self {
            Self::Off => None,
            Self::Simulated(s) => s.expose(now),
            Self::Recorded { samples, delay } => {
                let (sample, rest) = samples.split_first()?;
                *samples = rest;
                let so = now - *delay;
                let stamp = |value| GazeStamp {
                    exposure_start: so,
                    exposure_end: so,
                    delivered: now,
                    value,
                };
                sample.value.map(stamp)
            }
        }
    }
}

impl Simulated<'_> {
    fn expose(&mut self, start: Nanos) -> Option<GazeStamp> {
        let tracker = self.tracker;
        let end = start + tracker.exposure;
        // Drawn whether or not anything is seen, so that a blink does not change later samples.
        let spread = (tracker.processing_max - tracker.processing_min).0 as u64;
        let processing = tracker.processing_min + Nanos(self.processing.below(spread + 1) as i64);
        let error = self.error();
        let middle = Nanos(start.0 + tracker.exposure.0 / 2);
        let seen = match &mut self.truth {
            Truth::Constant(value) => *value,
            Truth::Series(cursor) => cursor.at(middle, self.max_gap)?,
        };
        self.delivered = (end + processing).max(self.delivered);
        Some(GazeStamp {
            exposure_start: start,
            exposure_end: end,
            delivered: self.delivered,
            value: GazeDirection::new(
                seen.azimuth_deg + error.azimuth_deg,
                seen.elevation_deg + error.elevation_deg,
            ),
        })
    }

    /// Bias to the right, and normal noise on both axes.
    fn error(&mut self) -> GazeDirection {
        let (bias, precision) = (self.tracker.bias_deg, self.tracker.precision_deg);
        if precision == 0.0 {
            return GazeDirection::new(bias, 0.0);
        }
        let right = bias + precision * self.noise.normal();
        GazeDirection::new(right, precision * self.noise.normal())
    }
}

/// Samples on their way to the host.
pub(crate) type InFlight = VecDeque<GazeStamp>;
