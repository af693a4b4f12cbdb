use std::path::PathBuf;

use clap::ValueEnum;
use foveasim_models::presets;

use super::{Context, Failure};

/// The scenario file with every key, its default and what it means.
pub(crate) const SCENARIO: &str = include_str!("scenario.toml");

/// Write a commented file to start from: a scenario, a display, a tracker or a cost profile.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim init                                   scenario.toml, every key explained
  foveasim init --kind display --from quest-pro my-headset.toml
  foveasim run scenario.toml")]
pub(crate) struct Args {
    /// Where to write it [default: scenario.toml, display.toml …]
    file: Option<PathBuf>,
    /// What to write
    #[arg(long, value_enum, default_value_t = Kind::Scenario)]
    kind: Kind,
    /// Preset to start a display, tracker or cost profile from
    #[arg(long, value_name = "PRESET")]
    from: Option<String>,
    /// Replace the file if there is one
    #[arg(long)]
    force: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    Scenario,
    Display,
    Tracker,
    Cost,
}

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let from = args.from.as_deref();
    let (name, text) = match args.kind {
        Kind::Scenario if from.is_some() => {
            return Err(Failure::bad_input(
                "--from needs --kind display, tracker or cost",
            ));
        }
        Kind::Scenario => ("scenario.toml", SCENARIO),
        Kind::Display => (
            "display.toml",
            presets::display_text(from.unwrap_or("lg-w2363d"))?,
        ),
        Kind::Tracker => (
            "tracker.toml",
            presets::tracker_text(from.unwrap_or("tx300"))?,
        ),
        Kind::Cost => (
            "cost.toml",
            presets::cost_text(from.unwrap_or("guenter2012"))?,
        ),
    };
    let path = args.file.clone().unwrap_or_else(|| name.into());
    ctx.write_file(&path, text.as_bytes(), args.force)
}
