mod stereo;
mod volume;

use foveasim_models::foveation::{Method, Request};
use foveasim_models::math::tan_deg;
use foveasim_models::{Display, EyePanel, Geometry, Image, Viewport};
use foveasim_render::{Frame, LARGEST_SIDE};
use foveasim_reports::{ERROR_FULL_SCALE, error_map, png};
use foveasim_study::FrameStudy;

use super::drawing::DrawingArgs;
use super::rolling::RollingArgs;
use super::scene::SceneArgs;
use super::{Context, Failure, options};

/// Draw one frame by any method beside its full-resolution reference, with an error map.
///
/// Writes frame.png, reference.png, error.png, work.csv (what both cost, pass by pass) and quality.csv
/// (PSNR and SSIM, whole and by ring of eccentricity), and prints quality.csv. With --frames N it draws
/// the frames that lead up to it, too, and blends what they have seen.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim render --out frames
  foveasim render --method layers:4 --size 1280x720 --gaze 300,200 --out frames
  foveasim render --display quest-pro --method layers:3:strict --frame 1200 --out frames
  foveasim render --scene controller.glb --method full --size 960x540 --out frames
  foveasim render --scene mesh.obj --camera 2,1,4 --look-at 0,1,0 --texture wall.png --out frames
  foveasim render --msaa 4 --frames 16 --staggered --supersample 8 --size 960x540 --out frames
  foveasim render --display quest-pro --stereo --method efr:2:3 --gaze-distance 2 --out frames
  foveasim render --method kfr:2:1 --passes --out frames
  foveasim render --method radial:2:scale=0.7 --rolling --head-velocity 200,0 --out frames
  foveasim render --method radial:2 --rolling --head-trace recording.csv --at 2.5 --lens 0.22,0.12 --out frames
  foveasim render --scene head.nii.gz --size 1024x1024 --fov 40 --out frames
  foveasim render --scene volume:shells:128 --orbit 60,10 --transfer bone.toml --out frames
  foveasim render --fov 70 --size 1920x1080 --slope guenter-b --margin-deg 2 --out frames")]
