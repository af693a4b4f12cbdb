//! How settings of methods are written: `key` or `key=value`, separated by colons.

use std::ops::RangeInclusive;

use super::Aim;
use crate::{ModelError, unknown_name};

/// One setting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Setting<'a>(pub(super) &'a str, pub(super) Option<&'a str>);

/// The settings of a text.
pub(super) fn settings(text: &str) -> impl Iterator<Item = Setting<'_>> {
    text.split(':').map(Setting::from)
}

/// A number that stands by itself, as the first settings of some methods do: `example` shows where.
pub(super) fn number(
    field: &str,
    setting: Option<Setting<'_>>,
    valid: RangeInclusive<f64>,
    example: &str,
) -> Result<f64, ModelError> {
    let text = match setting {
        Some(Setting(key, None)) => key.to_owned(),
        Some(Setting(key, Some(value))) => format!("{key}={value}"),
        None => String::new(),
    };
    match text.parse::<f64>() {
        Ok(value) if valid.contains(&value) => Ok(value),
        _ => {
            let (low, high) = (valid.start(), valid.end());
            let valid = format!("a number from {low} to {high}, as in {example}");
            Err(ModelError::range(field, text, valid))
        }
    }
}

impl<'a> From<&'a str> for Setting<'a> {
    fn from(text: &'a str) -> Self {
        match text.split_once('=') {
            Some((key, value)) => Self(key, Some(value)),
            None => Self(text, None),
        }
    }
}

impl Setting<'_> {
    /// As a setting of [`Aim`], which every method has; `others` are the method's own, for the error
    /// if it is none of them.
    pub(super) fn aim(self, kind: &'static str, others: &[&str]) -> Result<Aim, ModelError> {
        Aim::read(self.0, self.1).unwrap_or_else(|| {
            let valid = [others, &["tracked", "fixed", "fixed="]].concat();
            let given = self
                .1
                .map_or(self.0.to_owned(), |v| format!("{}={v}", self.0));
            Err(unknown_name(kind, &given, &valid))
        })
    }
}
