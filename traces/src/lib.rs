//! Recordings of gaze and head pose: readers that find the format by content, one documented format
//! of our own, resampling, and synthesis.
//!
//! Every reader streams: besides the samples themselves it holds one line. What a reader had to
//! repair, skip or assume is in [`Recording::notes`](foveasim_models::Recording); what it cannot read
//! is one [`TraceError`] that names the file, the line, the field and its value. Nothing is guessed
//! in silence.
//!
//! Times are kept as the file has them (see [`rebase`]). Positions become metres, gaze becomes degrees
//! relative to the head, and poses `world_from_head` with −Z forward and +Y up.
//!
//! ```
//! use foveasim_traces::{ReadOptions, info, read, require_gaze};
//!
//! let file = "timestamp\tleft_x\tleft_y\n0\t0\t-270\n1\tnan\tnan\n2\t0\t-270\n";
//! let recording = read(file.as_bytes(), "gaze.tsv", &ReadOptions::default())?;
//! let up = require_gaze(&recording)?.samples()[0].value.expect("the first sample is there");
//! assert!((up.elevation_deg - 6.52).abs() < 0.01, "a quarter of a screen of 297 mm at 650 mm");
//! assert_eq!(info(&recording).gaze.map(|gaze| gaze.missing), Some(1));
//! # Ok::<(), foveasim_traces::TraceError>(())
//! ```

mod check;
mod edit;
mod error;
mod events;
mod formats;
mod info;
mod interval;
mod labels;
mod lines;
mod options;
mod read;
mod stream;
mod synth;
mod write;

pub use check::{require_gaze, require_pose};
pub use edit::{decimate_gaze, rebase, resample, resample_recording, slice};
pub use error::TraceError;
pub use events::{
    Agreement, Estimate, EventMethod, EventOptions, GazeEvent, GazeEvents, MainSequence,
    OnsetError, SpeedLimits, agreement, find_events, main_sequence, target_agreement,
    vendor_agreement,
};
pub use formats::{Format, RowSamples};
pub use info::{SeriesInfo, TraceInfo, info};
pub use labels::{EventKind, LabelledEvent, Labels, TargetStep};
pub use options::{ReadOptions, Screen, ScreenSpec};
pub use read::{detect, read, read_labelled, read_labelled_path, read_path};
pub use stream::{SampleReader, StreamedRecording};
pub use synth::{SynthSpec, default_recording, synth, with_synthetic_gaze};
pub use write::write;
