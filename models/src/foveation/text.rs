//! How settings of methods are written: `key` or `key=value`, separated by colons.

use super::Aim;
use crate::{ModelError, unknown_name};

/// One setting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Setting<'a>(pub(super) &'a str, pub(super) Option<&'a str>);

/// The settings of a text.
pub(super) fn settings(text: &str) -> impl Iterator<Item = Setting<'_>> {
    text.split(':').map(Setting::from)
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
