//! Synthetic recordings: a person who looks about, as the truth.

mod gaze;
mod head;

use foveasim_models::{Nanos, PoseSeries, Provenance, Rate, Recording, Sample, Series};

use crate::TraceError;
use crate::check::require_pose;
use crate::error::option_in;
use gaze::GazePath;
use head::{Head, HeadPath};

/// The most samples that one synthetic or resampled series may have.
pub(crate) const MAX_SAMPLES: f64 = 2e7;

/// What to synthesise. The same specification gives the same bytes on every machine; sampling the
/// same seed at another rate gives other samples of the same movement.
#[derive(Debug, Clone, PartialEq)]
pub struct SynthSpec {
    /// Chooses the movement.
    pub seed: u64,
    /// Length; samples lie in `0..duration`.
    pub duration: Nanos,
    /// Gaze samples per second \[Hz\]; 500 or more keep the shape of saccades.
    pub gaze_rate_hz: f64,
    /// Head-pose samples per second \[Hz\].
    pub pose_rate_hz: f64,
    /// How far from straight ahead saccades land, to each side and up or down \[deg\].
    pub field_deg: [f64; 2],
    /// Mean duration of a fixation \[ms\].
    pub fixation_ms: f64,
    /// Mean amplitude of saccades before those that would leave the field are drawn again \[deg\].
    pub amplitude_deg: f64,
    /// Blinks per minute, each 100 to 200 ms without samples' values; 0 for none.
    pub blinks_per_minute: f64,
    /// Root mean square of head yaw \[deg\]; pitch has 2/5 and roll 1/5 of it. 0 keeps it straight.
    pub head_yaw_deg: f64,
    /// Root mean square of head movement along each axis \[m\].
    pub head_sway_m: f64,
}

impl Default for SynthSpec {
    /// Ten seconds of free viewing: fixations of 250 ms, saccades of some 6° inside ±20° × ±15°,
    /// 12 blinks a minute, a head that turns 12° (RMS).
    fn default() -> Self {
        Self {
            seed: 1,
            duration: Nanos(10_000_000_000),
            gaze_rate_hz: 1000.0,
            pose_rate_hz: 500.0,
            field_deg: [20.0, 15.0],
            fixation_ms: 250.0,
            amplitude_deg: 6.0,
            blinks_per_minute: 12.0,
            head_yaw_deg: 12.0,
            head_sway_m: 0.03,
        }
    }
}

impl SynthSpec {
    fn validate(&self) -> Result<(Rate, Rate), TraceError> {
        let seconds = self.duration.as_secs();
        option_in("duration_s", seconds, 1e-3..=86_400.0)?;
        option_in("fixation_ms", self.fixation_ms, 50.0..=10_000.0)?;
        option_in("amplitude_deg", self.amplitude_deg, 0.1..=45.0)?;
        option_in("blinks_per_minute", self.blinks_per_minute, 0.0..=120.0)?;
        option_in("head_yaw_deg", self.head_yaw_deg, 0.0..=60.0)?;
        option_in("head_sway_m", self.head_sway_m, 0.0..=10.0)?;
        for half in self.field_deg {
            option_in("field_deg", half, 1.0..=60.0)?;
        }
        let rate = |field, hz: f64| {
            option_in(field, hz, 1.0..=100_000.0)?;
            if hz * seconds > MAX_SAMPLES {
                let valid = format!("at most {} for {seconds} s", MAX_SAMPLES / seconds);
                return Err(TraceError::option(field, hz, valid));
            }
            Rate::from_hz(field, hz).map_err(|e| TraceError::option(field, hz, e.to_string()))
        };
        Ok((
            rate("gaze_rate_hz", self.gaze_rate_hz)?,
            rate("pose_rate_hz", self.pose_rate_hz)?,
        ))
    }
}

/// Synthesises a recording: gaze by fixations and saccades on the main sequence, smooth head motion,
/// and eyes that hold their target while the head turns.
///
/// # Errors
/// If a number of the specification is out of range; the error names it.
pub fn synth(spec: &SynthSpec) -> Result<Recording, TraceError> {
    let (gaze_rate, pose_rate) = spec.validate()?;
    let head_path = HeadPath::new(spec);
    let head = Head::Path(&head_path);
    let mut path = GazePath::new(spec, &head);
    let ticks = |rate: Rate| (0..rate.first_at_or_after(spec.duration)).map(move |k| rate.tick(k));
    let gaze = ticks(gaze_rate)
        .map(|t| Sample {
            t,
            value: path.at(t, &head),
        })
        .collect();
    let pose = ticks(pose_rate)
        .map(|t| Sample {
            t,
            value: Some(head.at(t)),
        })
        .collect();
    let series = |e: foveasim_models::SeriesError| {
        TraceError::option("duration_s", spec.duration.as_secs(), e.to_string())
    };
    Ok(Recording {
        source: format!("synthetic, seed {}", spec.seed),
        format: "synthetic".into(),
        gaze: Some(Series::new(gaze, Provenance::Truth).map_err(series)?),
        gaze_rate: None,
        pose: Some(Series::new(pose, Provenance::Truth).map_err(series)?),
        notes: Vec::new(),
    })
}

/// The recording with synthetic gaze instead of its own: for one whose eye tracking failed.
///
/// The eyes move as in [`synth`], and hold their targets against the recorded head motion. Of `spec`
/// only what concerns the eyes counts; the recording's head pose gives the time. A note says so.
///
/// # Errors
/// If the recording has no head pose, or a number of the specification is out of range.
pub fn with_synthetic_gaze(
    recording: &Recording,
    spec: &SynthSpec,
) -> Result<Recording, TraceError> {
    let series = require_pose(recording)?;
    let duration = series.end() - series.start() + Nanos(1);
    let spec = SynthSpec {
        duration: duration.max(Nanos(1_000_000)),
        pose_rate_hz: 1.0,
        ..spec.clone()
    };
    let (rate, _) = spec.validate()?;
    let head = Head::Recorded(series);
    let mut path = GazePath::new(&spec, &head);
    let samples = (0..rate.first_at_or_after(spec.duration))
        .map(|k| rate.tick(k))
        .map(|t| Sample {
            t: series.start() + t,
            value: path.at(t, &head),
        })
        .collect();
    let mut notes = recording.notes.clone();
    notes.push(format!(
        "gaze is synthetic, seed {}; the recording's own is not used",
        spec.seed
    ));
    let gaze = Series::new(samples, Provenance::Truth).ok();
    Ok(Recording {
        gaze,
        gaze_rate: None,
        notes,
        ..recording.clone()
    })
}

/// Head pose at times after `start`, held where the recording has nothing.
fn recorded(series: &PoseSeries, t: Nanos) -> Option<foveasim_models::Pose> {
    let t = series.start() + t;
    series
        .at(t, Nanos::MAX)
        .or_else(|| series.latest(t, Nanos::MAX).map(|(_, pose)| pose))
}

/// The recording used where none is given: the default [`SynthSpec`].
pub fn default_recording() -> Recording {
    synth(&SynthSpec::default()).expect("the default specification is valid")
}
