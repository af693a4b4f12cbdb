use foveasim_models::{ModelError, Nanos};
use thiserror::Error;

/// Why a recording cannot be replayed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The parts of the runtime's loop do not fit each other.
    #[error(transparent)]
    Runtime(ModelError),
    /// A setting of the head's predictor or of its sampling is out of range.
    #[error(transparent)]
    Head(ModelError),
    /// Nothing was recorded.
    #[error("{origin}: no samples at all; a replay needs gaze or head poses")]
    Empty {
        /// The recording.
        origin: String,
    },
    /// The gaze should steer the fovea, but there is none.
    #[error(
        "{origin}: {what}; replay it with a fixed fovea (gaze mode `fixed`) or use another one"
    )]
    NoGaze {
        /// The recording.
        origin: String,
        /// What is missing.
        what: &'static str,
    },
    /// Its duration is of no use.
    #[error("{origin}: lasts {seconds} s; must be {valid}")]
    Duration {
        /// The recording.
        origin: String,
        /// How long it lasts \[s\].
        seconds: f64,
        /// What would be valid.
        valid: String,
    },
    /// It says that its tracker reported impossibly late.
    #[error("{origin}: a tracker delay of {delay}; must be from 0 to 10000 ms")]
    Delay {
        /// The recording.
        origin: String,
        /// The delay it states.
        delay: Nanos,
    },
    /// It cannot be read any more while it is replayed.
    #[error("{0}")]
    Reading(String),
    /// Its time stamps cannot be computed with.
    #[error("{origin}: time stamps from {first} to {last} ns; must be within ±4e18 ns (126 years)")]
    Time {
        /// The recording.
        origin: String,
        /// The first time stamp \[ns\].
        first: i64,
        /// The last time stamp \[ns\].
        last: i64,
    },
}
