use fearless_simd::prelude::*;
use foveasim_models::Pose;
use glam::{DMat3, DVec3};

use super::lanes::{Simd, three};
use super::wide::{F, V3, piece, splat};
use crate::moving::MovingAttributes;

/// From where and how the world is seen during a scan: the inverse of what takes it to the eye, which is linear in
/// time, as vertices are. So a point that does not move is found where it is, at every time. By powers of t; all are over a
/// determinant that is 1 at the start and the end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rolling {
    /// For each component in the world, what tangents along x, y and straight ahead give, by powers of t.
    direction: [[[f32; 3]; 3]; 3],
    /// The eye \[m\].
    eye: [[f32; 4]; 3],
    determinant: [f32; 4],
    /// Whether shading follows the eye through the scan.
    pub(super) shading: bool,
}

impl Rolling {
    /// Between two poses of the eye.
    pub(crate) fn new(world_from_eye: [Pose; 2], shading: bool) -> Self {
        let [start, end] = world_from_eye.map(|pose| {
            let eye_from_world = pose.inverse();
            let turn = DMat3::from_quat(eye_from_world.orientation);
            (turn, eye_from_world.position)
        });
        // Rows of the turn and the shift: what they are at the start, and what is added until the end.
        let rows = [0, 1, 2].map(|i| [start.0.row(i), end.0.row(i) - start.0.row(i)]);
        let shift = [start.1, end.1 - start.1];
        let cross = |[a, b]: [DVec3; 2], [c, d]: [DVec3; 2]| {
            [a.cross(c), a.cross(d) + b.cross(c), b.cross(d)]
        };
        let columns = [
            cross(rows[1], rows[2]),
            cross(rows[2], rows[0]),
            cross(rows[0], rows[1]),
        ];
        let [a, b] = rows[0];
        let [c0, c1, c2] = columns[0];
        let determinant = [
            a.dot(c0),
            a.dot(c1) + b.dot(c0),
            a.dot(c2) + b.dot(c1),
            b.dot(c2),
        ];
        let eye = |k: usize| {
            let mut powers = [0.0; 4];
            for (i, column) in columns.iter().enumerate() {
                for (p, c) in column.iter().enumerate() {
                    powers[p] -= c[k] * shift[0][i];
                    powers[p + 1] -= c[k] * shift[1][i];
                }
            }
            powers.map(|x| x as f32)
        };
        // Straight ahead is −z.
        let direction = |k: usize| {
            let along = |i: usize, sign: f64| columns[i].map(|c| (c[k] * sign) as f32);
            [along(0, 1.0), along(1, 1.0), along(2, -1.0)]
        };
        Self {
            direction: [0, 1, 2].map(direction),
            eye: [0, 1, 2].map(eye),
            determinant: determinant.map(|x| x as f32),
            shading,
        }
    }

    /// The direction in the world of tangents at their times.
    #[inline(always)]
    pub(super) fn direction<S: Simd>(&self, simd: S, t: F<S>, tangent: [F<S>; 2]) -> V3<S> {
        piece(
            simd,
            #[inline(always)]
            || {
                let over = self.over(simd, t);
                let [x, y, z] = three(
                    #[inline(always)]
                    |k| {
                        let [x, y, z] = self.direction[k];
                        let ahead = quadratic(t, z);
                        (tangent[0] * quadratic(t, x) + tangent[1] * quadratic(t, y) + ahead) * over
                    },
                );
                V3 { x, y, z }
            },
        )
    }

    /// Where the eye is at a time \[m\].
    #[inline(always)]
    pub(super) fn eye<S: Simd>(&self, simd: S, t: F<S>) -> V3<S> {
        piece(
            simd,
            #[inline(always)]
            || {
                let over = self.over(simd, t);
                let [x, y, z] = three(
                    #[inline(always)]
                    |k| {
                        let n = self.eye[k];
                        (((t * n[3] + n[2]) * t + n[1]) * t + n[0]) * over
                    },
                );
                V3 { x, y, z }
            },
        )
    }

