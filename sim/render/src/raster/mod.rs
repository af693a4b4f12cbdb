//! Geometry of one pass: transformed vertices, triangles set up for tiles, bins of tiles.

mod attributes;
mod bins;
mod clip;
mod geometry;
mod setup;

pub(crate) use attributes::attributes;
pub(crate) use bins::{Bins, TriangleRef};
pub(crate) use geometry::{Geometry, ScreenVertex, transform};
pub(crate) use setup::{SetUpTriangle, set_up};
