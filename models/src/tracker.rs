use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::error::in_range;
use crate::presets::Source;
use crate::{ModelError, Nanos, Rate};

/// An eye tracker as people write it (TOML).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrackerSpec {
    /// Short name, as given to `--tracker`.
    pub name: String,
    /// Full name.
    #[serde(default)]
    pub title: String,
    /// Samples per second \[Hz\], from 1 to 100,000.
    pub rate_hz: f64,
    /// How long one sample's exposure lasts \[ms\].
    pub exposure_ms: f64,
    /// Shortest and longest time from the end of exposure to the sample being delivered \[ms\].
    pub processing_ms: [f64; 2],
    /// Constant offset of the reported gaze (accuracy) \[deg\], applied to the right.
    #[serde(default)]
    pub bias_deg: f64,
    /// Standard deviation of the reported gaze about its mean (precision), each axis \[deg\].
    #[serde(default)]
    pub precision_deg: f64,
    /// Where each number comes from, by field name.
    #[serde(default)]
    pub sources: BTreeMap<String, Source>,
}

/// A valid eye tracker.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracker {
    /// Short name.
    pub name: String,
    /// Full name.
    pub title: String,
    /// Exposure starts this often.
    pub rate: Rate,
    /// How long an exposure lasts.
    pub exposure: Nanos,
    /// Shortest time from the end of exposure to delivery.
    pub processing_min: Nanos,
    /// Longest time from the end of exposure to delivery.
    pub processing_max: Nanos,
    /// Offset of the reported gaze to the right \[deg\].
    pub bias_deg: f64,
    /// Standard deviation of the reported gaze, each axis \[deg\].
    pub precision_deg: f64,
}

impl TryFrom<TrackerSpec> for Tracker {
    type Error = ModelError;

    fn try_from(spec: TrackerSpec) -> Result<Self, ModelError> {
        let [min, max] = spec.processing_ms;
        for ms in [min, max] {
            in_range("processing_ms", ms, 0.0..=10_000.0)?;
        }
        if max < min {
            let value = format!("[{min}, {max}]");
            return Err(ModelError::range(
                "processing_ms",
                value,
                "[shortest, longest]",
            ));
        }
        in_range("rate_hz", spec.rate_hz, 1.0..=100_000.0)?;
        in_range("exposure_ms", spec.exposure_ms, 0.0..=10_000.0)?;
        in_range("bias_deg", spec.bias_deg, -90.0..=90.0)?;
        in_range("precision_deg", spec.precision_deg, 0.0..=90.0)?;
        Ok(Self {
            name: spec.name,
            title: spec.title,
            rate: Rate::from_hz("rate_hz", spec.rate_hz)?,
            exposure: Nanos::from_ms(spec.exposure_ms),
            processing_min: Nanos::from_ms(min),
            processing_max: Nanos::from_ms(max),
            bias_deg: spec.bias_deg,
            precision_deg: spec.precision_deg,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_that_no_tracker_has() {
        let build = |rate_hz| {
            Tracker::try_from(TrackerSpec {
                name: "t".into(),
                title: String::new(),
                rate_hz,
                exposure_ms: 1.0,
                processing_ms: [1.0, 2.0],
                bias_deg: 0.0,
                precision_deg: 0.0,
                sources: BTreeMap::new(),
            })
        };
        for hz in [1.0, 100_000.0] {
            assert!(build(hz).is_ok(), "{hz}");
        }
        for hz in [0.0, 0.001, 0.999, 100_001.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = build(hz).unwrap_err().to_string();
            let want = format!("rate_hz = {hz}: must be a number from 1 to 100000");
            assert_eq!(error, want);
        }
    }
}
