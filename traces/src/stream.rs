use std::fmt;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use foveasim_models::{Nanos, OutlineSketch, SeriesOutline};

use crate::formats::{Head, RowReader, RowSamples, next_row};
use crate::lines::Lines;
use crate::read::{BUFFER, open, state_provenance, text};
use crate::{ReadOptions, TraceError};

/// A recording that stays in its file: read once to see that all of it is valid and what it holds, and then
/// again, sample by sample, as often as wanted. Memory does not grow with its length.
#[derive(Debug, Clone)]
pub struct StreamedRecording {
    path: PathBuf,
    options: ReadOptions,
    /// The file's name.
    pub source: String,
    /// The format it has.
    pub format: String,
    /// What there is of gaze.
    pub gaze: Option<SeriesOutline>,
    /// What there is of head pose.
    pub pose: Option<SeriesOutline>,
    /// What the reader had to repair, skip or assume, as of [`Recording`](foveasim_models::Recording).
    pub notes: Vec<String>,
    /// Which rows with samples belong to it.
    rows: std::ops::Range<usize>,
}

impl StreamedRecording {
    /// Reads the file at `path` once, and keeps no sample.
    ///
    /// `None` if it cannot be read that way: its format is understood only as a whole (EyeNavGS with its two
    /// rows per sample, EyeLink, whose resolution stands at the end, the JSON of Glasses 3), or it is
    /// no file but a pipe, which can be read once. [`read_path`](crate::read_path) takes those.
    ///
    /// # Errors
    /// As [`read_path`](crate::read_path), which gives the same samples and notes.
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Option<Self>, TraceError> {
        options.validate()?;
        let source = path.display().to_string();
        let file = open(path, &source)?;
        if !file.metadata().is_ok_and(|about| about.is_file()) {
            return Ok(None);
        }
        let mut lines = text(BufReader::with_capacity(BUFFER, file), &source)?;
        let head = Head::read(&mut lines)?;
        let Some(mut rows) = head.format.rows(&head, &source, options)? else {
            return Ok(None);
        };
        let mut session = Session::default();
        while let Some(samples) = next_row(rows.as_mut(), &mut lines)? {
            session.take(&samples);
        }
        let mut all = rows.finish(options)?;
        all.notes.extend(lines.note());
        drop((rows, lines));
        // Of several sessions in one file only the end says which is read: those are gone through again.
        if !all.range.contains(&0) || all.range.end < session.rows {
            let mut reader = SampleReader::new(path, &source, options, all.range.clone())?;
            session = Session::default();
            while let Some(samples) = reader.next_row()? {
                session.take(&samples);
            }
        }
        let [mut of_gaze, of_pose] = all.provenance;
        let mut notes = all.notes;
        if let Some(given) = options.provenance {
            state_provenance(given, session.gaze.is_some(), &mut notes);
            of_gaze = given;
        }
        Ok(Some(Self {
            path: path.to_owned(),
            options: options.clone(),
            format: head.format.name().to_owned(),
            gaze: session.gaze.and_then(|s| s.finish(of_gaze)),
            pose: session.pose.and_then(|s| s.finish(of_pose)),
            notes,
            rows: all.range,
            source,
        }))
    }

    /// First and last time of any sample; `None` where there is none.
    pub fn span(&self) -> Option<(Nanos, Nanos)> {
        let ends = |o: SeriesOutline| (o.start, o.end);
        match (self.gaze.map(ends), self.pose.map(ends)) {
            (Some(a), Some(b)) => Some((a.0.min(b.0), Ord::max(a.1, b.1))),
            (a, b) => a.or(b),
        }
    }

    /// Begins to read the samples.
    ///
    /// # Errors
    /// If the file cannot be opened any more, or is another by now.
    pub fn reader(&self) -> Result<SampleReader<'_>, TraceError> {
        SampleReader::new(&self.path, &self.source, &self.options, self.rows.clone())
    }
}

/// What the samples of one session amount to.
#[derive(Default)]
struct Session {
    rows: usize,
    gaze: Option<OutlineSketch>,
    pose: Option<OutlineSketch>,
}

impl Session {
    fn take(&mut self, samples: &RowSamples) {
        self.rows += 1;
        if let Some(gaze) = &samples.gaze {
            self.gaze.get_or_insert_default().add(gaze);
        }
        if let Some(pose) = &samples.pose {
            self.pose.get_or_insert_default().add(pose);
        }
    }
}

/// Reads the samples of a [`StreamedRecording`] in the order of time.
pub struct SampleReader<'a> {
    lines: Lines<'a, Box<dyn BufRead>>,
    rows: Box<dyn RowReader + 'a>,
    /// Number of the next row with samples, and which of them are read.
    next: usize,
    range: std::ops::Range<usize>,
}

impl<'a> SampleReader<'a> {
    fn new(
        path: &Path,
        source: &'a str,
        options: &ReadOptions,
        range: std::ops::Range<usize>,
    ) -> Result<Self, TraceError> {
        let file = open(path, source)?;
        let mut lines: Lines<'a, Box<dyn BufRead>> =
            text(BufReader::with_capacity(BUFFER, file), source)?;
        let head = Head::read(&mut lines)?;
        let rows = head.format.rows(&head, source, options)?;
        let changed = || TraceError::Io {
            file: source.to_owned(),
            reason: std::io::Error::other("was replaced while it was read"),
        };
        Ok(Self {
            rows: rows.ok_or_else(changed)?,
            lines,
            next: 0,
            range,
        })
    }

    /// The samples of the next row; `None` at the end.
    ///
    /// # Errors
    /// If the file cannot be read on, or has changed since it was opened and is damaged now.
    pub fn next_row(&mut self) -> Result<Option<RowSamples>, TraceError> {
        while self.next < self.range.end {
            let Some(samples) = next_row(self.rows.as_mut(), &mut self.lines)? else {
                break;
            };
            self.next += 1;
            if self.next > self.range.start {
                return Ok(Some(samples));
            }
        }
        Ok(None)
    }
}

impl fmt::Debug for SampleReader<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SampleReader")
            .field("lines", &self.lines.file())
            .field("next", &self.next)
            .finish_non_exhaustive()
    }
}
