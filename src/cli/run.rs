use std::path::PathBuf;

use foveasim_study::{
    Evidence, MARGIN_TOLERANCE_DEG, MOMENT_PICTURES, Scenario, ScenarioSpec, close_margin,
    read_text,
};

use super::chain::ChainFlags;
use super::context::Format;
use super::trace::ReadFlags;
use super::{Context, Failure};

/// The main job: replay a recording, simulate its latency, render what the viewer would see, predict
/// the savings, and write one report.
///
/// Without arguments it uses embedded defaults. Flags win over the scenario file.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim run
  foveasim run --trace recording.csv --display quest-pro --tracker quest-pro --out out
  foveasim run --display lg-w2363d --tracker tx300 --method layers:3 --margin-deg 2 --sync tearing
  foveasim run --method layers:3,vrs,kfr:2:1 --evidence verified
  foveasim init && foveasim run scenario.toml")]
pub(crate) struct Args {
    /// Scenario file (TOML); `foveasim init` writes one with every key explained
    scenario: Option<PathBuf>,
    /// Recording of gaze and head; the format is found by content [default: a synthetic one]
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Display: a preset, or a TOML file [default: lg-w2363d]
    #[arg(long, value_name = "NAME|FILE")]
    display: Option<String>,
    /// Eye tracker: a preset, or a TOML file [default: tx300]
    #[arg(long, value_name = "NAME|FILE")]
    tracker: Option<String>,
    /// Methods to compare, separated by commas [default: full,layers:3,layers:2,layers:4]
    #[arg(long, value_name = "METHODS")]
    method: Option<String>,
    /// Acuity slope: guenter-a, guenter-b, j:INDEX or a number [default: guenter-a]
    #[arg(long, value_name = "SLOPE")]
    slope: Option<String>,
    /// recorded, or synthetic: made-up gaze on the recorded head motion [default: recorded]
    #[arg(long, value_name = "SOURCE")]
    gaze_source: Option<String>,
    /// Whether the sharp region follows the eye: tracked or fixed [default: tracked]
    #[arg(long, value_name = "MODE")]
    gaze_mode: Option<String>,
    /// How much wider the sharp region is, against tracking error and lag [deg] [default: 0]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    margin_deg: Option<f64>,
    /// tearing, vsync-free or vsync [default: vsync]
    #[arg(long, value_name = "MODE")]
    sync: Option<String>,
    /// How the head pose is predicted: constant, linear (the same as angular-velocity), components,
    /// angular-velocity, acceleration, kalman or double-exponential [default: linear]
    #[arg(long, value_name = "NAME")]
    predict: Option<String>,
    /// Gaze older than this is given up [ms] [default: 250]
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    max_gaze_age_ms: Option<f64>,
    /// How long a frame renders: refresh, cost, or a law as for --processing [default: refresh]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    render_time: Option<String>,
    /// Cost profile of predicted times: a preset, or a TOML file [default: guenter2012]
    #[arg(long, value_name = "NAME|FILE")]
    cost: Option<String>,
    /// Runs of the latency simulation [default: 100000]
    #[arg(long, value_name = "N")]
    runs: Option<u64>,
    /// Moments of the recording to render [default: 3]
    #[arg(long, value_name = "N")]
    images: Option<u32>,
    /// Pictures show what a rolling display does while the head moves: each row as seen when it lights
    #[arg(long)]
    rolling: bool,
    /// Fields of view of the savings map [deg] [default: 40..120:10]
    #[arg(long, value_name = "LIST")]
    fov: Option<String>,
    /// Pixels per degree at the centre of the savings map [default: 10..60:10]
    #[arg(long, value_name = "LIST")]
    ppd_centre: Option<String>,
    /// Instead of all that: find the margin that covers the gaze error in so many of 100 displayed frames,
    /// with frames that take what the cost profile says of the margin itself; exit 1 if there is none
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    close_margin: Option<f64>,
    /// Folder in which plan --verify or pareto left what they measured, for the report to show
    #[arg(long, value_name = "DIR", conflicts_with = "close_margin")]
    evidence: Option<PathBuf>,
    #[command(flatten)]
    chain: ChainFlags,
    #[command(flatten)]
    read: ReadFlags,
}

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let scenario = args.spec(ctx)?.resolve()?;
    if let Some(percent) = args.close_margin {
        if !(percent > 0.0 && percent < 100.0) {
            return Err(Failure::bad_input(format!(
                "--close-margin = {percent}: must be above 0 and below 100, percent of the displayed frames"
            )));
        }
        return margin(&scenario, percent, ctx);
    }
    // An unwritable folder is found before the work, not after.
    let mut outputs = ctx.outputs("out")?;
    let evidence = args.evidence.as_deref().map(Evidence::read).transpose()?;
    let bar = ctx.progress(1000, "starting");
    let run = foveasim_study::run(&scenario, &|what, done| {
        bar.set_message(what.to_owned());
        bar.set_position((done * 1000.0) as u64);
    })?;
    for (name, bytes) in run.files(&scenario, evidence.as_ref())? {
        outputs.add(name, bytes);
    }
    bar.finish_and_clear();
    // A shorter run must not leave an earlier one's pictures beside its report.
    for k in run.moments.len() + 1..=100 {
        for what in MOMENT_PICTURES {
            outputs.retire(format!("moment-{k}-{what}.png"));
        }
    }
    let report = outputs.path("report.html");
    outputs.commit()?;
    let cautions = scenario.chain.cautions();
    for note in run
        .recording
        .notes
        .iter()
        .chain(&run.replay.notes)
        .chain(&cautions)
    {
        ctx.warn(note);
    }
    ctx.print_table(&run.summary())?;
    if ctx.format == Format::Table {
        let (answer, digest) = (run.answer(&scenario), run.digest());
        ctx.print(&format!(
            "\n{answer}\n\ndigest  {digest}\nreport  {}\n",
            report.display()
        ))?;
    }
    Ok(())
}

