use fearless_simd::prelude::*;

use super::Kernel;
use super::lanes::{F, Simd, piece, splat};
use crate::project::Optics;
use crate::raster::EyeVertex;

/// From object space to eye space and on to the display.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VertexTransform {
    /// Rows give x, y and w = −z in eye space; the last column is the translation \[m\].
    pub(crate) eye_from_object: [[f32; 4]; 3],
    /// Rows turn a normal from the object to the world.
    pub(crate) world_from_normal: [[f32; 3]; 3],
    pub(crate) optics: Optics,
}

/// Transforms vertices, each once.
pub(crate) struct TransformVertices<'a> {
    pub(crate) transform: &'a VertexTransform,
    /// x, y and z of the vertices, equally long.
    pub(crate) positions: [&'a [f32]; 3],
    /// The same of their normals.
    pub(crate) normals: [&'a [f32]; 3],
    /// As long.
    pub(crate) out: &'a mut [EyeVertex],
}

impl Kernel for TransformVertices<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let t = self.transform;
        let [xs, ys, zs] = self.positions;
        let [nxs, nys, nzs] = self.normals;
        for (start, out) in (0..).step_by(8).zip(self.out.chunks_mut(8)) {
            let range = start..start + out.len();
            let p = [
                load(simd, &xs[range.clone()]),
                load(simd, &ys[range.clone()]),
                load(simd, &zs[range.clone()]),
            ];
            let n = [
                load(simd, &nxs[range.clone()]),
                load(simd, &nys[range.clone()]),
                load(simd, &nzs[range]),
            ];
            let [nx, ny, nz] = t.world_from_normal;
            let nx = turn(n, nx).to_array();
            let ny = turn(n, ny).to_array();
            let nz = turn(n, nz).to_array();
            let [x, y, w] = t.eye_from_object;
            let (x, y, w) = (row(p, x), row(p, y), row(p, w));
            // Only what is ahead is used; behind, any number will do.
            let ahead = w.simd_gt(0.0);
            let safe_w = ahead.select(w, splat(simd, 1.0));
            let u = x / safe_w * t.optics.px_per_tan[0] + t.optics.axis_px[0];
            let v = y / safe_w * t.optics.px_per_tan[1] + t.optics.axis_px[1];
            let (x, y, w) = (x.to_array(), y.to_array(), w.to_array());
            let (u, v) = (u.to_array(), v.to_array());
            for (i, vertex) in out.iter_mut().enumerate() {
                *vertex = EyeVertex {
                    eye: [x[i], y[i], w[i]],
                    px: [u[i], v[i]],
                    normal: [nx[i], ny[i], nz[i]],
                };
            }
        }
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, values: &[f32]) -> F<S> {
    if values.len() == 8 {
        F::from_slice(simd, values)
    } else {
        let mut padded = [0.0; 8];
        padded[..values.len()].copy_from_slice(values);
        F::from_slice(simd, &padded)
    }
}

/// One row of an affine transform.
#[inline(always)]
fn row<S: Simd>(p: [F<S>; 3], m: [f32; 4]) -> F<S> {
    piece(
        p[0].simd,
        #[inline(always)]
        || p[0] * m[0] + p[1] * m[1] + p[2] * m[2] + m[3],
    )
}

/// One row of a rotation.
#[inline(always)]
fn turn<S: Simd>(p: [F<S>; 3], m: [f32; 3]) -> F<S> {
    piece(
        p[0].simd,
        #[inline(always)]
        || p[0] * m[0] + p[1] * m[1] + p[2] * m[2],
    )
}
