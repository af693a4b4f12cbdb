use std::path::{Path, PathBuf};

use foveasim_models::{DrawnCost, FrameCost, GazeMode, HeadPredictor, MeasuredCost};
use foveasim_pipeline::SyncMode;
use foveasim_study::{Golden, ReplayOptions, head_predictor, replay};
use foveasim_traces::read_path;

use super::chain::ChainFlags;
use super::trace::ReadFlags;
use super::{Context, Failure, options};

/// A recording through the gaze-to-photon chain: one row per displayed frame.
///
/// Shows how old the gaze was that each frame used, where the eye really was when its light came out,
/// and by how much the fovea was off. The same recording and flags give the same table: keep a digest
/// or a CSV as a golden file and check against it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim replay gaze.tsv --display lg-w2363d --tracker tx300 --format csv
  foveasim replay user116.csv --display quest-pro --tracker quest-pro --digest > golden.txt
  foveasim replay user116.csv --display quest-pro --tracker quest-pro --check golden.txt

Columns: times count from the start of the recording. gaze_state is tracked; held (newer samples are
missing, the last one is used); lost (none, or too old: the fovea is at the centre); or fixed.
gaze_age_ms counts from the middle of the exposure that the frame used, exposure_to_photon_ms from
its start, both to the light of the row gazed at. gaze_error_deg is the angle between the true gaze and
the drawn fovea at that moment; empty where the true gaze was not recorded.

--check exits with 1 at the first difference, and with 2 if the golden file cannot be read.")]
pub(crate) struct Args {
    /// The recording; its format is found by content
    file: PathBuf,
    /// Display preset or TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = "lg-w2363d")]
    display: String,
    /// Eye tracker preset or TOML file; not used for recordings of a tracker's own output
    #[arg(long, value_name = "NAME|FILE", default_value = "tx300")]
    tracker: String,
    /// tearing, vsync-free or vsync
    #[arg(long, value_name = "MODE", default_value = "vsync")]
    sync: SyncMode,
    /// How long a frame renders [ms] [default: one refresh period]
    #[arg(long, value_name = "MS", allow_hyphen_values = true)]
    render_ms: Option<f64>,
    /// How long frames render, as a law; of a csv:FILE, one measured frame after the other
    #[arg(long, value_name = "LAW", conflicts_with = "render_ms")]
    render: Option<String>,
    /// tracked: the fovea follows the eye; fixed: it stays at the centre
    #[arg(long, value_name = "MODE", default_value = "tracked")]
    gaze_mode: GazeMode,
    /// How the head pose is predicted for the time of display: constant, linear (the same as
    /// angular-velocity), components, angular-velocity, acceleration, kalman or double-exponential
    #[arg(long, value_name = "NAME", default_value = "linear", value_parser = head_predictor)]
    predict: HeadPredictor,
    /// Gaze older than this is given up, and the fovea goes to the centre [ms] [default: 250]
    #[arg(long, value_name = "MS", allow_hyphen_values = true)]
    max_gaze_age_ms: Option<f64>,
    /// Print only the table's digest
    #[arg(long, conflicts_with = "check")]
    digest: bool,
    /// Compare with a digest or a CSV written earlier
    #[arg(long, value_name = "GOLDEN")]
    check: Option<PathBuf>,
    #[command(flatten)]
    chain: ChainFlags,
    #[command(flatten)]
    read: ReadFlags,
}

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let display = options::display(&args.display)?;
    let tracker = options::tracker(&args.tracker)?;
    let golden = args.check.as_deref().map(golden).transpose()?;
    let render = options::render(args.render_ms, args.render.as_deref(), &display)?;
    let spec = args.chain.spec();
    let chain = spec.resolve(display, tracker, args.sync, render)?;
    let (display, tracker) = (&chain.display, &chain.tracker);
    let options = ReplayOptions {
        sync: args.sync,
        gaze_mode: args.gaze_mode,
        predictor: args.predict,
        head: chain.head,
        gaze_max_age: args
            .max_gaze_age_ms
            .map(|ms| options::milliseconds("--max-gaze-age-ms", ms))
            .transpose()?,
        runtime: chain.runtime,
        host_rate: Some(chain.host_rate),
        seed: ctx.seed,
    };
    let mut outputs = match &ctx.out {
        Some(_) => Some(ctx.outputs("out")?),
        None => None,
    };
    let recording = read_path(&args.file, &args.read.options())?;
    let drawn = DrawnCost {
        law: &chain.render,
        seed: ctx.seed,
        run: 0,
    };
    let measured = chain.render.in_order().map(MeasuredCost);
    let cost: &dyn FrameCost = match &measured {
        Some(measured) => measured,
        None => &drawn,
    };
    let out = replay(&recording, display, tracker, cost, &options)?;
    let table = out.table();

    for note in recording.notes.iter().chain(&out.notes) {
        ctx.warn(note);
    }
    for line in out.summary().lines() {
        ctx.note(&line);
    }
    if let Some(mut outputs) = outputs.take() {
        outputs.add("replay.csv", table.csv());
        outputs.add("gaze_error.svg", out.gaze_error_chart().svg());
        outputs.add("timeline.json", out.timeline(display).json());
        outputs.commit()?;
    }
    if let (Some(golden), Some(path)) = (golden, &args.check) {
        return match golden.difference(&table) {
            None => ctx.print(&format!("replay equals {}\n", path.display())),
            Some(d) => Err(Failure::CheckFailed(format!(
                "replay differs from {}: {d}",
                path.display()
            ))),
        };
    }
    if args.digest {
        return ctx.print(&format!("{}\n", table.digest()));
    }
    ctx.print_table(&table)
}

/// A golden file: read before the replay, so that a wrong path costs no time.
fn golden(path: &Path) -> Result<Golden, Failure> {
    let error =
        |why: &dyn std::fmt::Display| Failure::bad_input(format!("{}: {why}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| error(&e))?;
    Golden::parse(&text).ok_or_else(|| {
        error(&"not a golden file; want what `replay --digest` or `replay --format csv` prints")
    })
}
