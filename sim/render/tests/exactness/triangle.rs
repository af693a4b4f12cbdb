//! A triangle without snapping, and how far single precision may be off.
//!
//! All bounds are to first order in u = 2⁻²⁴, the rounding of one operation; where a bound exceeds a few
//! per cent the first order is not enough, and nothing is claimed.
//! **Vertices.** x, y and w in eye space are Σ mᵢpᵢ + t: entries rounded (1 u), products (1 u), three
//! sums (3 u), so each is off by at most δ = 5u·(Σ|mᵢpᵢ| + |t|).
//!
//! **Edges.** A vertex at tangent x/w lands on px = x/w · s + axis, s pixels per tangent. It is off by
//! s·δ/w·(1 + |x/w|), by 12u·(|x/w|·s + |axis|) for the quotient, products and sums of px and of
//! sub-samples, and by 1/512 px for snapping, along each axis: ε is √2 times all that.
//!
//! **Depth.** With edges e and f from vertex a, n = e × f, a sample at tangents t = a/w + Δ has
//! 1/w = 1/w_a + Σ (n_k/det)·Δ_k, det = n·a. With |n| the cross product of absolute values, a component of n is off
//! by 4u·|n|_k, det by 8u·|n|·|a|, Δ by 12u of the terms of px, and sums by 3u of their terms. Vertices that are
//! off by ρ = √3·δ move the plane by as much, and where a ray d meets it by ρ·‖n‖/|n·d| along d.
//!
//! **Attributes.** The weight β of a vertex is w·(row·d), row = p × q/det: as for n_k/det, times w, and
//! w's own error times β. Moving the hit by h moves β by h over the triangle's height.

use std::f64::consts::SQRT_2;

use foveasim_assets::{Mesh, Similarity};
use foveasim_models::View;
use glam::{DMat3, DVec2, DVec3};

pub(crate) const U: f64 = 1.0 / (1u64 << 24) as f64;
pub(crate) const NEAR_M: f64 = 0.5;

/// A triangle in eye space (x, y, w), and how far f32 may be off.
pub(crate) struct Triangle {
    pub(crate) p: [DVec3; 3],
    /// Bound of a vertex's error, as a vector \[m\].
    rho: f64,
    /// Its outline on the display, where w is not below near.
    outline: Vec<DVec2>,
    /// How far from there it may be drawn \[px\].
    pub(crate) epsilon: f64,
}

fn pixels(view: &View, p: DVec3) -> DVec2 {
    let step = view.optics.pixel_tan() * DVec2::new(1.0, -1.0);
    view.optics.axis_px() + DVec2::new(p.x, p.y) / p.z / step
}

/// What the terms of a pixel position add up to.
fn pixel_terms(view: &View, p: DVec3) -> DVec2 {
    let axis = view.optics.axis_px().abs();
    axis + (DVec2::new(p.x, p.y) / p.z / view.optics.pixel_tan()).abs()
}

impl Triangle {
    pub(crate) fn new(mesh: &Mesh, index: usize, placed: Similarity, view: &View) -> Self {
        let eye_from_object = view.poses[0].inverse().then(placed.pose);
        let matrix = DMat3::from_quat(eye_from_object.orientation) * placed.scale;
        let shift = eye_from_object.position;
        let corners = mesh.triangles()[index].map(|i| mesh.position(i));
        let p = corners.map(|p| {
            let eye = matrix * p + shift;
            DVec3::new(eye.x, eye.y, -eye.z)
        });
        let terms = corners.map(|p| {
            let absolute = [
                matrix.x_axis * p.x,
                matrix.y_axis * p.y,
                matrix.z_axis * p.z,
            ];
            let sum = absolute.map(DVec3::abs).iter().sum::<DVec3>() + shift.abs();
            sum.max_element()
        });
        let delta = 5.0 * U * terms.into_iter().fold(0.0, f64::max);

        let mut outline = Vec::new();
        for (i, &a) in p.iter().enumerate() {
            let b = p[(i + 1) % 3];
            if a.z >= NEAR_M {
                outline.push(a);
            }
            if (a.z >= NEAR_M) != (b.z >= NEAR_M) {
                outline.push(a + (b - a) * ((NEAR_M - a.z) / (b.z - a.z)));
            }
        }
        let px_per_tan = 1.0 / view.optics.pixel_tan().min_element();
        let off = |c: &DVec3| {
            let tangent = (c.x / c.z).abs().max((c.y / c.z).abs());
            let rounding = 12.0 * U * pixel_terms(view, *c).max_element();
            px_per_tan * delta / c.z * (1.0 + tangent) + rounding
        };
        let rounding = outline.iter().map(off).fold(0.0, f64::max);
        Self {
            rho: 3f64.sqrt() * delta,
            epsilon: SQRT_2 * (1.0 / 512.0 + rounding),
            outline: outline.iter().map(|c| pixels(view, *c)).collect(),
            p,
        }
    }

