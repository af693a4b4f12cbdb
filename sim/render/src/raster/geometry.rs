use foveasim_assets::{Scene, Similarity};
use foveasim_models::{Pose, Work};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::Simd;
use crate::kernels::{TransformVertices, VertexTransform, dispatch};
use crate::project::Optics;

/// A vertex in eye space and on the display.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct EyeVertex {
    /// x, y and w = −z \[m\].
    pub(crate) eye: [f32; 3],
    /// Display position \[px\]; meaningless where w is not ahead of the near plane.
    pub(crate) px: [f32; 2],
    /// Normal in the world.
    pub(crate) normal: [f32; 3],
}

/// A mesh of the scene somewhere in front of the eye.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Object {
    /// Index of the instance in the scene.
    pub(crate) instance: u32,
    /// Index of the mesh drawn for it.
    pub(crate) mesh: u32,
    /// Its first vertex in the view's list.
    pub(crate) first_vertex: u32,
}

/// The bounds of an instance as the eye sees it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    /// x, y and w of the centre \[m\].
    pub(crate) centre: DVec3,
    /// \[m\]
    pub(crate) radius: f64,
}

/// All vertices that the passes of a view need, each transformed once.
#[derive(Debug)]
pub(crate) struct ViewGeometry {
    pub(crate) objects: Vec<Object>,
    pub(crate) vertices: Vec<EyeVertex>,
    /// The same at the end of a scan; empty where nothing moves.
    pub(crate) ends: Vec<EyeVertex>,
    /// Vertices counted while transforming.
    pub(crate) work: Work,
}

/// Vertices per parallel job.
const JOB: usize = 4096;

/// Where mesh `mesh` of instance `instance` is, as the eye sees it.
pub(crate) fn bounds(scene: &Scene, instance: usize, mesh: usize, eye_from_world: Pose) -> Bounds {
    let placed = scene.instances()[instance].world_from_object;
    bounds_at(scene, placed, mesh, eye_from_world)
}

/// The same for an instance that is `placed` otherwise.
pub(crate) fn bounds_at(
    scene: &Scene,
    placed: Similarity,
    mesh: usize,
    eye_from_world: Pose,
) -> Bounds {
    let (centre, radius) = scene.meshes()[mesh].bounds();
    let centre = eye_from_world.point(placed.point(centre));
    Bounds {
        centre: DVec3::new(centre.x, centre.y, -centre.z),
        radius: radius * placed.scale,
    }
}

impl ViewGeometry {
    /// Transforms the vertices of `named` (instance, mesh): each pair is given once.
    pub(crate) fn new(
        scene: &Scene,
        world_from_eye: Pose,
        optics: &Optics,
        named: &[(u32, u32)],
        simd: Simd,
    ) -> Self {
        let mut objects = Vec::with_capacity(named.len());
        let mut total = 0;
        for &(instance, mesh) in named {
            objects.push(Object {
                instance,
                mesh,
                first_vertex: total as u32,
            });
            total += scene.meshes()[mesh as usize].vertex_count();
        }
        let work = Work {
            vertices: total as u64,
            ..Work::default()
        };
        Self {
            objects,
            vertices: transformed(scene, world_from_eye, optics, named, simd, false),
            ends: Vec::new(),
            work,
        }
    }

    /// The same for a scan whose end sees from `world_from_eye`: each vertex is transformed again.
    pub(crate) fn until(
        self,
        scene: &Scene,
        world_from_eye: Pose,
        optics: &Optics,
        named: &[(u32, u32)],
        simd: Simd,
    ) -> Self {
        let mut work = self.work;
        work.vertices *= 2;
        Self {
            ends: transformed(scene, world_from_eye, optics, named, simd, true),
            work,
            ..self
        }
    }

