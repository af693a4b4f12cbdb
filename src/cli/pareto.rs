use std::path::PathBuf;

use anyhow::Context as _;
use foveasim_models::foveation::{Method, Request};
use foveasim_models::math::tan_deg;
use foveasim_models::{Acuity, Eye, GazeDirection, Msaa, Nanos, Rate, Viewport};
use foveasim_quality::Rings;
use foveasim_render::{RenderOptions, TemporalOptions};
use foveasim_reports::Outputs;
use foveasim_study::{
    Clip, ClipFrame, Drawing, ErrorMeasure, Export, Pareto, Scores, Terms, Timing, read_text,
};
use foveasim_traces::read_path;

use super::clock::{OF_PROCESSORS, on_one_thread, processor_time};
use super::context::Format;
use super::scene::{SceneArgs, Stage};
use super::{Context, Failure, options};

/// Time against error: every method and setting on chosen scenes and gaze recordings.
///
/// Draws consecutive frames by every method, compares each with a supersampled reference, and takes the processor time of
/// one thread, all methods in turn. Marks those that no other is both faster and closer than: the front. Over all scenes,
/// and for each.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim pareto --out pareto
  foveasim pareto --scene study@1500,room,machine --frames 8 --size 1280x720 --out pareto
  foveasim pareto --method layers:2,layers:3,vrs,fdm --measure dssim --error 0.05
  foveasim pareto --scene room --trace user116.csv --at 2 --frames 12 --out pareto
  foveasim pareto --no-time --format csv
  foveasim pareto --export frames && (cd frames && python3 score.py)
  foveasim pareto --import frames/scores.csv --measure jod --error 0.5

Measures of error: dssim (1 - SSIM of luma), rmse (of luma, grey levels of 255), flicker (of the error, followed along the
motion, grey levels), jod (10 - JOD of FovVideoVDP, with --import). None of the first three knows what the eye can see.
Times are of this project's renderer on one thread of this machine's processor; --no-time takes the cost profile's
instead, which are the same on every machine.")]
pub(crate) struct Args {
    /// Scenes: study or study@FRAME, hairball[:STRANDS], machine, room[:BARS], or files
    #[arg(long, value_name = "SCENES", default_value = "study@1500,room")]
    scene: String,
    /// Methods and settings; full is always among them
    #[arg(long, value_name = "METHODS", default_value = METHODS)]
    method: String,
    /// Consecutive frames of each scene that are judged and timed, 1 to 200
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=200))]
    frames: u32,
    /// Pixels of the image
    #[arg(long, value_name = "WxH", value_parser = options::size, default_value = "960x540")]
    size: [u32; 2],
    /// Horizontal field of view [deg]
    #[arg(
        long,
        value_name = "DEGREES",
        default_value_t = 80.0,
        allow_hyphen_values = true
    )]
    fov: f64,
    /// Frames a second
    #[arg(long, value_name = "HZ", value_parser = options::rate, default_value = "60")]
    rate: Rate,
    /// Where the eye looks, in pixels from the top left [default: straight ahead]
    #[arg(long, value_name = "X,Y", value_parser = options::pair, allow_hyphen_values = true, conflicts_with = "trace")]
    gaze: Option<[f64; 2]>,
    /// A gaze recording: where the eye looks in each frame
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Where in the recording the first frame is [s]
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = 0.0,
        requires = "trace"
    )]
    at: f64,
    /// How old the gaze is that methods follow [ms]
    #[arg(long, value_name = "MS", default_value_t = 0.0, requires = "trace")]
    gaze_age_ms: f64,
    /// Acuity slope: guenter-a, guenter-b, a quality index j:12, or a number
    #[arg(long, value_name = "SLOPE", value_parser = Acuity::parse, default_value = "guenter-a")]
    slope: Acuity,
    /// How far gaze may be off without being noticed [deg]
    #[arg(
        long = "margin-deg",
        visible_alias = "margin",
        value_name = "DEGREES",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    margin: f64,
    /// Samples along each side of a pixel of the reference, 1 to 16
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=16))]
    supersample: u32,
    /// Positions of visibility in each sample of the methods: 1 or 4
    #[arg(long, value_name = "1|4", default_value = "1", value_parser = ["1", "4"])]
    msaa: String,
    /// How often the frames are drawn for their time, 2 to 1000
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(2..=1000), conflicts_with = "no_time")]
    rounds: u32,
    /// Measure no time: take the cost profile's
    #[arg(long)]
    no_time: bool,
    /// Cost profile for --no-time: name or TOML file
    #[arg(
        long,
        visible_alias = "profile",
        value_name = "PROFILE",
        default_value = "guenter2012"
    )]
    cost: String,
    /// Measure of error for the front, the chart and --error: dssim, rmse, flicker or jod
    #[arg(long, value_name = "MEASURE", default_value = "dssim")]
    measure: ErrorMeasure,
    /// Say which method takes least time within this error
    #[arg(long, value_name = "ERROR", allow_hyphen_values = true)]
    error: Option<f64>,
    /// Write frames, gaze and display to a folder that FovVideoVDP judges, with a script that has it do so
    #[arg(long, value_name = "DIR")]
    export: Option<PathBuf>,
    /// Qualities that FovVideoVDP found: CSV with the columns clip, method, jod
    #[arg(long, value_name = "FILE")]
    import: Option<PathBuf>,
}

