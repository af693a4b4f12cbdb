//! The command-line tool: flags and glue, one file per subcommand.

mod calibrate;
mod chain;
mod clock;
mod context;
mod drawing;
mod failure;
mod init;
mod latency;
mod mask;
mod options;
mod pareto;
mod parquet;
mod plan;
mod presets;
mod render;
mod replay;
mod reproduce;
mod rolling;
mod run;
mod scene;
mod stress;
mod trace;
mod trace_events;
mod trace_predict;
mod trace_scanlines;

use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

pub(crate) use context::{Context, Global};
pub(crate) use failure::Failure;

/// Predict what foveated and low-latency rendering saves on an eye-tracked display.
#[derive(Debug, Parser)]
#[command(
    name = "foveasim",
    version,
    about,
    propagate_version = true,
    max_term_width = 100
)]
struct Cli {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Run(Box<run::Args>),
    Plan(Box<plan::Args>),
    Pareto(Box<pareto::Args>),
    Calibrate(calibrate::Args),
    Latency(Box<latency::Args>),
    Replay(Box<replay::Args>),
    Render(Box<render::Args>),
    Reproduce(Box<reproduce::Args>),
    Mask(mask::Args),
    Stress(stress::Args),
    Trace(trace::Args),
    Presets(presets::Args),
    Init(init::Args),
}

/// Parses the command line, runs the subcommand and turns its outcome into an exit code.
pub fn main() -> ExitCode {
    let cli = match parse() {
        Ok(cli) => cli,
        Err(error) => return bad_flags(&error),
    };
    let plans = matches!(cli.command, Command::Plan(_));
    let outcome = Context::new(&cli.global, plans).and_then(|ctx| match &cli.command {
        Command::Run(args) => run::run(args, &ctx),
        Command::Plan(args) => plan::run(args, &ctx),
        Command::Pareto(args) => pareto::run(args, &ctx),
        Command::Calibrate(args) => calibrate::run(args, &ctx),
        Command::Latency(args) => latency::run(args, &ctx),
        Command::Replay(args) => replay::run(args, &ctx),
        Command::Render(args) => render::run(args, &ctx),
        Command::Reproduce(args) => reproduce::run(args, &ctx),
        Command::Mask(args) => mask::run(args, &ctx),
        Command::Stress(args) => stress::run(args, &ctx),
        Command::Trace(args) => trace::run(args, &ctx),
        Command::Presets(args) => presets::run(args, &ctx),
        Command::Init(args) => init::run(args, &ctx),
    });
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

/// Parses the command line. Every flag that takes a value takes negative numbers, so that a wrong
/// sign is refused for what it means and not for how it looks.
fn parse() -> Result<Cli, clap::Error> {
    fn numbers(command: clap::Command) -> clap::Command {
        let command = command.mut_args(|arg| {
            let takes_value = arg.get_action().takes_values() && !arg.is_positional();
            arg.allow_negative_numbers(takes_value)
        });
        command.mut_subcommands(numbers)
    }
    Cli::from_arg_matches(&numbers(Cli::command()).try_get_matches()?)
}

/// Help and version as clap prints them; what is wrong in one line.
fn bad_flags(error: &clap::Error) -> ExitCode {
    match error.kind() {
        ErrorKind::DisplayHelp
        | ErrorKind::DisplayVersion
        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            // Nobody left to tell if the pipe is closed.
            let _ = error.print();
            ExitCode::from(u8::from(error.use_stderr()) * 2)
        }
        _ => {
            let text = error.to_string();
            let useful = |p: &&str| !(p.starts_with("Usage:") || p.starts_with("For more"));
            // Negative numbers are taken as values already: that tip would be wrong.
            let wrong = |p: &&str| !p.trim_start().starts_with("tip: to pass");
            let joined = |p: &str| p.lines().map(str::trim).collect::<Vec<_>>().join(" ");
            let paragraphs = text.split("\n\n").filter(useful).filter(wrong).map(joined);
            let line = paragraphs.collect::<Vec<_>>().join("; ");
            let line = line.trim_start_matches("error: ");
            Failure::bad_input(format!("{line} (see --help)")).report()
        }
    }
}
