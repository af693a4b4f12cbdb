//! Geometry: vertices transformed once for a view, triangles set up and binned for each pass.

mod attributes;
mod bins;
mod clip;
mod coverage;
mod gather;
mod geometry;
mod plane;
mod setup;

pub(crate) use attributes::{Needs, attributes, details, vertices, vertices_at_end};
pub(crate) use bins::Bins;
pub(crate) use geometry::{Bounds, EyeVertex, Object, ViewGeometry, bounds, bounds_at};
pub(crate) use setup::{BEHIND, Emitter, PassTriangles, SetUp, SetUpTriangle, segments, set_up};
