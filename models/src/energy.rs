use serde::{Deserialize, Serialize};

use crate::error::in_range;
use crate::{FrameWork, ModelError};

/// Energy from counts: what a frame takes whatever it draws, and coefficients times work and what is sent to the
/// display. Nothing here is known of a machine until somebody measures it: what is left out counts as 0.
///
/// A nanojoule a sample is a millijoule for a million of them.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EnergyProfile {
    /// Of a frame, whatever its samples \[mJ\].
    pub fixed_mj: f64,
    /// Of shading one sample \[nJ\].
    pub per_sample_nj: f64,
    /// Of finding what is visible in one sample \[nJ\].
    pub per_visible_sample_nj: f64,
    /// Of reconstructing one display pixel \[nJ\].
    pub per_pixel_nj: f64,
    /// Of a pass, whatever its samples: its geometry \[mJ\].
    pub per_pass_mj: f64,
    /// Of 10⁹ bits on the link to the display, as compressed \[mJ\].
    pub per_gbit_mj: f64,
}

impl EnergyProfile {
    fn coefficients(&self) -> [(&'static str, f64); 6] {
        [
            ("energy.fixed_mj", self.fixed_mj),
            ("energy.per_sample_nj", self.per_sample_nj),
            ("energy.per_visible_sample_nj", self.per_visible_sample_nj),
            ("energy.per_pixel_nj", self.per_pixel_nj),
            ("energy.per_pass_mj", self.per_pass_mj),
            ("energy.per_gbit_mj", self.per_gbit_mj),
        ]
    }

    /// Checks that every number is in range, and one of them above 0.
    ///
    /// # Errors
    /// Names the number that is not, and what would be valid.
    pub fn validate(&self) -> Result<(), ModelError> {
        for (name, value) in self.coefficients() {
            in_range(name, value, 0.0..=1e9)?;
        }
        match self.coefficients().iter().any(|(_, value)| *value > 0.0) {
            true => Ok(()),
            false => Err(ModelError::range(
                "energy",
                "0 for everything",
                "left out where nothing is known, or one number above 0 at least",
            )),
        }
    }

    /// What a frame takes that sends so many bits to the display \[mJ\].
    pub fn frame_mj(&self, work: &FrameWork, link_gbit: f64) -> f64 {
        let samples = self.per_sample_nj * work.samples_shaded
            + self.per_visible_sample_nj * work.samples
            + self.per_pixel_nj * work.pixels_resolved;
        self.fixed_mj
            + samples * 1e-6
            + self.per_pass_mj * work.passes
            + self.per_gbit_mj * link_gbit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::presets;

    const TEXT: &str = "name = 'x'\nfixed_ms = 1\nper_sample_ns = 10\n[energy]\n";

    #[test]
    fn each_coefficient_counts_its_own_work() {
        let work = FrameWork {
            samples_shaded: 1e6,
            samples: 2e6,
            pixels_resolved: 4e6,
            passes: 3.0,
        };
        // Of a million each, and of the others: 1, 2, 4 million, 3 passes and 0.5 Gbit.
        for (line, want) in [
            ("fixed_mj = 7", 7.0),
            ("per_sample_nj = 5", 5.0),
            ("per_visible_sample_nj = 5", 10.0),
            ("per_pixel_nj = 5", 20.0),
            ("per_pass_mj = 5", 15.0),
            ("per_gbit_mj = 5", 2.5),
            ("fixed_mj = 7\nper_gbit_mj = 5", 9.5),
        ] {
            let profile = presets::parse_cost(&format!("{TEXT}{line}"), "x").unwrap();
            let energy = profile.energy.unwrap();
            let got = energy.frame_mj(&work, 0.5);
            assert!((got - want).abs() < 1e-12, "{line}: {got}");
        }
    }

    #[test]
    fn what_cannot_be_an_energy_is_named() {
        for (line, expect) in [
            ("fixed_mj = -1", "energy.fixed_mj = -1"),
            ("per_sample_nj = nan", "energy.per_sample_nj = NaN"),
            ("per_gbit_mj = 1e12", "energy.per_gbit_mj"),
            ("per_pass_nj = 1", "per_pass_nj"),
            ("", "left out where nothing is known"),
        ] {
            let error = presets::parse_cost(&format!("{TEXT}{line}"), "x").unwrap_err();
            let error = error.to_string();
            assert!(error.contains(expect), "{line}: {error}");
        }
        assert_eq!(presets::cost("guenter2012").unwrap().energy, None);
    }
}
