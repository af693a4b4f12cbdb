//! What the rasterizer computes, one position at a time: the specification of its kernels.

use super::SetUpTriangle;
use crate::project::SUBSAMPLES;

impl SetUpTriangle {
    /// Whether the triangle covers a position of the lattice \[sub-samples\]: exact, and of the positions
    /// on an edge only those of a top or a left edge (Direct3D 11.3 functional specification, §3.4.2.1).
    pub(crate) fn covers(&self, at: [i32; 2]) -> bool {
        let [a, b, c] = self.corners;
        [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
            let d = [0, 1].map(|k| i64::from(to[k]) - i64::from(from[k]));
            let p = [0, 1].map(|k| i64::from(at[k]) - i64::from(from[k]));
            let side = d[0] * p[1] - d[1] * p[0];
            side > 0 || (side == 0 && (d[1] < 0 || (d[1] == 0 && d[0] > 0)))
        })
    }

    /// 1/w at a position of the lattice \[1/m\]; larger is nearer.
    pub(crate) fn inverse_w(&self, at: [i32; 2]) -> f32 {
        // Exact: less than 2²⁴ sub-samples.
        let [dx, dy] =
            [0, 1].map(|k| (at[k] - self.corners[0][k]) as f32 * (1.0 / SUBSAMPLES as f32));
        let depth = dx * self.depth[1] + self.depth[0] + dy * self.depth[2];
        let [low, high] = self.depth_range;
        let depth = if depth < high { depth } else { high };
        if depth > low { depth } else { low }
    }
}
