use foveasim_models::math::{mean, quantile_sorted, sqrt};
use foveasim_models::{
    GazeDirection, Interpolate, Nanos, Pose, Provenance, Rate, Recording, Series,
};

use crate::interval::{intervals_ms, usual_interval_ms};

/// What `trace info` says about a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceInfo {
    /// Gaze, if there is any.
    pub gaze: Option<SeriesInfo>,
    /// Head pose, if there is any.
    pub pose: Option<SeriesInfo>,
}

/// One series in numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct SeriesInfo {
    /// What the values are.
    pub provenance: Provenance,
    /// Samples, missing ones included.
    pub samples: usize,
    /// Samples without a value.
    pub missing: usize,
    /// Samples with the time of the one before.
    pub duplicates: usize,
    /// From the first sample to the last.
    pub duration: Nanos,
    /// As the file states it, else one over the median interval \[Hz\]; NaN for fewer than two samples, as all of
    /// these are.
    pub rate_hz: f64,
    /// Quartile distance of the intervals \[ms\].
    pub interval_iqr_ms: f64,
    /// Standard deviation of the intervals that are not gaps \[ms\].
    pub interval_sd_ms: f64,
    /// Intervals over three times the usual one: that of the rate.
    pub gaps: usize,
    /// The longest interval.
    pub longest_gap: Nanos,
    /// Longest run of missing samples, from the last value before it to the first after it (or the
    /// end of the series).
    pub longest_loss: Nanos,
    /// Smallest and largest value of each coordinate, with its name and unit.
    pub extents: Vec<(&'static str, f64, f64)>,
    /// 1 % quantile of the angles between neighbouring values that differ at all \[deg\]: about the
    /// step in which angles come where they were rounded, and otherwise a small movement.
    pub angle_step_deg: f64,
}

/// Describes a recording.
pub fn info(recording: &Recording) -> TraceInfo {
    TraceInfo {
        gaze: recording
            .gaze
            .as_ref()
            .map(|gaze| describe(gaze, recording.gaze_rate)),
        pose: recording.pose.as_ref().map(|pose| describe(pose, None)),
    }
}

/// What the description needs of a value.
trait Described: Interpolate {
    fn coordinates(self) -> Vec<(&'static str, f64)>;
    fn angle_deg(self, other: Self) -> f64;
}

impl Described for GazeDirection {
    fn coordinates(self) -> Vec<(&'static str, f64)> {
        vec![
            ("azimuth_deg", self.azimuth_deg),
            ("elevation_deg", self.elevation_deg),
        ]
    }

    fn angle_deg(self, other: Self) -> f64 {
        self.angle_to_deg(other)
    }
}

impl Described for Pose {
    fn coordinates(self) -> Vec<(&'static str, f64)> {
        let forward = GazeDirection::from_vector(self.direction(glam::DVec3::NEG_Z));
        let p = self.position;
        vec![
            ("x_m", p.x),
            ("y_m", p.y),
            ("z_m", p.z),
            ("yaw_deg", forward.azimuth_deg),
            ("pitch_deg", forward.elevation_deg),
        ]
    }

    fn angle_deg(self, other: Self) -> f64 {
        self.angle_to_deg(other)
    }
}

/// Of samples taken at a `stated` rate, or else one that the median interval gives.
fn describe<T: Described>(series: &Series<T>, stated: Option<Rate>) -> SeriesInfo {
    let samples = series.samples();
    let intervals = intervals_ms(series);
    let duplicates = samples.len().saturating_sub(1) - intervals.len();
    let usual = usual_interval_ms(series, stated);
    let regular = intervals.partition_point(|ms| *ms <= 3.0 * usual);
    SeriesInfo {
        provenance: series.provenance(),
        samples: samples.len(),
        missing: samples.iter().filter(|s| s.value.is_none()).count(),
        duplicates,
        duration: series.end() - series.start(),
        rate_hz: 1e3 / usual,
        interval_iqr_ms: quantile_sorted(&intervals, 0.75) - quantile_sorted(&intervals, 0.25),
        interval_sd_ms: deviation(&intervals[..regular]),
        gaps: intervals.len() - regular,
        longest_gap: samples
            .windows(2)
            .map(|w| w[1].t - w[0].t)
            .max()
            .unwrap_or_default(),
        longest_loss: longest_loss(series),
        extents: extents(series),
        angle_step_deg: angle_step(series),
    }
}

fn deviation(values: &[f64]) -> f64 {
    let centre = mean(values);
    sqrt(mean(
        &values
            .iter()
            .map(|v| (v - centre) * (v - centre))
            .collect::<Vec<_>>(),
    ))
}

fn longest_loss<T: Described>(series: &Series<T>) -> Nanos {
    let (mut longest, mut since, mut lost) = (Nanos::ZERO, series.start(), false);
    for sample in series.samples() {
        if lost {
            longest = longest.max(sample.t - since);
        }
        lost = sample.value.is_none();
        if !lost {
            since = sample.t;
        }
    }
    longest
}

fn extents<T: Described>(series: &Series<T>) -> Vec<(&'static str, f64, f64)> {
    let mut extents: Vec<(&'static str, f64, f64)> = Vec::new();
    for value in series.samples().iter().filter_map(|s| s.value) {
        let coordinates = value.coordinates();
        if extents.is_empty() {
            extents = coordinates
                .iter()
                .map(|(name, v)| (*name, *v, *v))
                .collect();
        }
        for ((_, low, high), (_, v)) in extents.iter_mut().zip(coordinates) {
            *low = low.min(v);
            *high = high.max(v);
        }
    }
    extents
}

fn angle_step<T: Described>(series: &Series<T>) -> f64 {
    // Below this an angle is the rounding of the arithmetic.
    const ZERO_DEG: f64 = 1e-6;
    let pairs = series
        .samples()
        .windows(2)
        .filter_map(|w| w[0].value.zip(w[1].value));
    let mut steps: Vec<f64> = pairs
        .map(|(a, b)| a.angle_deg(b))
        .filter(|a| *a > ZERO_DEG)
        .collect();
    steps.sort_by(f64::total_cmp);
    quantile_sorted(&steps, 0.01)
}
