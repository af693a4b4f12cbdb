//! One file per format, behind one closed list.

mod columns;
mod eyenavgs;
mod foveasim;
mod number;
mod screen;
mod tum;

use std::io::BufRead;

use foveasim_models::{Interpolate, Nanos, Provenance, Recording, Sample, Series};

use crate::lines::Lines;
use crate::{ReadOptions, TraceError};

pub(crate) use foveasim::{COLUMNS, MAGIC, NO_SAMPLE, VERSION};

/// The note on gaze of which nobody said what it is. Readers give it instead of a provenance, and
/// [`write`](crate::write) writes neither, so that an assumption does not become a statement.
pub(crate) const GAZE_ASSUMED: &str =
    "gaze taken as the truth: the file does not say what delay or filter its samples have";
/// The same of head pose.
pub(crate) const POSE_ASSUMED: &str =
    "head pose taken as the truth: the file does not say what delay or filter its samples have";

/// The formats that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// EyeNavGS: CSV of head pose and gaze, one row per eye (Meta Quest Pro).
    EyeNavGs,
    /// Tab-separated gaze in pixels from the centre of a screen (as in ETDQualitizer).
    ScreenCentred,
    /// TUM trajectory: `time x y z qx qy qz qw`, separated by spaces.
    Tum,
    /// Our own CSV; `docs/trace-format.md` describes it.
    Foveasim,
}

impl Format {
    /// Every format.
    pub const ALL: [Self; 4] = [
        Self::EyeNavGs,
        Self::ScreenCentred,
        Self::Tum,
        Self::Foveasim,
    ];

    /// Short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::EyeNavGs => "eyenavgs",
            Self::ScreenCentred => "screen-centred",
            Self::Tum => "tum",
            Self::Foveasim => "foveasim",
        }
    }

    /// What its content is recognised by.
    pub fn mark(self) -> &'static str {
        match self {
            Self::EyeNavGs => "columns ViewIndex, QuaternionX, GazeQX, Timestamp",
            Self::ScreenCentred => "columns timestamp and left_x, left_y or right_x, right_y",
            Self::Tum => "rows of 8 numbers separated by spaces",
            Self::Foveasim => "first line `# foveasim-trace 1`, or a column t_ns",
        }
    }

    pub(crate) fn parse<R: BufRead>(
        self,
        head: &Head,
        lines: &mut Lines<'_, R>,
        options: &ReadOptions,
    ) -> Result<Recording, TraceError> {
        if self != Self::EyeNavGs && options.segment.is_some_and(|n| n != 1) {
            let (file, wanted) = (lines.file().to_owned(), options.segment.unwrap_or(1));
            return Err(TraceError::NoSuchSegment {
                file,
                wanted,
                segments: 1,
            });
        }
        match self {
            Self::EyeNavGs => eyenavgs::parse(head, lines, options),
            Self::ScreenCentred => screen::parse(head, lines, options),
            Self::Tum => tum::parse(lines),
            Self::Foveasim => foveasim::parse(head, lines),
        }
    }

    fn of_line(first: &str) -> Option<Self> {
        let names = columns::names(first);
        let has = |name: &str| names.iter().any(|n| n.eq_ignore_ascii_case(name));
        if has("t_ns") {
            Some(Self::Foveasim)
        } else if ["ViewIndex", "QuaternionX", "GazeQX", "Timestamp"]
            .iter()
            .all(|n| has(n))
        {
            Some(Self::EyeNavGs)
        } else if has("timestamp")
            && ["left_x", "left_y", "right_x", "right_y"]
                .iter()
                .any(|n| has(n))
        {
            Some(Self::ScreenCentred)
        } else if first.split_ascii_whitespace().count() == tum::FIELDS
            && first
                .split_ascii_whitespace()
                .all(|f| f.parse::<f64>().is_ok())
        {
            Some(Self::Tum)
        } else {
            None
        }
    }
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// What stands before the data: comments, and the line that names the columns.
#[derive(Debug)]
pub(crate) struct Head {
    pub(crate) format: Format,
    /// Comment lines without `#`, with their numbers.
    pub(crate) comments: Vec<(usize, String)>,
    /// The line of column names and its number; for TUM the first row, which will be read again.
    pub(crate) columns: (usize, String),
}

impl Head {
    /// Comment text kept at most \[bytes\]; more than that is no header.
    const LIMIT: usize = 1 << 20;

    pub(crate) fn read<R: BufRead>(lines: &mut Lines<'_, R>) -> Result<Self, TraceError> {
        let file = lines.file().to_owned();
        let mut comments: Vec<(usize, String)> = Vec::new();
        let mut size = 0;
        while let Some(line) = lines.next()? {
            if let Some(comment) = line.text.strip_prefix('#') {
                size += line.text.len();
                if size > Self::LIMIT {
                    return Err(unknown(&file, line.text));
                }
                comments.push((line.number, comment.trim().to_owned()));
                continue;
            }
            let columns = (line.number, line.text.to_owned());
            let own = comments.first().is_some_and(|(_, c)| c.starts_with(MAGIC));
            let format = if own {
                Some(Format::Foveasim)
            } else {
                Format::of_line(&columns.1)
            };
            let format = format.ok_or_else(|| unknown(&file, &columns.1))?;
            if format == Format::Tum {
                lines.push_back();
            }
            return Ok(Self {
                format,
                comments,
                columns,
            });
        }
        let what = if comments.is_empty() {
            "the file is empty"
        } else {
            "comments alone"
        };
        Err(TraceError::NoSamples { file, what })
    }
}

fn unknown(file: &str, line: &str) -> TraceError {
    const SHOWN: usize = 60;
    let mut seen: String = line
        .chars()
        .take(SHOWN)
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
    if line.chars().nth(SHOWN).is_some() {
        seen.push('…');
    }
    let known: Vec<_> = Format::ALL
        .iter()
        .map(|f| format!("{f} ({})", f.mark()))
        .collect();
    TraceError::UnknownFormat {
        file: file.to_owned(),
        seen,
        known: known.join("; "),
    }
}

/// Refuses a row whose time is before the one above it.
fn in_order(row: &number::Row<'_>, previous: Option<Nanos>, t: Nanos) -> Result<(), TraceError> {
    match previous {
        // The last row of a file that was cut off may have lost digits of its time.
        Some(from) if t < from && !row.complete => Err(TraceError::Truncated {
            file: row.file.to_owned(),
            line: row.line,
        }),
        Some(from) if t < from => Err(TraceError::TimeReversed {
            file: row.file.to_owned(),
            line: row.line,
            from,
            to: t,
        }),
        _ => Ok(()),
    }
}

/// A series of samples whose order was checked; `None` where there is none.
fn series<T: Interpolate>(samples: Vec<Sample<T>>, provenance: Provenance) -> Option<Series<T>> {
    (!samples.is_empty())
        .then(|| Series::new(samples, provenance).expect("readers check the order of time"))
}

/// The error for a file with a header and no row.
fn no_rows(file: &str) -> TraceError {
    TraceError::NoSamples {
        file: file.to_owned(),
        what: "a header alone",
    }
}

/// "1 sample", "2 samples".
pub(crate) fn count(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}
