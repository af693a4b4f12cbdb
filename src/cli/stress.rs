use foveasim_study::StressStudy;

use super::{Context, Failure};

/// Try closed forms and kernels on extreme inputs, and say how far off each came.
///
/// Each is held against 256 bits, or an identity that would hold exactly. The exit code is 1 if one is beyond its
/// tolerance.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim stress
  foveasim stress --inputs 1000000 --seed 7 --out stress")]
pub(crate) struct Args {
    /// Inputs for each quantity; those that cost more get fewer
    #[arg(long, value_name = "N", default_value_t = StressStudy::default().inputs, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    inputs: u32,
}

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let study = StressStudy {
        inputs: args.inputs,
        seed: ctx.seed,
    };
    let rows = study.run();
    ctx.deliver_table(&StressStudy::table(&rows), "stress.csv")?;
    let beyond: Vec<&str> = rows
        .iter()
        .filter(|row| !row.holds())
        .map(|row| row.quantity)
        .collect();
    match beyond.as_slice() {
        [] => Ok(()),
        some => Err(Failure::CheckFailed(format!(
            "beyond the tolerance: {}",
            some.join(", ")
        ))),
    }
}
