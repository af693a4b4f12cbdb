use glam::DVec3;

use crate::surface::SurfaceTable;
use crate::{Mesh, ParametricSurface, Vertex};

/// One step of a ladder of ever coarser tessellations of one surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Tessellation {
    /// The triangles.
    pub mesh: Mesh,
    /// No point of the surface is farther from the mesh \[m\].
    pub deviation_m: f64,
    /// How far interpolated normals are from where the surface has them \[m\], an estimate: at the middles
    /// of sides, the difference of the unit normals times half the side. It shrinks with the third power
    /// of the side where a surface is smooth; along an edge it is a quarter or so of the triangles there.
    pub shading_m: f64,
}

/// Triangles of neighbouring steps of a ladder differ by this ratio, up to rounding: with the nearer
/// of two, 6 % from the count wanted at most.
const RATIO: f64 = 1.122_462_048_309_373; // 2^(1/6)

/// Triangles over the parameter square of `surface`: about `2 · around · along`, fewer at poles. They
/// run row by row; two rows of vertices are all that a walk over them needs at hand.
///
/// # Panics
/// If there are fewer than 3 steps round or 2 along.
pub fn tessellate(surface: ParametricSurface, around: u32, along: u32) -> Mesh {
    Lattice::new(surface, around, along).mesh()
}

/// Tessellations of `surface` from `finest` triangles (at most) down to about `coarsest`, in steps of
/// 2^(1/6) up to the rounding to whole rows and columns.
///
/// # Panics
/// If `coarsest` is below 48 or above `finest`.
pub fn tessellation_ladder(
    surface: ParametricSurface,
    finest: u32,
    coarsest: u32,
) -> Vec<Tessellation> {
    assert!(
        (48..=finest).contains(&coarsest),
        "no ladder from {finest} to {coarsest} triangles"
    );
    let mut ladder: Vec<Tessellation> = Vec::new();
    let mut wanted = f64::from(finest);
    while wanted > 0.97 * f64::from(coarsest) {
        let steps = surface.steps(wanted, finest);
        let lattice = Lattice::new(surface, steps[0], steps[1]);
        let count = lattice.triangles();
        // Where few rows and columns are left, two counts wanted may have one answer.
        if ladder
            .last()
            .is_none_or(|t| count < t.mesh.triangles().len())
        {
            ladder.push(Tessellation {
                mesh: lattice.mesh(),
                deviation_m: lattice.deviation_m(),
                shading_m: lattice.shading_m(),
            });
        }
        wanted /= RATIO;
    }
    ladder
}

impl ParametricSurface {
    /// Steps round per step along that spread a given number of triangles well.
    fn aspect(self) -> f64 {
        match self {
            Self::Torus { tube } => (1.0 / tube).sqrt(),
            Self::Trefoil { .. } => 6.0,
            _ => 2.0,
        }
    }

    /// Steps round and along that make `most` triangles or fewer, as near to `triangles` and to the best
    /// shape as whole numbers allow.
    fn steps(self, triangles: f64, most: u32) -> [u32; 2] {
        // Edges of a superellipsoid must lie on edges of the mesh.
        let (unit_u, unit_v) = match self {
            Self::Superellipsoid { .. } => (4, 2),
            _ => (1, 1),
        };
        let lost = u32::from(self.has_poles());
        let ideal = (triangles / (2.0 * self.aspect())).sqrt();
        let mut best = ([4, 3], f64::INFINITY);
        for along in (3.max((0.7 * ideal) as u32)..=(1.4 * ideal) as u32 + 2)
            .filter(|along| along % unit_v == 0)
        {
            let per_unit = 2 * (along - lost) * unit_u;
            let nearest = (triangles / f64::from(per_unit)).round() as u32;
            let units = nearest.min(most / per_unit);
            let around = units * unit_u;
            if around < 4 {
                continue;
            }
            let off = (f64::from(units * per_unit) / triangles - 1.0).abs();
            let skew = f64::from(around) / f64::from(along - lost) / self.aspect();
            let cost = off + 0.05 * (skew.max(1.0 / skew) - 1.0);
            if cost < best.1 {
                best = ([around, along], cost);
            }
        }
        best.0
    }

