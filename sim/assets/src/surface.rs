use foveasim_models::math::{cos, pow, sin};
use glam::DVec3;

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
        SurfaceTable::new(self, &[u], &[v]).at(0, 0).0
    }

    /// The outward unit normal at `u`, `v`; on an edge, one between those of its sides.
    pub fn normal(self, u: f64, v: f64) -> DVec3 {
        SurfaceTable::new(self, &[u], &[v]).at(0, 0).1
    }

    /// Whether `v` = 0 and `v` = 1 are each a single point.
    pub(crate) fn has_poles(self) -> bool {
        matches!(
            self,
            Self::Sphere | Self::Superellipsoid { .. } | Self::Waves { .. }
        )
    }
}

/// A surface over a grid of parameters. All that depends on one parameter alone, every transcendental
/// function with it, is worked out once for its column or row.
pub(crate) enum SurfaceTable {
    /// A profile swept along a closed curve (spherical product, Barr 1981).
    Product {
        curve: Vec<Section>,
        profile: Vec<Section>,
    },
    /// Radius (1 + h·a(λ)·b(φ)) / (1 + h) in direction (λ, φ).
    Waves {
        height: f64,
        columns: Vec<WaveColumn>,
        rows: Vec<WaveRow>,
    },
    /// A circle moved along a space curve.
    Tube {
        radius: f64,
        frames: Vec<Frame>,
        circle: Vec<[f64; 2]>,
    },
}

/// A point of a plane curve and its outward normal, of any length.
#[derive(Clone, Copy)]
pub(crate) struct Section {
    point: [f64; 2],
    normal: [f64; 2],
}

/// cos λ, sin λ, a = sin nλ and its derivative.
#[derive(Clone, Copy)]
pub(crate) struct WaveColumn {
    longitude: [f64; 2],
    wave: f64,
    slope: f64,
}

/// cos φ, sin φ, b = sin nφ · cos²φ, its derivative, and b / cos φ.
#[derive(Clone, Copy)]
pub(crate) struct WaveRow {
    latitude: [f64; 2],
    wave: f64,
    slope: f64,
    over_cosine: f64,
}

/// A point of a space curve and two directions across it.
#[derive(Clone, Copy)]
pub(crate) struct Frame {
    centre: DVec3,
    side: DVec3,
    up: DVec3,
}

impl SurfaceTable {
    pub(crate) fn new(surface: ParametricSurface, us: &[f64], vs: &[f64]) -> Self {
        let turn = |x: f64| 2.0 * std::f64::consts::PI * x;
        // v = 0 is the south pole of the sphere-like ones.
        let latitude = |v: f64| std::f64::consts::PI * (v - 0.5);
        let curve = |f: &dyn Fn(f64) -> Section| us.iter().map(|&u| f(turn(u))).collect();
        match surface {
            ParametricSurface::Sphere => Self::Product {
                curve: curve(&Section::circle),
                profile: vs.iter().map(|&v| Section::circle(latitude(v))).collect(),
            },
            ParametricSurface::Torus { tube } => Self::Product {
                curve: curve(&Section::circle),
                profile: vs
                    .iter()
                    .map(|&v| {
                        let round = Section::circle(turn(v));
                        let [c, s] = round.point;
                        Section {
                            point: [1.0 - tube + tube * c, tube * s],
                            ..round
                        }
                    })
                    .collect(),
            },
            ParametricSurface::Superellipsoid { exponents: [n, e] } => Self::Product {
                curve: curve(&|angle| Section::superellipse(angle, e)),
                profile: vs
                    .iter()
                    .map(|&v| Section::superellipse(latitude(v), n))
                    .collect(),
            },
            ParametricSurface::Waves { count, height } => {
                let n = f64::from(count);
                Self::Waves {
                    height,
                    columns: us.iter().map(|&u| WaveColumn::new(turn(u), n)).collect(),
                    rows: vs.iter().map(|&v| WaveRow::new(latitude(v), n)).collect(),
                }
            }
            ParametricSurface::Trefoil { tube } => Self::Tube {
                radius: tube,
                frames: us.iter().map(|&u| Frame::trefoil(turn(u))).collect(),
                circle: vs.iter().map(|&v| cos_sin(turn(v))).collect(),
            },
        }
    }

    /// Point and outward unit normal at the crossing of column `i` and row `j`.
    pub(crate) fn at(&self, i: usize, j: usize) -> (DVec3, DVec3) {
        let (point, normal) = match self {
            Self::Product { curve, profile } => {
                let (a, b) = (curve[i], profile[j]);
                // Across the swept curve the normal leans out as far as the curve is away.
                let reach = a.point[0] * a.normal[0] + a.point[1] * a.normal[1];
                let point = |p: [f64; 2], y: f64, k: f64| DVec3::new(k * p[0], y, -k * p[1]);
                (
                    point(a.point, b.point[1], b.point[0]),
                    point(a.normal, b.normal[1] * reach, b.normal[0]),
                )
            }
            Self::Waves {
                height,
                columns,
                rows,
            } => {
                let (a, b) = (columns[i], rows[j]);
                let ([cl, sl], [cp, sp]) = (a.longitude, b.latitude);
                let k = height / (1.0 + height);
                let radius = 1.0 / (1.0 + height) + k * a.wave * b.wave;
                let out = DVec3::new(cp * cl, sp, -cp * sl);
                let north = DVec3::new(-sp * cl, cp, sp * sl);
                let east = DVec3::new(-sl, 0.0, -cl);
                let climb = north * (k * a.wave * b.slope) + east * (k * a.slope * b.over_cosine);
                (out * radius, out * radius - climb)
            }
            Self::Tube {
                radius,
                frames,
                circle,
            } => {
                // Turning about its own axis, the frame moves points along the surface only.
                let (f, [c, s]) = (frames[i], circle[j]);
                let out = f.side * c + f.up * s;
                (f.centre + out * *radius, out)
            }
        };
        (point, normal.normalize())
    }
}

