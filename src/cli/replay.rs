mod show;

use std::path::{Path, PathBuf};

use foveasim_models::foveation::Method;
use foveasim_models::{
    Acuity, Display, DrawnCost, FrameCost, GazeMode, HeadPredictor, MeasuredCost, Nanos, Rate,
    Recording,
};
use foveasim_pipeline::SyncMode;
use foveasim_study::{
    GazePhases, Golden, PhaseSpec, PhaseStudy, ReplayOptions, Suppression, head_predictor, replay,
    replay_streamed,
};
use foveasim_traces::{EventOptions, StreamedRecording, decimate_gaze, read_path};

use super::chain::ChainFlags;
use super::trace::ReadFlags;
use super::{Context, Failure, options};
use show::Show;

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
  foveasim replay gaze.tsv --phases --decimate 72

Columns: times count from the start of the recording. gaze_state is tracked; held (newer samples are
missing, the last one is used); lost (none, or too old: the fovea is at the centre); or fixed.
gaze_age_ms counts from the middle of the exposure that the frame used, exposure_to_photon_ms from
its start, both to the light of the row gazed at. gaze_error_deg is the angle between the true gaze and
the drawn fovea at that moment; empty where the true gaze was not recorded.

--phases prints, for all frames and by what the eye does (fixation; saccade; landing, up to 50 ms after
one; other), the angle between eye and drawn fovea, and for the margins that are as wide as its 95th and 99th
percentile: sample_factor, how many times more samples they take; pops_per_minute, jumps of the fovea by
more than the margin that are neither in a saccade or blink nor within --suppression-ms after (--suppression-before-ms before) a saccade;
pop_chance_per_minute, that of at least one. decimation_bias_p95_deg: how much wider (narrower, if
negative) the 95th percentile comes out of the slower recording. It is phases.csv in --out.

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
    /// How long frames render: milliseconds, uniform:MIN..MAX, normal:MEAN,SD, csv:FILE (measured values
    /// [ms], one frame after the other: the first column whose name ends in ms) or csv:FILE#COLUMN
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
    /// Print the gaze error by what the eye does, instead of a row per frame
    #[arg(long, conflicts_with_all = ["digest", "check"])]
    phases: bool,
    /// What the margins of --phases are counted for [default: layers:3]
    #[arg(long, value_name = "METHOD", conflicts_with_all = ["digest", "check"])]
    method: Option<Method>,
    /// Acuity slope for it: guenter-a, guenter-b, a quality index j:12, or a number [default: guenter-a]
    #[arg(long, value_name = "SLOPE", value_parser = Acuity::parse, conflicts_with_all = ["digest", "check"])]
    slope: Option<Acuity>,
    /// How long after a saccade jumps of the fovea go unseen [ms] [default: 60]
    #[arg(long, value_name = "MS", allow_hyphen_values = true, conflicts_with_all = ["digest", "check"])]
    suppression_ms: Option<f64>,
    /// How long before a saccade they do already [ms] [default: 0]
    #[arg(long, value_name = "MS", allow_hyphen_values = true, conflicts_with_all = ["digest", "check"])]
    suppression_before_ms: Option<f64>,
    /// Replay the recording with its gaze decimated to this rate as well [Hz], and say what that does to
    /// the 95th percentiles of --phases
    #[arg(long, value_name = "HZ", value_parser = options::rate, conflicts_with_all = ["digest", "check"])]
    decimate: Option<Rate>,
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

