//! Hot loops, one source for every vector width.

mod attributes;
mod blocks;
mod dispatch;
mod edge;
mod environment;
pub(crate) mod lanes;
mod noise;
mod phong;
mod shade;
mod sky;
mod surface;
mod terrain;
mod triangles;
mod vertices;
mod visible;

pub(crate) use attributes::{Attributes, Details};
pub(crate) use dispatch::{Kernel, dispatch};
pub(crate) use shade::{ShadeContext, ShadeTile};
pub(crate) use triangles::SetUpEight;
pub(crate) use vertices::{TransformVertices, VertexTransform};
pub(crate) use visible::RasterizeTile;