    /// How many columns of triangles differ by more than a rotation or reflection.
    fn distinct_columns(self, around: u32) -> u32 {
        match self {
            Self::Sphere | Self::Torus { .. } => 1,
            Self::Superellipsoid { .. } if around.is_multiple_of(4) => around / 4,
            _ => around,
        }
    }
}

/// A surface sampled at the corners of a grid, at the middles of its sides and of its squares.
struct Lattice {
    surface: ParametricSurface,
    around: u32,
    along: u32,
    table: SurfaceTable,
}

impl Lattice {
    fn new(surface: ParametricSurface, around: u32, along: u32) -> Self {
        assert!(
            around >= 3 && along >= 2,
            "{around} x {along} steps do not close a surface"
        );
        let halves = |steps: u32| -> Vec<f64> {
            (0..2 * steps)
                .map(|k| f64::from(k) / f64::from(2 * steps))
                .collect()
        };
        let us = halves(around);
        let mut vs = halves(along);
        vs.push(1.0);
        Self {
            surface,
            around,
            along,
            table: SurfaceTable::new(surface, &us, &vs),
        }
    }

    /// Point and normal, counted in half steps. The seam's two sides are one entry, bit for bit, or it
    /// would gape.
    fn at(&self, half_u: u32, half_v: u32) -> (DVec3, DVec3) {
        let wrap = |half: u32, steps: u32| if half == 2 * steps { 0 } else { half };
        let j = if self.surface.has_poles() {
            half_v
        } else {
            wrap(half_v, self.along)
        };
        self.table
            .at(wrap(half_u, self.around) as usize, j as usize)
    }

    fn triangles(&self) -> usize {
        let lost = u32::from(self.surface.has_poles());
        (2 * self.around * (self.along - lost)) as usize
    }

    fn mesh(&self) -> Mesh {
        let (around, along) = (self.around, self.along);
        // Vertices of the seam are doubled: their texture coordinates differ.
        let row = around + 1;
        let mut vertices = Vec::with_capacity((row * (along + 1)) as usize);
        for j in 0..=along {
            for i in 0..=around {
                let (position, normal) = self.at(2 * i, 2 * j);
                let uv = [
                    f64::from(i) / f64::from(around),
                    f64::from(j) / f64::from(along),
                ];
                vertices.push(Vertex {
                    position,
                    normal,
                    uv,
                });
            }
        }
        let poles = self.surface.has_poles();
        let mut triangles = Vec::with_capacity(self.triangles());
        for j in 0..along {
            for i in 0..around {
                let a = j * row + i;
                let (b, c, d) = (a + 1, a + row, a + row + 1);
                // At the poles one of the two triangles has no area.
                if !(poles && j == 0) {
                    triangles.push([a, b, d]);
                }
                if !(poles && j == along - 1) {
                    triangles.push([a, d, c]);
                }
            }
        }
        Mesh::new(&vertices, triangles).expect("a parametric surface has finite points")
    }

    /// A bound on the distance from the surface to the mesh \[m\].
    ///
    /// From a triangle whose sides' middles are off by a, b and c, a quadratic surface is off by
    /// 4·(λ₁λ₂a + λ₂λ₃b + λ₃λ₁c) at most. An eighth is added for what is not quadratic.
    fn deviation_m(&self) -> f64 {
        let columns = self.surface.distinct_columns(self.around);
        let middles = self.middles(columns);
        let at = |i: u32, j: u32| middles[(j * columns + i % columns) as usize];
        let mut largest: f64 = 0.0;
        for j in 0..self.along {
            for i in 0..columns {
                let [lower, left, diagonal] = at(i, j);
                let (upper, right) = (at(i, j + 1)[0], at(i + 1, j)[1]);
                largest = largest
                    .max(largest_within([lower, right, diagonal]))
                    .max(largest_within([left, upper, diagonal]));
            }
        }
        1.125 * largest
    }