/// Holes longer than this stay missing when gaze is decimated.
const MAX_GAP: Nanos = Nanos(100_000_000);

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
    let study = args.study(ctx, display)?;
    let mut outputs = match &ctx.out {
        Some(_) => Some(ctx.outputs("out")?),
        None => None,
    };
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
    let mut show = Show {
        ctx,
        golden: golden.as_ref().zip(args.check.as_deref()),
        digest: args.digest,
        notes: Vec::new(),
    };
    let whole = study.is_some() || outputs.is_some();
    let streamed = match whole {
        true => None,
        false => StreamedRecording::open(&args.file, &args.read.options())?,
    };
    if let Some(recording) = streamed {
        let start = recording.span().map_or(Nanos::ZERO, |(start, _)| start);
        show.notes.clone_from(&recording.notes);
        return show.rows(start, &|each| {
            replay_streamed(&recording, display, tracker, cost, &options, each)
        });
    }

    let play = |recording: &Recording| replay(recording, display, tracker, cost, &options);
    let recording = read_path(&args.file, &args.read.options())?;
    let out = play(&recording)?;
    let events = |of: &Recording| GazePhases::find(of, &EventOptions::default());
    // What was not asked for is left out where the recording has no events.
    let phases = match &study {
        Some(_) if args.asks_for_phases() => Some(events(&recording)?),
        Some(_) => events(&recording).ok(),
        None => None,
    };
    let by_phase = match (&study, &phases) {
        (Some(spec), Some(phases)) => {
            let whole = PhaseStudy::new(&out, phases, spec)?;
            let slow = args.decimate.map(|rate| -> Result<_, Failure> {
                let slow = decimate_gaze(&recording, rate, MAX_GAP)?;
                Ok(PhaseStudy::new(&play(&slow)?, &events(&slow)?, spec)?)
            });
            let slow = slow.transpose()?;
            Some(whole.table(slow.as_ref()))
        }
        _ => None,
    };

    show.notes.clone_from(&recording.notes);
    let slow = phases.iter().filter_map(GazePhases::warning);
    show.notes.extend(slow);
    if let Some(mut outputs) = outputs.take() {
        outputs.add("replay.csv", out.table().csv());
        outputs.add(
            "gaze_error.svg",
            out.gaze_error_chart(phases.as_ref()).svg(),
        );
        outputs.add("latency.svg", out.latency_chart(phases.as_ref()).svg());
        outputs.add("gaze_path.svg", out.gaze_path_chart(phases.as_ref()).svg());
        if let Some(table) = &by_phase {
            outputs.add("phases.csv", table.csv());
        }
        outputs.add("timeline.json", out.timeline(display).json());
        outputs.commit()?;
    }
    match by_phase {
        Some(by_phase) if args.phases => {
            show.about(&out.notes, &out.summary());
            ctx.print_table(&by_phase)
        }
        _ => show.rows(out.start, &|each| {
            out.frames.iter().copied().for_each(each);
            Ok(out.about())
        }),
    }
}

impl Args {
    /// Whether a flag needs the events of the recording.
    fn asks_for_phases(&self) -> bool {
        self.phases
            || self.method.is_some()
            || self.slope.is_some()
            || self.suppression_ms.is_some()
            || self.suppression_before_ms.is_some()
            || self.decimate.is_some()
    }

    /// What to split the gaze error for; `None` where nobody would see it.
    fn study<'a>(
        &self,
        ctx: &Context,
        display: &'a Display,
    ) -> Result<Option<PhaseSpec<'a>>, Failure> {
        if !self.phases && ctx.out.is_none() {
            if self.asks_for_phases() {
                let flags =
                    "--method, --slope, --suppression-ms, --suppression-before-ms and --decimate";
                return Err(Failure::bad_input(format!(
                    "{flags} are for the table of --phases: give --phases, or --out DIR to keep it"
                )));
            }
            return Ok(None);
        }
        let window = |flag, ms: Option<f64>, default| {
            ms.map_or(Ok(default), |ms| options::milliseconds(flag, ms))
        };
        let Suppression { before, after } = Suppression::default();
        let suppression = Suppression {
            before: window(
                "--suppression-before-ms",
                self.suppression_before_ms,
                before,
            )?,
            after: window("--suppression-ms", self.suppression_ms, after)?,
        };
        let method = match self.method {
            Some(method) => method,
            None => "layers:3".parse()?,
        };
        Ok(Some(PhaseSpec {
            display,
            method,
            acuity: self.slope.unwrap_or_default(),
            suppression,
        }))
    }
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
