//! What one frame can take from those before it: samples that move within their cells, means over
//! frames that follow what is seen, and passes that are not drawn every time.
//!
//! ```text
//! plan + frame index ─► offsets ─► pass drawn (if due) ─► place of each sample in the last image of
//! its pass ─► test: same surface? ─► clamp ─► mean over frames ─► kept ─► resolve
//! ```

mod history;
mod jitter;
mod motion;
mod options;
mod reproject;
mod sequence;

pub use jitter::jitter;
pub use options::{Clamp, Interpolation, TemporalOptions};
pub use sequence::Sequence;
