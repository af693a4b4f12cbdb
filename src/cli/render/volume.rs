//! `render` of volumes.

use std::path::PathBuf;
use std::time::Instant;

use foveasim_assets::{TransferFunction, ValueHistogram, Volume};
use foveasim_models::{Display, Image, View, srgb8_from_linear};
use foveasim_quality::{Rings, compare};
use foveasim_render::{Frame, RenderOptions, assemble};
use foveasim_reports::{Cell, ERROR_FULL_SCALE, LineChart, LineSeries, Table, error_map, png};
use foveasim_study::{FrameOutcome, Shot};
use foveasim_volume::{CastOptions, CastWork, Caster, Phong, VolumeFrame, orbit};

use super::{Args, request};
use crate::cli::{Context, Failure};

/// What is only said of volumes.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Volumes")]
pub(crate) struct VolumeArgs {
    /// Colour and opacity of values: a TOML file of [[point]] tables with value, srgb and opacity [default:
    /// found from the histogram]
    #[arg(long, value_name = "FILE")]
    transfer: Option<PathBuf>,
    /// Distance from sample to sample along a ray, in voxels [default: 0.5]
    #[arg(long, value_name = "VOXELS", allow_hyphen_values = true)]
    step: Option<f64>,
    /// A ray ends where what is behind could change no channel by this much, 0 to below 1; 0: never
    /// [default: 1/255]
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    terminate: Option<f32>,
    /// Shift each ray's samples by a random part of a step, by --seed
    #[arg(long)]
    jitter_rays: bool,
    /// Colours as the transfer function has them, without light
    #[arg(long)]
    unlit: bool,
    /// Where the eye is about the volume: degrees to the right, degrees above, and perhaps the distance as a
    /// multiple of the nearest one from which all is seen [default: 35,20,1]
    #[arg(
        long,
        value_name = "RIGHT,ABOVE[,TIMES]",
        value_parser = place,
        allow_hyphen_values = true,
        conflicts_with = "camera"
    )]
    orbit: Option<[f64; 3]>,
    /// Which of a file's volumes in time, from 0 [default: 0]
    #[arg(long, value_name = "N")]
    volume_number: Option<usize>,
}

fn place(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|v| v.trim().parse().ok()).collect();
    let (a, b, times) = match numbers.as_deref() {
        Some(&[a, b]) => (a, b, 1.0),
        Some(&[a, b, times]) => (a, b, times),
        _ => return Err("want two or three numbers, as in 35,20 or 35,20,1.5".into()),
    };
    let valid = a.abs() <= 360.0 && b.abs() <= 90.0 && (0.01..=100.0).contains(&times);
    if valid {
        Ok([a, b, times])
    } else {
        Err("want degrees within ±360 and ±90, and a distance from 0.01 to 100".into())
    }
}

impl VolumeArgs {
    /// Refuses these flags where no volume is drawn.
    pub(super) fn check(&self) -> Result<(), Failure> {
        let given = [
            ("--transfer", self.transfer.is_some()),
            ("--step", self.step.is_some()),
            ("--terminate", self.terminate.is_some()),
            ("--jitter-rays", self.jitter_rays),
            ("--unlit", self.unlit),
            ("--orbit", self.orbit.is_some()),
            ("--volume-number", self.volume_number.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((flag, _)) => Err(Failure::bad_input(format!("{flag}: only with a volume"))),
            None => Ok(()),
        }
    }

    fn transfer(&self, volume: &Volume) -> Result<TransferFunction, Failure> {
        let Some(path) = &self.transfer else {
            return Ok(TransferFunction::of_volume(volume));
        };
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path)
            .map_err(|e| Failure::bad_input(format!("{name}: cannot be read: {e}")))?;
        Ok(TransferFunction::from_toml(&name, &text)?)
    }
}

