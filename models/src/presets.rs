//! Devices as data files: each number has a source, or says that nobody verified it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::error::toml_error;
use crate::{CostProfile, Display, DisplaySpec, ModelError, Tracker, TrackerSpec, unknown_name};

/// Where a number comes from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Publication, manual or driver that states it; or how it was derived.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
    /// True where it is reported or assumed, and nobody on this project could check it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub unverified: bool,
}

/// One number of a device description, with where it comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fact {
    /// Path of the field (`scan.refresh_hz`).
    pub field: String,
    /// Its value, as written in TOML.
    pub value: String,
    /// Where it comes from; `None` where the description does not say.
    pub source: Option<Source>,
}

/// All numbers and names of a device description, in the order of their paths.
pub fn facts<T: Serialize>(spec: &T, sources: &BTreeMap<String, Source>) -> Vec<Fact> {
    let mut facts = Vec::new();
    if let Ok(value) = toml::Value::try_from(spec) {
        collect(String::new(), &value, sources, &mut facts);
    }
    facts
}

fn collect(
    path: String,
    value: &toml::Value,
    sources: &BTreeMap<String, Source>,
    facts: &mut Vec<Fact>,
) {
    match value {
        toml::Value::Table(fields) => {
            for (key, v) in fields.iter().filter(|(key, _)| *key != "sources") {
                let dot = if path.is_empty() { "" } else { "." };
                collect(format!("{path}{dot}{key}"), v, sources, facts);
            }
        }
        leaf => {
            let value = leaf
                .as_str()
                .map_or_else(|| leaf.to_string(), str::to_owned);
            let source = sources.get(&path).cloned();
            facts.push(Fact {
                field: path,
                value,
                source,
            });
        }
    }
}

macro_rules! embed {
    ($folder:literal: $($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../presets/", $folder, "/", $name, ".toml")))),+]
    };
}

const DISPLAYS: &[(&str, &str)] = embed!(
    "displays": "lg-w2363d", "fove-0", "dk2", "quest-pro", "quest-3", "vive-pro", "vive-pro-2", "index",
    "varjo-xr-4", "psvr2", "bigscreen-beyond"
);
const TRACKERS: &[(&str, &str)] = embed!(
    "trackers": "tx300", "spectrum", "fove-0", "quest-pro", "vive-pro-eye", "varjo"
);

const COSTS: &[(&str, &str)] = embed!("costs": "guenter2012");

/// Names of all cost profiles.
pub fn cost_names() -> Vec<&'static str> {
    COSTS.iter().map(|(name, _)| *name).collect()
}

/// The cost profile `name`.
///
/// # Errors
/// If there is none of that name; the error names the nearest.
pub fn cost(name: &str) -> Result<CostProfile, ModelError> {
    parse_cost(cost_text(name)?, name)
}

/// Reads a cost profile from TOML text; `origin` names it in errors.
///
/// # Errors
/// If the text is not TOML, has an unknown key, lacks one, or a coefficient is out of range.
pub fn parse_cost(text: &str, origin: &str) -> Result<CostProfile, ModelError> {
    let profile: CostProfile = toml::from_str(text).map_err(|e| toml_error(origin, text, &e))?;
    profile.validate()
}

/// Names of all displays.
pub fn display_names() -> Vec<&'static str> {
    DISPLAYS.iter().map(|(name, _)| *name).collect()
}

/// Names of all trackers.
pub fn tracker_names() -> Vec<&'static str> {
    TRACKERS.iter().map(|(name, _)| *name).collect()
}

/// The TOML text of display preset `name`, to start one's own from.
///
/// # Errors
/// If there is none of that name; the error names the nearest.
pub fn display_text(name: &str) -> Result<&'static str, ModelError> {
    find("display", name, DISPLAYS)
}

/// The TOML text of tracker preset `name`, to start one's own from.
///
/// # Errors
/// If there is none of that name; the error names the nearest.
pub fn tracker_text(name: &str) -> Result<&'static str, ModelError> {
    find("tracker", name, TRACKERS)
}

/// The TOML text of cost profile `name`, to start one's own from.
///
/// # Errors
/// If there is none of that name; the error names the nearest.
pub fn cost_text(name: &str) -> Result<&'static str, ModelError> {
    find("cost profile", name, COSTS)
}

/// The display preset `name`, as written, with its sources.
///
/// # Errors
/// If there is none of that name; the error names the nearest.
pub fn display_spec(name: &str) -> Result<DisplaySpec, ModelError> {
    parse_display(display_text(name)?, name)
}

/// The tracker preset `name`, as written, with its sources.
///
/// # Errors
/// If there is none of that name; the error names the nearest.
pub fn tracker_spec(name: &str) -> Result<TrackerSpec, ModelError> {
    parse_tracker(tracker_text(name)?, name)
}

/// The display preset `name`.
///
/// # Errors
/// If there is none of that name; the error names the nearest.
pub fn display(name: &str) -> Result<Display, ModelError> {
    display_spec(name)?.try_into()
}

/// The tracker preset `name`.
///
/// # Errors
/// If there is none of that name; the error names the nearest.
pub fn tracker(name: &str) -> Result<Tracker, ModelError> {
    tracker_spec(name)?.try_into()
}

/// Reads a display from TOML text; `origin` names it in errors.
///
/// # Errors
/// If the text is not TOML, has an unknown key or lacks one.
pub fn parse_display(text: &str, origin: &str) -> Result<DisplaySpec, ModelError> {
    let spec: DisplaySpec = toml::from_str(text).map_err(|e| toml_error(origin, text, &e))?;
    check_sources(&facts(&spec, &spec.sources), &spec.sources, origin)?;
    Ok(spec)
}

/// Reads a tracker from TOML text; `origin` names it in errors.
///
/// # Errors
/// If the text is not TOML, has an unknown key or lacks one.
pub fn parse_tracker(text: &str, origin: &str) -> Result<TrackerSpec, ModelError> {
    let spec: TrackerSpec = toml::from_str(text).map_err(|e| toml_error(origin, text, &e))?;
    check_sources(&facts(&spec, &spec.sources), &spec.sources, origin)?;
    Ok(spec)
}

/// A source for a field that does not exist is a misspelt one: its number would be left without.
fn check_sources(
    facts: &[Fact],
    sources: &BTreeMap<String, Source>,
    origin: &str,
) -> Result<(), ModelError> {
    let fields: Vec<&str> = facts.iter().map(|f| f.field.as_str()).collect();
    match sources.keys().find(|key| !fields.contains(&key.as_str())) {
        None => Ok(()),
        Some(key) => {
            let error = unknown_name("field", key, &fields);
            Err(ModelError::Syntax(format!("{origin}: [sources]: {error}")))
        }
    }
}

fn find(
    kind: &'static str,
    name: &str,
    list: &[(&'static str, &'static str)],
) -> Result<&'static str, ModelError> {
    match list.iter().find(|(n, _)| *n == name) {
        Some((_, text)) => Ok(text),
        None => Err(unknown_name(
            kind,
            name,
            &list.iter().map(|(n, _)| *n).collect::<Vec<_>>(),
        )),
    }
}

#[cfg(test)]
mod tests;
