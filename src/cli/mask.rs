use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Subcommand;
use foveasim_mask::{Cache, Hysteresis, LbgIteration, Mask, MaskSpec};
use foveasim_models::math::tan_deg;
use foveasim_models::{Acuity, RayDensity, Viewport, unknown_name};
use foveasim_reports::png;
use foveasim_study::{MaskReport, mask_interpolation};

use super::{Context, Failure, options};

/// Sampling masks that follow the eye: where rays are cast, and what pixels take of them.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Build(Box<BuildArgs>),
}

/// Build a mask (weighted Linde-Buzo-Gray, natural-neighbour weights), show how it came to rest, and keep it.
///
/// With --out: convergence, spacing and distances as CSV and SVG, pictures of cells and of the order of rays. With --cache
/// the mask is kept under a name made of all that it depends on, and loaded from there the next time.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim mask build --out mask                             8 % of 1024 x 1024 rays, a Gaussian
  foveasim mask build --density mar --slope guenter-a --display lg-w2363d --out mask
  foveasim mask build --size 1024x1024 --sigma-deg 3.4 --distance-cm 60 --pitch-mm 0.277 --cache masks")]
struct BuildArgs {
    /// Pixels of the display [default: 1024x1024]
    #[arg(long, value_name = "WxH", value_parser = options::size)]
    size: Option<[u32; 2]>,
    /// Width of a pixel [mm] [default: 0.2767, a 24-inch display of 1920 x 1080]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    pitch_mm: Option<f64>,
    /// From the eye to the display [cm] [default: 60]
    #[arg(long, value_name = "CM", allow_hyphen_values = true)]
    distance_cm: Option<f64>,
    /// Preset or TOML file of a display, instead of the three above
    #[arg(long, value_name = "NAME", conflicts_with_all = ["size", "pitch_mm", "distance_cm"])]
    display: Option<String>,
    /// Rays per pixel around the gaze: gaussian (Bruder et al. 2019) or mar (the square of acuity)
    #[arg(long, value_name = "KIND", default_value = "gaussian")]
    density: String,
    /// Rays over pixels of the display, gaze in its middle [default: 0.08]
    #[arg(long, value_name = "SHARE", conflicts_with_all = ["slope", "sigma_deg"])]
    fraction: Option<f64>,
    /// σ of a Gaussian, in degrees at the gaze
    #[arg(long, value_name = "DEGREES", conflicts_with = "slope")]
    sigma_deg: Option<f64>,
    /// Acuity slope of a mar density: guenter-a, guenter-b, a quality index j:12, or a number
    #[arg(long, value_name = "SLOPE", allow_hyphen_values = true)]
    slope: Option<String>,
    /// Rays per pixel that a Gaussian has at least, however far from the gaze
    #[arg(
        long,
        value_name = "RAYS",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    floor: f64,
    /// How much wider the limits of a cell's share become with each iteration; 0.01 in the authors' program
    #[arg(long, value_name = "H", default_value_t = Hysteresis::PUBLISHED.step, allow_hyphen_values = true)]
    hysteresis_step: f64,
    /// How pixels come from rays: natural, barycentric or nearest
    #[arg(long, value_name = "NAME", default_value = "natural")]
    interpolation: String,
    /// Folder in which masks are kept
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
}

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    match &args.command {
        Command::Build(args) => build(args, ctx),
    }
}

fn build(args: &BuildArgs, ctx: &Context) -> Result<(), Failure> {
    let spec = args.spec(ctx.seed)?;
    // An unwritable folder is found before the work, not after.
    let outputs = ctx.out.is_some().then(|| ctx.outputs("out")).transpose()?;
    let began = Instant::now();
    let bar = ctx.progress(0, "cells that change");
    let progress = |row: &LbgIteration| {
        bar.set_message(format!(
            "iteration {}: {} of {} cells change",
            row.iteration,
            row.split + row.merged,
            row.sites
        ));
        bar.tick();
    };
    let (mask, loaded) = get(args.cache.as_deref(), &spec, &progress, ctx)?;
    bar.finish_and_clear();
    let took = began.elapsed().as_secs_f64();
    let report = MaskReport::new(&mask);
    ctx.print_table(&report.summary())?;
    let how = if loaded { "loaded" } else { "built" };
    ctx.note(&format!("{how} in {took:.2} s"));
    if let Some(mut outputs) = outputs {
        outputs.add("summary.csv", report.summary().csv());
        outputs.add("convergence.csv", report.convergence().csv());
        outputs.add("spacing.csv", report.spacing().csv());
        outputs.add("distances.csv", report.distances().csv());
        for (name, chart) in report.charts() {
            outputs.add(format!("{name}.svg"), chart.svg());
        }
        for (name, picture) in report.pictures() {
            outputs.add(format!("{name}.png"), png(&picture)?);
        }
        for path in outputs.commit()? {
            ctx.note(&format!("wrote {}", path.display()));
        }
    }
    Ok(())
}