    #[inline(always)]
    fn over<S: Simd>(&self, simd: S, t: F<S>) -> F<S> {
        let n = self.determinant;
        splat(simd, 1.0) / (((t * n[3] + n[2]) * t + n[1]) * t + n[0])
    }
}

#[inline(always)]
fn quadratic<S: Simd>(t: F<S>, n: [f32; 3]) -> F<S> {
    (t * n[2] + n[1]) * t + n[0]
}

/// What samples see of a moving triangle.
pub(super) struct Within<S: Simd> {
    /// Normal in the world, not of unit length.
    pub(super) normal: V3<S>,
    /// Weights of the second and the third corner.
    pub(super) weights: [F<S>; 2],
}

impl MovingAttributes {
    /// What samples at image positions `px` and times `t` see; the normal that the surface has at `normal_at`.
    #[inline(always)]
    pub(super) fn within<S: Simd>(
        &self,
        simd: S,
        [u, v]: [F<S>; 2],
        t: F<S>,
        normal_at: F<S>,
    ) -> Within<S> {
        piece(
            simd,
            #[inline(always)]
            || {
                let edges = three(
                    #[inline(always)]
                    |i| {
                        let n = &self.edges[i];
                        let at = three(
                            #[inline(always)]
                            |c| (t * n[2][c] + n[1][c]) * t + n[0][c],
                        );
                        (u * at[0] + v * at[1]) + at[2]
                    },
                );
                let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
                let sum = edges[0] + edges[1] + edges[2];
                let over = one / sum.simd_eq(zero).select(one, sum);
                let weights = three(
                    #[inline(always)]
                    |i| edges[i] * over,
                );
                // From behind, all edges are positive, and the other side's normal counts.
                let sign = sum.simd_gt(zero).select(splat(simd, -1.0), one);
                let normal = three(
                    #[inline(always)]
                    |k| {
                        let [a, b, c] = three(
                            #[inline(always)]
                            |i| (normal_at * self.turns[i][k] + self.normals[i][k]) * weights[i],
                        );
                        (a + b + c) * sign
                    },
                );
                let [x, y, z] = normal;
                Within {
                    normal: V3 { x, y, z },
                    weights: [weights[1], weights[2]],
                }
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd as fs;
    use glam::DQuat;

    use super::*;

    /// A point of the world that both poses take to the eye lies, at every time, on the ray from the eye then through where it is
    /// seen then.
    #[test]
    fn still_points_are_found_where_they_are() {
        let poses = [
            Pose::new(DVec3::new(1.0, 2.0, -3.0), DQuat::from_rotation_y(0.3)),
            Pose::new(
                DVec3::new(1.02, 1.99, -3.01),
                DQuat::from_rotation_y(0.38) * DQuat::from_rotation_x(0.05),
            ),
        ];
        let rolling = Rolling::new(poses, true);
        let simd = fs::Fallback::new();
        for point in [DVec3::new(4.0, 1.0, -30.0), DVec3::new(0.0, 2.5, -5.0)] {
            let [start, end] = poses.map(|p| p.inverse().point(point));
            for t in [0.0, 0.25, 0.5, 1.0] {
                let p = start + (end - start) * t;
                let w = -p.z;
                let splat = |x: f64| splat(simd, x as f32);
                let tangent = [splat(p.x / w), splat(p.y / w)];
                let d = rolling.direction(simd, splat(t), tangent);
                let e = rolling.eye(simd, splat(t));
                let found = [(e.x, d.x), (e.y, d.y), (e.z, d.z)]
                    .map(|(e, d)| f64::from(e.to_array()[0]) + f64::from(d.to_array()[0]) * w);
                let off = DVec3::from(found).distance(point);
                assert!(off < 1e-5 * (1.0 + point.length()), "{t}: {off}");
            }
        }
    }
}
