use std::path::PathBuf;

use foveasim_models::{HeadPredictor, Nanos};
use foveasim_study::{PredictionStudy, parse_numbers};

use super::options::duration;
use super::trace::{ReadFlags, each_recording};
use super::{Context, Failure};

/// Longest horizon \[ms\].
const MAX_HORIZON_MS: f64 = 1000.0;
/// Most horizons.
const MAX_HORIZONS: usize = 1000;

/// How well predictors foresee head pose in recordings, at several horizons.
///
/// Predictors: constant, linear (position and quaternion by components), angular-velocity (constant on
/// SO(3)), acceleration, kalman, double-exponential. With --out: prediction.csv, and charts of each
/// recording's RMS errors.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim trace predict user110_playroom.csv --scale 2.7
  foveasim trace predict head/*.csv --horizon-ms 16.7,33.3 --predictor constant,linear --format csv")]
pub(crate) struct Args {
    /// Recordings with head pose
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Horizons [ms]: a list, or FROM..TO:STEP
    #[arg(long, value_name = "MS", default_value = "5..60:5")]
    horizon_ms: String,
    /// Which predictors [default: all]
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    predictor: Vec<HeadPredictor>,
    /// A hole longer than this is not predicted across
    #[arg(long, value_name = "TIME", default_value = "100ms", value_parser = duration)]
    max_gap: Nanos,
    #[command(flatten)]
    read: ReadFlags,
}

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let horizons = parse_numbers(&args.horizon_ms)?;
    if horizons.len() > MAX_HORIZONS {
        return Err(Failure::bad_input(format!(
            "--horizon-ms {}: {} horizons; at most {MAX_HORIZONS}",
            args.horizon_ms,
            horizons.len()
        )));
    }
    if let Some(ms) = horizons
        .iter()
        .find(|ms| !(0.0..=MAX_HORIZON_MS).contains(*ms))
    {
        return Err(Failure::bad_input(format!(
            "--horizon-ms {ms}: must be a number from 0 to {MAX_HORIZON_MS}"
        )));
    }
    let mut study = PredictionStudy {
        horizons: horizons.into_iter().map(Nanos::from_ms).collect(),
        max_gap: args.max_gap,
        ..PredictionStudy::default()
    };
    if !args.predictor.is_empty() {
        study.predictors.clone_from(&args.predictor);
    }
    each_recording(
        &args.files,
        &args.read,
        ctx,
        "prediction.csv",
        |recording| {
            let found = study.run(recording)?;
            let charts = [
                ("rotation", found.rotation_chart()),
                ("translation", found.translation_chart()),
            ];
            Ok((found.table(), charts))
        },
    )
}
