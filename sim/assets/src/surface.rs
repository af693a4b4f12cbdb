use foveasim_models::math::{cos, pow, sin};
use glam::DVec3;

use crate::{Mesh, Vertex};

/// A closed surface given by two parameters, about 1 m in radius, outside out.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ParametricSurface {
    /// The unit sphere.
    Sphere,
    /// A ring with a tube of the given radius about a circle of the rest.
    Torus {
        /// Tube radius, 0.05 to 0.45.
        tube: f64,
    },
    /// A superellipsoid (Barr 1981): exponents below 1 square it, above 1 pinch it.
    Superellipsoid {
        /// Exponent in latitude and in longitude, 0.2 to 3.
        exponents: [f64; 2],
    },
    /// A sphere with waves on it.
    Waves {
        /// Waves around.
        count: u32,
        /// Their height, 0 to 0.4.
        height: f64,
    },
    /// A tube along a trefoil knot.
    Trefoil {
        /// Tube radius, 0.05 to 0.25.
        tube: f64,
    },
}

impl ParametricSurface {
    /// The point at `u`, `v`, both 0 to 1: `u` runs round the surface; `v` runs round the tube, or
    /// from pole to pole.
    pub fn point(self, u: f64, v: f64) -> DVec3 {
        let turn = 2.0 * std::f64::consts::PI;
        let (around, along) = (turn * u, turn * v);
        // v = 0 is the south pole of the sphere-like ones.
        let latitude = std::f64::consts::PI * (v - 0.5);
        match self {
            Self::Sphere => globe(around, latitude, 1.0),
            Self::Torus { tube } => {
                let ring = 1.0 - tube;
                let r = ring + tube * cos(along);
                DVec3::new(r * cos(around), tube * sin(along), -r * sin(around))
            }
            Self::Superellipsoid { exponents: [n, e] } => {
                let power = |x: f64, p: f64| pow(x.abs(), p).copysign(x);
                let ring = power(cos(latitude), n);
                DVec3::new(
                    ring * power(cos(around), e),
                    power(sin(latitude), n),
                    -ring * power(sin(around), e),
                )
            }
            Self::Waves { count, height } => {
                let n = f64::from(count);
                // The waves vanish at the poles, where all longitudes meet.
                let envelope = cos(latitude) * cos(latitude);
                let wave = sin(n * around) * sin(n * latitude) * envelope;
                globe(around, latitude, (1.0 + height * wave) / (1.0 + height))
            }
            Self::Trefoil { tube } => {
                let knot = |t: f64| {
                    DVec3::new(
                        sin(t) + 2.0 * sin(2.0 * t),
                        cos(t) - 2.0 * cos(2.0 * t),
                        -sin(3.0 * t),
                    ) * 0.28
                };
                let centre = knot(around);
                let tangent = (knot(around + 1e-4) - knot(around - 1e-4)).normalize();
                // A frame that turns smoothly: away from the axis of the knot, which it never crosses.
                let outward = DVec3::new(centre.x, centre.y, 0.0);
                let side = (outward - tangent * outward.dot(tangent)).normalize();
                let up = side.cross(tangent);
                centre + (side * cos(along) + up * sin(along)) * tube
            }
        }
    }

    fn has_poles(self) -> bool {
        matches!(
            self,
            Self::Sphere | Self::Superellipsoid { .. } | Self::Waves { .. }
        )
    }

    /// The unit normal at `u`, `v`, by central differences.
    fn normal(self, u: f64, v: f64) -> DVec3 {
        const STEP: f64 = 1e-4;
        // At a pole every u is the same point: look at it from just beside.
        let v = if self.has_poles() {
            v.clamp(2.0 * STEP, 1.0 - 2.0 * STEP)
        } else {
            v
        };
        let du = self.point(u + STEP, v) - self.point(u - STEP, v);
        let dv = self.point(u, v + STEP) - self.point(u, v - STEP);
        let n = du.cross(dv);
        // Corners of a superellipsoid have no tangent plane; their direction will do.
        if n.length() > 1e-16 {
            n.normalize()
        } else {
            self.point(u, v).normalize()
        }
    }
}

