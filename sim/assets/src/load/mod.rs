//! Files of meshes, each format in its own file; the same rules for all of them.
//!
//! * What a file claims is compared with its length before memory is asked for: what is allocated is
//!   proportional to the bytes that are there.
//! * What makes a picture wrong is an error that names file, place and value. What leaves a picture
//!   that is less than its author meant is a warning.

mod error;
mod files;
mod gltf;
mod mtl;
mod normals;
mod obj;
mod picture;
mod ply;
mod soup;
mod stl;
mod text;
mod warnings;

use std::fmt;
use std::path::{Path, PathBuf};

use foveasim_models::Pose;
use glam::{DQuat, DVec3};

pub use error::LoadError;
pub use files::{NoSideFiles, SideFiles};

use crate::{
    Encoding, Instance, Material, Mesh, Motion, STUDY_SUN, Scene, SceneParts, Similarity, Sky, Sun,
    Texture, Textured, Track, Wrap, study_sky,
};
pub(crate) use error::Flaw;
pub(crate) use files::{Folder, whole};
use picture::decode;
use soup::Soup;
pub(crate) use warnings::Warnings;

/// A format of mesh files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ, with MTL material libraries.
    Obj,
    /// glTF 2.0 as JSON.
    Gltf,
    /// glTF 2.0 in its binary container.
    Glb,
    /// Stanford PLY, as text or binary of either byte order.
    Ply,
    /// STL, as text or binary.
    Stl,
}

/// Which axis of a file points up. glTF says +y; the others say nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Up {
    /// +y, as in the renderer's world.
    #[default]
    Y,
    /// +z: usual in engineering and terrain.
    Z,
}

/// How a file becomes a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadOptions {
    /// A picture laid on every material that has no base-colour texture of its own, in place of its
    /// base colour.
    pub texture: Option<PathBuf>,
    /// Which axis of the file points up.
    pub up: Up,
    /// What is seen where no triangle is.
    pub sky: Sky,
    /// The sun.
    pub sun: Sun,
}

impl Default for LoadOptions {
    /// +y up; sky and sun of the study scene, in clear air, for a mesh may be of any size.
    fn default() -> Self {
        let mut sky = study_sky(1);
        sky.visibility_m = f32::INFINITY;
        Self {
            texture: None,
            up: Up::Y,
            sky: Sky::Analytic(sky),
            sun: STUDY_SUN,
        }
    }
}

/// A file as a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded {
    /// One instance for each mesh and place; a file's unit is taken as the metre.
    pub scene: Scene,
    /// What format the file was.
    pub format: Format,
    /// What was left out or replaced, one line each, naming the file.
    pub warnings: Vec<String>,
}

/// Cosine of the crease angle, 45°: where a file gives no normals (and is not glTF, whose missing
/// normals are flat by its rules, 3.7.2.1), triangles that meet at less are shaded as one smooth
/// surface.
const CREASE_COSINE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// The scene in the file at `path`, whose format is told by its content, or else by its name.
///
/// # Errors
/// If the file or a buffer it needs cannot be read, is not of a known format, or is malformed: has a
/// number that is not finite, an index out of range, no triangle, or less than it claims. Missing
/// material libraries and pictures are warnings.
pub fn load_scene(path: &Path, options: &LoadOptions) -> Result<Loaded, LoadError> {
    let bytes = whole(path)?;
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    load_bytes(&bytes, &path.to_string_lossy(), &Folder(folder), options)
}

