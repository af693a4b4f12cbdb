use foveasim_models::math::{cos, sin, sqrt, to_rad};
use foveasim_models::{HeadPredictor, Nanos, Pose, Provenance, Recording, Sample, Series, exp_so3};
use foveasim_reports::{Cell, Table};
use foveasim_traces::{SynthSpec, synth};
use glam::DVec3;

use super::{Friston2019Outcome, ReproduceError, paper};
use crate::PredictionStudy;

/// How wrong a prediction is one frame ahead, on one movement.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadRow {
    /// The movement.
    pub movement: &'static str,
    /// The predictor.
    pub predictor: HeadPredictor,
    /// Root mean square of rotation \[deg\].
    pub rotation_deg: f64,
    /// The same in closed form, where there is one \[deg\].
    pub exact_deg: Option<f64>,
    /// What the paper says of its own recording \[deg\].
    pub paper_deg: Option<f64>,
    /// Root mean square of translation \[m\].
    pub translation_m: f64,
    /// What the paper says of its own recording \[m\].
    pub paper_m: Option<f64>,
}

/// Samples per second of the paper's recording.
const RATE_HZ: f64 = 1000.0;
/// Refreshes per second of its display, a DK2.
const DISPLAY_HZ: f64 = 75.0;
/// A turn to and fro: its amplitude \[deg\], frequency \[Hz\], and how far ahead is looked \[ms\].
const TURN: (f64, f64, f64) = (20.0, 1.0, 16.7);

/// The predictors that the paper compares.
const PREDICTORS: [HeadPredictor; 2] = [HeadPredictor::Linear, HeadPredictor::Constant];

/// A turn in closed form, and as many frames of synthetic movement as the paper recorded.
pub(super) fn rows(seed: u64) -> Result<Vec<HeadRow>, ReproduceError> {
    let (amplitude, frequency, ahead_ms) = TURN;
    let mut rows = judged("turn of 20 deg at 1 Hz, 16.7 ms ahead", &turn(), ahead_ms)?;
    let x = std::f64::consts::TAU * frequency * ahead_ms * 1e-3;
    for row in &mut rows {
        row.exact_deg = Some(match row.predictor {
            HeadPredictor::Constant => sqrt(2.0) * amplitude * sin(x / 2.0).abs(),
            _ => {
                let off = (cos(x) - 1.0) * (cos(x) - 1.0) + (sin(x) - x) * (sin(x) - x);
                amplitude / sqrt(2.0) * sqrt(off)
            }
        });
    }
    let seconds = f64::from(paper::HEAD_FRAMES) / DISPLAY_HZ;
    let synthetic = synth(&SynthSpec {
        seed,
        duration: Nanos::from_ms(1e3 * seconds),
        pose_rate_hz: RATE_HZ,
        ..SynthSpec::default()
    })?;
    for mut row in judged(
        "synthetic, a frame of 75 Hz ahead",
        &synthetic,
        1e3 / DISPLAY_HZ,
    )? {
        let printed = match row.predictor {
            HeadPredictor::Constant => paper::HEAD_CONSTANT,
            _ => paper::HEAD_LINEAR,
        };
        (row.paper_m, row.paper_deg) = (Some(printed.0), Some(printed.1));
        rows.push(row);
    }
    Ok(rows)
}

fn judged(
    movement: &'static str,
    recording: &Recording,
    ahead_ms: f64,
) -> Result<Vec<HeadRow>, ReproduceError> {
    let study = PredictionStudy {
        predictors: PREDICTORS.into(),
        horizons: vec![Nanos::from_ms(ahead_ms)],
        ..PredictionStudy::default()
    };
    let found = study.run(recording)?;
    let row = |r: crate::PredictionRow| HeadRow {
        movement,
        predictor: r.predictor,
        rotation_deg: r.rotation_deg.rms,
        exact_deg: None,
        paper_deg: None,
        translation_m: 1e-3 * r.translation_mm.rms,
        paper_m: None,
    };
    Ok(found.rows.into_iter().map(row).collect())
}

/// Ten seconds of a head that turns to and fro about the vertical.
fn turn() -> Recording {
    let (amplitude, frequency, _) = TURN;
    let sample = |k: i64| {
        let t = Nanos(k * (1e9 / RATE_HZ) as i64);
        let angle = amplitude * sin(std::f64::consts::TAU * frequency * t.as_secs());
        Sample {
            t,
            value: Some(Pose::new(DVec3::ZERO, exp_so3(DVec3::Y * to_rad(angle)))),
        }
    };
    let samples = (0..10 * RATE_HZ as i64).map(sample).collect();
    Recording {
        pose: Series::new(samples, Provenance::Truth).ok(),
        ..Recording::default()
    }
}

impl Friston2019Outcome {
    /// §5.2, head pose estimation.
    pub fn head_table(&self) -> Table {
        let mut table = Table::new([
            "movement",
            "predictor",
            "rotation_rms_deg",
            "rotation_exact_deg",
            "rotation_paper_deg",
            "translation_rms_m",
            "translation_paper_m",
        ]);
        for r in &self.head {
            let optional = |v: Option<f64>| v.map_or(Cell::Empty, Cell::from);
            table.push(vec![
                r.movement.into(),
                r.predictor.name().into(),
                r.rotation_deg.into(),
                optional(r.exact_deg),
                optional(r.paper_deg),
                r.translation_m.into(),
                optional(r.paper_m),
            ]);
        }
        table
    }
}
