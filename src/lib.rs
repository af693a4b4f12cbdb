//! foveasim predicts what foveated and low-latency rendering saves on an eye-tracked display, and
//! shows why the prediction can be trusted.
//!
//! This crate is the front door: it re-exports the workspace's libraries under one name, and holds
//! the command-line tool. Start with [`models`] for displays, acuity and methods, and with [`study`]
//! for whole experiments.

#[cfg(feature = "cli")]
pub mod cli;

pub use foveasim_assets as assets;
pub use foveasim_mask as mask;
pub use foveasim_models as models;
pub use foveasim_pipeline as pipeline;
pub use foveasim_quality as quality;
pub use foveasim_render as render;
pub use foveasim_reports as reports;
pub use foveasim_study as study;
pub use foveasim_traces as traces;
pub use foveasim_volume as volume;
