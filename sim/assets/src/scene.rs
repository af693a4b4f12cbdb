use std::sync::Arc;

use foveasim_models::Pose;
use glam::DVec3;
use thiserror::Error;

use crate::{Detail, LevelOfDetail, Material, Mesh, Motion, Sky, Sun, Texture};

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

/// Everything there is to see. Checked when built, immutable after; copies share meshes and textures.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    meshes: Arc<[Mesh]>,
    lods: Arc<[LevelOfDetail]>,
    textures: Arc<[Texture]>,
    motions: Arc<[Motion]>,
    instances: Vec<Instance>,
    /// Where instances are at the end of a span of time; empty for a moment.
    ends: Vec<Similarity>,
    materials: Vec<Material>,
    sky: Sky,
    sun: Sun,
}

/// What a [`Scene`] is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneParts {
    /// Triangles.
    pub meshes: Vec<Mesh>,
    /// Meshes that stand for one shape.
    pub lods: Vec<LevelOfDetail>,
    /// Where they are.
    pub instances: Vec<Instance>,
    /// What they are made of.
    pub materials: Vec<Material>,
    /// Pictures that materials name.
    pub textures: Vec<Texture>,
    /// How instances move; those not named stay where they are.
    pub motions: Vec<Motion>,
    /// What is seen where no triangle is.
    pub sky: Sky,
    /// The sun.
    pub sun: Sun,
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
    #[error("instance {instance} has no usable placement: {}", Similarity::VALID)]
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
    /// A material names a texture that is not there.
    #[error("material {material} names texture {texture}: there are {count}, counted from 0")]
    Texture {
        /// Which material, from 0.
        material: usize,
        /// The index given.
        texture: usize,
        /// How many textures there are.
        count: usize,
    },
    /// A motion names an instance that is not there, or takes one out of range.
    #[error(
        "motion {motion} names instance {instance} of {count}, or leaves the usable placements: {}",
        Similarity::VALID
    )]
    Motion {
        /// Which motion, from 0.
        motion: usize,
        /// The instance it names.
        instance: usize,
        /// How many instances there are.
        count: usize,
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
    /// Not moved.
    pub const IDENTITY: Self = Self {
        pose: Pose::IDENTITY,
        scale: 1.0,
    };

    /// What a usable placement is.
    pub(crate) const VALID: &str =
        "finite position within ±1e6 m, unit rotation and scale from 1e-6 to 1e6 are needed";

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

    /// `a_from_b.then(b_from_c)` is `a_from_c`.
    #[must_use]
    pub fn then(self, inner: Self) -> Self {
        Self {
            pose: Pose {
                position: self.point(inner.pose.position),
                orientation: (self.pose.orientation * inner.pose.orientation).normalize(),
            },
            scale: self.scale * inner.scale,
        }
    }

    /// Between this (`f = 0`) and `other` (`f = 1`): see [`Pose::interpolate`]; linear in scale.
    #[must_use]
    pub fn interpolate(self, other: Self, f: f64) -> Self {
        Self {
            pose: self.pose.interpolate(other.pose, f),
            scale: self.scale + (other.scale - self.scale) * f,
        }
    }

    pub(crate) fn is_valid(&self) -> bool {
        let p = self.pose.position;
        let far = if p.is_finite() {
            p.abs().max_element()
        } else {
            f64::INFINITY
        };
        Self::in_range(far, self.scale) && (self.pose.orientation.length() - 1.0).abs() < 1e-6
    }

    /// Whether a placement so far out and so large is usable.
    pub(crate) fn in_range(far: f64, scale: f64) -> bool {
        far <= 1e6 && (1e-6..=1e6).contains(&scale)
    }
}

impl Scene {
    /// A scene without textures or levels of detail in which nothing moves.
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
        Self::build(SceneParts {
            meshes,
            lods: Vec::new(),
            instances,
            materials,
            textures: Vec::new(),
            motions: Vec::new(),
            sky,
            sun,
        })
    }

    /// A scene of its parts. Instances that move are placed as at time 0.
    ///
    /// # Errors
    /// If a part names what does not exist, or a number is out of range.
    pub fn build(parts: SceneParts) -> Result<Self, SceneError> {
        let SceneParts {
            meshes,
            lods,
            instances,
            materials,
            textures,
            motions,
            sky,
            sun,
        } = parts;
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
        for (material, m) in materials.iter().enumerate() {
            let Material::Textured(t) = m else { continue };
            if let Some(texture) = t.textures().find(|&i| i >= textures.len()) {
                let count = textures.len();
                return Err(SceneError::Texture {
                    material,
                    texture,
                    count,
                });
            }
        }
        for (motion, m) in motions.iter().enumerate() {
            let (instance, count) = (m.instance, instances.len());
            if instance >= count || !m.is_valid() {
                return Err(SceneError::Motion {
                    motion,
                    instance,
                    count,
                });
            }
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
            textures: textures.into(),
            motions: motions.into(),
            instances,
            ends: Vec::new(),
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
        Ok(scene.at(0.0))
    }

    /// The scene as it is at `seconds`. Costs a copy of the instances; the rest is shared.
    #[must_use]
    pub fn at(&self, seconds: f64) -> Self {
        let mut scene = self.clone();
        scene.ends = Vec::new();
        for motion in self.motions.iter() {
            scene.instances[motion.instance].world_from_object = motion.at(seconds);
        }
        scene
    }

    /// The scene from one time to another, as a scan takes it: placed as at the first, and it knows where
    /// instances are at the second. In between each vertex moves evenly on a straight line, so
    /// that what turns by θ shrinks by 1 − cos(θ/2) midway.
    #[must_use]
    pub fn over(&self, [start, end]: [f64; 2]) -> Self {
        let placed = |scene: &Self| -> Vec<Similarity> {
            scene
                .instances
                .iter()
                .map(|i| i.world_from_object)
                .collect()
        };
        let mut scene = self.at(start);
        let ends = placed(&self.at(end));
        if ends != placed(&scene) {
            scene.ends = ends;
        }
        scene
    }

    /// Where instance `instance` is at the end of the scene's span of time: where it is, for a moment.
    ///
    /// # Panics
    /// If there is no such instance.
    pub fn world_from_object_at_end(&self, instance: usize) -> Similarity {
        let here = self.instances[instance].world_from_object;
        self.ends.get(instance).copied().unwrap_or(here)
    }

    /// Whether anything moves within the scene's span of time, instances or vertices of meshes.
    pub fn is_moving(&self) -> bool {
        !self.ends.is_empty() || self.meshes.iter().any(|m| m.end_positions().is_some())
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

    /// All textures.
    pub fn textures(&self) -> &[Texture] {
        &self.textures
    }

    /// How instances move.
    pub fn motions(&self) -> &[Motion] {
        &self.motions
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

    /// Least and greatest coordinates of all vertices in the world \[m\]; `None` without instances.
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        let mut bounds: Option<[DVec3; 2]> = None;
        for instance in &self.instances {
            let mesh = &self.meshes[instance.mesh];
            for i in 0..mesh.vertex_count() as u32 {
                let p = instance.world_from_object.point(mesh.position(i));
                let [low, high] = bounds.get_or_insert([p, p]);
                *low = low.min(p);
                *high = high.max(p);
            }
        }
        bounds
    }
}
