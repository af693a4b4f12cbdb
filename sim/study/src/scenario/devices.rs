//! Devices and texts that a scenario names.

use std::path::Path;

use foveasim_models::{
    CostProfile, Display, DisplaySpec, ModelError, Tracker, TrackerSpec, presets,
};

use super::ScenarioError;

/// The display of that name, or in that TOML file.
///
/// # Errors
/// If there is none, or it is not valid.
pub fn display(text: &str) -> Result<Display, ScenarioError> {
    Ok(in_file(text, Display::try_from(display_spec(text)?))?)
}

pub(super) fn display_spec(text: &str) -> Result<DisplaySpec, ScenarioError> {
    Ok(match as_file(text) {
        Some(path) => presets::parse_display(&read_text(path)?, text)?,
        None => presets::display_spec(text)?,
    })
}

/// The tracker of that name, or in that TOML file.
///
/// # Errors
/// If there is none, or it is not valid.
pub fn tracker(text: &str) -> Result<Tracker, ScenarioError> {
    Ok(in_file(text, Tracker::try_from(tracker_spec(text)?))?)
}

pub(super) fn tracker_spec(text: &str) -> Result<TrackerSpec, ScenarioError> {
    Ok(match as_file(text) {
        Some(path) => presets::parse_tracker(&read_text(path)?, text)?,
        None => presets::tracker_spec(text)?,
    })
}

/// The cost profile of that name, or in that TOML file.
///
/// # Errors
/// If there is none, or it is not valid.
pub fn cost(text: &str) -> Result<CostProfile, ScenarioError> {
    match as_file(text) {
        Some(path) => Ok(in_file(text, presets::parse_cost(&read_text(path)?, text))?),
        None => Ok(presets::cost(text)?),
    }
}

/// Adds the file's name to an error about a value in it.
fn in_file<T>(origin: &str, result: Result<T, ModelError>) -> Result<T, ModelError> {
    result.map_err(|e| match e {
        ModelError::OutOfRange {
            field,
            value,
            valid,
        } => ModelError::OutOfRange {
            field: format!("{origin}: {field}"),
            value,
            valid,
        },
        other => other,
    })
}

/// Text that can only be meant as a path: it ends in `.toml` or has a folder in it.
pub(super) fn as_file(text: &str) -> Option<&Path> {
    let path = Path::new(text);
    (path.extension().is_some_and(|e| e == "toml") || path.components().count() > 1).then_some(path)
}

/// A text file that people wrote; at most 1 MiB.
///
/// # Errors
/// If it cannot be read, or is larger.
pub fn read_text(path: &Path) -> Result<String, ScenarioError> {
    read_text_up_to(path, 1 << 20)
}

/// A text file of at most `limit` bytes.
pub(crate) fn read_text_up_to(path: &Path, limit: u64) -> Result<String, ScenarioError> {
    let error = |why| ScenarioError::Read {
        path: path.to_owned(),
        why,
    };
    let size = std::fs::metadata(path).map_err(error)?.len();
    if size > limit {
        let text = format!("{size} bytes; such a file has at most {limit}");
        return Err(error(std::io::Error::new(
            std::io::ErrorKind::FileTooLarge,
            text,
        )));
    }
    std::fs::read_to_string(path).map_err(error)
}
