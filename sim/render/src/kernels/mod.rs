//! Hot loops, one source for every vector width.

mod attributes;
mod batch;
mod blocks;
mod cubic;
mod edge;
mod environment;
mod extremes;
mod fetch;
mod locate;
mod noise;
mod phong;
mod place;
mod place_tile;
mod placed;
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

pub(crate) use foveasim_lanes::wide::WIDTH;
pub(crate) use foveasim_lanes::{Kernel, dispatch, lanes};
use foveasim_lanes::{transcendental, wide};

pub(crate) use attributes::{Attributes, Details};
pub(crate) use cubic::Centre;
pub(crate) use fetch::FetchRow;
pub(crate) use locate::{LocateRow, PolarInverse};
pub(crate) use place_tile::{PlacePolar, PolarTable, sub_sample};
pub(crate) use placed::RasterizePlaced;
pub(crate) use reproject::{Before, ReprojectRow, ReprojectScratch, Source, Warp};
pub(crate) use shade::{EdgeSample, ShadeContext, ShadeTile};
pub(crate) use triangles::SetUpEight;
pub(crate) use vertices::{TransformVertices, VertexTransform};
pub(crate) use visible::RasterizeTile;
