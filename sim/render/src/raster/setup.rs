use foveasim_assets::Scene;
use foveasim_models::Work;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::clip::{SnappedCorner, clip};
use super::{Geometry, ScreenVertex};
use crate::kernels::{CODE_GUARD, CODE_NEAR};
use crate::project::{Projection, SUBSAMPLES};

/// A triangle ready for rasterization.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SetUpTriangle {
    /// Corners in sub-samples, positive area with y down.
    pub(crate) corners: [[i32; 2]; 3],
    /// 1/w at the first corner, and its change per sample along x and y [1/m].
    pub(crate) depth: [f32; 3],
    /// Least and greatest 1/w of the triangle [1/m].
    pub(crate) depth_range: [f32; 2],
    /// Which drawn instance of the pass's geometry.
    pub(crate) drawn: u32,
    /// Which triangle of its mesh.
    pub(crate) triangle: u32,
    /// Which material of the scene.
    pub(crate) material: u32,
}

/// Triangles per parallel job.
const JOB: usize = 512;

/// Sets up all triangles of the pass that face the eye and may cover a sample: a list of lists, in
/// the order of the scene.
pub(crate) fn set_up(
    scene: &Scene,
    geometry: &Geometry,
    projection: &Projection,
) -> (Vec<Vec<SetUpTriangle>>, Work) {
    let mut jobs = Vec::new();
    for (drawn, d) in geometry.drawn.iter().enumerate() {
        let mesh = scene.instances()[d.instance as usize].mesh;
        let count = scene.meshes()[mesh].triangles().len();
        jobs.extend(
            (0..count)
                .step_by(JOB)
                .map(|s| (drawn, s..(s + JOB).min(count))),
        );
    }
    let results: Vec<_> = jobs
        .into_par_iter()
        .map(|(drawn, range)| {
            let instance = &scene.instances()[geometry.drawn[drawn].instance as usize];
            let triangles = scene.meshes()[instance.mesh].triangles();
            let mut job = Job {
                projection,
                out: Vec::new(),
                work: Work::default(),
                origin: (drawn as u32, 0, instance.material as u32),
            };
            for index in range {
                job.origin.1 = index as u32;
                job.triangle(triangles[index].map(|i| geometry.vertex(drawn, i)));
            }
            (job.out, job.work)
        })
        .collect();
    let mut total = Work::default();
    let lists = results
        .into_iter()
        .map(|(list, work)| {
            total += work;
            list
        })
        .collect();
    (lists, total)
}

struct Job<'a> {
    projection: &'a Projection,
    out: Vec<SetUpTriangle>,
    work: Work,
    /// Drawn instance, triangle, material.
    origin: (u32, u32, u32),
}

