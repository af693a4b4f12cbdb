use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use foveasim_models::Recording;

use crate::formats::{self, Format};
use crate::lines::Lines;
use crate::{ReadOptions, TraceError};

/// Reads the recording in a file, whatever known format it has.
///
/// # Errors
/// If the file cannot be opened, has no known format, or its content is damaged: see [`TraceError`].
pub fn read_path(path: &Path, options: &ReadOptions) -> Result<Recording, TraceError> {
    let name = path.display().to_string();
    let open = || -> std::io::Result<File> {
        let file = File::open(path)?;
        if file.metadata()?.is_dir() {
            return Err(std::io::Error::other("is a folder; want a file"));
        }
        Ok(file)
    };
    let file = open().map_err(|reason| TraceError::Io {
        file: name.clone(),
        reason,
    })?;
    read(BufReader::with_capacity(1 << 16, file), &name, options)
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
    options.validate()?;
    let mut lines = Lines::new(reader, name);
    let head = formats::Head::read(&mut lines)?;
    let mut recording = head.format.parse(&head, &mut lines, options)?;
    recording.source = name.to_owned();
    recording.format = head.format.name().to_owned();
    if let Some(provenance) = options.provenance {
        recording.notes.push(match recording.gaze {
            Some(_) => format!("gaze provenance as given: {provenance}"),
            None => "the provenance given is one of gaze; there is none here to apply it to".into(),
        });
        recording.notes.retain(|n| n != formats::GAZE_ASSUMED);
        recording.gaze = recording.gaze.map(|s| s.with_provenance(provenance));
    }
    Ok(recording)
}

/// Finds the format of a recording from its first lines.
///
/// # Errors
/// If it is of no known format, or not text at all.
pub fn detect(reader: impl BufRead, name: &str) -> Result<Format, TraceError> {
    formats::Head::read(&mut Lines::new(reader, name)).map(|head| head.format)
}
