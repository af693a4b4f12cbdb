//! Everything that a run can be told.

mod devices;
mod resolve;

use std::path::{Path, PathBuf};

use foveasim_models::{ModelError, toml_error};
use serde::{Deserialize, Deserializer, Serialize};

pub(crate) use devices::read_text_up_to;
pub use devices::{cost, display, read_text, tracker};
pub use resolve::{GazeSource, MapGrid, RenderTime, Scenario, ScenarioError};

use crate::ChainSpec;
use devices::as_file;

/// Everything that `foveasim run` can be told, as people write it: a scenario file (TOML) and the
/// flags of the command have the same names, and a flag wins over the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ScenarioSpec {
    /// Display: a preset's name, or a TOML file.
    pub display: String,
    /// Tracker: a preset's name, or a TOML file.
    pub tracker: String,
    /// Recording of gaze and head; none for the embedded synthetic one.
    pub trace: Option<PathBuf>,
    /// Scene units per metre of a recording made in scene units (EyeNavGS); estimated if absent.
    pub scale: Option<f64>,
    /// Which session of a recording that joins several, from 1; the longest if absent.
    pub segment: Option<usize>,
    /// Pixels of the screen of a screen-centred recording, width and height.
    pub screen_px: Option<Vec<f64>>,
    /// Its size \[mm\].
    pub screen_mm: Option<Vec<f64>>,
    /// How far from it the eye was \[mm\].
    pub distance_mm: Option<f64>,
    /// What the recorded gaze is, where the reader knows better than the file: `truth` or `tracker:MS`.
    pub provenance: Option<String>,
    /// `recorded`, or `synthetic`: made-up gaze on the recorded head motion, for recordings that have
    /// none.
    pub gaze_source: String,
    /// Methods, separated by commas; the first other than `full` is the one explained in detail.
    pub method: String,
    /// Acuity slope: a name, a quality index `j:12`, or a number \[deg/cycle per deg\].
    #[serde(deserialize_with = "text_or_number")]
    pub slope: String,
    /// `tracked` or `fixed`.
    pub gaze_mode: String,
    /// By how much the sharp region is widened for tracking error and lag \[deg\].
    pub margin_deg: f64,
    /// `tearing`, `vsync-free` or `vsync`.
    pub sync: String,
    /// How the head pose is predicted for the time of display ([`head_predictor`](crate::head_predictor)).
    pub predict: String,
    /// Gaze older than this is given up, and the fovea goes to the centre \[ms\].
    pub max_gaze_age_ms: f64,
    /// How long the pipeline lets a frame render: `refresh` (one refresh period), `cost` (the cost
    /// profile on each frame's own samples), or a law of durations ([`render_law`](crate::render_law)).
    #[serde(deserialize_with = "text_or_number")]
    pub render_time: String,
    /// Cost profile for predicted frame times: a preset's name, or a TOML file.
    pub cost: String,
    /// Runs of the latency simulation.
    pub runs: u64,
    /// How many moments of the recording are rendered.
    pub images: u32,
    /// Whether pictures show what a rolling display does while the head moves: each row as seen when it lights.
    #[serde(skip_serializing_if = "is_off")]
    pub rolling: bool,
    /// Horizontal fields of view of the savings map \[deg\]: `from..to:step`, or a comma list.
    #[serde(deserialize_with = "text_or_number")]
    pub fov: String,
    /// Pixels per degree at the centre of the savings map: `from..to:step`, or a comma list.
    #[serde(deserialize_with = "text_or_number")]
    pub ppd_centre: String,
    /// Seed of everything random.
    pub seed: u64,
    /// The loop between tracker and display.
    #[serde(skip_serializing_if = "is_default")]
    pub chain: ChainSpec,
}

fn is_default(chain: &ChainSpec) -> bool {
    *chain == ChainSpec::default()
}

/// Text, or a number where the text would be one: `slope = 0.0275` is as good as `slope = "0.0275"`.
fn text_or_number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "text or a number")]
    enum TextOrNumber {
        Text(String),
        Whole(i64),
        Number(f64),
    }
    Ok(match TextOrNumber::deserialize(deserializer)? {
        TextOrNumber::Text(text) => text,
        TextOrNumber::Whole(number) => number.to_string(),
        TextOrNumber::Number(number) => number.to_string(),
    })
}

/// What is off is not written, so that scenarios look as they did before there was such a switch.
fn is_off(switch: &bool) -> bool {
    !switch
}