/// Cosine and sine, zero where they are but for rounding: poles and seams must meet.
fn cos_sin(angle: f64) -> [f64; 2] {
    [cos(angle), sin(angle)].map(|x| if x.abs() < 1e-14 { 0.0 } else { x })
}

impl Section {
    fn circle(angle: f64) -> Self {
        let point = cos_sin(angle);
        Self {
            point,
            normal: point,
        }
    }

    /// |x|^p + |y|^p = 1 with p = 2 / exponent. Barr's own parameter puts nearly all points into the
    /// corners and even angles put too few there; the exponent to the power of ¾ lies between.
    fn superellipse(angle: f64, exponent: f64) -> Self {
        let p = 2.0 / exponent;
        let power = |x: f64, p: f64| pow(x.abs(), p).copysign(x);
        let [c, s] = cos_sin(angle).map(|x| power(x, pow(exponent, 0.75)));
        let radius = pow(pow(c.abs(), p) + pow(s.abs(), p), -1.0 / p);
        // The gradient; below p = 1 times |cs|^(1−p), which keeps it finite at a cusp.
        let gradient = |x: f64, other: f64| {
            if p >= 1.0 {
                power(x, p - 1.0)
            } else {
                pow(other.abs(), 1.0 - p).copysign(x)
            }
        };
        Self {
            point: [radius * c, radius * s],
            normal: [gradient(c, s), gradient(s, c)],
        }
    }
}

impl WaveColumn {
    fn new(longitude: f64, n: f64) -> Self {
        Self {
            longitude: cos_sin(longitude),
            wave: sin(n * longitude),
            slope: n * cos(n * longitude),
        }
    }
}

impl WaveRow {
    fn new(latitude: f64, n: f64) -> Self {
        // The waves vanish at the poles, where all longitudes meet.
        let [c, s] = cos_sin(latitude);
        let (cn, sn) = (cos(n * latitude), sin(n * latitude));
        Self {
            latitude: [c, s],
            wave: sn * c * c,
            slope: n * cn * c * c - 2.0 * sn * c * s,
            over_cosine: sn * c,
        }
    }
}

impl Frame {
    fn trefoil(t: f64) -> Self {
        const SIZE: f64 = 0.28;
        let centre = DVec3::new(
            sin(t) + 2.0 * sin(2.0 * t),
            cos(t) - 2.0 * cos(2.0 * t),
            -sin(3.0 * t),
        ) * SIZE;
        let tangent = DVec3::new(
            cos(t) + 4.0 * cos(2.0 * t),
            -sin(t) + 4.0 * sin(2.0 * t),
            -3.0 * cos(3.0 * t),
        )
        .normalize();
        // A frame that turns smoothly: away from the axis of the knot, which it never crosses.
        let outward = DVec3::new(centre.x, centre.y, 0.0);
        let side = (outward - tangent * outward.dot(tangent)).normalize();
        Self {
            centre,
            side,
            up: side.cross(tangent),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tessellate::tests::ALL;
    use foveasim_models::{Role, Stream};

    #[test]
    fn normals_are_those_of_central_differences() {
        const STEP: f64 = 1e-5;
        let random = &mut Stream::new(1, Role::Scene, 0);
        for surface in ALL {
            for _ in 0..2000 {
                let (u, v) = (random.range(0.01, 0.99), random.range(0.05, 0.95));
                // Within a few steps of an edge there is no tangent plane to compare with.
                let off_edge = |x: f64| (x * 4.0 - (x * 4.0).round()).abs() > 0.01;
                if !(off_edge(u) && off_edge(v)) {
                    continue;
                }
                let du = surface.point(u + STEP, v) - surface.point(u - STEP, v);
                let dv = surface.point(u, v + STEP) - surface.point(u, v - STEP);
                let n = du.cross(dv).normalize();
                let cosine = surface.normal(u, v).dot(n);
                assert!(cosine > 1.0 - 1e-5, "{surface:?} at {u}, {v}: {cosine}");
            }
        }
    }

    #[test]
    fn superellipsoids_keep_their_equation() {
        let random = &mut Stream::new(2, Role::Scene, 0);
        for exponents @ [n, e] in [[0.35, 0.35], [1.8, 1.8], [0.5, 2.5], [3.0, 1.0]] {
            let surface = ParametricSurface::Superellipsoid { exponents };
            for _ in 0..1000 {
                let p = surface.point(random.uniform(), random.uniform());
                let ring = pow(p.x.abs(), 2.0 / e) + pow(p.z.abs(), 2.0 / e);
                let value = pow(ring, e / n) + pow(p.y.abs(), 2.0 / n);
                assert!((value - 1.0).abs() < 1e-9, "{exponents:?}: {value}");
            }
        }
    }
}
