use std::path::Path;

use foveasim_models::{Display, Durations, Eye, EyeOrder, ModelError, Nanos, Rate, Tracker};
use foveasim_pipeline::{FrameStart, Missed, Runtime, SyncMode};
use serde::{Deserialize, Serialize};

use super::{Chain, HeadSampling, Part};
use crate::scenario::{ScenarioError, read_text_up_to};

/// The loop between tracker and display as people write it: the `[chain]` section of a scenario. What
/// is absent is off, or as the devices say.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ChainSpec {
    /// How often a free-running host starts a frame \[Hz\]; absent: at the display's rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub host_hz: Option<f64>,
    /// A free-running host's clock is the display's, and its frames are due this long after each
    /// vertical blank \[ms\]; absent: the clocks are independent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub host_lock_ms: Option<f64>,
    /// When a host that waits for the display starts a frame: `vblank`, `just-in-time` (reserving the
    /// longest rendering time), or `just-in-time:MS`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<String>,
    /// The compositor takes frames this long before the vertical blank \[ms\]; absent: as long as the
    /// late warp takes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lead_ms: Option<f64>,
    /// What the late warp takes \[ms\]; absent: no warp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warp_ms: Option<f64>,
    /// Frames in flight, from 1 to 3.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames_in_flight: Option<u32>,
    /// `repeat`, `half-rate` or `reproject`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub missed: Option<String>,
    /// The gaze is read this long after a frame starts \[ms\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gaze_latch_ms: Option<f64>,
    /// The head pose is read this long after a frame starts \[ms\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose_latch_ms: Option<f64>,
    /// Time from the end of exposure to the tracker's sample, instead of the tracker's own: see
    /// [`render_law`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub processing: Option<String>,
    /// Time of tracker samples on their way to the host, instead of the tracker's own, likewise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transport: Option<String>,
    /// Frames that the display holds, instead of its own number, from 0 to 4.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub buffered_frames: Option<u32>,
    /// Head samples a second \[Hz\]; absent: the pose is always new, or in a replay each recorded one is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub head_hz: Option<f64>,
    /// From a head sample to the host having it \[ms\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub head_delay_ms: Option<f64>,
    /// Whose rows are looked at: `left` or `right`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eye: Option<String>,
    /// Parts that are off ([`Part`]).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub off: Vec<String>,
    /// How much faster than stated each clock runs.
    #[serde(skip_serializing_if = "DriftSpec::is_none")]
    pub drift_ppm: DriftSpec,
}

/// How much faster than stated clocks run (slower, if negative), in parts in a million.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DriftSpec {
    /// The eye tracker's.
    pub tracker: f64,
    /// A free-running host's.
    pub host: f64,
    /// The display's.
    pub display: f64,
}

