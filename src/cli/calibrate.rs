use std::path::PathBuf;

use anyhow::{Context as _, anyhow};
use foveasim_models::CostForm;
use foveasim_study::{Calibration, CostRows, read_text};

use super::{Context, Failure};

/// Fit a cost profile to measured frames: what a sample, a pixel and a pass take.
///
/// Both forms of cost are fitted, none of whose coefficients is negative: the sum of all parts of the work, and the
/// largest of them. With --out, a profile is written that `foveasim plan --cost FILE` and scenarios read.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim calibrate examples/data/guenter2012-table1.csv --group Full
  foveasim calibrate frames.csv --name my-gpu --out profiles
  foveasim plan --fov 90 --ppd centre:20 --cost profiles/my-gpu.toml

Columns of the CSV: time_ms, and one or more of samples_shaded, samples (where visibility is found),
pixels_resolved (put together from samples that are not their own), passes. name and group are for
people. Lines that begin with # are comments.
Errors are relative; each row is predicted by a fit to the others. Intervals are the 5th to 95th
percentile of 400 fits to resampled rows. A profile of times measured with this project's renderer
is one of a CPU.")]
pub(crate) struct Args {
    /// CSV of measured frames
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Only the rows of this group
    #[arg(long, value_name = "NAME")]
    group: Option<String>,
    /// The profile's form: sum or largest [default: the one that predicts left-out rows best]
    #[arg(long, value_name = "FORM")]
    form: Option<String>,
    /// The profile's name, and its file's
    #[arg(long, default_value = "profile")]
    name: String,
}

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let origin = args.file.display().to_string();
    let form = args.form.as_deref().map(form).transpose()?;
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if args.name.is_empty() || args.name.starts_with('.') || !args.name.chars().all(plain) {
        let text = format!("--name {}: want letters, digits, - and _", args.name);
        return Err(Failure::bad_input(text));
    }
    let mut rows = CostRows::parse(&read_text(&args.file)?, &origin)?;
    if let Some(group) = &args.group {
        rows = rows.of_group(group).context("--group")?;
    }
    let calibration = Calibration::new(rows, ctx.seed).with_context(|| origin.clone())?;
    let fit = match form {
        None => calibration.best(),
        Some(form) => calibration
            .fits
            .iter()
            .find(|f| f.form == form)
            .expect("both forms are fitted"),
    };
    let name = args
        .file
        .file_name()
        .map(|n| n.to_string_lossy().into_owned());
    let profile = calibration.profile(fit, &args.name, &name.unwrap_or(origin))?;
    ctx.print_table(&calibration.coefficients())?;
    if ctx.format == super::context::Format::Table {
        ctx.print("\n")?;
        ctx.print_table(&calibration.errors())?;
    }
    ctx.note(&format!("the {} form: {}", fit.form.name(), profile.title));
    if ctx.out.is_none() {
        return Ok(());
    }
    let text = toml::to_string(&profile).map_err(|e| anyhow!("writing the profile: {e}"))?;
    let mut outputs = ctx.outputs("out")?;
    outputs.add(format!("{}.toml", args.name), text);
    outputs.add("coefficients.csv", calibration.coefficients().csv());
    outputs.add("errors.csv", calibration.errors().csv());
    outputs.add("predictions.csv", calibration.predictions().csv());
    outputs.add("residuals.svg", calibration.residuals().svg());
    for path in outputs.commit()? {
        ctx.note(&format!("wrote {}", path.display()));
    }
    Ok(())
}

fn form(text: &str) -> Result<CostForm, Failure> {
    let found = CostForm::ALL.into_iter().find(|f| f.name() == text);
    found.ok_or_else(|| {
        let names = CostForm::ALL.map(CostForm::name);
        foveasim_models::unknown_name("form of cost", text, &names).into()
    })
}
