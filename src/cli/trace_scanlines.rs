use std::path::PathBuf;

use foveasim_models::{HeadPredictor, Nanos, Rate};
use foveasim_study::ScanlineStudy;

use super::options::duration;
use super::trace::{ReadFlags, each_recording};
use super::{Context, Failure};

/// How far the view is off, row by row while a frame is scanned out, for plain, warped and rolling images.
///
/// The last row's errors are E1 (plain), E2 (warped), E3 (rolling) and E4 (rolling-warp-content) of Friston
/// 2019, Fig. 16. With --out: scanlines.csv, and charts of each recording.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim trace scanlines user110_playroom.csv --scale 2.7 --refresh 72 --out scanlines")]
pub(crate) struct Args {
    /// Recordings with head pose
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Frames per second [Hz]
    #[arg(long, value_name = "HZ", default_value = "90", value_parser = refresh)]
    refresh: Rate,
    /// How head pose is predicted where it is
    #[arg(long, value_name = "NAME", default_value = "kalman")]
    predictor: HeadPredictor,
    /// A hole longer than this is not predicted across
    #[arg(long, value_name = "TIME", default_value = "100ms", value_parser = duration)]
    max_gap: Nanos,
    #[command(flatten)]
    read: ReadFlags,
}

/// A display's frames per second.
fn refresh(text: &str) -> Result<Rate, String> {
    const FASTEST_HZ: f64 = 1000.0;
    match text.parse() {
        Ok(hz) if (1.0..=FASTEST_HZ).contains(&hz) => {
            Rate::from_hz("refresh", hz).map_err(|e| e.to_string())
        }
        _ => Err(format!(
            "want a number of hertz from 1 to {FASTEST_HZ}, as in 90"
        )),
    }
}

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let study = ScanlineStudy {
        refresh: args.refresh,
        predictor: args.predictor,
        max_gap: args.max_gap,
    };
    each_recording(&args.files, &args.read, ctx, "scanlines.csv", |recording| {
        let found = study.run(recording)?;
        let charts = [
            ("rotation", found.rotation_chart()),
            ("translation", found.translation_chart()),
        ];
        Ok((found.table(), charts))
    })
}
