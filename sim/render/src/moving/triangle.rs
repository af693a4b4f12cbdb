use foveasim_models::raster::{Facing, Forms, MovingTriangle};
use glam::DVec3;

use crate::project::SUBSAMPLES;

/// A moving triangle ready for rasterization, in single precision: [`Forms`] of image positions \[px\] and time.
///
/// These numbers are the triangle: it covers a sample (u, v, t) where the forms say so and the sample lies
/// within the box of all its places. No more rounding is hidden in it, so that a rasterizer, which leaves out blocks by
/// [a bound](super::Blocks), and a ray tracer, which does not, agree to the bit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Target {
    /// Edges by power of t and component.
    pub(crate) edges: [[[f32; 3]; 3]; 3],
    pub(crate) volume: [f32; 4],
    /// 1/w is d·plane(t)/volume(t).
    pub(crate) plane: [[f32; 3]; 3],
    /// For each edge, the sum of its powers' sizes by component.
    pub(crate) sizes: [[f32; 3]; 3],
    /// Least and greatest image position along x and y, at any time \[px\].
    pub(crate) bounds: [[f32; 2]; 2],
    /// Least and greatest 1/w.
    pub(crate) depth_range: [f32; 2],
    /// Whether it is seen from behind as well.
    pub(crate) both_faces: bool,
    /// Whether its corners move.
    pub(crate) moves: bool,
    /// Which object of the view.
    pub(crate) object: u32,
    /// Which triangle of its mesh.
    pub(crate) triangle: u32,
}

/// Why a triangle is not drawn at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Dropped {
    /// It shows its back at all times, or has no area.
    BackFacing,
    /// It is behind the near plane at all times, where no sample looks, or is not finite.
    Outside,
}

/// How far beyond its corners a triangle may cover samples \[px\]. Rounded, its edges move by less than a hundredth
/// of a pixel; corners of slivers would reach on from there, and are cut off here.
const MARGIN: f64 = 1.0 / 16.0;

/// Bounds of what crosses the eye's plane: anywhere.
pub(crate) const ANYWHERE: [[f32; 2]; 2] = [[f32::MIN, f32::MAX]; 2];

impl Target {
    /// Sets a triangle up that is not nearer than `near` at all times \[m\], if it may be seen where samples look, within
    /// `image` \[px\].
    pub(crate) fn set_up(
        t: &MovingTriangle,
        near: f64,
        image: &[[f32; 2]; 2],
        both_faces: bool,
        [object, triangle]: [u32; 2],
    ) -> Result<Self, Dropped> {
        let points = t.0.map(|p| [p.start, p.end]);
        let points: &[DVec3] = points.as_flattened();
        let most = points.iter().fold(f64::NEG_INFINITY, |m, p| m.max(p.z));
        let least = points.iter().fold(f64::INFINITY, |m, p| m.min(p.z));
        if !points.iter().all(|p| p.is_finite()) || most < near {
            return Err(Dropped::Outside);
        }
        let in_front = least > 0.0;
        let mut bounds = ANYWHERE;
        if in_front {
            for (axis, bounds) in bounds.iter_mut().enumerate() {
                let places = points.iter().map(|p| p[axis] / p.z);
                let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
                    (l.min(x), h.max(x))
                });
                *bounds = [(low - MARGIN) as f32, (high + MARGIN) as f32];
            }
        }
        let beside = |axis: usize| {
            let ([low, high], [first, last]) = (bounds[axis], image[axis]);
            low > last || high < first
        };
        if beside(0) || beside(1) {
            return Err(Dropped::Outside);
        }
        let facing = match both_faces {
            true => Facing::Both,
            false => Facing::Front,
        };
        let Some(forms) = Forms::<f32>::new(t, facing) else {
            return Err(Dropped::BackFacing);
        };
        let volume = *forms.volume_coefficients();
        if !both_faces && is_never_negative(volume) {
            return Err(Dropped::BackFacing);
        }
        let depth_range = match in_front {
            true => [
                (1.0 / most) as f32,
                (1.0 / least).min(f32::MAX.into()) as f32,
            ],
            false => [(1.0 / most) as f32, f32::MAX],
        };
        let edges = *forms.edges();
        let size = |i: usize, c: usize| {
            let [a, b, d]: [[f32; 3]; 3] = edges[i];
            a[c].abs() + b[c].abs() + d[c].abs()
        };
        Ok(Self {
            sizes: [0, 1, 2].map(|i| [0, 1, 2].map(|c| size(i, c))),
            moves: t.0.iter().any(|p| p.start != p.end),
            edges,
            volume,
            plane: *forms.plane(),
            bounds,
            depth_range,
            both_faces,
            object,
            triangle,
        })
    }

    /// 1/w of what a sample at (u, v) \[px\] and t sees of the triangle, if it is covered and not nearer than
    /// 1/`nearest`: the specification of the kernel, operation by operation.
    pub(crate) fn sees(&self, [u, v, t]: [f32; 3], nearest: f32) -> Option<f32> {
        let [x, y] = self.bounds;
        if !(u >= x[0] && u <= x[1] && v >= y[0] && v <= y[1]) {
            return None;
        }
        let form = |n: &[[f32; 3]; 3]| {
            let at = |c: usize| match self.moves {
                true => (n[2][c] * t + n[1][c]) * t + n[0][c],
                false => n[0][c],
            };
            (u * at(0) + v * at(1)) + at(2)
        };
        let [d0, d1, d2, d3] = self.volume;
        let volume = match self.moves {
            true => ((d3 * t + d2) * t + d1) * t + d0,
            false => d0,
        };
        let e = [
            form(&self.edges[0]),
            form(&self.edges[1]),
            form(&self.edges[2]),
        ];
        let front = volume < 0.0 && e.iter().all(|e| *e <= 0.0);
        let back = self.both_faces && volume > 0.0 && e.iter().all(|e| *e >= 0.0);
        if !(front || back) {
            return None;
        }
        let depth = form(&self.plane) / volume;
        let [low, high] = self.depth_range;
        let depth = if depth < high { depth } else { high };
        let depth = if depth > low { depth } else { low };
        (depth <= nearest).then_some(depth)
    }
}

/// Whether a polynomial of third degree is nowhere negative from 0 to 1 by its Bézier points.
fn is_never_negative(d: [f32; 4]) -> bool {
    let [a, b, c, d] = d.map(f64::from);
    let points = [a, a + b / 3.0, a + b * (2.0 / 3.0) + c / 3.0, a + b + c + d];
    // Far above what f32 and these sums can round.
    let slack = 1e-5 * (a.abs() + b.abs() + c.abs() + d.abs());
    points.iter().all(|p| *p >= slack)
}

/// Image position of a place in sub-samples \[px\]: exact.
#[inline(always)]
pub(crate) fn px(sub: i32) -> f32 {
    sub as f32 * (1.0 / SUBSAMPLES as f32)
}
