mod bias;
mod loss;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use bias::{BiasMap, BiasMapSpec};
pub use loss::{Loss, LossSpec, Losses};

use crate::error::in_range;
use crate::presets::Source;
use crate::{Durations, ModelError, Nanos, Rate};

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
    /// Shortest and longest time from the end of exposure to the sample being ready \[ms\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub processing_ms: Option<[f64; 2]>,
    /// Measured times of that instead \[ms\]; each sample takes one of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub processing_measured_ms: Vec<f64>,
    /// Shortest and longest time on the way to the host \[ms\].
    #[serde(default, skip_serializing_if = "nothing")]
    pub transport_ms: [f64; 2],
    /// Constant offset of the reported gaze (accuracy) \[deg\], applied to the right.
    #[serde(default)]
    pub bias_deg: f64,
    /// Standard deviation of the reported gaze about its mean (precision), each axis \[deg\].
    #[serde(default)]
    pub precision_deg: f64,
    /// How far the headset slips on the face: a random walk whose standard deviation on each axis
    /// grows to this within a minute \[deg/√min\].
    #[serde(default, skip_serializing_if = "zero")]
    pub slippage_deg_per_sqrt_min: f64,
    /// Systematic error over the field of gaze, besides `bias_deg`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias_map: Option<BiasMapSpec>,
    /// Short losses of track.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dropouts: Option<LossSpec>,
    /// Blinks of the viewer, where the gaze that is tracked has none of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blinks: Option<LossSpec>,
    /// Where each number comes from, by field name.
    #[serde(default)]
    pub sources: BTreeMap<String, Source>,
}

fn nothing(range: &[f64; 2]) -> bool {
    *range == [0.0; 2]
}

fn zero(number: &f64) -> bool {
    *number == 0.0
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
    /// From the end of exposure until a sample is ready.
    pub processing: Durations,
    /// From there until the host has it.
    pub transport: Durations,
    /// Offset of the reported gaze to the right \[deg\].
    pub bias_deg: f64,
    /// Standard deviation of the reported gaze, each axis \[deg\].
    pub precision_deg: f64,
    /// Random walk of the headset on the face, each axis \[deg/√min\].
    pub slippage_deg_per_sqrt_min: f64,
    /// Systematic error over the field of gaze.
    pub bias_map: Option<BiasMap>,
    /// Short losses of track.
    pub dropouts: Option<Loss>,
    /// Blinks.
    pub blinks: Option<Loss>,
}

impl Tracker {
    /// The same tracker without error in what it reports; when it reports is unchanged.
    #[must_use]
    pub fn exact(self) -> Self {
        Self {
            bias_deg: 0.0,
            precision_deg: 0.0,
            slippage_deg_per_sqrt_min: 0.0,
            bias_map: None,
            ..self
        }
    }

    /// The longest time for which it can see nothing.
    pub fn longest_loss(&self) -> Nanos {
        [&self.dropouts, &self.blinks]
            .into_iter()
            .flatten()
            .map(|loss| loss.lasts.max())
            .fold(Nanos::ZERO, Nanos::max)
    }
}

impl TryFrom<TrackerSpec> for Tracker {
    type Error = ModelError;

    fn try_from(spec: TrackerSpec) -> Result<Self, ModelError> {
        let processing = match (spec.processing_ms, spec.processing_measured_ms.as_slice()) {
            (Some(range), []) => Durations::uniform("processing_ms", range)?,
            (None, []) => {
                let valid = "a range, or give processing_measured_ms";
                return Err(ModelError::range("processing_ms", "nothing", valid));
            }
            (None, measured) => Durations::measured("processing_measured_ms", measured)?,
            (Some([min, max]), _) => {
                let value = format!("[{min}, {max}]");
                let valid = "absent beside processing_measured_ms, which takes its place";
                return Err(ModelError::range("processing_ms", value, valid));
            }
        };
        let slippage = spec.slippage_deg_per_sqrt_min;
        in_range("slippage_deg_per_sqrt_min", slippage, 0.0..=90.0)?;
        let loss = |field, loss: &Option<LossSpec>| match loss {
            None => Ok(None),
            Some(spec) => spec.build(field),
        };
        in_range("rate_hz", spec.rate_hz, 1.0..=100_000.0)?;
        in_range("exposure_ms", spec.exposure_ms, 0.0..=10_000.0)?;
        in_range("bias_deg", spec.bias_deg, -90.0..=90.0)?;
        in_range("precision_deg", spec.precision_deg, 0.0..=90.0)?;
        Ok(Self {
            name: spec.name,
            title: spec.title,
            rate: Rate::from_hz("rate_hz", spec.rate_hz)?,
            exposure: Nanos::from_ms(spec.exposure_ms),
            processing,
            transport: Durations::uniform("transport_ms", spec.transport_ms)?,
            bias_deg: spec.bias_deg,
            precision_deg: spec.precision_deg,
            slippage_deg_per_sqrt_min: slippage,
            dropouts: loss("dropouts", &spec.dropouts)?,
            blinks: loss("blinks", &spec.blinks)?,
            bias_map: spec.bias_map.map(BiasMap::try_from).transpose()?,
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
                processing_ms: Some([1.0, 2.0]),
                bias_deg: 0.0,
                precision_deg: 0.0,
                processing_measured_ms: Vec::new(),
                transport_ms: [0.0; 2],
                slippage_deg_per_sqrt_min: 0.0,
                bias_map: None,
                dropouts: None,
                blinks: None,
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

    #[test]
    fn processing_is_a_range_or_measured() {
        let build = |processing: &str| {
            let text = format!("name = 't'\nrate_hz = 100\nexposure_ms = 1\n{processing}");
            let spec: TrackerSpec = toml::from_str(&text).unwrap();
            Tracker::try_from(spec).map_err(|e| e.to_string())
        };
        let measured = build("processing_measured_ms = [8, 9, 11]")
            .unwrap()
            .processing;
        assert_eq!(measured.min(), Nanos::from_ms(8.0));
        assert_eq!(measured.max(), Nanos::from_ms(11.0));
        assert!(build("processing_ms = [1, 2]").is_ok());
        let neither = build("").unwrap_err();
        assert!(neither.contains("processing_ms = nothing"), "{neither}");
        let both = build("processing_ms = [1, 2]\nprocessing_measured_ms = [3]").unwrap_err();
        assert!(
            both.contains("processing_ms = [1, 2]: must be absent"),
            "{both}"
        );
    }
}
