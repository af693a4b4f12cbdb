mod bruder;

use std::time::Instant;

use foveasim_models::unknown_name;
use foveasim_study::{
    Friston2019, Guenter2012, KernelErrors, KernelMeasured, KernelTimes, Meng2020, Stein2021,
};

use super::context::Format;
use super::{Context, Failure, options};

/// Reproduce a paper's tables and figures, ours beside theirs.
///
/// Writes each table as CSV, each figure as SVG, and report.html with all of them and what differs.
/// Times are measured on this machine: leave it alone meanwhile.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim reproduce guenter2012 --out guenter2012
  foveasim reproduce guenter2012 --quick --out quick
  foveasim reproduce meng2020 --out meng2020
  foveasim reproduce friston2019 --quick --out friston2019
  foveasim reproduce bruder2019 --cache masks --out bruder2019
  foveasim reproduce bruder2019 --volume ct.nii.gz --volume jet:128 --cameras 16 --gazes 8
  foveasim reproduce stein2021
  foveasim reproduce guenter2012 --frames 48 --antialiasing-frames 0 --out times-only")]
pub(crate) struct Args {
    /// The paper: guenter2012 (Foveated 3D Graphics), meng2020 (Eye-dominance-guided Foveated
    /// Rendering: its equations, what its Fig. 7 says of them, and times and errors measured), friston2019
    /// (Perceptual Rasterization: foveated and rolling frames over scenes and strengths, head poses), bruder2019
    /// (Voronoi-Based Foveated Volume Rendering: its Table 1, and error by ring), or stein2021 (latencies of three headsets, predicted
    /// from their presets)
    #[arg(value_name = "PAPER")]
    paper: String,
    /// Moments of the fly-through at which things are measured; Figs 10 and 11 of guenter2012 take a third
    /// [default: 8; meng2020: 4]; for friston2019 rounds of each time [default: 5]; for bruder2019 frames for each gaze, of
    /// which the median counts [default: 3]
    #[arg(long, value_name = "N", conflicts_with = "quick")]
    frames: Option<u32>,
    /// Pixels of the image, of each eye's for meng2020; the field of view is that of the study's display
    /// [default: 1920x1080; meng2020: 1280x1440; friston2019: 1024x1024, 90 degrees across; bruder2019: 1024x1024]
    #[arg(long, value_name = "WxH", value_parser = options::size, conflicts_with = "quick")]
    size: Option<[u32; 2]>,
    /// Consecutive frames on which antialiasing is judged against 8 x 8 samples to the pixel; 0 for none [default: 12]
    #[arg(long, value_name = "N", conflicts_with = "quick")]
    antialiasing_frames: Option<u32>,
    /// Pixels of those frames [default: 960x540]
    #[arg(long, value_name = "WxH", value_parser = options::size, conflicts_with = "quick")]
    antialiasing_size: Option<[u32; 2]>,
    /// Small pictures of few moments: seconds instead of minutes, and times that mean little
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    bruder: bruder::BruderArgs,
}

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let paper = args.paper.as_str();
    if paper == "bruder2019" {
        return bruder2019(args, ctx);
    }
    args.bruder.refuse(paper)?;
    match paper {
        "guenter2012" => {}
        "meng2020" => return meng2020(args, ctx),
        "friston2019" => return friston2019(args, ctx),
        "stein2021" => return stein2021(args, ctx),
        other => {
            let papers = [
                "bruder2019",
                "friston2019",
                "guenter2012",
                "meng2020",
                "stein2021",
            ];
            return Err(unknown_name("paper", other, &papers).into());
        }
    }
    let asked = asked(args, ctx);
    // An unwritable folder is found before the work, not after.
    let mut outputs = ctx.outputs("out")?;
    let bar = ctx.progress(1000, "starting");
    let began = Instant::now();
    let found = asked.run(&mut || began.elapsed(), &|what, done| {
        bar.set_message(what.to_owned());
        bar.set_position((done * 1000.0) as u64);
    })?;
    for (name, bytes) in found.files()? {
        outputs.add(name, bytes);
    }
    bar.finish_and_clear();
    if found.antialiasing.is_empty() {
        // An earlier run's must not stand beside a report that does not speak of them.
        for name in [
            "antialiasing.csv",
            "antialiasing-flicker.svg",
            "antialiasing-pixels.svg",
            "antialiasing-ssim.svg",
        ] {
            outputs.retire(name);
        }
    }
    let report = outputs.path("report.html");
    outputs.commit()?;
    ctx.print_table(&found.summary())?;
    if ctx.format == Format::Table {
        ctx.print(&format!("\nreport  {}\n", report.display()))?;
    }
    Ok(())
}

fn bruder2019(args: &Args, ctx: &Context) -> Result<(), Failure> {
    if args.antialiasing_frames.is_some() || args.antialiasing_size.is_some() {
        let text = "bruder2019 has no antialiasing: --antialiasing-* are for guenter2012";
        return Err(Failure::bad_input(text));
    }
    args.bruder.run(args.frames, args.size, args.quick, ctx)
}

/// Runs for each headset of Stein 2021.
const RUNS: u64 = 200_000;

