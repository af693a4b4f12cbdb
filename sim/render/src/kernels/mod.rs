//! Hot loops, one source for every vector width.

mod dispatch;
pub(crate) mod lanes;
mod noise;
mod shade;
mod sky;
mod surface;
mod terrain;
mod texture;
mod textured;
mod vertices;
mod visible;

pub(crate) use dispatch::{Kernel, dispatch};
pub(crate) use shade::{Attributes, ShadeContext, ShadeTile};
pub(crate) use vertices::{CODE_GUARD, CODE_NEAR, TransformVertices, VertexTransform};
pub(crate) use visible::RasterizeTile;