fn globe(longitude: f64, latitude: f64, radius: f64) -> DVec3 {
    let ring = cos(latitude);
    DVec3::new(ring * cos(longitude), sin(latitude), -ring * sin(longitude)) * radius
}

/// Triangles over the parameter square of `surface`: about `2 · around · along`, fewer at poles.
///
/// # Panics
/// If there are fewer than 3 steps round or 2 along.
pub fn tessellate(surface: ParametricSurface, around: u32, along: u32) -> Mesh {
    assert!(
        around >= 3 && along >= 2,
        "{around} x {along} steps do not close a surface"
    );
    // Vertices of the seam are doubled: their texture coordinates differ.
    let mut vertices = Vec::new();
    for j in 0..=along {
        for i in 0..=around {
            let (u, v) = (
                f64::from(i) / f64::from(around),
                f64::from(j) / f64::from(along),
            );
            // The seam's two copies must be one point, bit for bit, or it would gape.
            let wrap = |x: f64| if x == 1.0 { 0.0 } else { x };
            let at_v = if surface.has_poles() { v } else { wrap(v) };
            let at_u = if surface.has_poles() && (j == 0 || j == along) {
                0.0
            } else {
                wrap(u)
            };
            let position = surface.point(at_u, at_v);
            let normal = surface.normal(wrap(u), at_v);
            vertices.push(Vertex {
                position,
                normal,
                uv: [u, v],
            });
        }
    }
    let mut triangles = Vec::new();
    let row = around + 1;
    for j in 0..along {
        for i in 0..around {
            let a = j * row + i;
            let (b, c, d) = (a + 1, a + row, a + row + 1);
            // At the poles one of the two triangles has no area.
            if !(surface.has_poles() && j == 0) {
                triangles.push([a, b, d]);
            }
            if !(surface.has_poles() && j == along - 1) {
                triangles.push([a, d, c]);
            }
        }
    }
    Mesh::new(&vertices, triangles).expect("a parametric surface has finite points")
}

/// The volume enclosed: positive if front faces look outwards (divergence theorem).
#[cfg(test)]
fn signed_volume(mesh: &Mesh) -> f64 {
    let six_fold = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| mesh.position(i));
        a.dot(b.cross(c))
    };
    mesh.triangles().iter().map(six_fold).sum::<f64>() / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [ParametricSurface; 5] = [
        ParametricSurface::Sphere,
        ParametricSurface::Torus { tube: 0.3 },
        ParametricSurface::Superellipsoid {
            exponents: [0.4, 0.4],
        },
        ParametricSurface::Waves {
            count: 5,
            height: 0.2,
        },
        ParametricSurface::Trefoil { tube: 0.2 },
    ];

    #[test]
    fn surfaces_are_closed_and_outside_out() {
        for surface in ALL {
            let mesh = tessellate(surface, 48, 32);
            assert!(
                signed_volume(&mesh) > 0.1,
                "{surface:?}: {}",
                signed_volume(&mesh)
            );
            // Closed: the area vectors of all faces add up to nothing.
            let mut sum = DVec3::ZERO;
            let mut agree = 0;
            for t in mesh.triangles() {
                let [a, b, c] = t.map(|i| mesh.position(i));
                let area = (b - a).cross(c - a);
                sum += area;
                let [x, y, z] = mesh.normals();
                let i = t[0] as usize;
                let n = DVec3::new(x[i].into(), y[i].into(), z[i].into());
                agree += usize::from(n.dot(area) > 0.0);
            }
            assert!(sum.length() < 1e-4, "{surface:?} gapes by {sum}");
            assert!(
                agree * 100 > mesh.triangles().len() * 97,
                "{surface:?}: {agree}"
            );
            let (_, radius) = mesh.bounds();
            assert!(radius < 1.85, "{surface:?}: {radius}");
        }
    }

    #[test]
    fn sphere_has_the_volume_of_a_sphere() {
        let volume = signed_volume(&tessellate(ParametricSurface::Sphere, 128, 64));
        // An inscribed polyhedron lacks about (2π²/3)(1/n²) of it, n steps round.
        let exact = 4.0 / 3.0 * std::f64::consts::PI;
        assert!((volume / exact - 1.0).abs() < 2e-3, "{volume}");
    }
}