impl Job<'_> {
    fn triangle(&mut self, v: [&ScreenVertex; 3]) {
        let [a, b, c] = v.map(|v| v.code);
        if a & b & c & !CODE_GUARD != 0 {
            self.work.triangles_outside += 1;
        } else if (a | b | c) & (CODE_NEAR | CODE_GUARD) == 0 {
            let corners = v.map(|v| (v.snapped, 1.0 / f64::from(v.eye[2])));
            match area_sign(corners.map(|c| c.0)) {
                1.. => self.work.triangles_back_facing += 1,
                0 => self.work.triangles_outside += 1,
                _ => {
                    if !self.emit(corners, Plane::new(v)) {
                        self.work.triangles_outside += 1;
                    }
                }
            }
        } else {
            self.clipped(v);
        }
    }

    fn clipped(&mut self, v: [&ScreenVertex; 3]) {
        let plane = Plane::new(v);
        if !plane.det.is_finite() {
            // A vertex that is nowhere.
            self.work.triangles_outside += 1;
            return;
        }
        if plane.det <= 0.0 {
            self.work.triangles_back_facing += 1;
            return;
        }
        let polygon = clip(v, self.projection);
        let mut any = false;
        for i in 2..polygon.len() {
            let fan = [polygon[0], polygon[i - 1], polygon[i]];
            if area_sign(fan.map(|c| c.0)) < 0 {
                any |= self.emit(fan, plane);
            }
        }
        if !any {
            self.work.triangles_outside += 1;
        }
    }

    /// Adds a triangle facing the eye, unless its bounds hold no sample.
    fn emit(&mut self, corners: [SnappedCorner; 3], plane: Plane) -> bool {
        let set_up = SetUpTriangle {
            // Seen from outside they run counter-clockwise with y up: turn them for y down.
            corners: [corners[0].0, corners[2].0, corners[1].0],
            depth: [0.0; 3],
            depth_range: [0.0; 2],
            drawn: self.origin.0,
            triangle: self.origin.1,
            material: self.origin.2,
        };
        let [x, y] = set_up.sample_bounds();
        let size = self.projection.size;
        if x[0] > x[1].min(size.x as i32 - 1)
            || y[0] > y[1].min(size.y as i32 - 1)
            || x[1] < 0
            || y[1] < 0
        {
            return false;
        }
        let inverse_w = corners.map(|c| c.1);
        let low = inverse_w.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let high = inverse_w.iter().fold(0.0, |a: f64, &b| a.max(b));
        let depth = plane.depth(set_up.corners[0], self.projection);
        // Seen edge-on there may be no usable slope; such a sliver is as far as its farthest corner.
        let depth = if depth.iter().all(|d| d.is_finite()) {
            depth
        } else {
            [low as f32, 0.0, 0.0]
        };
        let depth_range = [low as f32, high as f32];
        self.out.push(SetUpTriangle {
            depth,
            depth_range,
            ..set_up
        });
        self.work.triangles_set_up += 1;
        true
    }
}

impl SetUpTriangle {
    /// First and last sample whose centre lies within the bounds, along x and y.
    pub(crate) fn sample_bounds(&self) -> [[i32; 2]; 2] {
        [0, 1].map(|axis| {
            let c = self.corners.map(|c| c[axis]);
            let (low, high) = (c[0].min(c[1]).min(c[2]), c[0].max(c[1]).max(c[2]));
            let half = SUBSAMPLES / 2;
            [
                (low - half + SUBSAMPLES - 1).div_euclid(SUBSAMPLES),
                (high - half).div_euclid(SUBSAMPLES),
            ]
        })
    }
}

/// Sign of the area with y down: negative faces the eye.
fn area_sign(c: [[i32; 2]; 3]) -> i64 {
    let [ax, ay] = [0, 1].map(|k| i64::from(c[1][k]) - i64::from(c[0][k]));
    let [bx, by] = [0, 1].map(|k| i64::from(c[2][k]) - i64::from(c[0][k]));
    (ax * by - bx * ay).signum()
}

/// The plane of a triangle in eye space: n·p = const, facing the eye where `det` is positive.
#[derive(Clone, Copy)]
struct Plane {
    n: DVec3,
    det: f64,
}

impl Plane {
    fn new(v: [&ScreenVertex; 3]) -> Self {
        // (x, y, w) is left-handed, so the cross product looks inwards and n·p is positive in front.
        let [a, b, c] = v.map(|v| DVec3::from_array(v.eye.map(f64::from)));
        let n = (b - a).cross(c - a);
        Self { n, det: n.dot(a) }
    }

    /// 1/w at a corner, and its change per sample: 1/w = n·(tx, ty, 1) / n·p for tangents tx, ty.
    fn depth(&self, corner: [i32; 2], projection: &Projection) -> [f32; 3] {
        let lattice = DVec2::new(corner[0].into(), corner[1].into()) / f64::from(SUBSAMPLES);
        let t = projection.tangent(lattice);
        let step = projection.tangent_step();
        let n = self.n / self.det;
        [n.dot(DVec3::new(t.x, t.y, 1.0)), n.x * step.x, n.y * step.y].map(|v| v as f32)
    }
}
