use thiserror::Error;

/// A value or a name that a model cannot be built from.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ModelError {
    /// A number outside what is physically or numerically meaningful.
    #[error("{field} = {value}: must be {valid}")]
    OutOfRange {
        /// The field's name, with its unit.
        field: String,
        /// The value given, as text.
        value: String,
        /// What would be valid.
        valid: String,
    },
    /// A name that is in no list; see [`unknown_name`].
    #[error("unknown {kind} `{given}`{suggestion}; valid: {valid}")]
    UnknownName {
        /// What kind of thing was named.
        kind: &'static str,
        /// The name given.
        given: String,
        /// `"; did you mean …?"`, or empty.
        suggestion: String,
        /// All valid names.
        valid: String,
    },
    /// Text that does not have the form its reader documents.
    #[error("{0}")]
    Syntax(String),
}

impl ModelError {
    /// An [`ModelError::OutOfRange`].
    pub fn range(field: impl Into<String>, value: impl ToString, valid: impl Into<String>) -> Self {
        Self::OutOfRange {
            field: field.into(),
            value: value.to_string(),
            valid: valid.into(),
        }
    }
}

/// The valid name closest to `given`, if any is close enough to be a likely slip.
pub fn closest<'a>(given: &str, valid: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = given.to_lowercase();
    valid
        .into_iter()
        .map(|name| (strsim::jaro_winkler(&wanted, &name.to_lowercase()), name))
        .filter(|(score, _)| *score > 0.7)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

/// The error for a name that is not among `valid`, with the nearest one.
pub fn unknown_name(kind: &'static str, given: &str, valid: &[&str]) -> ModelError {
    ModelError::UnknownName {
        kind,
        given: given.to_owned(),
        suggestion: closest(given, valid.iter().copied())
            .map(|name| format!(", did you mean `{name}`?"))
            .unwrap_or_default(),
        valid: valid.join(", "),
    }
}

/// One line for a TOML text that does not fit its type: `origin`, line, what is wrong, and for an
/// unknown key the nearest valid one.
pub fn toml_error(origin: &str, text: &str, error: &toml::de::Error) -> ModelError {
    let line = error
        .span()
        .map_or(1, |span| 1 + text[..span.start].matches('\n').count());
    // serde lists names in backquotes: the unknown one first, then those that are valid.
    let message = error.message().trim_end().replace('\n', "; ");
    let mut quoted = message.split('`').skip(1).step_by(2);
    let suggestion = match (message.starts_with("unknown field"), quoted.next()) {
        (true, Some(given)) => closest(given, quoted)
            .map(|name| format!("; did you mean `{name}`?"))
            .unwrap_or_default(),
        _ => String::new(),
    };
    ModelError::Syntax(format!("{origin}: line {line}: {message}{suggestion}"))
}

/// Checks that `value` is finite and in `range`; the error names the field and the range.
pub(crate) fn in_range(
    field: &str,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
) -> Result<f64, ModelError> {
    if range.contains(&value) {
        Ok(value)
    } else {
        let valid = format!("a number from {} to {}", range.start(), range.end());
        // What is far beyond has hundreds of digits.
        let value = match value.abs() >= 1e15 {
            true => format!("{value:e}"),
            false => value.to_string(),
        };
        Err(ModelError::range(field, value, valid))
    }
}

/// Checks that `value` is finite, above `low` and at most `high`.
pub(crate) fn above(field: &str, value: f64, low: f64, high: f64) -> Result<f64, ModelError> {
    if value > low && value <= high {
        Ok(value)
    } else {
        Err(ModelError::range(
            field,
            value,
            format!("a number above {low}, at most {high}"),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_name_is_suggested() {
        let text = unknown_name("display", "quest-por", &["quest-pro", "dk2"]).to_string();
        assert!(text.contains("did you mean `quest-pro`?"), "{text}");
        let text = unknown_name("display", "xxxxxxxx", &["quest-pro", "dk2"]).to_string();
        assert!(!text.contains("did you mean"), "{text}");
    }

    #[test]
    fn toml_errors_are_one_line_with_the_nearest_key() {
        #[derive(Debug, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        #[expect(dead_code, reason = "only parsed")]
        struct Spec {
            width: f64,
            height: f64,
        }
        let text = "width = 1\nhieght = 2\n";
        let error = toml_error("a.toml", text, &toml::from_str::<Spec>(text).unwrap_err());
        let error = error.to_string();
        assert!(
            error.starts_with("a.toml: line 2: unknown field `hieght`"),
            "{error}"
        );
        assert!(
            error.ends_with("did you mean `height`?") && !error.contains('\n'),
            "{error}"
        );
    }

    #[test]
    fn nan_is_never_in_range() {
        assert!(in_range("x", f64::NAN, 0.0..=1.0).is_err());
        assert!(above("x", f64::NAN, 0.0, 1.0).is_err());
    }
}