/// Refuses flags of guenter2012's antialiasing.
fn no_antialiasing(args: &Args, paper: &str) -> Result<(), Failure> {
    if args.antialiasing_frames.is_some() || args.antialiasing_size.is_some() {
        let text = format!("{paper} has no antialiasing: --antialiasing-* are for guenter2012");
        return Err(Failure::bad_input(text));
    }
    Ok(())
}

fn friston2019(args: &Args, ctx: &Context) -> Result<(), Failure> {
    no_antialiasing(args, "friston2019")?;
    let default = if args.quick {
        Friston2019::quick()
    } else {
        Friston2019::default()
    };
    let asked = Friston2019 {
        size: args.size.map_or(default.size, Into::into),
        rounds: args.frames.unwrap_or(default.rounds),
        seed: ctx.seed,
        ..default
    };
    let mut outputs = ctx.outputs("out")?;
    let bar = ctx.progress(1000, "starting");
    let began = Instant::now();
    let found = asked.run(&mut || began.elapsed(), &|what, done| {
        bar.set_message(what.to_owned());
        bar.set_position((done * 1000.0) as u64);
    })?;
    bar.finish_and_clear();
    for (name, bytes) in found.files()? {
        outputs.add(name, bytes);
    }
    let report = outputs.path("report.html");
    outputs.commit()?;
    ctx.print_table(&found.foveated_table())?;
    if ctx.format == Format::Table {
        ctx.print(&format!("\nreport  {}\n", report.display()))?;
    }
    Ok(())
}

fn meng2020(args: &Args, ctx: &Context) -> Result<(), Failure> {
    no_antialiasing(args, "meng2020")?;
    let (times, errors) = measured(args, ctx);
    let mut outputs = ctx.outputs("out")?;
    let found = Meng2020::new()?;
    let bar = ctx.progress(1000, "starting");
    let began = Instant::now();
    let measured = KernelMeasured::run(&times, &errors, &mut || began.elapsed(), &|what, done| {
        bar.set_message(what.to_owned());
        bar.set_position((done * 1000.0) as u64);
    })?;
    bar.finish_and_clear();
    for (name, bytes) in found.files().into_iter().chain(measured.files()) {
        outputs.add(name, bytes);
    }
    let mut page = found.page();
    measured.add_to(&mut page);
    outputs.add("report.html", page.html());
    let report = outputs.path("report.html");
    outputs.commit()?;
    ctx.print_table(&found.caption())?;
    if ctx.format == Format::Table {
        ctx.print("\n")?;
        ctx.print_table(&measured.timings.table())?;
        ctx.print(&format!("\nreport  {}\n", report.display()))?;
    }
    Ok(())
}

/// What is measured of Meng 2020, as flags have it.
fn measured(args: &Args, ctx: &Context) -> (KernelTimes, KernelErrors) {
    let (quick_times, quick_errors) = (KernelTimes::quick(), KernelErrors::quick());
    if args.quick {
        return (
            KernelTimes {
                seed: ctx.seed,
                ..quick_times
            },
            KernelErrors {
                seed: ctx.seed,
                ..quick_errors
            },
        );
    }
    let moments = args.frames.unwrap_or(4);
    let size = args.size.unwrap_or([1280, 1440]).into();
    let times = KernelTimes {
        size,
        moments,
        rounds: 7,
        seed: ctx.seed,
    };
    let errors = KernelErrors {
        size,
        moments,
        reference_samples: 8,
        seed: ctx.seed,
    };
    (times, errors)
}

/// Refuses flags of a reproduction that draws.
fn draws_nothing(args: &Args, paper: &str) -> Result<(), Failure> {
    let drawn = args.frames.is_some()
        || args.size.is_some()
        || args.antialiasing_frames.is_some()
        || args.antialiasing_size.is_some()
        || args.quick;
    if drawn {
        let text = format!(
            "{paper} draws nothing: --frames, --size, --antialiasing-* and --quick are for papers that do"
        );
        return Err(Failure::bad_input(text));
    }
    Ok(())
}

fn stein2021(args: &Args, ctx: &Context) -> Result<(), Failure> {
    draws_nothing(args, "stein2021")?;
    let found = Stein2021::run(RUNS, ctx.seed)?;
    if ctx.out.is_some() {
        let mut outputs = ctx.outputs("out")?;
        outputs.add("stein2021.csv", found.table().csv());
        outputs.add("unverified.csv", found.unverified_table().csv());
        outputs.commit()?;
    }
    ctx.print_table(&found.table())?;
    if ctx.format == Format::Table {
        ctx.print("\nWhat this rests on that nobody could verify:\n\n")?;
        ctx.print_table(&found.unverified_table())?;
    }
    Ok(())
}

fn asked(args: &Args, ctx: &Context) -> Guenter2012 {
    let default = if args.quick {
        Guenter2012::quick()
    } else {
        Guenter2012::default()
    };
    Guenter2012 {
        size: args.size.map_or(default.size, Into::into),
        moments: args.frames.unwrap_or(default.moments),
        antialiasing_frames: args
            .antialiasing_frames
            .unwrap_or(default.antialiasing_frames),
        antialiasing_size: args
            .antialiasing_size
            .map_or(default.antialiasing_size, Into::into),
        seed: ctx.seed,
    }
}
