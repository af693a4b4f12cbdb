use foveasim_models::Pose;
use foveasim_models::math::{cos, sin};
use glam::{DQuat, DVec3};

use crate::{Mesh, Vertex};

/// Closed solids put together into one mesh. Each closes by itself; where they overlap, nothing is cut.
#[derive(Debug, Default)]
pub(super) struct Solids {
    vertices: Vec<Vertex>,
    triangles: Vec<[u32; 3]>,
}

/// A corner of a quadrilateral: where, its normal and texture coordinates.
type Corner = (DVec3, DVec3, [f64; 2]);

impl Solids {
    /// All of them, as one mesh.
    pub(super) fn mesh(self) -> Mesh {
        Mesh::new(&self.vertices, self.triangles).expect("generated solids are finite")
    }

    /// A box with its middle at `centre`, half as long as `half` along the axes.
    pub(super) fn block(&mut self, centre: DVec3, half: DVec3) {
        let section = |z: f64| {
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(|[x, y]| centre + half * DVec3::new(x, y, z))
        };
        self.loft(&[section(-1.0), section(1.0)]);
    }

    /// A round bar with flat ends.
    pub(super) fn rod(&mut self, from: DVec3, to: DVec3, radius: f64, sides: u32) {
        let along = to - from;
        let placed = Pose::new(from, DQuat::from_rotation_arc(DVec3::Y, along.normalize()));
        let length = along.length();
        let profile = [[0.0, 0.0], [radius, 0.0], [radius, length], [0.0, length]];
        self.lathe(placed, &profile, sides);
    }

    /// A profile (distance from the axis, height along it) turned round the y axis of `placed`. What is solid
    /// lies to the left of the profile, which begins and ends on the axis or where it began. Each of its lines is a
    /// smooth band; bands meet in edges.
    pub(super) fn lathe(&mut self, placed: Pose, profile: &[[f64; 2]], sides: u32) {
        let turned = |side: u32| {
            // The last corner is the first one, to the bit.
            let angle = std::f64::consts::TAU * f64::from(side % sides) / f64::from(sides);
            placed.direction(DVec3::new(cos(angle), 0.0, -sin(angle)))
        };
        let up = placed.direction(DVec3::Y);
        for line in profile.windows(2) {
            let [[r0, h0], [r1, h1]] = [line[0], line[1]];
            for side in 0..sides {
                let corner = |side: u32, radius: f64, height: f64, v: f64| {
                    let out = turned(side);
                    let point = placed.position + out * radius + up * height;
                    let normal = out * (h1 - h0) - up * (r1 - r0);
                    (point, normal, [f64::from(side) / f64::from(sides), v])
                };
                let near = [corner(side, r0, h0, 0.0), corner(side + 1, r0, h0, 0.0)];
                let far = [corner(side, r1, h1, 1.0), corner(side + 1, r1, h1, 1.0)];
                match (r0 == 0.0, r1 == 0.0) {
                    (true, true) => {}
                    (true, false) => self.face(&[near[0], far[1], far[0]]),
                    (false, true) => self.face(&[near[0], near[1], far[0]]),
                    (false, false) => self.face(&[near[0], near[1], far[1], far[0]]),
                }
            }
        }
    }

    /// A bar through four-cornered sections, counter-clockwise seen from where it goes; its ends are flat. Sides are
    /// smooth along, and meet in edges.
    pub(super) fn loft(&mut self, sections: &[[DVec3; 4]]) {
        let last = sections.len() - 1;
        for side in 0..4 {
            let next = (side + 1) % 4;
            let normal = |k: usize| {
                let middle = |k: usize| (sections[k][side] + sections[k][next]) / 2.0;
                let along = middle((k + 1).min(last)) - middle(k.saturating_sub(1));
                (sections[k][next] - sections[k][side]).cross(along)
            };
            for k in 0..last {
                let corner = |k: usize, side: usize, u: f64| {
                    let v = k as f64 / last as f64;
                    (sections[k][side], normal(k), [u, v])
                };
                self.face(&[
                    corner(k, side, 0.0),
                    corner(k, next, 1.0),
                    corner(k + 1, next, 1.0),
                    corner(k + 1, side, 0.0),
                ]);
            }
        }
        for (k, order) in [(0, [3, 2, 1, 0]), (last, [0, 1, 2, 3])] {
            let s = order.map(|i: usize| sections[k][i]);
            let normal = (s[1] - s[0]).cross(s[3] - s[0]);
            let uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            self.face(&[0, 1, 2, 3].map(|i| (s[i], normal, uv[i])));
        }
    }

    /// A triangle, or two that share the diagonal from the first corner to the third; counter-clockwise from outside.
    fn face(&mut self, corners: &[Corner]) {
        let first = self.vertices.len() as u32;
        self.vertices
            .extend(corners.iter().map(|&(position, normal, uv)| Vertex {
                position,
                normal,
                uv,
            }));
        for k in 2..corners.len() as u32 {
            self.triangles.push([first, first + k - 1, first + k]);
        }
    }
}

/// Whether a mesh closes, and the volume it holds \[m³\]: for tests.
#[cfg(test)]
pub(super) fn volume_if_closed(mesh: &Mesh) -> Option<f64> {
    let mut open = std::collections::HashMap::new();
    let mut volume = 0.0;
    for t in mesh.triangles() {
        let p = t.map(|i| mesh.position(i));
        volume += p[0].dot(p[1].cross(p[2])) / 6.0;
        let key = p.map(|p| p.to_array().map(|c| (c + 0.0).to_bits()));
        for k in 0..3 {
            let (a, b) = (key[k], key[(k + 1) % 3]);
            *open.entry((a.min(b), a.max(b))).or_insert(0_i64) += if a < b { 1 } else { -1 };
        }
    }
    open.values().all(|n| *n == 0).then_some(volume)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solids_close_and_have_their_volume() {
        let volume = |build: &dyn Fn(&mut Solids)| {
            let mut solids = Solids::default();
            build(&mut solids);
            let mesh = solids.mesh();
            // Normals look out: with the triangle they belong to.
            for t in mesh.triangles() {
                let [a, b, c] = t.map(|i| mesh.position(i));
                let face = (b - a).cross(c - a);
                for i in t {
                    let [x, y, z] = mesh.normals();
                    let i = *i as usize;
                    assert!(face.dot(DVec3::new(x[i].into(), y[i].into(), z[i].into())) > 0.0);
                }
            }
            volume_if_closed(&mesh).expect("closed")
        };
        let block = volume(&|s| s.block(DVec3::ONE, DVec3::new(1.0, 2.0, 3.0)));
        assert!((block - 48.0).abs() < 1e-5, "{block}");
        // A prism with 64 sides: n/2·sin(2π/n) of r²·h.
        let rod = volume(&|s| s.rod(DVec3::X, DVec3::new(1.0, 2.0, 2.0), 0.5, 64));
        let want = 32.0 * sin(std::f64::consts::TAU / 64.0) * 0.25 * 8.0_f64.sqrt();
        assert!((rod - want).abs() < 1e-5, "{rod} {want}");
        let ring = volume(&|s| {
            let profile = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
            s.lathe(Pose::IDENTITY, &profile, 64);
        });
        let want = 32.0 * sin(std::f64::consts::TAU / 64.0) * 3.0;
        assert!((ring - want).abs() < 1e-5, "{ring} {want}");
    }
}