impl DriftSpec {
    fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// The largest file of measured durations \[bytes\].
const MOST_MEASURED: u64 = 1 << 28;

/// A law of durations: milliseconds, `uniform:MIN..MAX`, `normal:MEAN,SD`, `csv:FILE` with measured
/// values (the first column whose name ends in `ms`) or `csv:FILE#COLUMN` (the column of this name).
///
/// # Errors
/// If the text has none of these forms, or names the file's line and value that is no duration.
pub fn render_law(text: &str) -> Result<Durations, ScenarioError> {
    match text.strip_prefix("csv:") {
        None => Ok(text.parse()?),
        Some(path) => {
            // A file may have the sign in its name.
            let (path, column) = match path.rsplit_once('#') {
                Some((file, column)) if !Path::new(path).exists() => (file, Some(column)),
                _ => (path, None),
            };
            let text = read_text_up_to(Path::new(path), MOST_MEASURED)?;
            Ok(Durations::from_csv(&text, path, column)?)
        }
    }
}

impl ChainSpec {
    /// The valid chain of these devices; frames render as `render` says.
    ///
    /// # Errors
    /// Names the first field that is wrong, its value and what would be valid.
    pub fn resolve(
        &self,
        mut display: Display,
        mut tracker: Tracker,
        sync: SyncMode,
        render: Durations,
    ) -> Result<Chain, ScenarioError> {
        let drift = self.drift_ppm;
        display.scan.rate = display
            .scan
            .rate
            .drifted("drift_ppm.display", drift.display)?;
        tracker.rate = tracker.rate.drifted("drift_ppm.tracker", drift.tracker)?;
        if let (SyncMode::Vsync, Some(hz)) = (sync, self.host_hz) {
            let valid = "absent with vsync, where the display says when frames start";
            return Err(ModelError::range("host_hz", hz, valid).into());
        }
        let host_rate = match self.host_hz {
            None => display.scan.rate,
            Some(hz) => Rate::from_hz("host_hz", hz)?,
        };
        if let Some(text) = &self.processing {
            tracker.processing = render_law(text)?;
        }
        if let Some(text) = &self.transport {
            tracker.transport = render_law(text)?;
        }
        if let Some(frames) = self.buffered_frames {
            display = display.holding(frames)?;
        }
        let runtime = self.runtime(&render)?;
        if let Some(name @ ("left" | "right")) = self.eye.as_deref()
            && display.eye_order == EyeOrder::Together
        {
            let valid = "absent: this display scans both eyes together";
            return Err(ModelError::range("eye", name, valid).into());
        }
        let eye = match self.eye.as_deref() {
            None | Some("left") => 0,
            Some("right") => display
                .eyes
                .iter()
                .position(|e| e.eye == Eye::Right)
                .unwrap_or(1),
            Some(other) => {
                return Err(foveasim_models::unknown_name("eye", other, &["left", "right"]).into());
            }
        };
        let head = HeadSampling {
            rate: self
                .head_hz
                .map(|hz| Rate::from_hz("head_hz", hz))
                .transpose()?,
            delay: milliseconds("head_delay_ms", self.head_delay_ms)?.unwrap_or_default(),
        };
        let mut chain = Chain {
            host_rate: host_rate.drifted("drift_ppm.host", drift.host)?,
            display,
            tracker,
            sync,
            runtime,
            render,
            head,
            eye,
            off: Vec::new(),
        };
        for part in self.parts_off()? {
            chain = chain.without(part);
        }
        chain.check()?;
        Ok(chain)
    }

    fn parts_off(&self) -> Result<Vec<Part>, ScenarioError> {
        let part = |name: &String| {
            let why = |why| ScenarioError::Field { field: "off", why };
            name.parse::<Part>().map_err(why)
        };
        self.off.iter().map(part).collect()
    }

    fn runtime(&self, render: &Durations) -> Result<Runtime, ScenarioError> {
        let field = |field| move |why| ScenarioError::Field { field, why };
        let warp = milliseconds("warp_ms", self.warp_ms)?;
        let lead = milliseconds("lead_ms", self.lead_ms)?;
        let start = match self.start.as_deref() {
            None | Some("vblank") => FrameStart::AtVblank,
            Some("just-in-time") => FrameStart::JustInTime {
                reserve: render.max(),
            },
            Some(text) => {
                let ms = text
                    .strip_prefix("just-in-time:")
                    .and_then(|ms| ms.parse::<f64>().ok());
                let Some(ms) = ms else {
                    let valid = "`vblank`, `just-in-time` or `just-in-time:MS`";
                    return Err(ModelError::range("start", text, valid).into());
                };
                let reserve = milliseconds("just-in-time", Some(ms))?.unwrap_or_default();
                FrameStart::JustInTime { reserve }
            }
        };
        let latch = |name, ms| milliseconds(name, ms).map(Option::unwrap_or_default);
        Ok(Runtime {
            overlapped: false,
            start,
            lead: lead.or(warp).unwrap_or_default(),
            warp,
            in_flight: self.frames_in_flight.unwrap_or(1),
            gaze_latch: latch("gaze_latch_ms", self.gaze_latch_ms)?,
            pose_latch: latch("pose_latch_ms", self.pose_latch_ms)?,
            host_lock: milliseconds("host_lock_ms", self.host_lock_ms)?,
            missed: match &self.missed {
                None => Missed::default(),
                Some(text) => text.parse().map_err(field("missed"))?,
            },
        })
    }
}

/// A duration from 0 to 10 s, where one is given.
fn milliseconds(field: &str, ms: Option<f64>) -> Result<Option<Nanos>, ModelError> {
    match ms {
        None => Ok(None),
        Some(ms) if (0.0..=10_000.0).contains(&ms) => Ok(Some(Nanos::from_ms(ms))),
        Some(ms) => Err(ModelError::range(field, ms, "from 0 to 10000 ms")),
    }
}
