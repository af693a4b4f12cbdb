use serde::{Deserialize, Serialize};

use crate::ModelError;
use crate::error::{in_range, unknown_name};

/// Smallest resolvable angle at the fovea \[deg/cycle\]: 48 cycles per degree (Guenter 2012, §3).
pub const OMEGA_0_DEG: f64 = 1.0 / 48.0;
/// Acuity slope A \[deg/cycle per deg\]: unnoticed in a slow ramp (Guenter 2012, §5).
pub const SLOPE_A: f64 = 0.0275;
/// Acuity slope B: judged equal to full resolution in pairs (Guenter 2012, §5).
pub const SLOPE_B: f64 = 0.0220;
/// Slope times quality index: m = 0.33/j, inferred from j = 12 ↔ slope A and j = 15 ↔ slope B.
pub const QUALITY_INDEX_DEG: f64 = 0.33;

/// How the minimum angle of resolution grows away from where one looks: ω(e) = m·e + ω₀
/// (Guenter 2012, Eq. 1). Slopes were measured within 23.4° of the centre; beyond is extrapolation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Acuity {
    slope: f64,
    omega_0_deg: f64,
}

impl Acuity {
    /// The eccentricity up to which Guenter's subjects could see the display \[deg\].
    pub const MEASURED_TO_DEG: f64 = 23.37;

    /// An acuity line with `slope` \[deg/cycle per deg\] and ω₀ = 1/48 deg/cycle.
    ///
    /// # Errors
    /// If `slope` is not from 0 to 10.
    pub fn new(slope: f64) -> Result<Self, ModelError> {
        Self::with_foveal(slope, OMEGA_0_DEG)
    }

    /// An acuity line with its own foveal limit `omega_0_deg` \[deg/cycle\].
    ///
    /// # Errors
    /// If `slope` is not from 0 to 10, or `omega_0_deg` not from 1e-6 to 90.
    pub fn with_foveal(slope: f64, omega_0_deg: f64) -> Result<Self, ModelError> {
        in_range("slope [deg/cycle per deg]", slope, 0.0..=10.0)?;
        in_range("omega_0 [deg/cycle]", omega_0_deg, 1e-6..=90.0)?;
        Ok(Self { slope, omega_0_deg })
    }

    /// Reads `a` or `guenter-a`, `b` or `guenter-b`, a quality index `j:12`, or a number.
    ///
    /// # Errors
    /// If the text is none of these or the number is out of range.
    pub fn parse(text: &str) -> Result<Self, ModelError> {
        match text {
            "a" | "guenter-a" => return Self::new(SLOPE_A),
            "b" | "guenter-b" => return Self::new(SLOPE_B),
            _ => {}
        }
        if let Some(index) = text.strip_prefix("j:") {
            let j: f64 = index
                .parse()
                .map_err(|_| ModelError::range("quality index j", index, "a number, as in j:12"))?;
            return Self::from_quality_index(j);
        }
        match text.parse::<f64>() {
            Ok(slope) => Self::new(slope),
            Err(_) => Err(unknown_name(
                "acuity slope",
                text,
                &[
                    "guenter-a",
                    "guenter-b",
                    "j:INDEX",
                    "a number such as 0.0275",
                ],
            )),
        }
    }

    /// The slope of Guenter's foveation quality index `j` (4 coarse … 22 fine): 0.33/j.
    ///
    /// # Errors
    /// If `j` is not from 0.033 to 1e6.
    pub fn from_quality_index(j: f64) -> Result<Self, ModelError> {
        in_range("quality index j", j, 0.033..=1e6)?;
        Self::new(QUALITY_INDEX_DEG / j)
    }

    /// m \[deg/cycle per deg\].
    pub fn slope(self) -> f64 {
        self.slope
    }

    /// ω₀ \[deg/cycle\].
    pub fn omega_0_deg(self) -> f64 {
        self.omega_0_deg
    }

    /// The minimum angle of resolution ω at eccentricity `e_deg` \[deg/cycle\]; below zero counts as 0.
    pub fn mar_deg(self, e_deg: f64) -> f64 {
        self.slope * e_deg.max(0.0) + self.omega_0_deg
    }
}

impl Default for Acuity {
    /// Slope A.
    fn default() -> Self {
        Self {
            slope: SLOPE_A,
            omega_0_deg: OMEGA_0_DEG,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_numbers_and_indices() {
        assert_eq!(Acuity::parse("guenter-b").unwrap().slope(), SLOPE_B);
        assert_eq!(Acuity::parse("j:12").unwrap().slope(), 0.0275);
        assert_eq!(Acuity::parse("0.03").unwrap().slope(), 0.03);
        for bad in ["nan", "-1", "inf", "j:", "j:0", "guenter-c", ""] {
            assert!(Acuity::parse(bad).is_err(), "{bad}");
        }
    }
}
