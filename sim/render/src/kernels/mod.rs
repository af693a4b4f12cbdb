//! Hot loops, one source for every vector width.

mod dispatch;
mod extremes;
pub(crate) mod lanes;
mod noise;
mod place;
mod reproject;
mod shade;
mod sky;
mod surface;
mod terrain;
mod vertices;
mod visible;

pub(crate) use dispatch::{Kernel, dispatch};
pub(crate) use extremes::Extremes;
pub(crate) use reproject::{Before, Past, ReprojectRow, Source, Warp};
pub(crate) use shade::{Attributes, ShadeContext, ShadeTile};
pub(crate) use vertices::{CODE_GUARD, CODE_NEAR, TransformVertices, VertexTransform};
pub(crate) use visible::RasterizeTile;