pub(crate) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Method, as in full, layers:3, layers:3:strict, vrs, fdm, rates or quad (see foveasim plan --help)
    #[arg(long, value_name = "METHOD", default_value = "layers:3")]
    method: Method,
    /// Display whose (first) eye's image is drawn: a preset or a TOML file
    #[arg(long, value_name = "NAME", default_value = "lg-w2363d")]
    display: String,
    /// Pixels of the image [default: the display's]
    #[arg(long, value_name = "WxH", value_parser = options::size)]
    size: Option<[u32; 2]>,
    /// Horizontal field of view [deg] [default: the display's]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    fov: Option<f64>,
    /// Where the (left) eye looks, in pixels from the top left; may lie outside [default: straight ahead]
    #[arg(long, value_name = "X,Y", value_parser = options::pair, allow_hyphen_values = true)]
    gaze: Option<[f64; 2]>,
    /// Acuity slope: guenter-a, guenter-b, a quality index j:12, or a number
    #[arg(
        long,
        value_name = "SLOPE",
        default_value = "guenter-a",
        allow_hyphen_values = true
    )]
    slope: String,
    /// How far gaze may be off without being noticed [deg]
    #[arg(
        long = "margin-deg",
        visible_alias = "margin",
        value_name = "DEGREES",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    margin: f64,
    /// Draw both eyes of a headset: left.png, right.png and so on
    #[arg(long)]
    stereo: bool,
    /// How far the left eye looks [m]; the right one looks at the same point (with --stereo) [default: the
    /// same direction, at infinity]
    #[arg(long, value_name = "METRES", requires = "stereo")]
    gaze_distance: Option<f64>,
    /// Write the samples of each pass as they lie in its lattice, too: pass-0.png and so on
    #[arg(long)]
    passes: bool,
    #[command(flatten)]
    rolling: RollingArgs,
    #[command(flatten)]
    drawing: DrawingArgs,
    #[command(flatten)]
    volume: volume::VolumeArgs,
}

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let display = options::display(&args.display)?;
    if args.scene.is_volume() {
        args.rolling.none_for_a_volume()?;
        return volume::run(args, &display, ctx);
    }
    args.volume.check()?;
    if args.stereo {
        return stereo::run(args, &display, ctx);
    }
    let request = request(args, display.primary(), &display)?;
    let viewport = request.viewport;
    args.drawing.check()?;
    let period_s = display.scan.rate.period().as_secs();
    let rolling = args.rolling.scan(&display)?;
    let scan_s = rolling.as_ref().map_or(0.0, |rolling| rolling.seconds);
    let stage = args
        .scene
        .stage(&viewport, args.drawing.frames, [period_s, scan_s], ctx)?;
    // Fails now, not after the work, if there is nowhere to write.
    let mut outputs = ctx.outputs("out")?;

    let mut drawing = args.drawing.drawing(stage.near_m);
    drawing.options.keep_passes = args.passes;
    args.rolling.apply(&mut drawing, display.primary().lens);
    let mut sights = stage.sights(|later| rolling.as_ref().map(|r| r.motion(later)));
    let study = FrameStudy {
        sight: sights.pop().expect("at least one frame is drawn"),
        before: sights,
        first_frame: stage.first_frame,
        gaze: request.gaze,
        request,
        drawing,
    };
    let bar = ctx.progress(u64::from(args.drawing.frames), "drawing");
    let outcome = study.run_showing(&[args.method], &mut |_, number, frame| {
        if args.drawing.all_frames {
            outputs.add(format!("frame-{number:04}.png"), png(&frame.image)?);
        }
        bar.inc(1);
        Ok::<(), Failure>(())
    })?;
    bar.finish_and_clear();
    let shot = &outcome.shots[0];

    let (frame, reference) = (&shot.frame.image, &outcome.reference.image);
    let quality = outcome.quality_table();
    outputs.add("frame.png", png(frame)?);
    outputs.add("reference.png", png(reference)?);
    outputs.add(
        "error.png",
        png(&error_map(frame, reference, ERROR_FULL_SCALE)?.image)?,
    );
    for (k, pass) in pictures(&shot.frame) {
        outputs.add(format!("pass-{k}.png"), png(pass)?);
    }
    outputs.add("work.csv", outcome.work_table().csv());
    outputs.add("quality.csv", quality.csv());
    let dir = outputs.dir().display().to_string();
    outputs.commit()?;
    ctx.print_table(&quality)?;
    let count = shot.plan.count();
    ctx.note(&format!(
        "{}: {} samples for {} pixels, {:.2} times fewer; files in {dir}",
        shot.plan.method,
        count.samples(),
        count.display_pixels,
        count.ratio(),
    ));
    Ok(())
}

/// The passes of a frame that are kept and were shaded, with their numbers.
fn pictures(frame: &Frame) -> impl Iterator<Item = (usize, &Image)> {
    let passes = frame.passes.iter().enumerate();
    passes.filter(|(_, image)| image.size.min_element() > 0)
}

/// What is drawn for the panel of the eye that looks ahead, and from where the flags say.
fn request(args: &Args, panel: &EyePanel, display: &Display) -> Result<Request, Failure> {
    let viewport = viewport(args, panel, display)?;
    let gaze = args
        .gaze
        .map_or(panel.ahead(), |px| viewport.gaze_at(px.into()));
    Ok(Request {
        viewport,
        acuity: options::acuity(&args.slope)?,
        gaze,
        margin_deg: args.margin,
        ..Request::ahead(panel)
    })
}

/// The image plane of a panel of the display, with another size or field of view where asked for.
fn viewport(args: &Args, panel: &EyePanel, display: &Display) -> Result<Viewport, Failure> {
    let own = panel.viewport;
    let size: glam::UVec2 = args.size.map_or(own.size, Into::into);
    // Said before anything as large is made.
    if size.max_element() > LARGEST_SIDE {
        let valid = format!("1 to {LARGEST_SIDE} pixels a side");
        return Err(Failure::bad_input(format!(
            "--size {}x{}: must be {valid}",
            size.x, size.y
        )));
    }
    if let Some(fov) = args.fov {
        if !(fov > 0.0 && fov < 180.0) {
            let valid = "above 0 and below 180 degrees";
            return Err(Failure::bad_input(format!("--fov {fov}: must be {valid}")));
        }
        return Ok(Viewport::symmetric(size, tan_deg(fov / 2.0))?);
    }
    match display.geometry {
        // A flat screen of the same width with square pixels.
        Geometry::Planar { .. } => Ok(Viewport::symmetric(size, own.tan[1])?),
        // The optics set all four edges.
        Geometry::HeadMounted => Ok(Viewport::new(size, own.tan)?),
    }
}
