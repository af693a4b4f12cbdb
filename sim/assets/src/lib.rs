//! Scenes: what there is to see, as data that a renderer reads.
//!
//! A [`Scene`] is meshes, instances of them, materials, a sky and a sun. Everything in it has been
//! checked when it is built, so that a renderer never meets an index out of range or a NaN vertex.
//! [`study_scene`] generates the scene of Guenter et al. 2012, §5, in a first version;
//! [`load_scene`] reads OBJ, glTF, GLB, PLY and STL files.
//!
//! # Simplifications
//!
//! Instances move rigidly; no normal maps and no transparency; one sun, no shadows.

mod camera;
mod load;
mod material;
mod mesh;
mod noise;
mod scene;
mod sky;
mod study;
mod surface;
mod terrain;
mod texture;
mod track;

pub use camera::{framing, look_at};
pub use load::{
    Format, LoadError, LoadOptions, Loaded, NoSideFiles, SideFiles, Up, load_bytes, load_scene,
};
pub use material::{Material, Pattern, Surface, Terrain, Textured};
pub use mesh::{Mesh, MeshError, Vertex};
pub use scene::{Instance, Scene, SceneError, SceneParts, Similarity};
pub use sky::{AnalyticSky, Sky, Sun};
pub use study::{STUDY_FRAMES, STUDY_SUN, study_camera, study_scene, study_sky};
pub use surface::{ParametricSurface, tessellate};
pub use terrain::{TERRAIN_EXTENT_M, terrain_height, terrain_mesh};
pub use texture::{Encoding, LARGEST_SIDE, MipLevel, Texture, TextureError, Wrap};
pub use track::{Key, Motion, Repeat, Track, TrackError};
