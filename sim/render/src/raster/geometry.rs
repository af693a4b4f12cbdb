use foveasim_assets::Scene;
use foveasim_models::{Pose, Work};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::Simd;
use crate::kernels::{TransformVertices, VertexTransform, dispatch};
use crate::project::Projection;

/// A vertex in eye space and on the lattice.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ScreenVertex {
    /// x, y and w = −z \[m\].
    pub(crate) eye: [f32; 3],
    /// Lattice position in sub-samples; meaningless where `code` says near or guard.
    pub(crate) snapped: [i32; 2],
    /// Which limits it lies beyond.
    pub(crate) code: i32,
}

/// An instance that may be visible in a pass.
#[derive(Debug)]
pub(crate) struct DrawnInstance {
    /// Index in the scene.
    pub(crate) instance: u32,
    /// Its first block of vertices.
    first_block: usize,
}

/// The transformed vertices of one pass.
#[derive(Debug)]
pub(crate) struct Geometry {
    pub(crate) drawn: Vec<DrawnInstance>,
    blocks: Vec<Vec<ScreenVertex>>,
    /// Vertices and triangles counted while transforming.
    pub(crate) work: Work,
}

/// Vertices per block: the unit of parallel work. A power of two.
const BLOCK: usize = 2048;

/// Transforms the vertices of all instances whose bounds meet the view of the pass.
pub(crate) fn transform(
    scene: &Scene,
    world_from_eye: Pose,
    projection: &Projection,
    simd: Simd,
) -> Geometry {
    let eye_from_world = world_from_eye.inverse();
    let mut drawn = Vec::new();
    let mut jobs = Vec::new();
    let mut work = Work::default();
    for (index, instance) in scene.instances().iter().enumerate() {
        let mesh = &scene.meshes()[instance.mesh];
        let triangles = mesh.triangles().len() as u64;
        work.triangles += triangles;
        let placed = instance.world_from_object;
        let (centre, radius) = mesh.bounds();
        let centre = eye_from_world.point(placed.point(centre));
        let centre = DVec3::new(centre.x, centre.y, -centre.z);
        if projection.misses_sphere(centre, radius * placed.scale) {
            work.triangles_outside += triangles;
            continue;
        }
        work.vertices += mesh.vertex_count() as u64;
        drawn.push(DrawnInstance {
            instance: index as u32,
            first_block: jobs.len(),
        });
        let eye_from_object = eye_from_world.then(placed.pose);
        let linear = DMat3::from_quat(eye_from_object.orientation) * placed.scale;
        let row = |r: DVec3, t: f64| [r.x as f32, r.y as f32, r.z as f32, t as f32];
        let shift = eye_from_object.position;
        let transform = VertexTransform {
            eye_from_object: [
                row(linear.row(0), shift.x),
                row(linear.row(1), shift.y),
                row(-linear.row(2), -shift.z),
            ],
            projection: *projection,
        };
        let count = mesh.vertex_count();
        jobs.extend(
            (0..count)
                .step_by(BLOCK)
                .map(|start| (transform, instance.mesh, start..(start + BLOCK).min(count))),
        );
    }
    let blocks = jobs
        .into_par_iter()
        .map(|(transform, mesh, range)| {
            let [x, y, z] = scene.meshes()[mesh].positions();
            let positions = [&x[range.clone()], &y[range.clone()], &z[range]];
            dispatch(
                simd,
                TransformVertices {
                    transform: &transform,
                    positions,
                },
            )
        })
        .collect();
    Geometry {
        drawn,
        blocks,
        work,
    }
}

impl Geometry {
    /// Vertex `index` of the mesh of drawn instance `drawn`.
    pub(crate) fn vertex(&self, drawn: usize, index: u32) -> &ScreenVertex {
        let index = index as usize;
        &self.blocks[self.drawn[drawn].first_block + index / BLOCK][index % BLOCK]
    }
}
