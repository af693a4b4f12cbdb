//! From what is written to what is valid.

use std::path::PathBuf;

use foveasim_models::foveation::Method;
use foveasim_models::{
    Acuity, CostProfile, Display, Durations, GazeMode, ModelError, Nanos, Tracker, presets,
    unknown_name,
};
use foveasim_pipeline::SyncMode;
use foveasim_traces::{ReadOptions, ScreenSpec, TraceError};

use super::ScenarioSpec;
use super::devices::{cost, display, display_spec, tracker, tracker_spec};
use crate::{
    Chain, DensityAt, MAX_RUNS, Part, ReplayOptions, Resolution, SweepDisplay, head_predictor,
    parse_numbers, render_law,
};

/// Which gaze is replayed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GazeSource {
    /// The recording's own.
    Recorded,
    /// Synthetic, on the recorded head motion.
    Synthetic,
}

/// How long the pipeline lets a frame render.
#[derive(Debug, Clone, PartialEq)]
pub enum RenderTime {
    /// A time for each frame, whatever it shows: fixed, drawn, or measured. In a replay, measured
    /// frames follow each other in their order; the latency study draws from them.
    Law(Durations),
    /// What the cost profile says of each frame's own samples.
    Cost,
}

/// A valid scenario: all names resolved, all numbers in range.
#[derive(Debug, Clone)]
pub struct Scenario {
    /// As written, for the report.
    pub spec: ScenarioSpec,
    /// The display.
    pub display: Display,
    /// The eye tracker.
    pub tracker: Tracker,
    /// Methods to compare, `full` among them.
    pub methods: Vec<Method>,
    /// The acuity line to keep.
    pub acuity: Acuity,
    /// Whether the sharp region follows the eye.
    pub gaze_mode: GazeMode,
    /// Which gaze is replayed.
    pub gaze_source: GazeSource,
    /// How frames meet the display.
    pub sync: SyncMode,
    /// The chain from tracker to light, with these devices; its frames render for the time of
    /// `render_time`, or, where that is a cost profile's, for one refresh period.
    pub chain: Chain,
    /// How long frames render.
    pub render_time: RenderTime,
    /// The profile for predicted times.
    pub cost: CostProfile,
    /// Every number of the display, the tracker and the cost profile, with its source.
    pub facts: Vec<(&'static str, presets::Fact)>,
    /// How the recording is to be read.
    pub reading: ReadOptions,
    /// The displays of the savings map.
    pub map: MapGrid,
    /// How the recording is replayed.
    pub replay: ReplayOptions,
}

/// The displays of a savings map: every field of view at every resolution.
#[derive(Debug, Clone)]
pub struct MapGrid {
    /// Horizontal fields of view \[deg\].
    pub fov_deg: Vec<f64>,
    /// Pixels per degree at the centre.
    pub ppd_centre: Vec<f64>,
    /// Row by row from the first resolution.
    pub displays: Vec<SweepDisplay>,
}

/// A scenario that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// A name or number is wrong.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A name or number in one field is wrong.
    #[error("{field}: {why}")]
    Field {
        /// The field.
        field: &'static str,
        /// What is wrong.
        why: ModelError,
    },
    /// How the recording is to be read is not valid.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// A file that the scenario names cannot be read.
    #[error("{path}: {why}")]
    Read {
        /// Which file.
        path: PathBuf,
        /// Why.
        why: std::io::Error,
    },
}