impl Default for ScenarioSpec {
    fn default() -> Self {
        Self {
            display: "lg-w2363d".into(),
            tracker: "tx300".into(),
            trace: None,
            scale: None,
            segment: None,
            screen_px: None,
            screen_mm: None,
            distance_mm: None,
            provenance: None,
            gaze_source: "recorded".into(),
            method: "full,layers:3,layers:2,layers:4".into(),
            slope: "guenter-a".into(),
            gaze_mode: "tracked".into(),
            margin_deg: 0.0,
            sync: "vsync".into(),
            predict: "linear".into(),
            max_gaze_age_ms: 250.0,
            render_time: "refresh".into(),
            cost: "guenter2012".into(),
            runs: 100_000,
            images: 3,
            rolling: false,
            fov: "40..120:10".into(),
            ppd_centre: "10..60:10".into(),
            seed: 1,
            chain: ChainSpec::default(),
        }
    }
}

impl ScenarioSpec {
    /// Reads scenario text; `origin` names it in errors.
    ///
    /// # Errors
    /// If it is not TOML, a key is unknown (the error names the nearest) or has the wrong type.
    pub fn parse(text: &str, origin: &str) -> Result<Self, ModelError> {
        toml::from_str(text).map_err(|e| toml_error(origin, text, &e))
    }

    /// Makes paths in the scenario relative to the folder of the scenario file.
    #[must_use]
    pub fn relative_to(mut self, folder: &Path) -> Self {
        if let Some(trace) = &mut self.trace {
            *trace = folder.join(&trace);
        }
        for law in [
            Some(&mut self.render_time),
            self.chain.processing.as_mut(),
            self.chain.transport.as_mut(),
        ] {
            if let Some(law) = law
                && let Some(path) = law.strip_prefix("csv:")
            {
                *law = format!("csv:{}", folder.join(path).display());
            }
        }
        for name in [&mut self.display, &mut self.tracker, &mut self.cost] {
            if let Some(path) = as_file(name) {
                *name = folder.join(path).display().to_string();
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::foveation::Method;

    use super::*;

    #[test]
    fn the_default_is_valid() {
        let scenario = ScenarioSpec::default().resolve().unwrap();
        assert_eq!(scenario.display.name, "lg-w2363d");
        assert_ne!(*scenario.featured(), Method::Full);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let error = |change: &dyn Fn(&mut ScenarioSpec)| {
            let mut spec = ScenarioSpec::default();
            change(&mut spec);
            spec.resolve().unwrap_err().to_string()
        };
        for (text, part) in [
            (
                error(&|s| s.display = "quest-por".into()),
                "did you mean `quest-pro`?",
            ),
            (error(&|s| s.slope = "nan".into()), "slope"),
            (
                error(&|s| s.margin_deg = f64::NAN),
                "margin_deg = NaN: must be 0 to 90 degrees",
            ),
            (error(&|s| s.sync = "vsnc".into()), "did you mean `vsync`?"),
            (
                error(&|s| s.method = "layrs:3".into()),
                "did you mean `layers`?",
            ),
            (error(&|s| s.render_time = "-1".into()), "render_time"),
            (error(&|s| s.runs = 0), "runs = 0"),
            (
                error(&|s| s.display = "no/such.toml".into()),
                "no/such.toml",
            ),
        ] {
            assert!(text.contains(part), "{text}");
        }
    }

    #[test]
    fn rendering_that_is_off_takes_no_time_by_any_law() {
        for (law, cost) in [("refresh", false), ("3", false), ("cost", true)] {
            let with = |off: &[&str]| {
                let mut spec = ScenarioSpec {
                    render_time: law.into(),
                    ..ScenarioSpec::default()
                };
                spec.chain.off = off.iter().map(|part| (*part).to_owned()).collect();
                spec.resolve().unwrap().render_time
            };
            assert_eq!(with(&[]) == RenderTime::Cost, cost, "{law}");
            assert_eq!(with(&["exposure"]) == RenderTime::Cost, cost, "{law}");
            let RenderTime::Law(render) = with(&["queue", "render"]) else {
                panic!("{law} goes on although rendering is off");
            };
            assert_eq!(render.max(), foveasim_models::Nanos::ZERO, "{law}");
        }
    }

    #[test]
    fn what_may_be_worse_is_kept_with_the_chain() {
        let cautions = |off: &[&str]| {
            let mut spec = ScenarioSpec::default();
            spec.chain.warp_ms = Some(1.0);
            spec.chain.off = off.iter().map(|part| (*part).to_owned()).collect();
            spec.resolve().unwrap().chain.cautions()
        };
        assert!(cautions(&[]).is_empty() && cautions(&["response"]).is_empty());
        let said = cautions(&["response", "lead", "lead"]);
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(
            said[0].starts_with("lead is off: motion may be slower"),
            "{said:?}"
        );
        // Each part on its own terms, whatever else is off.
        assert_eq!(cautions(&["queue", "render", "lead"]).len(), 3);
    }

    #[test]
    fn an_unknown_key_names_the_nearest() {
        let error = ScenarioSpec::parse("seed = 1\nmetod = 'full'", "s.toml").unwrap_err();
        let text = error.to_string();
        assert!(text.starts_with("s.toml: line 2") && text.ends_with("did you mean `method`?"));
    }
}
