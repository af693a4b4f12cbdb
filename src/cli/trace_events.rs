use std::path::PathBuf;

use foveasim_study::EventStudy;
use foveasim_traces::{EventMethod, EventOptions};

use super::trace::ReadFlags;
use super::{Context, Failure};

/// Fixations, saccades and blinks of a recording, its main sequence, and agreement with its own labels.
///
/// Saccades by speed have limits that adapt to the noise (Nyström & Holmqvist 2010); fixations by dispersion
/// are those of I-DT (Salvucci & Goldberg 2000). Where the file has events (EyeLink, Pupil Invisible) or
/// targets, the table says how well they agree. With --out: events.csv, events_summary.csv, gaze_events.svg,
/// main_sequence_peak.svg and main_sequence_duration.svg.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim trace events recording.asc
  foveasim trace events gaze.tsv --method dispersion --dispersion-deg 1.5 --out events")]
pub(crate) struct Args {
    /// The recording
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// How saccades and fixations are told apart: velocity or dispersion
    #[arg(long, value_name = "METHOD", default_value = "velocity")]
    method: EventMethod,
    /// Half of the window that speeds are taken over [ms]
    #[arg(long, value_name = "MS", default_value_t = EventOptions::default().half_window_ms)]
    half_window_ms: f64,
    /// Least peak speed of a saccade, however low the noise, with --method velocity [deg/s] [default: 30]
    #[arg(long, value_name = "SPEED")]
    floor_deg_per_s: Option<f64>,
    /// Largest dispersion of a fixation, width plus height, with --method dispersion [deg] [default: 1]
    #[arg(long, value_name = "DEG")]
    dispersion_deg: Option<f64>,
    /// Shortest fixation [ms]
    #[arg(long, value_name = "MS", default_value_t = EventOptions::default().min_fixation_ms)]
    min_fixation_ms: f64,
    #[command(flatten)]
    read: ReadFlags,
}

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let (floor, dispersion) = (args.floor_deg_per_s, args.dispersion_deg);
    let ignored = match args.method {
        EventMethod::Velocity => {
            dispersion.map(|deg| ("--dispersion-deg", deg, EventMethod::Dispersion))
        }
        EventMethod::Dispersion => {
            floor.map(|speed| ("--floor-deg-per-s", speed, EventMethod::Velocity))
        }
    };
    if let Some((flag, value, method)) = ignored {
        return Err(Failure::bad_input(format!(
            "{flag} = {value}: must be absent, unless with --method {}",
            method.name()
        )));
    }
    let default = EventOptions::default();
    let options = EventOptions {
        method: args.method,
        half_window_ms: args.half_window_ms,
        floor_deg_per_s: floor.unwrap_or(default.floor_deg_per_s),
        dispersion_deg: dispersion.unwrap_or(default.dispersion_deg),
        min_fixation_ms: args.min_fixation_ms,
        ..default
    };
    options.validate()?;
    let (recording, labels) =
        foveasim_traces::read_labelled_path(&args.file, &args.read.options())?;
    let study = EventStudy::new(&recording, &labels, &options)?;
    let summary = study.summary();
    if ctx.out.is_some() {
        let mut outputs = ctx.outputs("out")?;
        outputs.add("events.csv", study.table().csv());
        outputs.add("events_summary.csv", summary.csv());
        outputs.add("gaze_events.svg", study.gaze_chart(&recording).svg());
        outputs.add("main_sequence_peak.svg", study.peak_chart().svg());
        outputs.add("main_sequence_duration.svg", study.duration_chart().svg());
        outputs.commit()?;
    }
    ctx.print_table(&summary)
}
