use anyhow::Context as _;
use foveasim_pipeline::SyncMode;
use foveasim_study::{
    Band, Budget, Chain, Fig5Reading, LatencyResult, LatencyStudy, Part, Quantity, Rows,
    Sensitivity, sensitivity_table, tornado,
};

use super::chain::ChainFlags;
use super::{Context, Failure, options};

/// Gaze-to-photon and motion-to-photon latency from best to worst case, stage by stage.
///
/// Gaze steps at a random time, and the head moves; all clocks have random phases; every run simulates
/// the whole chain from the tracker's exposure to light. Beside the simulation stand its bounds, exact or outer.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim latency
  foveasim latency --display lg-w2363d --tracker tx300 --sync tearing --runs 1000000 --seed 1 --format csv
  foveasim latency --display quest-pro --tracker quest-pro --render-ms 9 --budget 50ms
  foveasim latency --display quest-3 --tracker quest-pro --render uniform:7..9 --start just-in-time \\
      --warp-ms 1.5 --missed reproject --sensitivity --out out
  foveasim latency --reading figure

Rows: each stage's own share on the way to the row gazed at, then the whole way; first for the eye's
movement, then for the head's. The inner layer is a band of rows about the row gazed at (--band,
--gaze-row). Each of its rows is renewed when it is first lit from a picture that knew of the movement:
  gaze_to_photon_first_row      the first of them to be renewed
  gaze_to_photon_gaze_row       the row gazed at
  gaze_to_photon_last_row       the last of them to be renewed, wherever the beam was at the flip
  gaze_to_photon_complete_pass  the first scan from end to end of the band that is all new
Quantiles are within 2 microseconds of the order statistics for ranges up to 30 ms, minimum, mean and
maximum exact. --out writes the tables (latency.csv, latency_histogram.csv, sensitivity.csv) and the
pictures: cases.svg (the fastest and the slowest run), waterfall.svg, cdf.svg, tornado.svg and a
histogram of every stage that varies.")]
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
    /// How long frames render: milliseconds, uniform:MIN..MAX, normal:MEAN,SD, csv:FILE (measured values
    /// [ms]: the first column whose name ends in ms) or csv:FILE#COLUMN
    #[arg(long, value_name = "LAW", conflicts_with = "render_ms")]
    render: Option<String>,
    /// The row gazed at [default: the middle one]
    #[arg(long, value_name = "ROW")]
    gaze_row: Option<u32>,
    /// Rows of the inner layer, from..to [default: 200/1080 of the rows, about the row gazed at]
    #[arg(long, value_name = "A..B", value_parser = rows)]
    band: Option<(u32, u32)>,
    /// Exit 1 if the 95th percentile of gaze to photon (row gazed at) is longer, naming what to shorten
    #[arg(long, value_name = "MS", value_parser = budget, allow_hyphen_values = true)]
    budget: Option<f64>,
    /// Print what one millisecond less of each part buys, instead of the stages
    #[arg(long)]
    sensitivity: bool,
    /// The rounded numbers of Guenter 2012, Fig. 5, instead of a simulation: figure (23 to 40 ms),
    /// scan-after-wait (to 42 ms) or two-periods-more (to 48 ms)
    #[arg(long, value_name = "READING", conflicts_with_all = [
        "display", "tracker", "sync", "budget", "sensitivity", "render", "render_ms", "band", "gaze_row",
        "host_hz", "host_lock_ms", "start", "lead_ms", "warp_ms", "frames_in_flight", "missed",
        "gaze_latch_ms", "pose_latch_ms", "processing", "transport", "buffered_frames", "head_hz",
        "head_delay_ms", "eye", "drift_ppm", "off",
    ])]
    reading: Option<Fig5Reading>,
    #[command(flatten)]
    chain: ChainFlags,
}

/// Milliseconds; `ms` may follow.
fn budget(text: &str) -> Result<f64, String> {
    match text.trim_end_matches("ms").trim_end().parse::<f64>() {
        Ok(ms) if (0.0..=10_000.0).contains(&ms) => Ok(ms),
        _ => Err("want milliseconds from 0 to 10000, as in 50ms".into()),
    }
}

/// `A..B`.
fn rows(text: &str) -> Result<(u32, u32), String> {
    text.split_once("..")
        .and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)))
        .ok_or_else(|| "want two rows A..B, as in 440..640".into())
}

/// Bins of the histogram that `--out` writes.
const HISTOGRAM_BINS: usize = 200;