/// The scene in `bytes`, the content of a file that is called `name`; see [`load_scene`].
///
/// # Errors
/// As [`load_scene`].
pub fn load_bytes(
    bytes: &[u8],
    name: &str,
    files: &dyn SideFiles,
    options: &LoadOptions,
) -> Result<Loaded, LoadError> {
    let format = Format::of(bytes, name).ok_or_else(|| LoadError::Format { file: name.into() })?;
    let mut warnings = Warnings::new(name);
    let draft = match format {
        Format::Obj => obj::load(bytes, files, &mut warnings),
        Format::Gltf | Format::Glb => gltf::load(bytes, files, &mut warnings),
        Format::Ply => ply::load(bytes, &mut warnings),
        Format::Stl => stl::load(bytes, &mut warnings),
    };
    let mut draft = draft.map_err(|flaw| flaw.of(name))?;
    if draft.instances.is_empty() {
        let flaw = Flaw::new("whole file", "has no triangle: there is nothing to draw");
        return Err(flaw.of(name));
    }
    if let Some(path) = &options.texture {
        let file = path.to_string_lossy();
        let texture = decode(&whole(path)?, Encoding::Srgb, [Wrap::Repeat; 2]);
        let texture = texture.map_err(|problem| Flaw::new("picture", problem).of(&file))?;
        draft.lay(texture, &mut warnings);
    }
    if options.up == Up::Z {
        draft.stand_up();
    }
    let parts = SceneParts {
        lods: Vec::new(),
        meshes: draft.meshes,
        instances: draft.instances,
        materials: draft.materials,
        textures: draft.textures,
        motions: draft.motions,
        sky: options.sky.clone(),
        sun: options.sun,
    };
    let scene = Scene::build(parts).map_err(|source| LoadError::Scene {
        file: name.into(),
        source,
    })?;
    Ok(Loaded {
        scene,
        format,
        warnings: warnings.finish(),
    })
}

impl Format {
    /// The format of `bytes`, or else the one that `name` ends in.
    fn of(bytes: &[u8], name: &str) -> Option<Self> {
        let start = bytes.trim_ascii_start();
        if bytes.starts_with(b"glTF") {
            return Some(Self::Glb);
        }
        if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
            return Some(Self::Ply);
        }
        if stl::is_binary(bytes) || stl::is_text(bytes) {
            return Some(Self::Stl);
        }
        if start.starts_with(b"{") {
            return Some(Self::Gltf);
        }
        if obj::is_likely(bytes) {
            return Some(Self::Obj);
        }
        let extension = Path::new(name).extension()?.to_string_lossy();
        match extension.to_ascii_lowercase().as_str() {
            "obj" => Some(Self::Obj),
            "gltf" => Some(Self::Gltf),
            "glb" => Some(Self::Glb),
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            _ => None,
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Obj => "OBJ",
            Self::Gltf => "glTF",
            Self::Glb => "GLB",
            Self::Ply => "PLY",
            Self::Stl => "STL",
        })
    }
}

/// A scene being put together.
#[derive(Debug, Default)]
struct Draft {
    meshes: Vec<Mesh>,
    instances: Vec<Instance>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    motions: Vec<Motion>,
    /// Whether the file has texture coordinates.
    has_uvs: bool,
}

impl Draft {
    /// The triangles of a format without instances: one where the file has it for each material.
    ///
    /// Such formats do not promise which way triangles face, so both sides are seen.
    fn of_soup(
        soup: Soup,
        materials: Vec<Textured>,
        warnings: &mut Warnings,
    ) -> Result<Self, Flaw> {
        let mut draft = Self {
            has_uvs: !soup.uvs.is_empty(),
            materials: materials.into_iter().map(Material::Textured).collect(),
            ..Self::default()
        };
        for (material, mesh) in soup.into_meshes(CREASE_COSINE, warnings)? {
            draft.instances.push(Instance {
                lod: None,
                mesh: draft.meshes.len(),
                material: material as usize,
                world_from_object: Similarity::IDENTITY,
                two_sided: true,
            });
            draft.meshes.push(mesh);
        }
        Ok(draft)
    }

    /// Lays `texture` on all materials that have none.
    fn lay(&mut self, texture: Texture, warnings: &mut Warnings) {
        if !self.has_uvs {
            warnings.add("has no texture coordinates: one texel of the texture shows everywhere");
        }
        for material in &mut self.materials {
            if let Material::Textured(t) = material
                && t.base_texture.is_none()
            {
                t.base_texture = Some(self.textures.len());
                t.base_colour = [1.0; 3];
            }
        }
        self.textures.push(texture);
    }

    /// Turns +z up.
    fn stand_up(&mut self) {
        let turn = DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2);
        let world_from_file = Similarity {
            pose: Pose::new(DVec3::ZERO, turn),
            scale: 1.0,
        };
        for instance in &mut self.instances {
            instance.world_from_object = world_from_file.then(instance.world_from_object);
        }
        let still = Track::still(world_from_file).expect("a quarter turn is a usable placement");
        for motion in &mut self.motions {
            motion.chain.insert(0, still.clone());
        }
    }
}
