use std::sync::Arc;

use foveasim_assets::{Scene, Similarity, Sun};
use foveasim_models::{Image, Pass, View};

use crate::kernels::Before;

/// The last image of a pass, and what it shows.
#[derive(Debug, Clone)]
pub(super) struct History {
    /// The pass as it was drawn, without offset.
    pub(super) pass: Pass,
    /// From where it was drawn.
    pub(super) view: View,
    /// What was where.
    pub(super) placed: Arc<Placed>,
    /// Means over frames.
    pub(super) image: Image,
    /// What is known of each sample; empty without reprojection.
    pub(super) past: Past,
}

/// What samples know besides their colours.
#[derive(Debug, Clone, Default)]
pub(super) struct Past {
    /// Frames that each colour is a mean of; 0 where nothing was drawn.
    pub(super) length: Vec<f32>,
    /// 1/w of the surface that each sample follows \[1/m\]; NaN where nothing was drawn.
    pub(super) nearest: Vec<f32>,
    /// Whether there is no sample where nothing was drawn.
    pub(super) all_drawn: bool,
}

impl History {
    pub(super) fn before(&self) -> Before<'_> {
        Before {
            size: self.image.size,
            rgb: &self.image.rgb,
            length: &self.past.length,
            nearest: &self.past.nearest,
            all_drawn: self.past.all_drawn,
        }
    }
}

/// Where the instances of a scene are, and by what the scene is known again.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Placed {
    pub(super) world_from_object: Vec<Similarity>,
    kind: Kind,
}

/// What must stay the same for frames to belong together.
#[derive(Debug, Clone, PartialEq)]
struct Kind {
    /// Mesh and material of each instance.
    instances: Vec<(usize, usize)>,
    /// Vertices and triangles of each mesh.
    meshes: Vec<(usize, usize)>,
    sun: Sun,
}

impl Placed {
    pub(super) fn of(scene: &Scene) -> Self {
        let instances = scene.instances();
        Self {
            world_from_object: instances.iter().map(|i| i.world_from_object).collect(),
            kind: Kind {
                instances: instances.iter().map(|i| (i.mesh, i.material)).collect(),
                meshes: scene
                    .meshes()
                    .iter()
                    .map(|m| (m.vertex_count(), m.triangles().len()))
                    .collect(),
                sun: *scene.sun(),
            },
        }
    }

    /// Whether both are one scene, wherever its instances are.
    pub(super) fn is_same_scene(&self, other: &Self) -> bool {
        self.kind == other.kind
    }
}
