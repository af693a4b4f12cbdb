//! Scenes: what there is to see, as data that a renderer reads.
//!
//! A [`Scene`] is meshes, instances of them, materials, a sky and a sun. Everything in it has been
//! checked when it is built, so that a renderer never meets an index out of range or a NaN vertex.
//! [`study_scene`] generates the scene of Guenter et al. 2012, §5; [`study_camera`] flies through it
//! and [`StudyGaze`] looks at what comes nearest; [`GeneratedScene`] names it and others. [`load_scene`] reads OBJ, glTF, GLB, PLY and STL files.
//!
//! A [`Volume`] is values on a lattice in space, a [`TransferFunction`] says how they look;
//! [`GeneratedVolume`] are computed ones, [`load_volume`] reads files.
//!
//! # Simplifications
//!
//! Instances move rigidly; no normal maps and no transparency; one sun.

mod atmosphere;
mod camera;
mod environment;
mod generated;
mod irradiance;
mod load;
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
mod texture;
mod track;
mod volume;

pub use camera::{framing, look_at};
pub use environment::EnvironmentMap;
pub use generated::GeneratedScene;
pub use irradiance::Irradiance;
pub use load::{
    Format, LoadError, LoadOptions, Loaded, NoSideFiles, SideFiles, Up, load_bytes, load_scene,
};
pub use lod::{Detail, LevelOfDetail, LodRule};
pub use material::{Material, Pattern, Phong, Surface, Terrain, TerrainDetail, Textured};
pub use mesh::{Mesh, MeshError, Vertex};
pub use scene::{Instance, Scene, SceneError, SceneParts, Similarity};
pub use sky::{AnalyticSky, Sky, SkyLight, Sun};
pub use study::{
    STUDY_FRAMES, STUDY_SUN, StudyContent, study_camera, study_scene, study_scene_with, study_sky,
};
pub use study_gaze::StudyGaze;
pub use surface::ParametricSurface;
pub use terrain::{TERRAIN_EXTENT_M, terrain_height, terrain_mesh};
pub use tessellate::{Tessellation, tessellate, tessellation_ladder};
pub use texture::{Encoding, LARGEST_SIDE, MipLevel, Texture, TextureError, Wrap};
pub use track::{Key, Motion, Repeat, Track, TrackError};
pub use volume::{
    Frame, GeneratedVolume, LoadedVolume, TransferError, TransferFunction, TransferPoint,
    ValueHistogram, Volume, VolumeError, VolumeFormat, VolumeParts, Voxels, load_volume,
    load_volume_bytes, volume_named,
};