const METHODS: &str = "full,layers:2,layers:3,layers:4,layers:3:strict,vrs,fdm,rates,quad,quad:auto,\
                       kfr:1.8:4,kfr:2.4:4,lms:0.5:0.5,radial:1.5:scale=0.7,radial:2:scale=0.6";
/// Frames drawn before those that count.
const WARM_UP: u32 = 1;
/// Most pictures of one export: each is kept until all are written.
const MOST_PICTURES: usize = 2000;
/// Holes in a recording no longer than this are bridged.
const MAX_GAP: Nanos = Nanos(100_000_000);

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    if !(args.fov > 0.0 && args.fov < 180.0) {
        let text = format!("--fov {}: must be above 0 and below 180 degrees", args.fov);
        return Err(Failure::bad_input(text));
    }
    if args.error.is_some_and(|e| !(0.0..=1e6).contains(&e)) {
        let text = "--error: must be a number from 0 to 1000000";
        return Err(Failure::bad_input(text));
    }
    if args.measure == ErrorMeasure::Jod && args.import.is_none() {
        return Err(Failure::bad_input(
            "--measure jod: needs --import SCORES.csv",
        ));
    }
    if args.measure == ErrorMeasure::Flicker && args.frames == 1 {
        return Err(Failure::bad_input(
            "--measure flicker: needs --frames 2 or more",
        ));
    }
    let methods = Method::parse_list(&args.method).context("--method")?;
    let scores = args.import.as_deref().map(|path| {
        let origin = path.display().to_string();
        Ok::<_, Failure>(Scores::parse(&read_text(path)?, &origin)?)
    });
    let scores = scores.transpose()?;
    let viewport = Viewport::symmetric(args.size.into(), tan_deg(args.fov / 2.0))?;
    let gazes = args.gazes(&viewport)?;
    let names: Vec<&str> = args.scene.split(',').map(str::trim).collect();
    let stages = names.iter().map(|name| args.stage(name, &viewport, ctx));
    let stages = stages.collect::<Result<Vec<Stage>, Failure>>()?;
    let pareto = args.pareto(&methods, viewport, &gazes, &names, &stages)?;
    // Unwritable folders are found before the work, not after.
    let outputs = ctx.out.is_some().then(|| ctx.outputs("out")).transpose()?;
    let pictures = (pareto.methods().len() + 1) * names.len() * args.frames as usize;
    if args.export.is_some() && pictures > MOST_PICTURES {
        let text =
            format!("--export: {pictures} pictures; at most {MOST_PICTURES} are written at once");
        return Err(Failure::bad_input(text));
    }
    let mut exported = args.export.as_ref().map(Outputs::new).transpose()?;
    let mut export = Export::new(viewport, args.rate);
    let bar = ctx.progress(
        pareto.steps(if args.no_time { 0 } else { args.rounds }),
        "drawing",
    );
    let mut found = on_one_thread(|| {
        let mut clock = processor_time;
        let timing = match args.no_time {
            true => Timing::Predicted,
            false => Timing::Measured(&mut clock, args.rounds),
        };
        pareto.run(
            timing,
            &mut |clip, method, number, frame, reference| {
                if let Some(outputs) = &mut exported {
                    for (name, bytes) in export.frame(clip, method, number, frame, reference)? {
                        if let Some(folder) = outputs.path(&name).parent() {
                            std::fs::create_dir_all(folder)?;
                        }
                        outputs.add(name, bytes);
                    }
                }
                Ok::<(), Failure>(())
            },
            &mut || bar.inc(1),
        )
    })??;
    bar.finish_and_clear();
    if !args.no_time && !OF_PROCESSORS {
        ctx.warn("this system has no clock of processor time: times are those that passed");
    }
    if let Some(scores) = &scores {
        found.join(scores);
        if found.overall().all(|row| row.jod.is_none()) {
            ctx.warn("--import: no score is of these clips and methods on all clips");
        }
    }
    if let Some(mut outputs) = exported {
        for (name, text) in export.finish(&pareto) {
            outputs.add(name, text);
        }
        let folder = outputs.dir().display().to_string();
        outputs.commit()?;
        ctx.note(&format!(
            "exported {pictures} pictures to {folder}: python3 {folder}/score.py"
        ));
    }
    let answer = args.error.map(|most| found.cheapest(args.measure, most));
    if ctx.format == Format::Table {
        ctx.print_table(&found.summary(args.measure))?;
        if let Some(noise) = found.noise {
            ctx.note(&format!(
                "Full resolution drawn again differs by {:.1} %.",
                100.0 * noise
            ));
        }
        if let Some(answer) = &answer {
            ctx.print(&format!("\n{answer}\n"))?;
        }
    } else {
        ctx.print_table(&found.table())?;
    }
    let Some(mut outputs) = outputs else {
        return Ok(());
    };
    outputs.add("pareto.csv", found.table().csv());
    outputs.add("pareto-rings.csv", found.rings().csv());
    outputs.add("pareto.json", found.summary(args.measure).json());
    outputs.add("pareto.svg", found.chart(args.measure).svg());
    if let Some(answer) = &answer {
        outputs.add("answer.txt", format!("{answer}\n"));
    }
    for path in outputs.commit()? {
        ctx.note(&format!("wrote {}", path.display()));
    }
    Ok(())
}

