use std::path::PathBuf;

use clap::Subcommand;
use foveasim_models::{Nanos, Provenance, Rate, Recording};
use foveasim_reports::{Cell, LineChart, Table};
use foveasim_traces::{ReadOptions, ScreenSpec, SynthSpec};

use super::{Context, Failure, options, trace_events, trace_predict, trace_scanlines};

/// Describe, convert, synthesise and analyse recordings of gaze and head pose.
///
/// Formats are found by content; docs/trace-format.md lists them.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim trace info recording.csv
  foveasim trace info --format json *.tsv
  foveasim trace convert user116_playroom.csv --scale 2.7 --to head.csv
  foveasim trace synth --duration 30s --to synthetic.csv
  foveasim trace events recording.asc --out events
  foveasim trace predict user110_playroom.csv --scale 2.7")]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Info(InfoArgs),
    Convert(ConvertArgs),
    Synth(SynthArgs),
    Events(trace_events::Args),
    Predict(trace_predict::Args),
    Scanlines(trace_scanlines::Args),
}

/// Rate, jitter, gaps, losses, range and angular step of recordings, and what reading them took.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim trace info recording.csv
  foveasim trace info user102_london.csv --segment 1 --scale 0.53
  foveasim trace info gaze.tsv --screen-px 2560x1440 --screen-mm 597x336 --distance-mm 700")]
struct InfoArgs {
    /// Recordings
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    read: ReadFlags,
}

/// Write a recording as CSV of our own format, whole or in part, as it is or resampled.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim trace convert gaze.tsv --to gaze.csv
  foveasim trace convert gaze.tsv --slice 2..5 --rebase --to three-seconds.csv
  foveasim trace convert gaze.tsv --resample 300 --provenance tracker:12 > tracked.csv")]
struct ConvertArgs {
    /// The recording
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    to: Destination,
    /// Keep the samples from A up to B seconds after the first
    #[arg(long, value_name = "A..B", value_parser = options::seconds_range)]
    slice: Option<(Nanos, Nanos)>,
    /// Sample again at this rate [Hz], linear between samples
    #[arg(long, value_name = "HZ", value_parser = options::rate)]
    resample: Option<Rate>,
    /// Holes longer than this stay missing when resampling
    #[arg(long, value_name = "TIME", default_value = "100ms", value_parser = options::duration)]
    max_gap: Nanos,
    /// Begin at time zero
    #[arg(long)]
    rebase: bool,
    #[command(flatten)]
    read: ReadFlags,
}

/// Synthesise gaze (fixations, saccades on the main sequence, blinks) and smooth head motion.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim trace synth --duration 10s --to synthetic.csv
  foveasim trace synth --seed 7 --gaze-rate 1200 --head-yaw-deg 0 --head-sway-m 0 > eyes.csv")]
struct SynthArgs {
    #[command(flatten)]
    to: Destination,
    /// Length
    #[arg(long, value_name = "TIME", default_value = "10s", value_parser = options::duration)]
    duration: Nanos,
    /// Gaze samples per second [Hz]
    #[arg(long, value_name = "HZ", default_value_t = SynthSpec::default().gaze_rate_hz)]
    gaze_rate: f64,
    /// Head-pose samples per second [Hz]
    #[arg(long, value_name = "HZ", default_value_t = SynthSpec::default().pose_rate_hz)]
    pose_rate: f64,
    /// How far to each side, and up or down, saccades land [deg]
    #[arg(long, value_name = "X,Y", default_value = "20,15", value_parser = options::pair)]
    field_deg: [f64; 2],
    /// Mean duration of fixations [ms]
    #[arg(long, value_name = "MS", default_value_t = SynthSpec::default().fixation_ms)]
    fixation_ms: f64,
    /// Mean amplitude of saccades [deg]
    #[arg(long, value_name = "DEG", default_value_t = SynthSpec::default().amplitude_deg)]
    amplitude_deg: f64,
    /// Blinks per minute; 0 for none
    #[arg(long, value_name = "N", default_value_t = SynthSpec::default().blinks_per_minute)]
    blinks: f64,
    /// Root mean square of head yaw [deg]; pitch and roll follow
    #[arg(long, value_name = "DEG", default_value_t = SynthSpec::default().head_yaw_deg)]
    head_yaw_deg: f64,
    /// Root mean square of head movement, sideways [m]
    #[arg(long, value_name = "M", default_value_t = SynthSpec::default().head_sway_m)]
    head_sway_m: f64,
}

/// Where a recording goes.
#[derive(Debug, clap::Args)]
struct Destination {
    /// Where to write, relative to --out; standard output if absent
    #[arg(long, value_name = "OUT.csv")]
    to: Option<PathBuf>,
    /// Replace the file if there is one
    #[arg(long)]
    force: bool,
}

