//! Scenes: what there is to see, as data that a renderer reads.
//!
//! A [`Scene`] is meshes, instances of them, materials, a sky and a sun. Everything in it has been
//! checked when it is built, so that a renderer never meets an index out of range or a NaN vertex.
//! [`study_scene`] generates the scene of Guenter et al. 2012, §5, in a first version.
//!
//! # Simplifications
//!
//! Instances do not move; materials are procedural (no image textures); one sun, no shadows.

mod material;
mod mesh;
mod noise;
mod scene;
mod sky;
mod study;
mod surface;
mod terrain;

pub use material::{Material, Pattern, Phong, Surface, Terrain};
pub use mesh::{Mesh, MeshError, Vertex};
pub use scene::{Instance, Scene, SceneError, Similarity};
pub use sky::{AnalyticSky, Sky, Sun};
pub use study::{STUDY_FRAMES, study_camera, study_scene};
pub use surface::{ParametricSurface, tessellate};
pub use terrain::{TERRAIN_EXTENT_M, terrain_height, terrain_mesh};
