//! Perceptual rasterization (Friston 2019): triangles that move while samples look at places and times of their own.
//!
//! A pass is drawn this way where its display is seen through a lens or scanned while something moves, or where a
//! [`Bound`] is asked for. `foveasim_models::raster` has the mathematics, `docs/bounds.md` the proof that nothing is
//! missed.

mod attributes;
mod bins;
mod bound;
mod counts;
mod setup;
mod trace;
mod triangle;
mod warp;

pub(crate) use attributes::MovingAttributes;
pub use bound::Bound;
pub(crate) use bound::Outlines;
pub(crate) use counts::Counts;
pub use counts::{BoundCounts, TriangleCount, bound_counts};
pub(crate) use setup::{MovingSetUp, MovingTriangles, find_blocks, set_up_moving};
pub use trace::sample_looks;
pub(crate) use trace::trace_moving;
pub(crate) use triangle::{ANYWHERE, Dropped, Seen, Target, px};
pub(crate) use warp::{EvenBlock, EvenPlaces, Warp};