fn margin(scenario: &Scenario, percent: f64, ctx: &Context) -> Result<(), Failure> {
    let found = close_margin(scenario, percent / 100.0)?;
    ctx.deliver_table(&found.table(), "margin.csv")?;
    match found.closed {
        true => Ok(()),
        false => Err(Failure::CheckFailed(format!(
            "the margin does not converge to {MARGIN_TOLERANCE_DEG}° within {} turns",
            found.steps.len()
        ))),
    }
}

impl Args {
    /// The scenario file, or the defaults, with the flags on top.
    fn spec(&self, ctx: &Context) -> Result<ScenarioSpec, Failure> {
        let mut spec = match &self.scenario {
            None => ScenarioSpec::default(),
            Some(path) => {
                let spec = ScenarioSpec::parse(&read_text(path)?, &path.display().to_string())?;
                spec.relative_to(path.parent().unwrap_or_else(|| "".as_ref()))
            }
        };
        fn set<T: Clone>(place: &mut T, flag: &Option<T>) {
            if let Some(value) = flag {
                place.clone_from(value);
            }
        }
        set(&mut spec.display, &self.display);
        set(&mut spec.tracker, &self.tracker);
        set(&mut spec.method, &self.method);
        set(&mut spec.slope, &self.slope);
        set(&mut spec.gaze_source, &self.gaze_source);
        set(&mut spec.gaze_mode, &self.gaze_mode);
        set(&mut spec.margin_deg, &self.margin_deg);
        set(&mut spec.sync, &self.sync);
        set(&mut spec.predict, &self.predict);
        set(&mut spec.max_gaze_age_ms, &self.max_gaze_age_ms);
        set(&mut spec.render_time, &self.render_time);
        set(&mut spec.cost, &self.cost);
        set(&mut spec.runs, &self.runs);
        set(&mut spec.images, &self.images);
        spec.rolling |= self.rolling;
        set(&mut spec.fov, &self.fov);
        set(&mut spec.ppd_centre, &self.ppd_centre);
        set(&mut spec.seed, &ctx.seed_flag);
        self.chain.over(&mut spec.chain);
        let read = &self.read;
        for (place, flag) in [
            (&mut spec.screen_px, read.screen_px),
            (&mut spec.screen_mm, read.screen_mm),
        ] {
            *place = flag.map(Vec::from).or(place.take());
        }
        spec.distance_mm = read.distance_mm.or(spec.distance_mm);
        spec.scale = read.scale.or(spec.scale);
        spec.segment = read.segment.or(spec.segment);
        spec.provenance = read.provenance.map(|p| p.to_string()).or(spec.provenance);
        spec.trace = self.trace.clone().or(spec.trace);
        Ok(spec)
    }
}
