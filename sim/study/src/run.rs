//! The main job: replay a recording, simulate its latency, render what the viewer would see, predict
//! what foveation saves, and report.

mod cost;
mod evidence;
mod growth;
mod margin;
mod moments;
mod page;
mod savings;

use foveasim_models::math::mean;
use foveasim_models::{
    DrawnCost, Durations, FrameCost, MeasuredCost, ModelError, Nanos, Recording,
};
use foveasim_quality::Measures;
use foveasim_reports::{ReportError, Table};
use foveasim_traces::{SynthSpec, TraceError};
use thiserror::Error;

pub use cost::PlanCost;
pub use evidence::{Evidence, EvidenceError};
pub use growth::Growth;
pub use margin::{MARGIN_TOLERANCE_DEG, MarginLoop, MarginStep, close_margin};
pub use moments::{MOMENT_PICTURES, Moment};
pub use savings::{MethodSaving, Savings};

use crate::{
    FrameError, GazeSource, LatencyError, LatencyResult, LatencyStudy, Quantity, RenderTime,
    Replay, ReplayError, Rows, Scenario, recording_table, replay,
};

/// Why a run cannot be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RunError {
    /// The recording cannot be read.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// A model refuses a number.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Latency cannot be simulated.
    #[error(transparent)]
    Latency(#[from] LatencyError),
    /// The recording cannot be replayed.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// A picture cannot be drawn.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The report cannot be made.
    #[error(transparent)]
    Report(#[from] ReportError),
}

/// Everything a run found.
#[derive(Debug)]
pub struct Run {
    /// The recording, times as in its file.
    pub recording: Recording,
    /// What the methods save on this display, and on others.
    pub savings: Savings,
    /// The gaze-to-photon chain, simulated and bounded.
    pub latency: LatencyResult,
    /// The recording, frame by displayed frame.
    pub replay: Replay,
    /// What the viewer would see at some moments.
    pub moments: Vec<Moment>,
}

/// Runs a scenario. `progress` is told what begins, and how much of all is done (0 to 1).
///
/// # Errors
/// If the recording cannot be read or replayed, or the scenario asks for what cannot be rendered.
pub fn run(scenario: &Scenario, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<Run, RunError> {
    progress("reading", 0.0);
    let recording = recording(scenario)?;
    progress("replaying", 0.05);
    let replay = replay_recording(scenario, &recording)?;
    progress("predicting", 0.2);
    let savings = savings::savings(scenario)?;
    progress("latency", 0.3);
    let latency = latency(scenario, &savings)?;
    let moments = moments::moments(scenario, &replay, &|done| {
        progress("rendering", 0.4 + 0.55 * done);
    })?;
    progress("reporting", 0.95);
    Ok(Run {
        recording,
        savings,
        latency,
        replay,
        moments,
    })
}

fn recording(scenario: &Scenario) -> Result<Recording, RunError> {
    let recorded = match &scenario.spec.trace {
        Some(path) => foveasim_traces::read_path(path, &scenario.reading)?,
        None => foveasim_traces::default_recording(),
    };
    Ok(match scenario.gaze_source {
        GazeSource::Recorded => recorded,
        GazeSource::Synthetic => {
            let spec = SynthSpec {
                seed: scenario.spec.seed,
                ..SynthSpec::default()
            };
            foveasim_traces::with_synthetic_gaze(&recorded, &spec)?
        }
    })
}

fn replay_recording(scenario: &Scenario, recording: &Recording) -> Result<Replay, RunError> {
    let (plan_cost, measured, drawn);
    let cost: &dyn FrameCost = match &scenario.render_time {
        RenderTime::Law(law) => match law.in_order() {
            Some(frames) => {
                measured = MeasuredCost(frames);
                &measured
            }
            None => {
                let seed = scenario.spec.seed;
                drawn = DrawnCost { law, seed, run: 0 };
                &drawn
            }
        },
        RenderTime::Cost => {
            plan_cost = PlanCost::new(scenario, scenario.featured())?;
            &plan_cost
        }
    };
    Ok(replay(
        recording,
        &scenario.display,
        &scenario.tracker,
        cost,
        &scenario.replay,
    )?)
}

/// Latency of the featured method, gaze at the centre. A cost profile's time is taken at its mean over
/// the layers' cadence.
fn latency(scenario: &Scenario, savings: &Savings) -> Result<LatencyResult, RunError> {
    let mut chain = scenario.chain.clone();
    if scenario.render_time == RenderTime::Cost {
        chain.render = Durations::fixed(Nanos::from_ms(savings.featured().predicted_ms));
    }
    let study = LatencyStudy::of(chain, None)?;
    Ok(study.run(scenario.spec.runs, scenario.spec.seed, &|_| ())?)
}

impl Run {
    /// The answer in one sentence.
    pub fn answer(&self, scenario: &Scenario) -> String {
        let featured = self.savings.featured();
        let photon = self.latency.histogram(Quantity::Gaze(Rows::Last));
        let replay = self.replay.summary();
        let error = replay.gaze_error_deg.map_or_else(
            || "the true gaze is not known".to_owned(),
            |e| format!("the eye was within {:.1} degrees of the drawn fovea in 95 % of displayed frames", e.p95),
        );
        let in_turns = match featured.shading_ratio_staggered {
            // Only layers have a rate of their own.
            ratio if ratio == featured.shading_ratio => String::new(),
            ratio => format!("{ratio:.1} times with its outer layers at their own lower rate; "),
        };
        format!(
            "{} shades {:.1} times fewer samples than full resolution on {} ({in_turns}{:.0} times is \
             the floor of any method), gaze-to-photon is {:.1} ms on average and below {:.1} ms in 95 % \
             of cases, and in this recording {error}.",
            featured.method,
            featured.shading_ratio,
            scenario.display.title,
            featured.ideal_ratio,
            photon.mean_ms(),
            photon.quantile_ms(0.95),
        )
    }

    /// The run in a few numbers, for the terminal.
    pub fn summary(&self) -> Table {
        let mut table = Table::new([
            "method",
            "samples_per_frame_staggered",
            "sample_ratio",
            "sample_ratio_staggered",
            "shading_ratio",
            "ideal_ratio",
            "predicted_ms",
            "predicted_speedup",
            "ssim",
            "psnr_db",
        ]);
        for saving in &self.savings.methods {
            let measures = || {
                let all = self.moments.iter().flat_map(|m| &m.measures);
                all.filter(|(method, _)| *method == saving.method)
                    .map(|(_, m)| m)
            };
            let mean = |f: fn(&Measures) -> f64| {
                let values: Vec<f64> = measures().map(f).collect();
                (!values.is_empty()).then(|| mean(&values))
            };
            table.push(vec![
                saving.method.to_string().into(),
                saving.samples_staggered.into(),
                saving.sample_ratio.into(),
                saving.sample_ratio_staggered.into(),
                saving.shading_ratio.into(),
                saving.ideal_ratio.into(),
                saving.predicted_ms.into(),
                saving.predicted_speedup.into(),
                mean(|m| m.ssim).into(),
                mean(|m| m.psnr_luma_db).into(),
            ]);
        }
        table
    }

    /// What was recorded, as a table of properties.
    pub fn recording_table(&self) -> Table {
        recording_table(&self.recording)
    }

    /// All files of the run: tables, pictures, timeline and the report, which shows `evidence` of how good the predictions
    /// are, or says that there is none.
    ///
    /// # Errors
    /// If a picture cannot be encoded.
    pub fn files(
        &self,
        scenario: &Scenario,
        evidence: Option<&Evidence>,
    ) -> Result<Vec<(String, Vec<u8>)>, RunError> {
        let mut files: Vec<(String, Vec<u8>)> = vec![
            ("summary.csv".into(), self.summary().csv().into()),
            ("plan.csv".into(), self.savings.table.csv().into()),
            ("map.csv".into(), self.savings.map_table().csv().into()),
            (
                "growth.csv".into(),
                self.savings.growth.table().csv().into(),
            ),
            ("latency.csv".into(), self.latency.table().csv().into()),
            ("replay.csv".into(), self.replay.table().csv().into()),
            ("recording.csv".into(), self.recording_table().csv().into()),
            (
                "quality.csv".into(),
                moments::quality_table(&self.moments).csv().into(),
            ),
            (
                "work.csv".into(),
                moments::work_table(&self.moments).csv().into(),
            ),
            (
                "timeline.json".into(),
                self.replay.timeline(&scenario.display).json().into(),
            ),
        ];
        for (k, moment) in self.moments.iter().enumerate() {
            for (what, bytes) in &moment.files {
                files.push((format!("moment-{}-{what}.png", k + 1), bytes.clone()));
            }
        }
        let html = page::page(self, scenario, evidence)?;
        files.push(("report.html".into(), html.into()));
        Ok(files)
    }

    /// A digest of everything found: tables and decoded pixels, not file bytes.
    pub fn digest(&self) -> String {
        let mut table = Table::new(["what", "digest"]);
        let mut add = |what: &str, digest: String| table.push(vec![what.into(), digest.into()]);
        add("plan", self.savings.table.digest());
        add("map", self.savings.map_table().digest());
        add("growth", self.savings.growth.table().digest());
        add("latency", self.latency.table().digest());
        add("replay", self.replay.table().digest());
        add("quality", moments::quality_table(&self.moments).digest());
        add("work", moments::work_table(&self.moments).digest());
        for (what, digest) in self.moments.iter().flat_map(|m| &m.digests) {
            add(what, digest.clone());
        }
        table.digest()
    }
}