    /// Distance of a display position from the outline \[px\].
    pub(crate) fn outline_distance(&self, at: DVec2) -> f64 {
        let count = self.outline.len();
        let distance = |i: usize| {
            let (a, b) = (self.outline[i], self.outline[(i + 1) % count]);
            let along =
                ((at - a).dot(b - a) / (b - a).length_squared().max(1e-300)).clamp(0.0, 1.0);
            at.distance(a + (b - a) * along)
        };
        (0..count).map(distance).fold(f64::INFINITY, f64::min)
    }

    /// Möller and Trumbore's test for the ray d from the eye: w, and the weights of the second and
    /// third vertex.
    pub(crate) fn hit(&self, d: DVec3) -> Option<(f64, [f64; 2])> {
        let [a, b, c] = self.p;
        let (e, f) = (b - a, c - a);
        let p = d.cross(f);
        let det = e.dot(p);
        let q = (-a).cross(e);
        let (u, v, w) = (-a.dot(p) / det, d.dot(q) / det, f.dot(q) / det);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && w >= NEAR_M).then_some((w, [u, v]))
    }

    /// Bounds for a sample in direction d that hits it at w: of 1/w \[1/m\], and of both weights.
    pub(crate) fn bounds(&self, view: &View, d: DVec3, w: f64, beta: [f64; 2]) -> Bounds {
        let [a, b, c] = self.p;
        let (e, f) = (b - a, c - a);
        let n = e.cross(f);
        let absolute = |a: DVec3, b: DVec3| {
            let (a, b) = (a.abs(), b.abs());
            DVec3::new(
                a.y * b.z + a.z * b.y,
                a.z * b.x + a.x * b.z,
                a.x * b.y + a.y * b.x,
            )
        };
        let (det, det_off) = (n.dot(a).abs(), 8.0 * U * absolute(e, f).dot(a.abs()));
        // A row of components over det, times Δ, each with its own error.
        let tan_per_px = view.optics.pixel_tan();
        let from = DVec2::new(a.x, a.y) / a.z;
        let delta = (DVec2::new(d.x, d.y) - from).abs();
        let delta_off = 12.0 * U * pixel_terms(view, a) * tan_per_px;
        // The sample's distance from the snapped corner, not from the vertex itself.
        let reach = delta + tan_per_px / 256.0;
        let linear = |row: DVec3, terms: DVec3, start: f64| {
            let (mut off, mut sum) = (0.0, start.abs());
            for k in 0..2 {
                let value = row[k].abs() / det;
                let own = 4.0 * U * terms[k] / det + value * (det_off / det + U);
                off += own * reach[k] + value * delta_off[k];
                sum += value * reach[k];
            }
            off + 3.0 * U * sum
        };
        let ray = d.length();
        let moved = 1.1 * self.rho * n.length() / n.dot(d).abs();
        let inverse_w = linear(n, absolute(e, f), 1.0 / a.z) + moved / (w * w) + 2.0 * U / w;
        let weight = |k: usize| {
            let (p, q) = if k == 0 { (c, a) } else { (a, b) };
            let opposite = [f, e][k];
            let height = n.length() / opposite.length();
            let off = w * linear(p.cross(q), absolute(p, q), 0.0);
            // Weights are those of the snapped triangle. It is the true one with corners moved by up to
            // 1/512 of a sample along each axis, so they are those of a place as far away.
            let slope = (p.cross(q).abs() + beta[k] * n.abs()) * (w / det);
            let snapped = 1.1 / 512.0 * (slope.x * tan_per_px.x + slope.y * tan_per_px.y);
            off + snapped
                + 1.1 * (moved * ray + self.rho) / height
                + beta[k] * (inverse_w * w + 4.0 * U)
        };
        Bounds {
            inverse_w,
            weights: [weight(0), weight(1)],
        }
    }
}

pub(crate) struct Bounds {
    pub(crate) inverse_w: f64,
    pub(crate) weights: [f64; 2],
}
