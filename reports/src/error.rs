use std::path::PathBuf;

use thiserror::Error;

/// Why a report could not be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A file or folder could not be written.
    #[error("cannot write {path}: {why}")]
    Write {
        /// Where.
        path: PathBuf,
        /// Why; part of the message, and so not a source that a chain of causes would say again.
        why: std::io::Error,
    },
    /// A picture that cannot be encoded: it has no pixels, or not one colour per pixel.
    #[error("cannot encode a picture of {width} x {height} pixels: {why}")]
    Picture {
        /// Its width \[px\].
        width: u32,
        /// Its height \[px\].
        height: u32,
        /// Why.
        why: String,
    },
    /// Pictures that belong together but differ in size.
    #[error("cannot compare a picture of {} x {} with one of {} x {} pixels; sizes must be equal", a[0], a[1], b[0], b[1])]
    SizesDiffer {
        /// Width and height of the first \[px\].
        a: [u32; 2],
        /// Width and height of the second \[px\].
        b: [u32; 2],
    },
    /// A text that is no table.
    #[error("{origin}:{line}: {why}")]
    Csv {
        /// What the text is called.
        origin: String,
        /// Where, from 1.
        line: u64,
        /// What is wrong.
        why: String,
    },
    /// A number that a picture cannot be drawn with.
    #[error("{what} = {value}: must be {valid}")]
    OutOfRange {
        /// The number's name and unit.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What would be valid.
        valid: &'static str,
    },
}

#[cfg(test)]
mod tests {
    use std::error::Error;

    use super::*;

    #[test]
    fn the_reason_is_said_once() {
        let error = ReportError::Write {
            path: "a/b".into(),
            why: std::io::Error::other("disk is full"),
        };
        assert_eq!(error.to_string(), "cannot write a/b: disk is full");
        assert!(error.source().is_none());
    }
}