impl ScenarioSpec {
    /// Resolves names and checks numbers.
    ///
    /// # Errors
    /// Names the first field that is wrong, its value and what would be valid.
    pub fn resolve(self) -> Result<Scenario, ScenarioError> {
        let field = |field| move |why| ScenarioError::Field { field, why };
        let display = display(&self.display)?;
        let tracker = tracker(&self.tracker)?;
        let mut methods = Method::parse_list(&self.method).map_err(field("method"))?;
        if !methods.contains(&Method::Full) {
            methods.insert(0, Method::Full);
        }
        let acuity = Acuity::parse(&self.slope).map_err(field("slope"))?;
        let gaze_mode = self.gaze_mode.parse().map_err(field("gaze_mode"))?;
        let gaze_source = match self.gaze_source.as_str() {
            "recorded" => GazeSource::Recorded,
            "synthetic" => GazeSource::Synthetic,
            other => {
                let error = unknown_name("gaze source", other, &["recorded", "synthetic"]);
                return Err(field("gaze_source")(error));
            }
        };
        let sync = self.sync.parse().map_err(field("sync"))?;
        let check = |ok: bool, name: &str, value: String, valid: &str| match ok {
            true => Ok(()),
            false => Err(ModelError::range(name, value, valid)),
        };
        let margin = self.margin_deg;
        check(
            (0.0..=90.0).contains(&margin),
            "margin_deg",
            margin.to_string(),
            "0 to 90 degrees",
        )?;
        let runs = self.runs;
        check(
            (1..=MAX_RUNS).contains(&runs),
            "runs",
            runs.to_string(),
            &format!("1 to {MAX_RUNS}"),
        )?;
        check(
            self.images <= 100,
            "images",
            self.images.to_string(),
            "0 to 100",
        )?;
        let refresh = Durations::fixed(display.scan.rate.period());
        let render_time = match self.render_time.as_str() {
            "refresh" => RenderTime::Law(refresh),
            "cost" => RenderTime::Cost,
            text => RenderTime::Law(render_law(text).map_err(|why| match why {
                ScenarioError::Model(why) => field("render_time")(why),
                other => other,
            })?),
        };
        if render_time == RenderTime::Cost && self.chain.start.as_deref() == Some("just-in-time") {
            let valid = "`just-in-time:MS`, where render times come from a cost profile";
            return Err(ModelError::range("chain.start", "just-in-time", valid).into());
        }
        let law = match &render_time {
            RenderTime::Law(law) => law.clone(),
            RenderTime::Cost => Durations::fixed(display.scan.rate.period()),
        };
        let chain = self.chain.resolve(display, tracker, sync, law)?;
        let render_time = match render_time {
            RenderTime::Cost if !chain.is_off(Part::Render) => RenderTime::Cost,
            _ => RenderTime::Law(chain.render.clone()),
        };
        let (display, tracker) = (chain.display.clone(), chain.tracker.clone());
        let cost = cost(&self.cost)?;
        let (d, t) = (display_spec(&self.display)?, tracker_spec(&self.tracker)?);
        let facts = [
            ("display", presets::facts(&d, &d.sources)),
            ("tracker", presets::facts(&t, &t.sources)),
            ("cost", presets::facts(&cost, &cost.sources)),
        ];
        let facts = facts
            .into_iter()
            .flat_map(|(k, f)| f.into_iter().map(move |f| (k, f)));
        let age = self.max_gaze_age_ms;
        let valid = "0 to 10000 ms";
        check(
            (0.0..=10_000.0).contains(&age),
            "max_gaze_age_ms",
            age.to_string(),
            valid,
        )?;
        let predictor = head_predictor(&self.predict).map_err(field("predict"))?;
        let replay = ReplayOptions {
            sync,
            gaze_mode,
            predictor,
            head: chain.head,
            gaze_max_age: Some(Nanos::from_ms(age)),
            runtime: chain.runtime,
            host_rate: Some(chain.host_rate),
            seed: self.seed,
        };
        let reading = self.reading()?;
        let map = self.map()?;
        // The report ends with the scenario as text.
        if let Some(path) = self.trace.as_ref().filter(|p| p.to_str().is_none()) {
            return Err(ModelError::range("trace", path.display(), "a path in UTF-8").into());
        }
        Ok(Scenario {
            facts: facts.collect(),
            reading,
            map,
            replay,
            display,
            tracker,
            methods,
            acuity,
            gaze_mode,
            gaze_source,
            sync,
            chain,
            render_time,
            cost,
            spec: self,
        })
    }
}
/// Width and height. Written as a list of any length, so that a wrong length is refused and not cut.
fn width_and_height(field: &str, given: &Option<Vec<f64>>) -> Result<Option<[f64; 2]>, ModelError> {
    let pair = |list: &Vec<f64>| {
        let pair = <[f64; 2]>::try_from(list.as_slice());
        pair.map_err(|_| ModelError::range(field, format!("{list:?}"), "[width, height]"))
    };
    given.as_ref().map(pair).transpose()
}

/// Height over width of the displays in the savings map.
const MAP_ASPECT: f64 = 0.5625;
/// The most displays of a savings map: more cannot be told apart in a picture.
const MAP_MOST: usize = 10_000;

impl ScenarioSpec {
    fn map(&self) -> Result<MapGrid, ScenarioError> {
        let field = |field| move |why| ScenarioError::Field { field, why };
        let fov_deg = parse_numbers(&self.fov).map_err(field("fov"))?;
        let ppd_centre = parse_numbers(&self.ppd_centre).map_err(field("ppd_centre"))?;
        let count = fov_deg.len().saturating_mul(ppd_centre.len());
        if count > MAP_MOST {
            let valid = format!("at most {MAP_MOST}: use larger steps");
            return Err(
                ModelError::range("fov × ppd_centre", format!("{count} cells"), valid).into(),
            );
        }
        let mut displays = Vec::with_capacity(count);
        for &ppd in &ppd_centre {
            if !(1e-3..=1e5).contains(&ppd) {
                return Err(ModelError::range("ppd_centre", ppd, "0.001 to 100000").into());
            }
            for &fov in &fov_deg {
                let resolution = Resolution::PerDegree(DensityAt::Centre, ppd);
                displays.push(resolution.display(fov, MAP_ASPECT).map_err(field("fov"))?);
            }
        }
        Ok(MapGrid {
            fov_deg,
            ppd_centre,
            displays,
        })
    }

    /// How the recording is to be read.
    fn reading(&self) -> Result<ReadOptions, ScenarioError> {
        let options = ReadOptions {
            screen: ScreenSpec {
                size_px: width_and_height("screen_px", &self.screen_px)?,
                size_mm: width_and_height("screen_mm", &self.screen_mm)?,
                distance_mm: self.distance_mm,
            },
            scale: self.scale,
            segment: self.segment,
            provenance: self.provenance.as_deref().map(str::parse).transpose()?,
        };
        options.validate()?;
        if self.trace.is_none() && options != ReadOptions::default() {
            let valid = "given only with a `trace`: the synthetic recording needs none of scale, \
                         segment, screen_px, screen_mm, distance_mm, provenance";
            return Err(ModelError::range("reading options", "set", valid).into());
        }
        Ok(options)
    }
}

impl Scenario {
    /// The scenario as TOML, every key written out.
    pub fn to_toml(&self) -> String {
        toml::to_string(&self.spec).expect("a scenario is plain text and numbers")
    }

    /// The method that the report explains in detail: the first other than `full`.
    pub fn featured(&self) -> &Method {
        self.methods
            .iter()
            .find(|m| **m != Method::Full)
            .unwrap_or(&Method::Full)
    }
}
