//! The gaze-to-photon chain as a discrete-event simulation in whole nanoseconds.
//!
//! ```text
//!            exposure grid            host frames                 vblank grid
//!                 │                        │                           │
//!  truth ─▶ [exposure│processing] ─▶ gaze ─▶ [ render ] ─▶ flip ─▶ [ scan-out row by row ] ─▶ photons
//!                                          ▲     ▲                 1 frame, or 2 when it tears   ▲
//!                            pose ─ predict ┘     └ FrameCost            PixelResponse, Emission ┘
//! ```
//!
//! [`Pipeline::run`] plays a [`Setup`] and pushes what happens into a [`Sink`]: gaze samples as they
//! are delivered, frames as they are finished ([`Rendered`]: what each one knew), scans as they
//! complete ([`Displayed`]: which frame lit which rows, when). Nothing is drawn here and no clock is
//! read: a frame's rendering time comes from [`FrameCost`](foveasim_models::FrameCost).
//!
//! Memory does not grow with the length of a run; the sink decides what to keep ([`Recorder`] keeps
//! all). The engine is single-threaded: run many in parallel, each with its own phases.
//!
//! # Simplifications
//!
//! A gaze sample reports the truth at the middle of its exposure. Samples are delivered in the order in which they were exposed. One frame is
//! rendered at a time, whole, by a host whose own work on it takes no time.

mod bounds;
mod calendar;
mod compositor;
mod cursor;
mod displayed;
mod gaze_feed;
mod host;
mod interval;
mod pipeline;
mod pose_feed;
mod rendered;
mod runtime;
mod samples;
mod setup;
mod sink;
mod stages;

pub use bounds::{Beat, BoundKind, Movement, StageBounds, until};
pub use calendar::Calendar;
pub use cursor::Cursor;
pub use displayed::{Displayed, Segment, Shown};
pub use interval::Interval;
pub use pipeline::{Pipeline, RunCounts};
pub use rendered::{GazeStamp, PoseStamp, Rendered, Warp};
pub use runtime::{FrameStart, Missed, Runtime};
pub use samples::{SampleWindow, Samples};
pub use setup::{GazeInput, HeadSampling, Phases, Setup, SyncMode};
pub use sink::{Recorder, Sink};
pub use stages::{STAGES, Sensed, Stage, Stages};

#[cfg(test)]
mod tests;
