use thiserror::Error;

use crate::{GazeDirection, ModelError, Nanos, Pose, Rate};

/// One sample of a series; `None` where the device recorded that it had nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<T> {
    /// When.
    pub t: Nanos,
    /// What, or `None` for an explicitly missing sample (blink, lost track).
    pub value: Option<T>,
}

impl<T: Interpolate> Sample<T> {
    /// The value at `t`, at or after this sample and before `next`, the one that follows: linear
    /// between the two. `None` if either is missing, there is no next one, or they are more than
    /// `max_gap` apart; at the very time of this sample its value alone counts.
    pub fn towards(&self, next: Option<&Self>, t: Nanos, max_gap: Nanos) -> Option<T> {
        let value = self.value?;
        if self.t == t {
            return Some(value);
        }
        let next = next?;
        let span = next.t - self.t;
        if span > max_gap {
            return None;
        }
        let f = (t - self.t).0 as f64 / span.0 as f64;
        Some(value.between(next.value?, f))
    }
}

/// What the numbers of a series are.
///
/// The distinction decides whether a replay adds tracker delay: it must to the truth, and must not to
/// something that already went through a tracker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Provenance {
    /// Where the eye or head really was at each time stamp.
    #[default]
    Truth,
    /// What a tracker reported at each time stamp, `delay` after it was so.
    TrackerOutput {
        /// How old the reported state is at its time stamp.
        delay: Nanos,
    },
}

impl std::str::FromStr for Provenance {
    type Err = ModelError;

    /// Reads `truth`, or `tracker:MS` for a tracker's output so many milliseconds late (`ms` may
    /// follow), from 0 to 10,000.
    fn from_str(text: &str) -> Result<Self, ModelError> {
        const LONGEST_MS: f64 = 10_000.0;
        if text == "truth" {
            return Ok(Self::Truth);
        }
        let ms = text
            .strip_prefix("tracker:")
            .map(|ms| ms.trim_end_matches("ms").parse::<f64>());
        match ms {
            Some(Ok(ms)) if (0.0..=LONGEST_MS).contains(&ms) => Ok(Self::TrackerOutput {
                delay: Nanos::from_ms(ms),
            }),
            _ => {
                let valid = "`truth`, or `tracker:MS` with MS from 0 to 10000, as in tracker:12";
                Err(ModelError::range("provenance", text, valid))
            }
        }
    }
}

impl std::fmt::Display for Provenance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Truth => f.write_str("truth"),
            Self::TrackerOutput { delay } => write!(f, "tracker:{}", delay.as_ms()),
        }
    }
}

/// What is wrong with samples offered as a series.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SeriesError {
    /// Time goes backwards.
    #[error("sample {index}: time goes back from {from} to {to}; times must not decrease")]
    TimeReversed {
        /// Index of the sample that is earlier than the one before.
        index: usize,
        /// The time before.
        from: Nanos,
        /// Its time.
        to: Nanos,
    },
    /// There is no sample at all.
    #[error("a series needs at least one sample")]
    Empty,
}

/// Values over time: at least one sample, times never decreasing.
#[derive(Debug, Clone, PartialEq)]
pub struct Series<T> {
    samples: Vec<Sample<T>>,
    provenance: Provenance,
}

/// Gaze relative to the head over time.
pub type GazeSeries = Series<GazeDirection>;
/// `world_from_head` over time.
pub type PoseSeries = Series<Pose>;

/// Values that can be interpolated between samples.
pub trait Interpolate: Copy {
    /// Between `self` (`f = 0`) and `other` (`f = 1`).
    #[must_use]
    fn between(self, other: Self, f: f64) -> Self;
}

impl Interpolate for GazeDirection {
    fn between(self, other: Self, f: f64) -> Self {
        self.interpolate(other, f)
    }
}

impl Interpolate for Pose {
    fn between(self, other: Self, f: f64) -> Self {
        self.interpolate(other, f)
    }
}

impl<T: Interpolate> Series<T> {
    /// A series of `samples`.
    ///
    /// # Errors
    /// If there is none, or time decreases somewhere. Equal times are allowed (real recordings have
    /// them); the later sample wins.
    pub fn new(samples: Vec<Sample<T>>, provenance: Provenance) -> Result<Self, SeriesError> {
        if samples.is_empty() {
            return Err(SeriesError::Empty);
        }
        if let Some(i) = samples.windows(2).position(|w| w[1].t < w[0].t) {
            let (from, to) = (samples[i].t, samples[i + 1].t);
            return Err(SeriesError::TimeReversed {
                index: i + 1,
                from,
                to,
            });
        }
        Ok(Self {
            samples,
            provenance,
        })
    }

    /// All samples, in order.
    pub fn samples(&self) -> &[Sample<T>] {
        &self.samples
    }

    /// Truth, or a tracker's output.
    pub fn provenance(&self) -> Provenance {
        self.provenance
    }

    /// The same samples declared to be something else.
    #[must_use]
    pub fn with_provenance(self, provenance: Provenance) -> Self {
        Self { provenance, ..self }
    }

    /// Time of the first sample.
    pub fn start(&self) -> Nanos {
        self.samples[0].t
    }

    /// Time of the last sample.
    pub fn end(&self) -> Nanos {
        self.samples[self.samples.len() - 1].t
    }

    /// Index of the last sample at or before `t`.
    pub fn index_at(&self, t: Nanos) -> Option<usize> {
        self.samples.partition_point(|s| s.t <= t).checked_sub(1)
    }

    /// The value at `t`, linear between the samples around it; `None` outside the series, next to a
    /// missing sample, or inside a hole longer than `max_gap`.
    pub fn at(&self, t: Nanos, max_gap: Nanos) -> Option<T> {
        let i = self.index_at(t)?;
        self.samples[i].towards(self.samples.get(i + 1), t, max_gap)
    }

    /// The value of the last sample at or before `t` that is present and not older than `max_age`,
    /// with its time: what a program sees that keeps the newest valid sample.
    pub fn latest(&self, t: Nanos, max_age: Nanos) -> Option<(Nanos, T)> {
        self.samples[..=self.index_at(t)?]
            .iter()
            .rev()
            .take_while(|s| t - s.t <= max_age)
            .find_map(|s| s.value.map(|v| (s.t, v)))
    }
}

/// What was recorded of one person in one sitting.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recording {
    /// Where it comes from: a file name, or how it was synthesised.
    pub source: String,
    /// The format it was read from.
    pub format: String,
    /// Gaze relative to the head.
    pub gaze: Option<GazeSeries>,
    /// How often gaze was sampled, where the file says so.
    pub gaze_rate: Option<Rate>,
    /// Head pose.
    pub pose: Option<PoseSeries>,
    /// What the reader had to repair, skip or assume; one sentence each, shown in reports.
    pub notes: Vec<String>,
}

impl Recording {
    /// First and last time of any sample; `None` for an empty recording.
    pub fn span(&self) -> Option<(Nanos, Nanos)> {
        let gaze = self.gaze.as_ref().map(|s| (s.start(), s.end()));
        let pose = self.pose.as_ref().map(|s| (s.start(), s.end()));
        match (gaze, pose) {
            (Some(a), Some(b)) => Some((a.0.min(b.0), Ord::max(a.1, b.1))),
            (a, b) => a.or(b),
        }
    }
}

#[cfg(test)]
mod tests;
