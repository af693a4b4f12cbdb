mod bruder;

use std::time::Instant;

use foveasim_models::unknown_name;
use foveasim_reports::Outputs;
use foveasim_study::{
    AllPublished, Clock, Friston2019, Guenter2012, KernelErrors, KernelMeasured, KernelTimes,
    Meng2020, Paper, Progress, Published, Reproduction, Stein2021, Verdict,
};

use super::context::Format;
use super::{Context, Failure, options};
use bruder::BruderArgs;

/// Reproduce a paper's tables and figures, ours beside theirs.
///
/// Writes each table as CSV, each figure as SVG, and report.html with all of them and what differs.
/// Times are measured on this machine: leave it alone meanwhile. `all` exits 1 if a number that should agree does not.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim reproduce guenter2012 --out guenter2012
  foveasim reproduce guenter2012 --quick --out quick
  foveasim reproduce meng2020 --out meng2020
  foveasim reproduce friston2019 --quick --out friston2019
  foveasim reproduce bruder2019 --cache masks --out bruder2019
  foveasim reproduce bruder2019 --volume ct.nii.gz --volume jet:128 --cameras 16 --gazes 8
  foveasim reproduce stein2021
  foveasim reproduce all --quick --out reproduced
  foveasim reproduce guenter2012 --frames 48 --antialiasing-frames 0 --out times-only")]
pub(crate) struct Args {
    /// The paper: guenter2012 (Foveated 3D Graphics), meng2020 (Eye-dominance-guided Foveated
    /// Rendering: its equations, what its Fig. 7 says of them, and times and errors measured), friston2019
    /// (Perceptual Rasterization: foveated and rolling frames over scenes and strengths, head poses), bruder2019
    /// (Voronoi-Based Foveated Volume Rendering: its Table 1, and error by ring), or stein2021 (latencies of three headsets, predicted
    /// from their presets); or all: every one of them, and a table of each number that they print
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
    bruder: BruderArgs,
}

/// Every paper, one after the other.
const ALL: &str = "all";

/// Runs for each headset of Stein 2021.
const RUNS: u64 = 200_000;

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    if args.paper == ALL {
        return all(args, ctx);
    }
    let paper = args.paper()?;
    args.refuse(paper)?;
    // An unwritable folder is found before the work, not after.
    let outputs = match ctx.out.is_some() || paper.is_drawn() {
        true => Some(ctx.outputs("out")?),
        false => None,
    };
    let found = with_bar(ctx, |clock, progress| {
        args.reproduce(paper, ctx, clock, progress)
    })?;
    let report = outputs.map(|o| write(&found, o)).transpose()?;
    for (k, (heading, table)) in found.summary.iter().enumerate() {
        if k > 0 && ctx.format != Format::Table {
            break;
        }
        match (k, *heading) {
            (0, _) => {}
            (_, "") => ctx.print("\n")?,
            (_, heading) => ctx.print(&format!("\n{heading}\n\n"))?,
        }
        ctx.print_table(table)?;
    }
    match report.flatten() {
        Some(path) if ctx.format == Format::Table => ctx.print(&format!("\nreport  {path}\n")),
        _ => Ok(()),
    }
}

/// Every paper in a folder of its own, and one table of all their printed numbers.
fn all(args: &Args, ctx: &Context) -> Result<(), Failure> {
    args.refuse_of_all()?;
    // Unwritable folders are found before the work, not after.
    let mut outputs = ctx.outputs("out")?;
    let mut folders = Vec::new();
    for paper in Paper::ALL {
        folders.push((paper, Outputs::new(outputs.path(paper.name()))?));
    }
    let mut numbers = Vec::new();
    for (paper, folder) in folders {
        let found = with_bar(ctx, |clock, progress| {
            let named = |what: &str, done: f64| progress(&format!("{paper}: {what}"), done);
            args.reproduce(paper, ctx, clock, &named)
        })?;
        write(&found, folder)?;
        numbers.extend(found.published);
    }
    let all = AllPublished {
        numbers,
        quick: args.quick,
    };
    outputs.add("published.csv", Published::table(&all.numbers).csv());
    outputs.add(Reproduction::PAGE, all.page());
    let report = outputs.path(Reproduction::PAGE);
    outputs.commit()?;
    if ctx.format == Format::Table {
        ctx.print_table(&Published::short_table(&all.numbers))?;
        ctx.print(&format!(
            "\n{}\n\nreport  {}\n",
            all.sentence(),
            report.display()
        ))?;
    } else {
        ctx.print_table(&Published::table(&all.numbers))?;
    }
    match all.of(Verdict::Differs).next() {
        None => Ok(()),
        Some(first) => Err(Failure::CheckFailed(format!(
            "{} of {} numbers differ from what is printed, without an explanation; the first: {}, {}, {}: {} where {} is printed",
            all.count(Verdict::Differs),
            all.numbers.len(),
            first.paper,
            first.place,
            first.quantity,
            first.ours,
            first.printed_value(),
        ))),
    }
}

