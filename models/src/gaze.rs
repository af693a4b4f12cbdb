use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::ModelError;
use crate::math::{atan2, cos, hypot, sin, to_deg, to_rad};

/// Where an eye looks, relative to the head: azimuth to the right, then elevation upwards \[deg\]
/// (Fick angles: the direction is (cos el·sin az, sin el, −cos el·cos az)).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct GazeDirection {
    /// To the right \[deg\].
    pub azimuth_deg: f64,
    /// Upwards \[deg\].
    pub elevation_deg: f64,
}

impl GazeDirection {
    /// Straight ahead.
    pub const AHEAD: Self = Self {
        azimuth_deg: 0.0,
        elevation_deg: 0.0,
    };

    /// From azimuth (right) and elevation (up) \[deg\].
    pub fn new(azimuth_deg: f64, elevation_deg: f64) -> Self {
        Self {
            azimuth_deg,
            elevation_deg,
        }
    }

    /// From a direction of any length above zero, head frame.
    pub fn from_vector(d: DVec3) -> Self {
        Self {
            azimuth_deg: to_deg(atan2(d.x, -d.z)),
            elevation_deg: to_deg(atan2(d.y, hypot(d.x, d.z))),
        }
    }

    /// The unit vector, head frame.
    pub fn vector(self) -> DVec3 {
        let (az, el) = (to_rad(self.azimuth_deg), to_rad(self.elevation_deg));
        DVec3::new(cos(el) * sin(az), sin(el), -cos(el) * cos(az))
    }

    /// The angle to another direction \[deg\].
    pub fn angle_to_deg(self, other: Self) -> f64 {
        angle_deg(self.vector(), other.vector())
    }

    /// On the way from here (`f = 0`) to `other` (`f = 1`), in equal steps of both angles.
    #[must_use]
    pub fn interpolate(self, other: Self, f: f64) -> Self {
        Self {
            azimuth_deg: self.azimuth_deg + (other.azimuth_deg - self.azimuth_deg) * f,
            elevation_deg: self.elevation_deg + (other.elevation_deg - self.elevation_deg) * f,
        }
    }
}

/// The angle between two directions \[deg\]; accurate near 0 and near 180.
pub(crate) fn angle_deg(a: DVec3, b: DVec3) -> f64 {
    to_deg(atan2(a.cross(b).length(), a.dot(b)))
}

/// Whether the sharp region follows the eye.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GazeMode {
    /// The eye tracker moves it.
    #[default]
    Tracked,
    /// It stays at the centre of the display; the eye does not.
    Fixed,
}

impl std::str::FromStr for GazeMode {
    type Err = ModelError;
    fn from_str(s: &str) -> Result<Self, ModelError> {
        match s {
            "tracked" => Ok(Self::Tracked),
            "fixed" => Ok(Self::Fixed),
            _ => Err(crate::unknown_name("gaze mode", s, &["tracked", "fixed"])),
        }
    }
}

impl std::fmt::Display for GazeMode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Tracked => "tracked",
            Self::Fixed => "fixed",
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn angles_and_vectors_agree(az in -179.0f64..179.0, el in -89.0f64..89.0) {
            let g = GazeDirection::new(az, el);
            let back = GazeDirection::from_vector(g.vector() * 3.0);
            prop_assert!((back.azimuth_deg - az).abs() < 1e-11);
            prop_assert!((back.elevation_deg - el).abs() < 1e-11);
            prop_assert!((g.vector().length() - 1.0).abs() < 1e-15 * 4.0);
        }
    }
}
