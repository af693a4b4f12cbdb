use glam::{DVec2, DVec3};

use super::EyeVertex;
use crate::project::{Projection, SUBSAMPLES};

/// The plane of a triangle in eye space: n·p = const, facing the eye where `det` is positive.
#[derive(Clone, Copy)]
pub(super) struct Plane {
    n: DVec3,
    pub(super) det: f64,
}

impl Plane {
    pub(super) fn new(v: [&EyeVertex; 3]) -> Self {
        // (x, y, w) is left-handed, so the cross product looks inwards and n·p is positive in front.
        let [a, b, c] = v.map(|v| DVec3::from_array(v.eye.map(f64::from)));
        let n = (b - a).cross(c - a);
        Self { n, det: n.dot(a) }
    }

    /// 1/w at a corner, and its change per sample: 1/w = n·(tx, ty, 1) / n·p for tangents tx, ty.
    pub(super) fn depth(&self, corner: [i32; 2], projection: &Projection) -> [f32; 3] {
        let lattice = DVec2::new(corner[0].into(), corner[1].into()) / f64::from(SUBSAMPLES);
        let t = projection.tangent(lattice);
        let step = projection.tangent_step();
        let n = self.n / self.det;
        [n.dot(DVec3::new(t.x, t.y, 1.0)), n.x * step.x, n.y * step.y].map(|v| v as f32)
    }
}
