use fearless_simd::prelude::*;

use super::Kernel;
use super::lanes::{F, Simd, i32x8, mask32x8, splat};
use crate::project::{GUARD_SAMPLES, Projection};
use crate::raster::ScreenVertex;

/// Beyond the left, right, upper or lower edge of the lattice by more than a sample.
const CODE_LEFT: i32 = 1;
const CODE_RIGHT: i32 = 2;
const CODE_UP: i32 = 4;
const CODE_DOWN: i32 = 8;
/// Nearer than the near plane, or behind, or at no finite distance.
pub(crate) const CODE_NEAR: i32 = 16;
/// Too far off the lattice to be snapped.
pub(crate) const CODE_GUARD: i32 = 32;

/// From object space to eye space and on to one pass's samples.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VertexTransform {
    /// Rows give x, y and w = −z in eye space; the last column is the translation \[m\].
    pub(crate) eye_from_object: [[f32; 4]; 3],
    pub(crate) projection: Projection,
}

/// Transforms vertices, each once.
pub(crate) struct TransformVertices<'a> {
    pub(crate) transform: &'a VertexTransform,
    /// x, y and z of the vertices, equally long.
    pub(crate) positions: [&'a [f32]; 3],
}

impl Kernel for TransformVertices<'_> {
    type Output = Vec<ScreenVertex>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Vec<ScreenVertex> {
        let count = self.positions[0].len();
        let mut out = Vec::with_capacity(count);
        for start in (0..count).step_by(8) {
            let lanes = (count - start).min(8);
            let [x, y, z] = self.positions;
            let range = start..start + lanes;
            let x = load(simd, &x[range.clone()]);
            let y = load(simd, &y[range.clone()]);
            let z = load(simd, &z[range]);
            let eight = transform(simd, self.transform, [x, y, z]);
            out.extend_from_slice(&eight[..lanes]);
        }
        out
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
    p[0] * m[0] + p[1] * m[1] + p[2] * m[2] + m[3]
}

#[inline(always)]
fn bit<S: Simd>(simd: S, on: mask32x8<S>, bit: i32) -> i32x8<S> {
    on.select(i32x8::splat(simd, bit), i32x8::splat(simd, 0))
}

#[inline(always)]
fn transform<S: Simd>(simd: S, t: &VertexTransform, p: [F<S>; 3]) -> [ScreenVertex; 8] {
    let [x, y, w] = t.eye_from_object;
    let (x, y, w) = (row(p, x), row(p, y), row(p, w));
    let projection = &t.projection;
    // Asked so that NaN is not ahead.
    let ahead = w.simd_ge(projection.near as f32) & w.simd_le(f32::MAX);
    let near = !ahead;
    let mut code = bit(simd, near, CODE_NEAR);
    let safe_w = near.select(splat(simd, 1.0), w);

    let (scale, shift) = projection.lattice_from_tangent();
    let mut snapped = [i32x8::splat(simd, 0); 2];
    for axis in 0..2 {
        let (c, size) = ([x, y][axis], f64::from(projection.size[axis]));
        // Lattice position times w, for tests against planes that hold in front and behind alike.
        let lattice = c * (scale[axis] as f32) + w * (shift[axis] as f32);
        let [low, high] = [[CODE_LEFT, CODE_RIGHT], [CODE_UP, CODE_DOWN]][axis];
        code |= bit(simd, lattice.simd_lt(-w), low);
        code |= bit(simd, lattice.simd_gt(w * (size as f32 + 1.0)), high);
        // A few samples inside the guard, for the rounding of this very test.
        let reach = GUARD_SAMPLES - 4.0;
        let within = lattice.simd_ge(w * ((size / 2.0 - reach) as f32))
            & lattice.simd_le(w * ((size / 2.0 + reach) as f32));

        let px = c / safe_w * projection.px_per_tan[axis] + projection.axis_px[axis];
        let sub = px * projection.sub_per_px[axis] - projection.origin_fraction[axis];
        let sub = (sub + 0.5).floor();
        // The conversion to integers is undefined for NaN and large numbers, so it gets only what was
        // just compared with the range of snapping; the rest goes the way of the guard.
        let [from, to] = projection.snap_range(axis).map(|s| s as f32);
        let within = within & sub.simd_ge(from) & sub.simd_le(to);
        code |= bit(simd, !within, CODE_GUARD);
        let sub = (within & ahead).select(sub, splat(simd, 0.0));
        snapped[axis] = sub.to_int::<i32x8<S>>() - projection.origin_whole[axis];
    }
    let (x, y, w) = (x.to_array(), y.to_array(), w.to_array());
    let (u, v, code) = (
        snapped[0].to_array(),
        snapped[1].to_array(),
        code.to_array(),
    );
    std::array::from_fn(|i| ScreenVertex {
        eye: [x[i], y[i], w[i]],
        snapped: [u[i], v[i]],
        code: code[i],
    })
}

#[cfg(test)]
mod tests {
    use foveasim_models::{Affine, Viewport};
    use glam::UVec2;

    use super::*;
    use crate::Simd as Choice;
    use crate::kernels::dispatch;

    /// An eye at the origin of the object, looking along −z.
    fn straight_ahead() -> VertexTransform {
        let size = UVec2::new(64, 32);
        let optics = Viewport::symmetric(size, 1.0).expect("a viewport");
        VertexTransform {
            eye_from_object: [
                [1.0, 0.0, 0.0, 0.0],
                [0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, -1.0, 0.0],
            ],
            projection: Projection::new(&optics, &Affine::IDENTITY, size, 0.05),
        }
    }

    #[test]
    fn vertices_that_are_nowhere_are_never_snapped() {
        let transform = straight_ahead();
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
        let mut points = vec![[0.0, 0.0, -2.0]];
        for v in odd {
            points.extend([[v, 0.0, -2.0], [0.0, v, -2.0], [0.0, 0.0, v], [v; 3]]);
        }
        points.extend([[f32::MAX, 0.0, -2.0], [f32::MAX, 0.0, -f32::MAX / 1e3]]);
        let axes = [0, 1, 2].map(|k| points.iter().map(|p| p[k]).collect::<Vec<_>>());
        for choice in [Choice::Auto, Choice::Scalar] {
            let kernel = TransformVertices {
                transform: &transform,
                positions: [&axes[0], &axes[1], &axes[2]],
            };
            let vertices = dispatch(choice, kernel);
            assert_eq!(
                (vertices[0].code, vertices[0].snapped),
                (0, [32 * 256, 16 * 256])
            );
            for (vertex, point) in vertices.iter().zip(&points).skip(1) {
                assert_ne!(vertex.code & (CODE_NEAR | CODE_GUARD), 0, "{point:?}");
            }
        }
    }
}
