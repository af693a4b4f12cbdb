//! The reference renderer: any sample plan of any scene on the CPU, with exact counts of the work.
//!
//! ```text
//! scene + view + pass ─► vertices ─► set-up ─► bins ─► tile: visibility ─► tile: shading ─► pass image
//!                        (once each)  (clip, cull)     (4×2 blocks)        (8 samples)         │
//!                                                   image ◄──────────── resolve ◄──────────────┘
//! ```
//!
//! * [`render`] draws a frame; [`Frame`] holds the image, the passes it was made of and their [`Work`].
//! * Coverage is decided in integers on vertices snapped to 1/256 of a sample, with the top-left rule:
//!   triangles that share an edge cover each sample along it exactly once.
//! * Depth is 1/w in single precision, larger is nearer; of equal depths the triangle that comes
//!   first in the scene wins.
//! * [`trace`] finds the same by casting rays, sample for sample.
//! * A [`Sequence`] draws frame after frame: samples move within their cells, are blended with what was
//!   seen of the same surface before, and passes are drawn in the frames of their cadence.
//! * Each visible sample is shaded once, after visibility is known.
//! * The same input gives the same bytes for any number of threads and any vector width: kernels use
//!   only + − × ÷ √, comparison and selection, and the scalar level runs the same source.
//!
//! # Simplifications
//!
//! Still views and affine maps only. [`render`] draws every
//! pass afresh, whatever its cadence; a [`Sequence`] knows what the frames before have drawn.
//!
//! [`Work`]: foveasim_models::Work

mod bvh;
mod error;
mod fragments;
mod frame;
mod kernels;
mod live;
mod mosaic;
mod msaa;
mod options;
mod pass;
mod passes;
mod project;
mod raster;
mod resolve;
mod temporal;
mod tile;
mod trace;
mod visible;

pub use error::RenderError;
pub use frame::{Frame, render, render_into};
pub use options::{RenderOptions, Simd, Skip};
pub use pass::{Surfel, visibility, visibility_at};
pub use temporal::{Clamp, Sequence, TemporalOptions, jitter};
pub use trace::trace;
