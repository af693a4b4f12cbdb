use anyhow::{Context as _, anyhow};
use foveasim_models::foveation::{Method, Request};
use foveasim_study::{GazeAt, SpacingOutcome, SpacingStudy};

use super::super::context::Format;
use super::super::{Context, Failure, options};

/// Find the log-polar kernel, and the lens-matched coefficients, that need the fewest samples.
///
/// Samples are nowhere farther apart than the eye can tell, or than the display's pixels where those are
/// coarser: the larger of the spacing along the radius and across it, at every pixel. Prints each method's
/// samples and how it keeps to that line; with --out also writes spacing over eccentricity as a table and
/// as a plot of all methods.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim plan kernel --display quest-pro
  foveasim plan kernel --display lg-w2363d --slope guenter-b --gaze 1500,200 --out kernel
  foveasim plan kernel --display quest-3 --margin-deg 2 --gaze any --method full,layers:3:strict,vrs:tile=8

Columns: spacing_over_limit is the longest step between samples over what is asked there, at worst, and
worst_at_deg how far from the gaze that is; meets_line allows a thousandth. over_ideal compares shadings
with a density that falls off continuously. Kernels are found to within half a percent of the fewest
samples; with --gaze any, between the 169 gazes that are looked at, the line may be exceeded by a percent.")]
pub(super) struct Args {
    /// Preset or TOML file
    #[arg(long, value_name = "NAME")]
    display: String,
    /// Acuity slope: guenter-a, guenter-b, a quality index j:12, or a number
    #[arg(
        long,
        value_name = "SLOPE",
        default_value = "guenter-a",
        allow_hyphen_values = true
    )]
    slope: String,
    /// How far gaze may be off without being noticed, in degrees
    #[arg(
        long = "margin-deg",
        visible_alias = "margin",
        value_name = "DEGREES",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    margin_deg: f64,
    /// Where the eye looks: centre, pixels from the top left of the (first eye's) image, or any: settings
    /// that hold wherever on the image it looks
    #[arg(
        long,
        value_name = "X,Y",
        default_value = "centre",
        allow_hyphen_values = true
    )]
    gaze: String,
    /// Methods to compare with
    #[arg(
        long,
        value_name = "METHODS",
        default_value = "full,layers:3,layers:3:strict,vrs:tile=8,vrs,vrs:tile=32,fdm,rates,quad:auto"
    )]
    method: String,
}

pub(super) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let study = args.study()?;
    // An unwritable folder is found before the work, not after.
    let outputs = ctx.out.is_some().then(|| ctx.outputs("out")).transpose()?;
    let found = study.run()?;
    if found.kernel.is_none() {
        ctx.warn(
            "no kernel keeps to the acuity line on this display: even sigma = 0.25 is too coarse",
        );
    }
    ctx.print_table(&found.table())?;
    if ctx.format == Format::Table {
        summary(&found, ctx);
    }
    if let Some(mut outputs) = outputs {
        outputs.add("kernel.csv", found.table().csv());
        outputs.add("spacing.csv", found.curves().csv());
        outputs.add("vrs-rates.csv", found.rates().csv());
        for (name, chart) in found.charts() {
            outputs.add(format!("{name}.svg"), chart.svg());
        }
        for path in outputs.commit()? {
            ctx.note(&format!("wrote {}", path.display()));
        }
    }
    Ok(())
}

fn summary(found: &SpacingOutcome, ctx: &Context) {
    if let Some(kernel) = found.kernel {
        let share = 100.0 * kernel.samples / found.display_pixels as f64;
        ctx.note(&format!(
            "fewest samples: kfr{} ({share:.1} % of the display's pixels)",
            kernel.settings
        ));
    }
    if found.lens.settings.coefficients() == [0.0; 2] {
        ctx.note(
            "lms: none but full resolution; w grows from the centre on, where every pixel is needed",
        );
    }
}

impl Args {
    fn study(&self) -> Result<SpacingStudy, Failure> {
        if !(0.0..=90.0).contains(&self.margin_deg) {
            let text = format!(
                "--margin-deg {}: must be from 0 to 90 degrees",
                self.margin_deg
            );
            return Err(anyhow!(text).into());
        }
        let display = options::display(self.display.trim())?;
        let panel = display.primary();
        let ahead = Request::ahead(panel);
        let any_gaze = self.gaze == "any";
        let gaze = if any_gaze {
            ahead.gaze
        } else {
            match super::gaze(&self.gaze, "centre, any")? {
                GazeAt::Centre => ahead.gaze,
                GazeAt::Pixel(px) => panel.viewport.gaze_at(px.into()),
            }
        };
        Ok(SpacingStudy {
            request: Request {
                acuity: options::acuity(&self.slope)?,
                gaze,
                margin_deg: self.margin_deg,
                ..ahead
            },
            any_gaze,
            methods: Method::parse_list(&self.method).context("--method")?,
        })
    }
}