/// The mask of `spec`, by way of a cache if there is one, and whether it was there; what was wrong with it is said.
pub(crate) fn get(
    cache: Option<&Path>,
    spec: &MaskSpec,
    progress: &dyn Fn(&LbgIteration),
    ctx: &Context,
) -> Result<(Mask, bool), Failure> {
    let Some(folder) = cache else {
        return Ok((Mask::build(spec, progress)?, false));
    };
    let cached = Cache::new(folder).get(spec, progress)?;
    if let Some(why) = &cached.replaced {
        ctx.warn(&format!("{why}: built anew"));
    }
    if let Some(why) = &cached.not_kept {
        ctx.warn(&format!("the mask could not be kept: {why}"));
    }
    Ok((cached.mask, cached.loaded))
}

impl BuildArgs {
    fn spec(&self, seed: u64) -> Result<MaskSpec, Failure> {
        let viewport = self.viewport()?;
        let density = self.density(&viewport)?.with_floor(self.floor)?;
        Ok(MaskSpec {
            hysteresis: Hysteresis {
                step: self.hysteresis_step,
                ..Hysteresis::PUBLISHED
            },
            interpolation: mask_interpolation(&self.interpolation)?,
            ..MaskSpec::new(viewport.size, density, seed)
        })
    }

    fn viewport(&self) -> Result<Viewport, Failure> {
        if let Some(name) = &self.display {
            return Ok(options::display(name)?.primary().viewport);
        }
        let size = self.size.unwrap_or([1024; 2]);
        let within = |flag: &str, value: f64| {
            if (1e-3..=1e5).contains(&value) {
                return Ok(value);
            }
            let text = format!("{flag} {value}: must be from 0.001 to 100000");
            Err(Failure::bad_input(text))
        };
        let pitch = within("--pitch-mm", self.pitch_mm.unwrap_or(PITCH_MM))?;
        let distance = within("--distance-cm", self.distance_cm.unwrap_or(DISTANCE_CM))?;
        let half = f64::from(size[0]) / 2.0 * pitch / (10.0 * distance);
        Ok(Viewport::symmetric(size.into(), half)?)
    }

    fn density(&self, viewport: &Viewport) -> Result<RayDensity, Failure> {
        let fraction = self.fraction.unwrap_or(0.08);
        let size = viewport.size.as_dvec2();
        match self.density.as_str() {
            "gaussian" if self.slope.is_some() => Err(Failure::bad_input(
                "--slope is for --density mar; a Gaussian has --sigma-deg or --fraction",
            )),
            "gaussian" => Ok(match self.sigma_deg {
                Some(deg) if (1e-3..=60.0).contains(&deg) => {
                    RayDensity::gaussian(tan_deg(deg) / viewport.pixel_tan().max_element())?
                }
                Some(deg) => {
                    let text = format!("--sigma-deg {deg}: must be from 0.001 to 60 degrees");
                    return Err(Failure::bad_input(text));
                }
                None => RayDensity::gaussian_of_fraction(fraction, size)?,
            }),
            "mar" if self.sigma_deg.is_some() || self.floor != 0.0 => Err(Failure::bad_input(
                "--sigma-deg and --floor are for --density gaussian; mar has --slope or --fraction",
            )),
            "mar" => Ok(match &self.slope {
                Some(slope) => RayDensity::mar(options::acuity(slope)?, viewport)?,
                None => RayDensity::mar_of_fraction(fraction, Acuity::default(), viewport)?.0,
            }),
            other => Err(unknown_name("density", other, &["gaussian", "mar"]).into()),
        }
    }
}

/// A pixel of a 24-inch display of 1920 × 1080 (Bruder et al. 2019, §5) \[mm\].
const PITCH_MM: f64 = 0.276_725_233;
/// A usual distance from such a display \[cm\].
const DISTANCE_CM: f64 = 60.0;