/// What a recording does not say about itself.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reading")]
pub(crate) struct ReadFlags {
    /// Pixels of the screen on which gaze was recorded [default: of the file or the format]
    #[arg(long, value_name = "WxH", value_parser = options::sides)]
    pub(crate) screen_px: Option<[f64; 2]>,
    /// Its size [mm] [default: of the file or the format]
    #[arg(long, value_name = "WxH", value_parser = options::sides)]
    pub(crate) screen_mm: Option<[f64; 2]>,
    /// How far from it the eye was [mm] [default: of the file or the format]
    #[arg(long, value_name = "D")]
    pub(crate) distance_mm: Option<f64>,
    /// Scene units per metre of an EyeNavGS recording [default: estimated]
    #[arg(long, value_name = "S")]
    pub(crate) scale: Option<f64>,
    /// Which of several sessions joined in one file, from 1 [default: the longest]
    #[arg(long, value_name = "N")]
    pub(crate) segment: Option<usize>,
    /// What the gaze samples are: `truth`, or `tracker:MS` for a tracker's output so many ms late
    #[arg(long, value_name = "WHAT")]
    pub(crate) provenance: Option<Provenance>,
}

impl ReadFlags {
    pub(crate) fn options(&self) -> ReadOptions {
        ReadOptions {
            screen: ScreenSpec {
                size_px: self.screen_px,
                size_mm: self.screen_mm,
                distance_mm: self.distance_mm,
            },
            scale: self.scale,
            segment: self.segment,
            provenance: self.provenance,
        }
    }
}

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    match &args.command {
        Command::Info(args) => info(args, ctx),
        Command::Convert(args) => convert(args, ctx),
        Command::Synth(args) => synth(args, ctx),
        Command::Events(args) => trace_events::run(args, ctx),
        Command::Predict(args) => trace_predict::run(args, ctx),
        Command::Scanlines(args) => trace_scanlines::run(args, ctx),
    }
}

fn info(args: &InfoArgs, ctx: &Context) -> Result<(), Failure> {
    let mut table = Table::new(["file", "series", "quantity", "value"]);
    for file in &args.files {
        let recording = foveasim_traces::read_path(file, &args.read.options())?;
        for row in foveasim_study::recording_table(&recording).rows() {
            let name = Cell::from(recording.source.as_str());
            table.push(std::iter::once(name).chain(row.iter().cloned()).collect());
        }
    }
    ctx.deliver_table(&table, "trace_info.csv")
}

fn convert(args: &ConvertArgs, ctx: &Context) -> Result<(), Failure> {
    let mut recording = foveasim_traces::read_path(&args.file, &args.read.options())?;
    if let Some((from, to)) = args.slice {
        recording = foveasim_traces::slice(&recording, from, to)?;
    }
    if let Some(rate) = args.resample {
        recording = foveasim_traces::resample_recording(&recording, rate, args.max_gap)?;
    }
    if args.rebase {
        recording = foveasim_traces::rebase(&recording);
    }
    deliver(&recording, &args.to, ctx)
}

fn synth(args: &SynthArgs, ctx: &Context) -> Result<(), Failure> {
    let recording = foveasim_traces::synth(&SynthSpec {
        seed: ctx.seed,
        duration: args.duration,
        gaze_rate_hz: args.gaze_rate,
        pose_rate_hz: args.pose_rate,
        field_deg: args.field_deg,
        fixation_ms: args.fixation_ms,
        amplitude_deg: args.amplitude_deg,
        blinks_per_minute: args.blinks,
        head_yaw_deg: args.head_yaw_deg,
        head_sway_m: args.head_sway_m,
    })?;
    deliver(&recording, &args.to, ctx)
}

/// Adds the rows of a table of the same columns.
fn append(all: &mut Option<Table>, table: Table) {
    match all {
        None => *all = Some(table),
        Some(all) => table.rows().iter().for_each(|row| all.push(row.clone())),
    }
}

/// One table of what `study` finds in each of several recordings, printed and, with `--out`, written as `csv`
/// beside its charts.
pub(crate) fn each_recording(
    files: &[PathBuf],
    read: &ReadFlags,
    ctx: &Context,
    csv: &str,
    study: impl Fn(&Recording) -> Result<(Table, [(&'static str, LineChart); 2]), Failure>,
) -> Result<(), Failure> {
    let mut outputs = match &ctx.out {
        Some(_) => Some(ctx.outputs("out")?),
        None => None,
    };
    let mut all: Option<Table> = None;
    for (i, file) in files.iter().enumerate() {
        let recording = foveasim_traces::read_path(file, &read.options())?;
        let (table, charts) = study(&recording)?;
        if let Some(outputs) = &mut outputs {
            let stem = file
                .file_stem()
                .and_then(|s| s.to_str())
                .unwrap_or("recording");
            for (what, chart) in charts {
                outputs.add(format!("{:02}_{stem}_{what}.svg", i + 1), chart.svg());
            }
        }
        append(&mut all, table);
    }
    let Some(table) = all else { return Ok(()) };
    if let Some(mut outputs) = outputs {
        outputs.add(csv, table.csv());
        outputs.commit()?;
    }
    ctx.print_table(&table)
}

/// Writes a recording to a file, or to standard output.
fn deliver(recording: &Recording, to: &Destination, ctx: &Context) -> Result<(), Failure> {
    let mut bytes = Vec::new();
    foveasim_traces::write(recording, &mut bytes)?;
    match (&to.to, &ctx.out) {
        (Some(path), _) => ctx.write_file(path, &bytes, to.force),
        (None, Some(_)) => Err(Failure::bad_input("--out needs --to: the name of the file")),
        (None, None) => ctx.print(&String::from_utf8(bytes)?),
    }
}
