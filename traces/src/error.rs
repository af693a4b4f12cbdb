use foveasim_models::Nanos;
use thiserror::Error;

/// Why a recording could not be read, written or made. Every message names the file and, where there
/// is one, the line, the field, its value and what would be valid.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TraceError {
    /// The operating system refused.
    #[error("{file}: {reason}")]
    Io {
        /// The file.
        file: String,
        /// What it said (not a `source`, which would be printed twice).
        reason: std::io::Error,
    },
    /// The content is of no format that can be read.
    #[error("{file}: not a recording in a known format (it begins `{seen}`); known: {known}")]
    UnknownFormat {
        /// The file.
        file: String,
        /// Its first line, shortened.
        seen: String,
        /// The formats that can be read, and how each is recognised.
        known: String,
    },
    /// Bytes that no text file has.
    #[error("{file}: line {line}: not a text recording ({what})")]
    NotText {
        /// The file.
        file: String,
        /// Line number, from 1.
        line: usize,
        /// What was met.
        what: &'static str,
    },
    /// There is nothing in the file, or a header alone.
    #[error("{file}: no samples ({what}); a recording has at least one row of data")]
    NoSamples {
        /// The file.
        file: String,
        /// What there is instead.
        what: &'static str,
    },
    /// A line beyond any sensible length.
    #[error("{file}: line {line} is longer than {limit} bytes; not a recording")]
    LineTooLong {
        /// The file.
        file: String,
        /// Line number, from 1.
        line: usize,
        /// The longest line that is read \[bytes\].
        limit: usize,
    },
    /// The header lacks a column, or has one twice.
    #[error("{file}: line {line}: {what}")]
    Header {
        /// The file.
        file: String,
        /// Line number, from 1.
        line: usize,
        /// What is wrong, and what would be right.
        what: String,
    },
    /// A row with too few or too many fields.
    #[error("{file}: line {line}: {found} fields; want {expected}")]
    FieldCount {
        /// The file.
        file: String,
        /// Line number, from 1.
        line: usize,
        /// How many fields there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// The file ends in the middle of its last row.
    #[error(
        "{file}: line {line}: truncated (the file ends inside this row); delete the row or copy the file again"
    )]
    Truncated {
        /// The file.
        file: String,
        /// Line number, from 1.
        line: usize,
    },
    /// A field that cannot be what its column says.
    #[error("{file}: line {line}: {field} = `{value}`: must be {valid}")]
    Field {
        /// The file.
        file: String,
        /// Line number, from 1.
        line: usize,
        /// The column's name.
        field: String,
        /// What stands there.
        value: String,
        /// What could stand there.
        valid: String,
    },
    /// Rows out of order.
    #[error(
        "{file}: line {line}: time goes back from {from} to {to}; rows must be in order of time"
    )]
    TimeReversed {
        /// The file.
        file: String,
        /// Line number of the earlier time, from 1.
        line: usize,
        /// Time of the row before.
        from: Nanos,
        /// Time of this row.
        to: Nanos,
    },
    /// A segment was asked for that the file does not have.
    #[error("{file}: segment {wanted}: must be 1 to {segments}")]
    NoSuchSegment {
        /// The file.
        file: String,
        /// The segment asked for.
        wanted: usize,
        /// How many there are.
        segments: usize,
    },
    /// No gaze sample has a value.
    #[error("{source_name}: no valid gaze sample ({why}); this needs a recording with gaze")]
    NoGaze {
        /// Where the recording comes from.
        source_name: String,
        /// What there is instead.
        why: String,
    },
    /// No pose sample has a value.
    #[error("{source_name}: no valid head pose ({why}); this needs a recording with head pose")]
    NoPose {
        /// Where the recording comes from.
        source_name: String,
        /// What there is instead.
        why: String,
    },
    /// An option or a specification that cannot be used.
    #[error("{field} = {value}: must be {valid}")]
    Option {
        /// Its name, with the unit.
        field: &'static str,
        /// The value given.
        value: String,
        /// What would be valid.
        valid: String,
    },
}

impl TraceError {
    pub(crate) fn option(
        field: &'static str,
        value: impl ToString,
        valid: impl Into<String>,
    ) -> Self {
        Self::Option {
            field,
            value: value.to_string(),
            valid: valid.into(),
        }
    }
}

/// Checks that an option's value is a number in `range`.
pub(crate) fn option_in(
    field: &'static str,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
) -> Result<f64, TraceError> {
    if range.contains(&value) {
        return Ok(value);
    }
    let valid = format!("a number from {} to {}", range.start(), range.end());
    Err(TraceError::option(field, value, valid))
}