impl Args {
    /// A scene by name, as it is in so many frames.
    fn stage(&self, name: &str, viewport: &Viewport, ctx: &Context) -> Result<Stage, Failure> {
        let (base, frame) = super::scene::at_frame(name)?;
        let args = SceneArgs::named(base, frame);
        if args.is_volume() {
            let text = format!("--scene {name}: pareto draws meshes, not volumes");
            return Err(Failure::bad_input(text));
        }
        let period_s = self.rate.period().as_secs();
        args.stage(viewport, self.frames + WARM_UP, [period_s, 0.0], ctx)
    }

    /// Where the eye looks in each frame, and where methods take it to look.
    fn gazes(&self, viewport: &Viewport) -> Result<Vec<[GazeDirection; 2]>, Failure> {
        let frames = self.frames + WARM_UP;
        let Some(path) = &self.trace else {
            let gaze = self
                .gaze
                .map_or(GazeDirection::AHEAD, |px| viewport.gaze_at(px.into()));
            return Ok(vec![[gaze; 2]; frames as usize]);
        };
        let age = options::milliseconds("--gaze-age-ms", self.gaze_age_ms)?;
        if !(0.0..=1e6).contains(&self.at) {
            let text = format!("--at {}: must be from 0 to 1000000 seconds", self.at);
            return Err(Failure::bad_input(text));
        }
        let recording = read_path(path, &foveasim_traces::ReadOptions::default())?;
        let origin = path.display();
        let gaze = recording.gaze.as_ref();
        let gaze = gaze.ok_or_else(|| Failure::bad_input(format!("{origin}: no gaze in it")))?;
        let start =
            recording.span().map_or(Nanos::ZERO, |(start, _)| start) + Nanos::from_secs(self.at);
        let at = |t: Nanos| {
            gaze.at(t, MAX_GAP).ok_or_else(|| {
                let text = format!(
                    "{origin}: no gaze at {:.3} s of it",
                    (t - start).as_secs() + self.at
                );
                Failure::bad_input(text)
            })
        };
        (0..frames)
            .map(|k| {
                let t = start + self.rate.tick(i64::from(k));
                Ok([at(t)?, at(t - age)?])
            })
            .collect()
    }

    fn pareto<'a>(
        &self,
        methods: &[Method],
        viewport: Viewport,
        gazes: &[[GazeDirection; 2]],
        names: &[&str],
        stages: &'a [Stage],
    ) -> Result<Pareto<'a>, Failure> {
        let clip = |(name, stage): (&&str, &'a Stage)| {
            let frames = stage.sights(|_| None).into_iter().zip(gazes);
            let short = std::path::Path::new(name).file_name();
            Clip {
                name: short.map_or((*name).into(), |n| n.to_string_lossy().into_owned()),
                frames: frames
                    .map(|(sight, [gaze, believed])| ClipFrame {
                        sight,
                        gaze: *gaze,
                        believed: *believed,
                    })
                    .collect(),
                first_frame: stage.first_frame,
            }
        };
        let near_m = stages
            .iter()
            .map(|s| s.near_m)
            .fold(f64::INFINITY, f64::min);
        let terms = Terms {
            cost: foveasim_study::cost(&self.cost).context("--cost")?,
            ..Terms::default()
        };
        Ok(Pareto {
            clips: names.iter().zip(stages).map(clip).collect(),
            methods: methods.to_vec(),
            request: Request {
                eye: Eye::Cyclopean,
                viewport,
                acuity: self.slope,
                gaze: GazeDirection::AHEAD,
                ahead: GazeDirection::AHEAD,
                margin_deg: self.margin,
            },
            drawing: Drawing {
                options: RenderOptions {
                    near_m,
                    ..RenderOptions::default()
                },
                msaa: if self.msaa == "4" {
                    Msaa::Four
                } else {
                    Msaa::One
                },
                temporal: TemporalOptions::OFF,
                reference_samples: self.supersample,
                lens: None,
            },
            rings: Rings::default(),
            warm_up: WARM_UP as usize,
            terms,
        })
    }
}