/// Shows how far `run` is, and gives it the time.
fn with_bar<T>(
    ctx: &Context,
    run: impl FnOnce(&mut Clock<'_>, &Progress<'_>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let bar = ctx.progress(1000, "starting");
    let began = Instant::now();
    let found = run(&mut || began.elapsed(), &|what, done| {
        bar.set_message(what.to_owned());
        bar.set_position((done * 1000.0) as u64);
    });
    bar.finish_and_clear();
    found
}

/// Writes all files of a reproduction; where its page is, if it has one.
fn write(found: &Reproduction, mut outputs: Outputs) -> Result<Option<String>, Failure> {
    for (name, bytes) in found.files() {
        outputs.add(name, bytes);
    }
    for name in &found.retired {
        outputs.retire(*name);
    }
    let page = outputs.path(Reproduction::PAGE);
    outputs.commit()?;
    let page = found.page.is_some().then_some(page);
    Ok(page.map(|path| path.display().to_string()))
}

impl Args {
    /// The paper that is asked for.
    fn paper(&self) -> Result<Paper, Failure> {
        let name = self.paper.as_str();
        let known = Paper::ALL.into_iter().find(|p| p.name() == name);
        let mut names = Paper::ALL.map(Paper::name).to_vec();
        names.push(ALL);
        known.ok_or_else(|| unknown_name("paper", name, &names).into())
    }

    /// Refuses flags that are of single papers.
    fn refuse_of_all(&self) -> Result<(), Failure> {
        let given = self.frames.is_some()
            || self.size.is_some()
            || self.antialiasing_frames.is_some()
            || self.antialiasing_size.is_some()
            || self.bruder.is_given();
        if given {
            let text = "all takes --quick alone: other flags are for single papers";
            return Err(Failure::bad_input(text));
        }
        Ok(())
    }

    /// Refuses flags that are of other papers.
    fn refuse(&self, paper: Paper) -> Result<(), Failure> {
        if paper != Paper::Bruder2019 {
            self.bruder.refuse(paper)?;
        }
        let antialiasing = self.antialiasing_frames.is_some() || self.antialiasing_size.is_some();
        let drawn = antialiasing || self.frames.is_some() || self.size.is_some() || self.quick;
        if drawn && !paper.is_drawn() {
            return Err(Failure::bad_input(format!(
                "{paper} draws nothing: --frames, --size, --antialiasing-* and --quick are for papers that do"
            )));
        }
        if antialiasing && paper != Paper::Guenter2012 {
            return Err(Failure::bad_input(format!(
                "{paper} has no antialiasing: --antialiasing-* are for guenter2012"
            )));
        }
        Ok(())
    }

    /// Measures and computes what there is of a paper.
    fn reproduce(
        &self,
        paper: Paper,
        ctx: &Context,
        clock: &mut Clock<'_>,
        progress: &Progress<'_>,
    ) -> Result<Reproduction, Failure> {
        Ok(match paper {
            Paper::Guenter2012 => self.guenter(ctx).run(clock, progress)?.reproduction(),
            Paper::Meng2020 => {
                let (times, errors) = self.meng(ctx);
                let measured = KernelMeasured::run(&times, &errors, clock, progress)?;
                Meng2020::new()?.reproduction(&measured)
            }
            Paper::Friston2019 => self.friston(ctx).run(clock, progress)?.reproduction()?,
            Paper::Bruder2019 => {
                let flags = (self.frames, self.size, self.quick);
                let found = match self.paper == ALL && !self.quick {
                    true => BruderArgs::AFFORDABLE.run(flags, ctx, clock, progress)?,
                    false => self.bruder.run(flags, ctx, clock, progress)?,
                };
                found.reproduction()?
            }
            Paper::Stein2021 => Stein2021::run(RUNS, ctx.seed)?.reproduction(),
        })
    }

    fn guenter(&self, ctx: &Context) -> Guenter2012 {
        let default = match self.quick {
            true => Guenter2012::quick(),
            false => Guenter2012::default(),
        };
        Guenter2012 {
            size: self.size.map_or(default.size, Into::into),
            moments: self.frames.unwrap_or(default.moments),
            antialiasing_frames: self
                .antialiasing_frames
                .unwrap_or(default.antialiasing_frames),
            antialiasing_size: self
                .antialiasing_size
                .map_or(default.antialiasing_size, Into::into),
            seed: ctx.seed,
        }
    }

    fn friston(&self, ctx: &Context) -> Friston2019 {
        let default = match self.quick {
            true => Friston2019::quick(),
            false => Friston2019::default(),
        };
        Friston2019 {
            size: self.size.map_or(default.size, Into::into),
            rounds: self.frames.unwrap_or(default.rounds),
            seed: ctx.seed,
            ..default
        }
    }

    /// What is measured of Meng 2020: times, and errors.
    fn meng(&self, ctx: &Context) -> (KernelTimes, KernelErrors) {
        let seed = ctx.seed;
        if self.quick {
            let (times, errors) = (KernelTimes::quick(), KernelErrors::quick());
            return (
                KernelTimes { seed, ..times },
                KernelErrors { seed, ..errors },
            );
        }
        let moments = self.frames.unwrap_or(4);
        let size = self.size.unwrap_or([1280, 1440]).into();
        let times = KernelTimes {
            size,
            moments,
            rounds: 7,
            seed,
        };
        let errors = KernelErrors {
            size,
            moments,
            reference_samples: 8,
            seed,
        };
        (times, errors)
    }
}
