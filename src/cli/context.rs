use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use foveasim_reports::{Outputs, Table};
use indicatif::{ProgressBar, ProgressStyle};

use super::{Failure, parquet};

/// Flags that every subcommand understands.
#[derive(Debug, clap::Args)]
pub(crate) struct Global {
    /// How tables are printed
    #[arg(long, global = true, value_enum, default_value_t = Format::Table)]
    pub(crate) format: Format,
    /// Folder for files; created if missing. Files appear whole or not at all
    #[arg(long, global = true, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Seed of everything random; the same seed gives the same bytes [default: 1]
    #[arg(long, global = true)]
    pub(crate) seed: Option<u64>,
    /// Worker threads (default: all cores); results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub(crate) threads: Option<u32>,
}

/// How a table is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Aligned columns for people
    Table,
    /// Comma-separated values, full precision
    Csv,
    /// A JSON array of objects, full precision
    Json,
    /// Apache Parquet, full precision: tables of `plan`, where it is built in
    Parquet,
}

/// What every subcommand is given: validated global flags, and the only way to print.
#[derive(Debug)]
pub(crate) struct Context {
    pub(crate) format: Format,
    pub(crate) out: Option<PathBuf>,
    pub(crate) seed: u64,
    /// The seed, if it was given as a flag: a scenario file may name another.
    pub(crate) seed_flag: Option<u64>,
}

impl Context {
    /// Of flags to a subcommand, which may be `plan`.
    pub(crate) fn new(global: &Global, plans: bool) -> Result<Self, Failure> {
        if global.format == Format::Parquet {
            if !plans {
                let text = "--format parquet: `foveasim plan` has it; here are table, csv and json";
                return Err(Failure::bad_input(text));
            }
            parquet::check()?;
        }
        if let Some(n) = global.threads {
            rayon::ThreadPoolBuilder::new()
                .num_threads(n as usize)
                .build_global()?;
        }
        Ok(Self {
            format: global.format,
            out: global.out.clone(),
            seed: global.seed.unwrap_or(1),
            seed_flag: global.seed,
        })
    }

    /// Prints text on standard output as it is.
    pub(crate) fn print(&self, text: &str) -> Result<(), Failure> {
        let mut out = std::io::stdout().lock();
        Self::delivered(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
    }

    /// What became of writing to standard output.
    pub(crate) fn delivered<T>(written: std::io::Result<T>) -> Result<(), Failure> {
        match written {
            Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Err(Failure::PipeClosed),
            Err(e) => Err(e.into()),
            Ok(_) => Ok(()),
        }
    }

    /// Prints a table in the format asked for.
    pub(crate) fn print_table(&self, table: &Table) -> Result<(), Failure> {
        self.print(&match self.format {
            Format::Table => table.text(),
            Format::Csv => table.csv(),
            Format::Json => table.json(),
            Format::Parquet => return self.print_bytes(&parquet::file(table, None)?),
        })
    }

    /// Prints what no terminal can show.
    pub(crate) fn print_bytes(&self, bytes: &[u8]) -> Result<(), Failure> {
        let mut out = std::io::stdout().lock();
        if out.is_terminal() {
            let text = "--format parquet: is no text: send it to a file, or give --out DIR";
            return Err(Failure::bad_input(text));
        }
        Self::delivered(out.write_all(bytes).and_then(|()| out.flush()))
    }

    /// Prints a table, and keeps it as `name` in the folder given with `--out`.
    pub(crate) fn deliver_table(&self, table: &Table, name: &str) -> Result<(), Failure> {
        if let Some(dir) = &self.out {
            let mut outputs = Outputs::new(dir)?;
            outputs.add(name, table.csv());
            outputs.commit()?;
        }
        self.print_table(table)
    }

    /// Writes one file that the user named, in the folder given with `--out` if there is one: whole or
    /// not at all, and over an existing file only with `force`.
    pub(crate) fn write_file(&self, path: &Path, bytes: &[u8], force: bool) -> Result<(), Failure> {
        let path = self
            .out
            .as_ref()
            .map_or(path.to_owned(), |dir| dir.join(path));
        let bad = || Failure::bad_input(format!("{}: not a file name", path.display()));
        let name = path.file_name().and_then(|n| n.to_str()).ok_or_else(bad)?;
        if path.exists() && !force {
            let text = format!("{} exists; --force replaces it", path.display());
            return Err(Failure::bad_input(text));
        }
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
        let mut outputs = Outputs::new(folder.unwrap_or(Path::new(".")))?;
        outputs.add(name, bytes);
        outputs.commit()?;
        self.note(&format!("wrote {}", path.display()));
        Ok(())
    }

    /// One line for people on standard error; silent where the output is for programs.
    pub(crate) fn note(&self, text: &str) {
        if self.format == Format::Table {
            // A note that cannot be delivered is not worth failing for.
            let _ = writeln!(std::io::stderr(), "{text}");
        }
    }

    /// What a user must know to read the result: a line on standard error, in every format.
    pub(crate) fn warn(&self, text: &str) {
        // A warning that cannot be delivered is not worth failing for.
        let _ = writeln!(std::io::stderr(), "foveasim: note: {text}");
    }

    /// The output folder given with `--out`, or `default`; fails now if it cannot be written.
    pub(crate) fn outputs(&self, default: &str) -> Result<Outputs, Failure> {
        let dir = self.out.clone().unwrap_or_else(|| default.into());
        Ok(Outputs::new(dir)?)
    }

    /// A progress bar on a terminal; hidden when piped.
    pub(crate) fn progress(&self, steps: u64, what: &str) -> ProgressBar {
        if !std::io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let style = ProgressStyle::with_template("{msg:20} {bar:40} {pos}/{len} {eta}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        ProgressBar::new(steps)
            .with_style(style)
            .with_message(what.to_owned())
    }
}
