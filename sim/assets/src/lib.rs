//! Scenes: what there is to see, as data that a renderer reads.
//!
//! A [`Scene`] is meshes, instances of them, materials, a sky and a sun. Everything in it has been
//! checked when it is built, so that a renderer never meets an index out of range or a NaN vertex.
//! [`study_scene`] generates the scene of Guenter et al. 2012, §5; [`study_camera`] flies through it
//! and [`StudyGaze`] looks at what comes nearest.
//!
//! # Simplifications
//!
//! Instances do not move; materials are procedural (no image textures); one sun, no shadows.

mod atmosphere;
mod environment;
mod lod;
mod material;
mod mesh;
mod noise;
mod scene;
mod sky;
mod study;
mod study_gaze;
mod study_objects;
mod surface;
mod terrain;
mod tessellate;

pub use environment::EnvironmentMap;
pub use lod::{Detail, LevelOfDetail, LodRule};
pub use material::{Material, Pattern, Phong, Surface, Terrain, TerrainDetail};
pub use mesh::{Mesh, MeshError, Vertex};
pub use scene::{Instance, Scene, SceneError, Similarity};
pub use sky::{AnalyticSky, Sky, SkyLight, Sun};
pub use study::{STUDY_FRAMES, StudyContent, study_camera, study_scene, study_scene_with};
pub use study_gaze::StudyGaze;
pub use surface::ParametricSurface;
pub use terrain::{TERRAIN_EXTENT_M, terrain_height, terrain_mesh};
pub use tessellate::{Tessellation, tessellate, tessellation_ladder};
