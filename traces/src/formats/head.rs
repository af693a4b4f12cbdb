use std::io::BufRead;

use super::{Format, MAGIC};
use crate::TraceError;
use crate::lines::Lines;

/// What stands before the data: comments, and the line that names the columns.
#[derive(Debug)]
pub(crate) struct Head {
    pub(crate) format: Format,
    /// Comment lines without `#`, with their numbers.
    pub(crate) comments: Vec<(usize, String)>,
    /// The line of column names and its number; for formats without one the first row, which will be
    /// read again.
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
                let comment = (line.number, comment.trim().to_owned());
                // EuRoC's names of columns are a comment.
                if Format::of_line(&comment.1) == Some(Format::Euroc) {
                    return Ok(Self {
                        format: Format::Euroc,
                        comments,
                        columns: comment,
                    });
                }
                comments.push(comment);
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
            if !format.names_columns() {
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
    let known: Vec<_> = Format::ALL.iter().map(|f| f.name()).collect();
    TraceError::UnknownFormat {
        file: file.to_owned(),
        seen,
        known: known.join(", "),
    }
}
