use std::sync::Arc;

use foveasim_models::Pose;
use glam::DVec3;
use thiserror::Error;

use crate::{Detail, LevelOfDetail, Material, Mesh, Sky, Sun};

/// Rotate, scale evenly, move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    /// Rotation and translation.
    pub pose: Pose,
    /// Scale, above zero.
    pub scale: f64,
}

/// A mesh somewhere in the world, made of something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// Index of the mesh; with `lod`, of the one among its meshes that stands for them all where no
    /// detail is asked for.
    pub mesh: usize,
    /// Index of the level of detail that the mesh is chosen from, if there is a choice.
    pub lod: Option<usize>,
    /// Index of the material.
    pub material: usize,
    /// Object to world coordinates.
    pub world_from_object: Similarity,
    /// Whether its triangles are seen from behind, too.
    pub two_sided: bool,
}

/// Everything there is to see. Checked when built, immutable after. A clone shares the meshes.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    meshes: Arc<[Mesh]>,
    lods: Arc<[LevelOfDetail]>,
    instances: Vec<Instance>,
    materials: Vec<Material>,
    sky: Sky,
    sun: Sun,
}

/// Why parts do not make a scene.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SceneError {
    /// An instance names a mesh, a material or a level of detail that is not there.
    #[error("instance {instance} names {what} {index}: there are {count}, counted from 0")]
    Reference {
        /// Which instance, from 0.
        instance: usize,
        /// `mesh`, `material` or `level of detail`.
        what: &'static str,
        /// The index given.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A level of detail does not make sense.
    #[error("level of detail {lod} {valid}")]
    Lod {
        /// Which one, from 0.
        lod: usize,
        /// What would be valid.
        valid: &'static str,
    },
    /// An instance's mesh is not among those of its level of detail.
    #[error("instance {instance} has mesh {mesh}: its level of detail {lod} has others")]
    NotOfLod {
        /// Which instance, from 0.
        instance: usize,
        /// Its mesh.
        mesh: usize,
        /// Its level of detail.
        lod: usize,
    },
    /// An instance is placed by numbers that are not finite, or scaled by none above zero.
    #[error(
        "instance {instance} has no usable placement: finite position within ±1e6 m, unit rotation and scale from 1e-6 to 1e6 are needed"
    )]
    Placement {
        /// Which instance, from 0.
        instance: usize,
    },
    /// A material has a number out of its range.
    #[error("material {material} has a value outside the range its documentation gives: {value}")]
    Material {
        /// Which material, from 0.
        material: usize,
        /// The material, as text.
        value: String,
    },
    /// Sky or sun have a number that is not finite or negative.
    #[error("{0} must have finite colours of 0 or more and a direction longer than zero")]
    Light(&'static str),
    /// More triangles or instances than identifiers can name.
    #[error(
        "the scene has {triangles} triangles in {instances} instances; at most 268435456 in 524288 can be told apart"
    )]
    TooLarge {
        /// Triangles of all instances.
        triangles: u64,
        /// Instances.
        instances: usize,
    },
}

impl Similarity {
    /// Only moved.
    pub fn at(position: DVec3) -> Self {
        Self {
            pose: Pose::new(position, glam::DQuat::IDENTITY),
            scale: 1.0,
        }
    }

    /// Object to world coordinates.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.pose.point(p * self.scale)
    }

    fn is_valid(&self) -> bool {
        let p = self.pose.position;
        p.is_finite()
            && p.abs().max_element() <= 1e6
            && (self.pose.orientation.length() - 1.0).abs() < 1e-6
            && (1e-6..=1e6).contains(&self.scale)
    }
}

impl Scene {
    /// A scene of its parts, each instance of one mesh.
    ///
    /// # Errors
    /// If an instance names what does not exist, or a number is out of range.
    pub fn new(
        meshes: Vec<Mesh>,
        instances: Vec<Instance>,
        materials: Vec<Material>,
        sky: Sky,
        sun: Sun,
    ) -> Result<Self, SceneError> {
        Self::with_lods(meshes, Vec::new(), instances, materials, sky, sun)
    }

    /// A scene of its parts, some instances with meshes to choose from.
    ///
    /// # Errors
    /// If an instance or a level of detail names what does not exist, or a number is out of range.
    pub fn with_lods(
        meshes: Vec<Mesh>,
        lods: Vec<LevelOfDetail>,
        instances: Vec<Instance>,
        materials: Vec<Material>,
        sky: Sky,
        sun: Sun,
    ) -> Result<Self, SceneError> {
        for (lod, level) in lods.iter().enumerate() {
            if let Some(valid) = level.fault(&meshes) {
                return Err(SceneError::Lod { lod, valid });
            }
        }
        for (instance, i) in instances.iter().enumerate() {
            let named = [
                ("mesh", i.mesh, meshes.len()),
                ("material", i.material, materials.len()),
                (
                    "level of detail",
                    i.lod.unwrap_or(0),
                    i.lod.map_or(1, |_| lods.len()),
                ),
            ];
            for (what, index, count) in named {
                if index >= count {
                    return Err(SceneError::Reference {
                        instance,
                        what,
                        index,
                        count,
                    });
                }
            }
            if let Some(lod) = i.lod.filter(|&lod| !lods[lod].meshes.contains(&i.mesh)) {
                let mesh = i.mesh;
                return Err(SceneError::NotOfLod {
                    instance,
                    mesh,
                    lod,
                });
            }
            if !i.world_from_object.is_valid() {
                return Err(SceneError::Placement { instance });
            }
        }
        if let Some(material) = materials.iter().position(|m| !m.is_valid()) {
            let value = format!("{:?}", materials[material]);
            return Err(SceneError::Material { material, value });
        }
        if !sky.is_valid() {
            return Err(SceneError::Light("sky"));
        }
        if !sun.is_valid() {
            return Err(SceneError::Light("sun"));
        }
        let scene = Self {
            meshes: meshes.into(),
            lods: lods.into(),
            instances,
            materials,
            sky,
            sun,
        };
        let (triangles, instances) = (scene.triangle_count(), scene.instances.len());
        if triangles > 1 << 28 || instances > 1 << 19 {
            return Err(SceneError::TooLarge {
                triangles,
                instances,
            });
        }
        Ok(scene)
    }

    /// All meshes.
    pub fn meshes(&self) -> &[Mesh] {
        &self.meshes
    }

    /// All levels of detail.
    pub fn lods(&self) -> &[LevelOfDetail] {
        &self.lods
    }

    /// Index of the mesh to draw of instance `instance` for an eye at `eye`, world \[m\].
    ///
    /// # Panics
    /// If there is no such instance.
    pub fn mesh_for(&self, instance: usize, eye: DVec3, detail: Detail) -> usize {
        let i = &self.instances[instance];
        match i.lod {
            Some(lod) => self.lods[lod].mesh(&self.meshes, &i.world_from_object, eye, detail),
            None => i.mesh,
        }
    }

    /// All instances; their order is the order of triangle identifiers.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// All materials.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// What is seen where no triangle is.
    pub fn sky(&self) -> &Sky {
        &self.sky
    }

    /// The sun.
    pub fn sun(&self) -> &Sun {
        &self.sun
    }

    /// Triangles of all instances, each at its finest.
    pub fn triangle_count(&self) -> u64 {
        let finest = |i: &Instance| i.lod.map_or(i.mesh, |lod| self.lods[lod].meshes.start);
        self.instances
            .iter()
            .map(|i| self.meshes[finest(i)].triangles().len() as u64)
            .sum()
    }
}
