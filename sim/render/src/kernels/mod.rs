//! Hot loops, one source for every vector width.

mod attributes;
mod batch;
mod blocks;
mod cubic;
mod dispatch;
mod edge;
mod environment;
mod extremes;
pub(crate) mod lanes;
mod noise;
mod phong;
mod place;
mod reproject;
mod shade;
mod sky;
mod surface;
mod terrain;
mod texture;
mod textured;
mod triangles;
mod vertices;
mod visible;
mod wide;

pub(crate) use attributes::{Attributes, Details};
pub(crate) use cubic::Centre;
pub(crate) use dispatch::{Kernel, dispatch};
pub(crate) use reproject::{Before, ReprojectRow, ReprojectScratch, Source, Warp};
pub(crate) use shade::{ShadeContext, ShadeTile};
pub(crate) use triangles::SetUpEight;
pub(crate) use vertices::{TransformVertices, VertexTransform};
pub(crate) use visible::RasterizeTile;
