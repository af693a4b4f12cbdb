use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use flate2::bufread::MultiGzDecoder;
use foveasim_models::{Provenance, Recording};

use crate::formats::{self, Format, Parsed};
use crate::lines::Lines;
use crate::{Labels, ReadOptions, TraceError};

/// Text that is unpacked from a compressed file at most \[bytes\]: an hour of 1200 Hz has some 0.3 GB, and a
/// few megabytes can be made to unpack to anything.
const UNPACKED_LIMIT: u64 = 1 << 32;

/// How much of a file is read at once \[bytes\].
pub(crate) const BUFFER: usize = 1 << 16;

/// What compressed files (gzip) begin with.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Reads the recording in a file, whatever known format it has, gzip-compressed or not.
///
/// # Errors
/// If the file cannot be opened, has no known format, or its content is damaged: see [`TraceError`].
pub fn read_path(path: &Path, options: &ReadOptions) -> Result<Recording, TraceError> {
    read_labelled_path(path, options).map(|(recording, _)| recording)
}

/// As [`read_path`], with what the file says of its samples: events that others found, targets.
///
/// # Errors
/// As [`read_path`].
pub fn read_labelled_path(
    path: &Path,
    options: &ReadOptions,
) -> Result<(Recording, Labels), TraceError> {
    let name = path.display().to_string();
    let file = open(path, &name)?;
    read_labelled(BufReader::with_capacity(BUFFER, file), &name, options)
}

/// Opens a file that is no folder.
pub(crate) fn open(path: &Path, name: &str) -> Result<File, TraceError> {
    let open = || -> std::io::Result<File> {
        let file = File::open(path)?;
        if file.metadata()?.is_dir() {
            return Err(std::io::Error::other("is a folder; want a file"));
        }
        Ok(file)
    };
    open().map_err(|reason| TraceError::Io {
        file: name.to_owned(),
        reason,
    })
}

/// Reads a recording from anything; `name` stands for the file's in errors and in
/// [`Recording::source`].
///
/// # Errors
/// As [`read_path`].
pub fn read(
    reader: impl BufRead,
    name: &str,
    options: &ReadOptions,
) -> Result<Recording, TraceError> {
    read_labelled(reader, name, options).map(|(recording, _)| recording)
}

/// As [`read`], with what the file says of its samples: events that others found, targets.
///
/// # Errors
/// As [`read_path`].
pub fn read_labelled(
    reader: impl BufRead,
    name: &str,
    options: &ReadOptions,
) -> Result<(Recording, Labels), TraceError> {
    options.validate()?;
    let mut lines = text(reader, name)?;
    let head = formats::Head::read(&mut lines)?;
    let Parsed {
        mut recording,
        labels,
    } = head.format.parse(&head, &mut lines, options)?;
    recording.notes.extend(lines.note());
    recording.source = name.to_owned();
    recording.format = head.format.name().to_owned();
    if let Some(provenance) = options.provenance {
        state_provenance(provenance, recording.gaze.is_some(), &mut recording.notes);
        recording.gaze = recording.gaze.map(|s| s.with_provenance(provenance));
    }
    Ok((recording, labels))
}

/// Notes that the provenance of gaze was given, and not read.
pub(crate) fn state_provenance(given: Provenance, has_gaze: bool, notes: &mut Vec<String>) {
    notes.push(match has_gaze {
        true => format!("gaze provenance as given: {given}"),
        false => "the provenance given is one of gaze; there is none here to apply it to".into(),
    });
    notes.retain(|n| n != formats::GAZE_ASSUMED);
}

/// Finds the format of a recording from its first lines.
///
/// # Errors
/// If it is of no known format, or not text at all.
pub fn detect(reader: impl BufRead, name: &str) -> Result<Format, TraceError> {
    Ok(formats::Head::read(&mut text(reader, name)?)?.format)
}

/// The lines of a text, which may be compressed.
pub(crate) fn text<'n, 'r>(
    mut reader: impl BufRead + 'r,
    name: &'n str,
) -> Result<Lines<'n, Box<dyn BufRead + 'r>>, TraceError> {
    let start = reader.fill_buf().map_err(|reason| TraceError::Io {
        file: name.to_owned(),
        reason,
    })?;
    let text: Box<dyn BufRead + 'r> = if start.starts_with(&GZIP) {
        let text = Limited {
            inner: MultiGzDecoder::new(reader),
            left: UNPACKED_LIMIT,
        };
        Box::new(BufReader::with_capacity(BUFFER, text))
    } else {
        Box::new(reader)
    };
    Ok(Lines::new(text, name))
}

/// A reader that fails, and does not end, where there is more than it may give.
struct Limited<R> {
    inner: R,
    /// Bytes it may still give.
    left: u64,
}

impl<R: Read> Read for Limited<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let n = self.inner.read(buffer)?;
        let over = || {
            let limit = UNPACKED_LIMIT >> 30;
            std::io::Error::other(format!("unpacks to more than {limit} GiB; unpack it first"))
        };
        self.left = self.left.checked_sub(n as u64).ok_or_else(over)?;
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_much_is_an_error_and_not_an_end() {
        let read = |left| {
            let mut all = Vec::new();
            Limited {
                inner: &b"12345"[..],
                left,
            }
            .read_to_end(&mut all)
            .map(|_| all)
        };
        assert_eq!(read(5).unwrap(), b"12345");
        assert!(read(4).unwrap_err().to_string().contains("more than 4 GiB"));
    }
}
