use std::io::{BufWriter, Write};
use std::path::Path;

use foveasim_models::Nanos;
use foveasim_reports::{Cell, TableDigest, TableWriter, TextLayout};
use foveasim_study::{
    Golden, GoldenCheck, REPLAY_COLUMNS, ReplayError, ReplayFrame, ReplayRun, ReplaySummary,
    ReplayTally,
};

use crate::cli::context::Format;
use crate::cli::{Context, Failure};

/// What is printed of a replay: its table, the table's digest, or whether it equals an older one.
pub(super) struct Show<'a> {
    pub(super) ctx: &'a Context,
    /// What it is compared with, and where that was.
    pub(super) golden: Option<(&'a Golden, &'a Path)>,
    pub(super) digest: bool,
    /// What is to be known of the recording, once it has been replayed.
    pub(super) notes: Vec<String>,
}

/// Gives all displayed frames, in order, as often as it is called.
pub(super) type Play<'a> =
    dyn Fn(&mut dyn FnMut(ReplayFrame)) -> Result<ReplayRun, ReplayError> + 'a;

impl Show<'_> {
    /// Prints the frames that `play` gives row by row, so that none need be kept; times from `start`.
    /// Aligned columns need to know all rows beforehand: they are played twice.
    pub(super) fn rows(&self, start: Nanos, play: &Play<'_>) -> Result<(), Failure> {
        if let Some((golden, path)) = self.golden {
            let mut check = GoldenCheck::new(golden, &REPLAY_COLUMNS);
            self.play(start, play, |row| check.row(row))?;
            return match check.finish() {
                None => self
                    .ctx
                    .print(&format!("replay equals {}\n", path.display())),
                Some(d) => Err(Failure::CheckFailed(format!(
                    "replay differs from {}: {d}",
                    path.display()
                ))),
            };
        }
        if self.digest {
            let mut digest = TableDigest::new(&REPLAY_COLUMNS);
            self.play(start, play, |row| digest.row(row))?;
            return self.ctx.print(&format!("{}\n", digest.finish()));
        }
        let out = BufWriter::new(std::io::stdout().lock());
        match self.ctx.format {
            Format::Csv => self.write(start, play, TableWriter::csv(out, REPLAY_COLUMNS)),
            Format::Json => self.write(start, play, TableWriter::json(out, REPLAY_COLUMNS)),
            Format::Parquet => Err(Failure::bad_input("--format parquet: not of replays")),
            Format::Table => {
                let mut layout = TextLayout::new(&REPLAY_COLUMNS);
                self.play(start, play, |row| layout.add(row))?;
                let mut writer = TableWriter::text(out, REPLAY_COLUMNS, layout);
                let mut written = Ok(());
                play(&mut |frame| {
                    if written.is_ok() {
                        written = writer.row(&frame.row(start));
                    }
                })?;
                Context::delivered(written.and_then(|()| writer.finish()))
            }
        }
    }

    fn write<W: Write>(
        &self,
        start: Nanos,
        play: &Play<'_>,
        mut writer: TableWriter<W>,
    ) -> Result<(), Failure> {
        let mut written = Ok(());
        self.play(start, play, |row| {
            if written.is_ok() {
                written = writer.row(row);
            }
        })?;
        Context::delivered(written.and_then(|()| writer.finish()))
    }

    /// Plays once, and says what there is to say about the whole.
    fn play(
        &self,
        start: Nanos,
        play: &Play<'_>,
        mut row: impl FnMut(&[Cell]),
    ) -> Result<(), Failure> {
        let mut tally = ReplayTally::default();
        let run = play(&mut |frame| {
            tally.add(&frame);
            row(&frame.row(start));
        })?;
        let summary = tally.finish(run.dark_scans, &run.counts);
        self.about(&run.notes, &summary);
        Ok(())
    }

    /// Notes, and the summary for people.
    pub(super) fn about(&self, notes: &[String], summary: &ReplaySummary) {
        let notes = self.notes.iter().chain(notes);
        notes.for_each(|note| self.ctx.warn(note));
        summary.lines().iter().for_each(|line| self.ctx.note(line));
    }
}