    /// See [`Tessellation::shading_m`].
    fn shading_m(&self) -> f64 {
        let mut largest: f64 = 0.0;
        for j in 0..self.along {
            for i in 0..self.surface.distinct_columns(self.around) {
                let from = self.at(2 * i, 2 * j);
                for (du, dv) in [(1, 0), (0, 1), (1, 1)] {
                    let middle = self.at(2 * i + du, 2 * j + dv).1;
                    let to = self.at(2 * (i + du), 2 * (j + dv));
                    largest = largest.max(normal_offset(from, to, middle));
                }
            }
        }
        largest
    }

    /// How far the surface is from the mesh \[m\] at the middle of each square's lower side, left side
    /// and diagonal, row by row; of the row beyond the last, lower sides alone.
    fn middles(&self, columns: u32) -> Vec<[f64; 3]> {
        let poles = self.surface.has_poles();
        let mut middles = Vec::with_capacity((columns * (self.along + 1)) as usize);
        for j in 0..=self.along {
            // At the top it is the last square's upper side.
            let (row, top) = (j.min(self.along - 1), j == self.along);
            for i in 0..columns {
                let corner = |du: u32, dv: u32| self.at(2 * (i + du), 2 * (row + dv)).0;
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
                let off = |du: u32, dv: u32| {
                    let p = self.at(2 * i + du, 2 * j + dv).0;
                    if poles && row == 0 {
                        to_triangle(p, [a, d, c])
                    } else if poles && row == self.along - 1 {
                        to_triangle(p, [a, b, d])
                    } else {
                        to_triangle(p, [a, b, d]).min(to_triangle(p, [a, d, c]))
                    }
                };
                middles.push(if top {
                    [off(1, 0), 0.0, 0.0]
                } else {
                    [off(1, 0), off(0, 1), off(1, 1)]
                });
            }
        }
        middles
    }
}

/// Half a side's length times the difference between the normal at its middle and the mean of those at
/// its ends.
fn normal_offset(from: (DVec3, DVec3), to: (DVec3, DVec3), middle: DVec3) -> f64 {
    let mean = (from.1 + to.1).normalize_or_zero();
    0.5 * from.0.distance(to.0) * (mean - middle).length()
}

/// The largest of 4·(λ₁λ₂a + λ₂λ₃b + λ₃λ₁c) over a triangle: with 2√a, 2√b, 2√c as lengths of sides, the
/// square of half the longest side, or of the circumradius if no angle is obtuse.
fn largest_within(mut middles: [f64; 3]) -> f64 {
    middles.sort_by(f64::total_cmp);
    let [a, b, c] = middles;
    if c >= a + b {
        return c;
    }
    4.0 * a * b * c / (2.0 * (a * b + b * c + c * a) - a * a - b * b - c * c)
}