/// Runs for each difference of a sensitivity, at most: more say nothing new.
const SENSITIVITY_RUNS: u64 = 100_000;

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    if let Some(reading) = args.reading {
        let result = reading.run(args.runs, ctx.seed)?;
        return ctx.deliver_table(&result.table(), "latency.csv");
    }
    let study = study(args, ctx)?;
    let mut outputs = match &ctx.out {
        Some(_) => Some(ctx.outputs("out")?),
        None => None,
    };
    let bar = ctx.progress(args.runs, "latency");
    let result = study.run(args.runs, ctx.seed, &|n| bar.inc(n));
    bar.finish_and_clear();
    let result = result?;
    // A budget that holds needs no reasons.
    let kept = args.budget.is_none_or(|ms| result.budget(ms, &[]).is_ok());
    let sensitivities = match args.sensitivity || outputs.is_some() || !kept {
        true => sensitivities(args, ctx, &study, &result)?,
        false => Vec::new(),
    };

    ctx.note(&told(args, &study, &result));
    ctx.print_table(&match args.sensitivity {
        true => sensitivity_table(&sensitivities),
        false => result.full_table(),
    })?;
    if let Some(mut outputs) = outputs.take() {
        for (name, bytes) in files(&result, &sensitivities) {
            outputs.add(name, bytes);
        }
        outputs.commit()?;
    }
    match args.budget.map(|ms| result.budget(ms, &sensitivities)) {
        None => Ok(()),
        Some(Ok(p95)) => {
            ctx.note(&format!(
                "p95 of gaze to photon is {p95:.2} ms: within the budget"
            ));
            Ok(())
        }
        Some(Err(budget)) => Err(Failure::CheckFailed(over(&budget, study.chain()))),
    }
}

fn study(args: &Args, ctx: &Context) -> Result<LatencyStudy, Failure> {
    let display = options::display(&args.display)?;
    let tracker = options::tracker(&args.tracker)?;
    let render = options::render(args.render_ms, args.render.as_deref(), &display)?;
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
    let spec = args.chain.spec();
    let chain = spec.resolve(display, tracker, args.sync, render)?;
    for caution in chain.cautions() {
        ctx.warn(&caution);
    }
    Ok(LatencyStudy::of(chain, Some(band)).with_context(|| args.display.clone())?)
}

fn sensitivities(
    args: &Args,
    ctx: &Context,
    study: &LatencyStudy,
    result: &LatencyResult,
) -> Result<Vec<Sensitivity>, Failure> {
    let runs = args.runs.min(SENSITIVITY_RUNS);
    let bar = ctx.progress(runs * foveasim_study::KNOBS.len() as u64, "sensitivity");
    // Differences are between runs with the same clocks: as many of them.
    let fewer;
    let base = match runs == args.runs {
        true => result,
        false => {
            fewer = study.run(runs, ctx.seed, &|_| ())?;
            &fewer
        }
    };
    let found = study.sensitivities(base, runs, ctx.seed, &|n| bar.inc(n));
    bar.finish_and_clear();
    Ok(found?)
}

fn told(args: &Args, study: &LatencyStudy, result: &LatencyResult) -> String {
    let Band { top, gaze, bottom } = study.band();
    let chain = study.chain();
    let (least, most) = (chain.render.min().as_ms(), chain.render.max().as_ms());
    let render = match (chain.is_off(Part::Render), least == most) {
        (true, _) if most > 0.0 => {
            format!("in no time, but take the {most} ms until their last latch")
        }
        (true, _) => "in no time".into(),
        (false, true) => format!("{least} ms"),
        (false, false) => format!("{least} to {most} ms"),
    };
    format!(
        "{} on {}, {}: frames render {render}; rows {top} to {bottom} of {}, gaze at {gaze}; {} runs, {} simulated events",
        args.tracker, args.display, args.sync, chain.display.scan.rows, args.runs, result.events
    )
}

/// Tables and pictures, by file name.
fn files(result: &LatencyResult, sensitivities: &[Sensitivity]) -> Vec<(String, String)> {
    let mut files: Vec<(String, String)> = vec![
        ("latency.csv".into(), result.full_table().csv()),
        (
            "latency_histogram.csv".into(),
            result.histogram_table(HISTOGRAM_BINS).csv(),
        ),
        (
            "sensitivity.csv".into(),
            sensitivity_table(sensitivities).csv(),
        ),
        (
            "latency.svg".into(),
            result.chart(Quantity::Gaze(Rows::Last)).svg(),
        ),
        ("waterfall.svg".into(), result.waterfall().svg()),
        ("cases.svg".into(), result.strips().svg()),
        ("cdf.svg".into(), result.cdf().svg()),
        ("tornado.svg".into(), tornado(sensitivities).svg()),
    ];
    for (name, chart) in result.charts() {
        files.push((format!("histogram-{name}.svg"), chart.svg()));
    }
    files
}

/// Why a budget does not hold, and what to do.
fn over(budget: &Budget, chain: &Chain) -> String {
    let Budget {
        p95_ms, budget_ms, ..
    } = budget;
    let what = match &budget.shorten {
        None => "no single part brings it down".into(),
        Some(s) => format!(
            "{}; a millisecond there buys {:.2} ms",
            s.knob.advice(chain),
            s.gaze_p95
        ),
    };
    format!("p95 of gaze to photon is {p95_ms:.2} ms, over the budget of {budget_ms} ms: {what}")
}