    /// The same vertices as seen by an eye of the head that these are seen from; `work` is what stands for
    /// them.
    pub(crate) fn seen_by(&self, eye_from_head: Pose, optics: &Optics, work: Work) -> Self {
        let turn = DMat3::from_quat(eye_from_head.orientation);
        let shift = eye_from_head.position;
        // w is −z, on both sides.
        let row = |r: DVec3, t: f64, sign: f64| {
            let r = DVec3::new(r.x, r.y, -r.z) * sign;
            [r.x, r.y, r.z, t * sign].map(|c| c as f32)
        };
        let rows = [
            row(turn.row(0), shift.x, 1.0),
            row(turn.row(1), shift.y, 1.0),
            row(turn.row(2), shift.z, -1.0),
        ];
        let mut vertices = self.vertices.clone();
        vertices.par_chunks_mut(JOB).for_each(|vertices| {
            for v in vertices {
                let [x, y, w] = v.eye;
                v.eye = rows.map(|r| x * r[0] + y * r[1] + w * r[2] + r[3]);
                // Only what is ahead is used; behind, any number will do.
                let w = if v.eye[2] > 0.0 { v.eye[2] } else { 1.0 };
                for k in 0..2 {
                    v.px[k] = v.eye[k] / w * optics.px_per_tan[k] + optics.axis_px[k];
                }
            }
        });
        Self {
            objects: self.objects.clone(),
            vertices,
            ends: Vec::new(),
            work,
        }
    }

    /// The vertices of one object.
    pub(crate) fn of(&self, object: &Object, scene: &Scene) -> &[EyeVertex] {
        let first = object.first_vertex as usize;
        let count = scene.meshes()[object.mesh as usize].vertex_count();
        &self.vertices[first..first + count]
    }

    /// The same at the end of a scan.
    pub(crate) fn at_end(&self, object: &Object, scene: &Scene) -> &[EyeVertex] {
        if self.ends.is_empty() {
            return self.of(object, scene);
        }
        let first = object.first_vertex as usize;
        let count = scene.meshes()[object.mesh as usize].vertex_count();
        &self.ends[first..first + count]
    }
}

/// The vertices of `named`, one after the other, at the start or the end of a scan.
fn transformed(
    scene: &Scene,
    world_from_eye: Pose,
    optics: &Optics,
    named: &[(u32, u32)],
    simd: Simd,
    at_end: bool,
) -> Vec<EyeVertex> {
    let eye_from_world = world_from_eye.inverse();
    let counts = named
        .iter()
        .map(|&(_, mesh)| scene.meshes()[mesh as usize].vertex_count());
    let mut vertices = vec![EyeVertex::default(); counts.sum()];
    let mut rest = vertices.as_mut_slice();
    let mut jobs = Vec::new();
    for &(instance, mesh) in named {
        let placed = match at_end {
            false => scene.instances()[instance as usize].world_from_object,
            true => scene.world_from_object_at_end(instance as usize),
        };
        let transform = transform(placed, eye_from_world, optics);
        let count = scene.meshes()[mesh as usize].vertex_count();
        for start in (0..count).step_by(JOB) {
            let length = JOB.min(count - start);
            let (out, remaining) = std::mem::take(&mut rest).split_at_mut(length);
            rest = remaining;
            jobs.push((transform, mesh, start, out));
        }
    }
    jobs.into_par_iter()
        .for_each(|(transform, mesh, start, out)| {
            let range = start..start + out.len();
            let mesh = &scene.meshes()[mesh as usize];
            let [x, y, z] = match mesh.end_positions() {
                Some(ends) if at_end => ends,
                _ => mesh.positions(),
            };
            let positions = [&x[range.clone()], &y[range.clone()], &z[range.clone()]];
            let [x, y, z] = mesh.normals();
            let normals = [&x[range.clone()], &y[range.clone()], &z[range]];
            let kernel = TransformVertices {
                transform: &transform,
                positions,
                normals,
                out,
            };
            dispatch(simd, kernel);
        });
    vertices
}

fn transform(placed: Similarity, eye_from_world: Pose, optics: &Optics) -> VertexTransform {
    let eye_from_object = eye_from_world.then(placed.pose);
    let linear = DMat3::from_quat(eye_from_object.orientation) * placed.scale;
    let row = |r: DVec3, t: f64| [r.x as f32, r.y as f32, r.z as f32, t as f32];
    let shift = eye_from_object.position;
    VertexTransform {
        eye_from_object: [
            row(linear.row(0), shift.x),
            row(linear.row(1), shift.y),
            row(-linear.row(2), -shift.z),
        ],
        world_from_normal: {
            let rotation = DMat3::from_quat(placed.pose.orientation);
            let row = |i| rotation.row(i).to_array().map(|v| v as f32);
            [row(0), row(1), row(2)]
        },
        optics: *optics,
    }
}