/// Distance from a point to a triangle that has an area.
pub(crate) fn to_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let beside = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(normal) < 0.0;
    let sides = [(a, b), (b, c), (c, a)];
    if sides.iter().all(|&(from, to)| !beside(from, to)) {
        return (p - a).dot(normal).abs() / normal.length();
    }
    let to_side = |(from, to): (DVec3, DVec3)| {
        let side = to - from;
        let t = ((p - from).dot(side) / side.length_squared()).clamp(0.0, 1.0);
        (p - from - side * t).length_squared()
    };
    sides
        .map(to_side)
        .into_iter()
        .fold(f64::INFINITY, f64::min)
        .sqrt()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use foveasim_models::{Role, Stream};

    pub(crate) const ALL: [ParametricSurface; 6] = [
        ParametricSurface::Sphere,
        ParametricSurface::Torus { tube: 0.34 },
        ParametricSurface::Superellipsoid {
            exponents: [0.35, 0.35],
        },
        ParametricSurface::Superellipsoid {
            exponents: [1.8, 1.8],
        },
        ParametricSurface::Waves {
            count: 6,
            height: 0.22,
        },
        ParametricSurface::Trefoil { tube: 0.17 },
    ];

    /// The volume enclosed: positive if front faces look outwards (divergence theorem).
    fn signed_volume(mesh: &Mesh) -> f64 {
        let six_fold = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| mesh.position(i));
            a.dot(b.cross(c))
        };
        mesh.triangles().iter().map(six_fold).sum::<f64>() / 6.0
    }

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

    #[test]
    fn ladders_go_down_in_small_steps() {
        for surface in ALL {
            let ladder = tessellation_ladder(surface, 20_000, 100);
            let counts: Vec<f64> = ladder
                .iter()
                .map(|t| t.mesh.triangles().len() as f64)
                .collect();
            assert!(counts[0] <= 20_000.0 && counts[0] > 19_800.0, "{counts:?}");
            for pair in counts.windows(2).filter(|pair| pair[1] > 380.0) {
                let ratio = pair[0] / pair[1];
                assert!((1.02..1.19).contains(&ratio), "{surface:?}: {pair:?}");
            }
            for pair in counts.windows(2) {
                let ratio = pair[0] / pair[1];
                assert!(ratio > 1.0 && ratio < 1.4, "{surface:?}: {pair:?}");
            }
        }
    }

    /// The bound that the footprint rule rests on, against the analytic surface at random points.
    #[test]
    fn no_point_of_the_surface_is_farther_than_the_bound() {
        let random = &mut Stream::new(3, Role::Scene, 0);
        for surface in ALL {
            for wanted in [110.0, 400.0, 1500.0, 20_000.0] {
                let [around, along] = surface.steps(wanted, 20_000);
                let lattice = Lattice::new(surface, around, along);
                let (mesh, bound) = (lattice.mesh(), lattice.deviation_m());
                let mut largest: f64 = 0.0;
                for _ in 0..1000 {
                    let (u, v) = (random.uniform(), random.uniform());
                    let p = surface.point(u, v);
                    let cell = [
                        (u * f64::from(around)) as u32,
                        (v * f64::from(along)) as u32,
                    ];
                    let near = |t: &&[u32; 3]| {
                        let (i, j) = (t[0] % (around + 1), t[0] / (around + 1));
                        i.abs_diff(cell[0]) <= 1 && j.abs_diff(cell[1]) <= 1
                    };
                    let rows = mesh.triangles().chunks(2 * around as usize);
                    let distance = rows
                        .skip((cell[1] as usize).saturating_sub(2))
                        .take(4)
                        .flatten()
                        .filter(near)
                        .map(|t| to_triangle(p, t.map(|k| mesh.position(k))))
                        .fold(f64::INFINITY, f64::min);
                    largest = largest.max(distance);
                }
                // Positions are single precision.
                assert!(
                    largest <= bound + 1e-7,
                    "{surface:?} {around} x {along}: {largest} > {bound}"
                );
                // And it is not idle: within a factor of 4 of what random points find.
                assert!(
                    largest * 4.0 > bound,
                    "{surface:?} {around} x {along}: {largest} << {bound}"
                );
            }
        }
    }

    /// The way back, where the surface's distance is known in closed form.
    #[test]
    fn no_point_of_the_mesh_is_farther_than_the_bound() {
        let random = &mut Stream::new(4, Role::Scene, 0);
        let from_sphere = |p: DVec3| (p.length() - 1.0).abs();
        let from_torus = |p: DVec3| {
            let ring = (p.x * p.x + p.z * p.z).sqrt() - 0.66;
            ((ring * ring + p.y * p.y).sqrt() - 0.34).abs()
        };
        let surfaces: [(_, &dyn Fn(DVec3) -> f64); 2] =
            [(ALL[0], &from_sphere), (ALL[1], &from_torus)];
        for (surface, distance) in surfaces {
            for step in tessellation_ladder(surface, 3000, 100) {
                for t in step.mesh.triangles() {
                    let [a, b, c] = t.map(|k| step.mesh.position(k));
                    let (s, t) = (random.uniform(), random.uniform());
                    let (s, t) = if s + t > 1.0 {
                        (1.0 - s, 1.0 - t)
                    } else {
                        (s, t)
                    };
                    let off = distance(a + (b - a) * s + (c - a) * t);
                    assert!(off <= step.deviation_m + 1e-7, "{surface:?}: {off}");
                }
            }
        }
    }
}
