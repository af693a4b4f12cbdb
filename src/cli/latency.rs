use anyhow::Context as _;
use foveasim_pipeline::SyncMode;
use foveasim_study::{Band, LatencyStudy, Quantity};

use super::{Context, Failure, options};

/// Gaze-to-photon latency from best to worst case, stage by stage.
///
/// Gaze steps at a random time; all clocks have random phases; every run simulates the whole chain
/// from the tracker's exposure to light. Beside the simulation stand the exact bounds.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim latency
  foveasim latency --display lg-w2363d --tracker tx300 --sync tearing --runs 1000000 --seed 1 --format csv
  foveasim latency --display quest-pro --tracker quest-pro --render-ms 9 --out out

Rows: each stage's own share on the way to the row gazed at, then the whole way. The inner layer is a
band of rows about the row gazed at (--band, --gaze-row). Each of its rows is renewed when it is first
lit from a frame that knew of the eye movement:
  gaze_to_photon_first_row      the first of them to be renewed
  gaze_to_photon_gaze_row       the row gazed at
  gaze_to_photon_last_row       the last of them to be renewed, wherever the beam was at the flip
  gaze_to_photon_complete_pass  the first scan from top to bottom of the band that is all new
Quantiles are within 2 microseconds of the order statistics for ranges up to 30 ms, minimum, mean and
maximum exact. --out writes latency.csv and latency_histogram.csv.")]
pub(crate) struct Args {
    /// Display preset or TOML file
    #[arg(long, value_name = "NAME", default_value = "lg-w2363d")]
    display: String,
    /// Eye tracker preset or TOML file
    #[arg(long, value_name = "NAME", default_value = "tx300")]
    tracker: String,
    /// tearing: flip at once; vsync-free: the host runs freely, flips wait for the vertical blank;
    /// vsync: the host waits for its frame to flip
    #[arg(long, value_name = "MODE", default_value = "vsync")]
    sync: SyncMode,
    /// How many times gaze steps (1 to 1000000000)
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    runs: u64,
    /// How long a frame renders [ms] [default: one refresh period]
    #[arg(long, value_name = "MS", allow_hyphen_values = true)]
    render_ms: Option<f64>,
    /// The row gazed at [default: the middle one]
    #[arg(long, value_name = "ROW")]
    gaze_row: Option<u32>,
    /// Rows of the inner layer, from..to [default: 200/1080 of the rows, about the row gazed at]
    #[arg(long, value_name = "A..B", value_parser = rows)]
    band: Option<(u32, u32)>,
}

/// `A..B`.
fn rows(text: &str) -> Result<(u32, u32), String> {
    text.split_once("..")
        .and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)))
        .ok_or_else(|| "want two rows A..B, as in 440..640".into())
}

/// Bins of the histogram that `--out` writes.
const HISTOGRAM_BINS: usize = 200;

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let display = options::display(&args.display)?;
    let tracker = options::tracker(&args.tracker)?;
    let render = args
        .render_ms
        .map(|ms| options::milliseconds("--render-ms", ms))
        .transpose()?;
    let rows = display.scan.rows;
    let band = match (args.band, args.gaze_row) {
        (None, gaze) => Band::about(gaze.unwrap_or(rows / 2), rows),
        (Some((top, bottom)), gaze) => {
            let middle = top.saturating_add(bottom) / 2;
            Band {
                top,
                gaze: gaze.unwrap_or(middle),
                bottom,
            }
        }
    };
    let study = LatencyStudy::new(display, tracker, args.sync, render, Some(band))
        .with_context(|| args.display.clone())?;
    let mut outputs = match &ctx.out {
        Some(_) => Some(ctx.outputs("out")?),
        None => None,
    };
    let bar = ctx.progress(args.runs, "latency");
    let result = study.run(args.runs, ctx.seed, &|n| bar.inc(n));
    bar.finish_and_clear();
    let result = result?;

    let table = result.table();
    let Band { top, gaze, bottom } = study.band();
    ctx.note(&format!(
        "{} on {}, {}: frames render {} ms; rows {top} to {bottom} of {rows}, gaze at {gaze}; {} runs, {} simulated events",
        args.tracker,
        args.display,
        args.sync,
        study.render().as_ms(),
        args.runs,
        result.events
    ));
    ctx.print_table(&table)?;
    if let Some(mut outputs) = outputs.take() {
        outputs.add("latency.csv", table.csv());
        outputs.add(
            "latency_histogram.csv",
            result.histogram_table(HISTOGRAM_BINS).csv(),
        );
        outputs.add(
            "latency.svg",
            result.chart(Quantity::Gaze(Rows::Last)).svg(),
        );
        outputs.add("waterfall.svg", result.waterfall().svg());
        outputs.commit()?;
    }
    match result.outside_bounds() {
        None => Ok(()),
        Some(quantity) => Err(Failure::CheckFailed(format!(
            "the simulation of {} left its bounds: one of the two is wrong",
            quantity.name()
        ))),
    }
}
