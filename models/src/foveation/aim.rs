use std::fmt;

use crate::error::in_range;
use crate::{GazeDirection, ModelError};

/// Whether a method follows the gaze, written `tracked` (the default), `fixed` or `fixed=DEG`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Aim {
    /// The sharpest part is where the eye looks.
    #[default]
    Tracked,
    /// The sharpest part stays straight ahead of the head, and is as sharp as the eye wherever that
    /// looks within `reach_deg` of straight ahead: the same quality as a tracked method has, for an
    /// eye that turns no farther.
    Fixed {
        /// How far the eye turns away from straight ahead \[deg\], 0 to 90.
        reach_deg: f64,
    },
}

impl Aim {
    /// How far eyes turn from straight ahead unless one says otherwise \[deg\]. Of saccades made in
    /// everyday surroundings 86 % are no larger (Bahill, Adler & Stark 1975, "Most naturally occurring
    /// human saccades have magnitudes of 15 degrees or less"): beyond, the head turns along. That eyes
    /// stay within it is an assumption, not a measurement of viewers in headsets.
    pub const DEFAULT_REACH_DEG: f64 = 15.0;

    /// Fixed, with the default reach.
    pub const FIXED: Self = Self::Fixed {
        reach_deg: Self::DEFAULT_REACH_DEG,
    };

    /// Where the sharpest part belongs for an eye that looks towards `gaze`.
    pub fn gaze(self, gaze: GazeDirection, ahead: GazeDirection) -> GazeDirection {
        match self {
            Self::Tracked => gaze,
            Self::Fixed { .. } => ahead,
        }
    }

    /// How far the eye may be from the sharpest part \[deg\], at most 90: the margin of a method that
    /// is aimed there.
    pub fn margin_deg(self, margin_deg: f64) -> f64 {
        (margin_deg + self.reach_deg()).min(90.0)
    }

    /// How far the eye turns from the sharpest part \[deg\]: 0 if that follows it.
    pub fn reach_deg(self) -> f64 {
        match self {
            Self::Tracked => 0.0,
            Self::Fixed { reach_deg } => reach_deg,
        }
    }

    /// Reads a setting; `None` if it is about something else.
    pub(super) fn read(key: &str, value: Option<&str>) -> Option<Result<Self, ModelError>> {
        match (key, value) {
            ("tracked", None) => Some(Ok(Self::Tracked)),
            ("fixed", None) => Some(Ok(Self::FIXED)),
            ("fixed", Some(text)) => {
                let reach_deg = text.parse().unwrap_or(f64::NAN);
                let valid = "degrees from 0 to 90, as in fixed=15";
                let reach_deg = in_range("fixed", reach_deg, 0.0..=90.0)
                    .map_err(|_| ModelError::range("fixed", text, valid));
                Some(reach_deg.map(|reach_deg| Self::Fixed { reach_deg }))
            }
            _ => None,
        }
    }
}

impl fmt::Display for Aim {
    /// As a setting with its colon; nothing if tracked.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Tracked => Ok(()),
            Self::FIXED => f.write_str(":fixed"),
            Self::Fixed { reach_deg } => write!(f, ":fixed={reach_deg}"),
        }
    }
}
