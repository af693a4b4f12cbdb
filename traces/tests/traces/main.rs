//! Everything that reads, writes and makes recordings, as others use it.

mod damage;
mod events;
mod eyenavgs;
mod foveasim_csv;
mod info;
mod makers;
mod properties;
mod real;
mod samples;
mod screen_centred;
mod synthesis;
mod tum;

use foveasim_models::Recording;
use foveasim_traces::{ReadOptions, TraceError, read};

/// Reads text as a file called `f`.
fn parse(text: &str) -> Result<Recording, TraceError> {
    read(text.as_bytes(), "f", &ReadOptions::default())
}

/// The message of the error that reading text gives.
fn error(text: &str) -> String {
    parse(text).expect_err("must not read").to_string()
}

/// Whether some note says this.
fn noted(recording: &Recording, part: &str) -> bool {
    recording.notes.iter().any(|n| n.contains(part))
}