/// Draws a volume by a method and at full resolution.
pub(super) fn run(args: &Args, display: &Display, ctx: &Context) -> Result<(), Failure> {
    if args.stereo {
        return Err(Failure::bad_input("--stereo: not with a volume"));
    }
    let (instructions, skip_empty) = args.drawing.of_volume()?;
    let request = request(args, display.primary(), display)?;
    let plan = args.method.plan(&request)?;
    let flags = &args.volume;
    let volume = args.scene.volume(flags.volume_number.unwrap_or(0), ctx)?;
    let transfer = flags.transfer(&volume)?;
    let defaults = CastOptions::default();
    let cast = CastOptions {
        step_voxels: flags.step.unwrap_or(defaults.step_voxels),
        terminate: flags.terminate.unwrap_or(defaults.terminate),
        jitter: flags.jitter_rays.then_some(ctx.seed),
        phong: (!flags.unlit).then(Phong::default),
        skip_empty,
        instructions,
        ..defaults
    };
    // Fails now, not after the work, if there is nowhere to write.
    let mut outputs = ctx.outputs("out")?;
    let began = Instant::now();
    let caster = Caster::new(&volume, &transfer, &cast)?;
    let prepared_s = began.elapsed().as_secs_f64();

    let bounds = volume.bounds();
    let middle = (bounds[0] + bounds[1]) / 2.0;
    let [azimuth, elevation, times] = flags.orbit.unwrap_or([35.0, 20.0, 1.0]);
    let own = orbit(bounds, &request.viewport, azimuth, elevation, times)
        .ok_or_else(|| Failure::bad_input("--orbit: is no place to look from"))?;
    let eye = args.scene.eye(own, Some(middle.to_array()))?;
    let view = View::still(request.eye, request.viewport, eye);
    let bar = ctx.progress(2, "casting rays");
    let reference = caster.full(&view)?;
    bar.inc(1);
    let passes = caster.passes(&view, &plan)?;
    bar.finish_and_clear();

    let work = work_table(&args.method.to_string(), &reference, &passes);
    let images: Vec<Image> = passes.into_iter().map(|p| p.image).collect();
    let drawing = RenderOptions {
        simd: instructions,
        keep_passes: args.passes,
        ..RenderOptions::default()
    };
    let frame = assemble(&view, &plan, images, &drawing)?;
    let comparison = compare(&frame.image, &reference.image)?;
    let gaze = request.gaze.vector();
    let rings = comparison.rings(&request.viewport, gaze, &Rings::default())?;
    let outcome = FrameOutcome {
        reference: plain(reference),
        shots: vec![Shot {
            method: args.method,
            plan,
            frame,
            measures: comparison.whole,
            rings,
        }],
    };
    let (shot, reference) = (&outcome.shots[0], &outcome.reference.image);
    outputs.add("frame.png", png(&shot.frame.image)?);
    outputs.add("reference.png", png(reference)?);
    let error = error_map(&shot.frame.image, reference, ERROR_FULL_SCALE)?;
    outputs.add("error.png", png(&error.image)?);
    for (k, pass) in super::pictures(&shot.frame) {
        outputs.add(format!("pass-{k}.png"), png(pass)?);
    }
    outputs.add("transfer.svg", chart(&volume, &transfer).svg());
    outputs.add("work.csv", work.csv());
    let quality = outcome.quality_table();
    outputs.add("quality.csv", quality.csv());
    let dir = outputs.dir().display().to_string();
    outputs.commit()?;
    ctx.print_table(&quality)?;
    let (count, kept) = (shot.plan.count(), caster.prepared());
    ctx.note(&format!(
        "{}: {} samples for {} pixels, {:.2} times fewer; {} voxels made ready in {:.2} s and {:.0} MiB, {:.0} % \
         of them can be seen; files in {dir}",
        shot.plan.method,
        count.samples(),
        count.display_pixels,
        count.ratio(),
        volume.voxels().len(),
        prepared_s,
        (kept.voxel_bytes + kept.other_bytes) as f64 / f64::from(1 << 20),
        100.0 * kept.parts_seen as f64 / kept.parts as f64,
    ));
    Ok(())
}

/// A cast image as a frame; its work stands in a table of its own.
fn plain(drawn: VolumeFrame) -> Frame {
    Frame {
        image: drawn.image,
        work: Default::default(),
        pass_work: Vec::new(),
        passes: Vec::new(),
    }
}

/// What casting took: of the reference, of each pass, and of all passes.
fn work_table(method: &str, reference: &VolumeFrame, passes: &[VolumeFrame]) -> Table {
    let counters = CastWork::default().rows().map(|(name, _)| name);
    let columns = ["image", "method", "pass"].into_iter().chain(counters);
    let mut table = Table::new(columns);
    let mut row = |image: &str, method: &str, pass: String, work: &CastWork| {
        let head: [Cell; 3] = [image.into(), method.to_owned().into(), pass.into()];
        let counts = work.rows().map(|(_, n)| n.into());
        table.push(head.into_iter().chain(counts).collect());
    };
    row("reference", "full", "all".into(), &reference.work);
    let mut all = CastWork::default();
    for (k, pass) in passes.iter().enumerate() {
        row("frame", method, k.to_string(), &pass.work);
        all += pass.work;
    }
    row("frame", method, "all".into(), &all);
    table
}

/// A transfer function over the values of a volume, beside how many voxels have them.
fn chart(volume: &Volume, transfer: &TransferFunction) -> LineChart {
    const BINS: usize = 256;
    let histogram = ValueHistogram::new(volume, BINS);
    let [low, high] = histogram.range;
    let mut values: Vec<f64> = (0..=BINS)
        .map(|k| low + (high - low) * k as f64 / BINS as f64)
        .chain(transfer.points().iter().map(|p| p.value))
        .filter(|v| (low..=high).contains(v))
        .collect();
    values.sort_by(f64::total_cmp);
    let line = |label: &str, f: &dyn Fn(f64) -> f64| LineSeries {
        label: label.into(),
        points: values.iter().map(|v| [*v, f(*v)]).collect(),
    };
    let srgb = |v: f64, part: usize| {
        let (colour, _) = transfer.at(v);
        f64::from(srgb8_from_linear(colour[part] as f32)) / 255.0
    };
    let most = histogram.counts.iter().copied().max().unwrap_or(0) as f64;
    let counts = histogram.counts.iter().enumerate().map(|(k, n)| {
        let share = foveasim_models::math::log(*n as f64 + 1.0)
            / foveasim_models::math::log(most + 1.0).max(f64::MIN_POSITIVE);
        [histogram.middle(k), share]
    });
    let counts = LineSeries {
        label: "voxels (logarithm, of the most)".into(),
        points: counts.collect(),
    };
    LineChart {
        title: "Transfer function".into(),
        x_label: "value".into(),
        y_label: "share".into(),
        series: vec![
            line("opacity of one voxel", &|v| transfer.at(v).1),
            counts,
            line("red (sRGB)", &|v| srgb(v, 0)),
            line("green", &|v| srgb(v, 1)),
            line("blue", &|v| srgb(v, 2)),
        ],
        ..LineChart::default()
    }
}
