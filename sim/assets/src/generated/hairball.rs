use std::ops::Range;

use foveasim_models::math::{cos, sin};
use foveasim_models::{Pose, Role, Stream};
use glam::DVec3;

use super::{environment, orbit, surface};
use crate::{
    Instance, LevelOfDetail, Mesh, ParametricSurface, Pattern, STUDY_SUN, Scene, SceneParts,
    Similarity, Vertex, tessellate,
};

/// Pieces of a strand at its finest; each coarser level has half as many.
const PIECES: usize = 24;
/// Levels of detail: 24, 12, 6 and 3 pieces.
const LEVELS: usize = 4;
/// Where strands begin: the radius of a dark ball \[m\].
const ROOT_M: f64 = 0.35;
/// Radius of a strand at its root \[m\]; it tapers to a point.
const STRAND_M: f64 = 0.0035;
/// Cells of the directions along each side of a cube's face: strands of one are one object.
const CELLS: usize = 3;

/// Triangles of a strand of so many pieces: three sides of two each, a tip and a root.
const fn triangles(pieces: usize) -> usize {
    6 * (pieces - 1) + 3 + 1
}

/// A strand's axis: from its root outwards, curling about where it began.
struct Strand {
    root: DVec3,
    side: DVec3,
    up: DVec3,
    length: f64,
    curl: f64,
    turns: f64,
    phase: f64,
    droop: f64,
}

impl Strand {
    fn new(seed: u64, k: u32, of: u32) -> Self {
        let random = &mut Stream::new(seed, Role::Scene, 10_000 + u64::from(k));
        // Fibonacci's lattice on the sphere, shaken by half a step.
        let (n, golden) = (f64::from(of), 2.399_963_229_728_653);
        let y = 1.0 - 2.0 * (f64::from(k) + random.uniform()) / n;
        let around = golden * f64::from(k) + random.range(-0.5, 0.5) * golden;
        let ring = (1.0 - y * y).max(0.0).sqrt();
        let root = DVec3::new(ring * cos(around), y, ring * sin(around));
        let side = root.any_orthonormal_vector();
        Self {
            root,
            side,
            up: root.cross(side),
            length: random.range(0.35, 0.7),
            curl: random.range(0.1, 0.45),
            turns: random.range(0.3, 0.9),
            phase: random.range(0.0, std::f64::consts::TAU),
            droop: random.range(0.0, 0.25),
        }
    }

    fn axis(&self, s: f64) -> DVec3 {
        let angle = self.phase + std::f64::consts::TAU * self.turns * s;
        let about =
            self.side * (cos(angle) - cos(self.phase)) + self.up * (sin(angle) - sin(self.phase));
        self.root * (ROOT_M + self.length * s) + about * (self.curl * s)
            - DVec3::Y * (self.droop * s * s)
    }

    /// The corners of the ring at piece `k` of [`PIECES`], and which way each looks.
    fn ring(&self, k: usize) -> [(DVec3, DVec3); 3] {
        let s = k as f64 / PIECES as f64;
        let step = 0.5 / PIECES as f64;
        let along = (self.axis(s + step) - self.axis(s - step)).normalize();
        // Not parallel to the strand anywhere: strands lean away from their root by less than a right angle.
        let side = self.side - along * self.side.dot(along);
        let side = if side.length() > 0.05 { side } else { self.up };
        let side = (side - along * side.dot(along)).normalize();
        let up = along.cross(side);
        [0.0, 1.0, 2.0].map(|corner| {
            let angle = std::f64::consts::TAU * corner / 3.0;
            let out = side * cos(angle) + up * sin(angle);
            (self.axis(s) + out * (STRAND_M * (1.0 - s)), out)
        })
    }

    /// Appends the strand with every `stride`-th ring.
    fn build(&self, stride: usize, vertices: &mut Vec<Vertex>, triangles: &mut Vec<[u32; 3]>) {
        let first = vertices.len() as u32;
        let rings = PIECES / stride;
        for ring in 0..rings {
            let v = ring as f64 / rings as f64;
            for (position, normal) in self.ring(ring * stride) {
                vertices.push(Vertex {
                    position,
                    normal,
                    uv: [0.0, v],
                });
            }
        }
        let tip = self.axis(1.0);
        vertices.push(Vertex {
            position: tip,
            normal: tip - self.axis(1.0 - 1.0 / PIECES as f64),
            uv: [0.0, 1.0],
        });
        let at = |ring: usize, corner: usize| first + (3 * ring + corner % 3) as u32;
        triangles.push([at(0, 2), at(0, 1), at(0, 0)]);
        for ring in 1..rings {
            for corner in 0..3 {
                let [a, b] = [at(ring - 1, corner), at(ring - 1, corner + 1)];
                let [c, d] = [at(ring, corner + 1), at(ring, corner)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        for corner in 0..3 {
            let tip = vertices.len() as u32 - 1;
            triangles.push([at(rings - 1, corner), at(rings - 1, corner + 1), tip]);
        }
    }

    /// How far a strand with every `stride`-th ring is from the finest one, at most \[m\].
    ///
    /// Both are triangles over the same square of parameters (side, along). At the finest one's corners they
    /// differ by what is measured here; between them, by a linear function less a four-cornered patch, which is
    /// off its corners' mean plane by a quarter of its twist at most, once for each of the two.
    fn deviation_m(&self, stride: usize) -> f64 {
        let tip = self.axis(1.0);
        let corner = |k: usize, c: usize| {
            if k == PIECES {
                tip
            } else {
                self.ring(k)[c % 3].0
            }
        };
        let mut largest: f64 = 0.0;
        for from in (0..PIECES).step_by(stride) {
            let to = from + stride;
            for side in 0..3 {
                let [a, d] = [corner(from, side), corner(to, side)];
                let [b, c] = [corner(from, side + 1), corner(to, side + 1)];
                let twist = (a - b + c - d).length() / 2.0;
                for k in from..to {
                    let f = (k - from) as f64 / stride as f64;
                    let off = corner(k, side).distance(a + (d - a) * f);
                    largest = largest.max(off + twist);
                }
            }
        }
        largest
    }
}

/// Which object a strand belongs to: the cell of a cube that its root is seen in from the middle.
fn cell(root: DVec3) -> usize {
    let size = root.abs();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let c = root.to_array();
    let place = |k: usize| {
        let unit = (c[k] / c[axis].abs() + 1.0) / 2.0;
        ((unit * CELLS as f64) as usize).min(CELLS - 1)
    };
    let face = 2 * axis + usize::from(c[axis] < 0.0);
    (face * CELLS + place((axis + 1) % 3)) * CELLS + place((axis + 2) % 3)
}

/// The scene: `strands` strands in up to 54 objects of four levels of detail, on a ball in the sky.
pub(super) fn scene(seed: u64, strands: u32) -> Scene {
    let mut cells: Vec<Vec<Strand>> = Vec::new();
    cells.resize_with(6 * CELLS * CELLS, Vec::new);
    for k in 0..strands {
        let strand = Strand::new(seed, k, strands);
        cells[cell(strand.root)].push(strand);
    }
    let (mut meshes, mut lods, mut instances) = (Vec::new(), Vec::new(), Vec::new());
    for (object, strands) in cells.iter().filter(|c| !c.is_empty()).enumerate() {
        let levels = ladder(strands, &mut meshes);
        instances.push(Instance {
            mesh: levels.meshes.start,
            lod: Some(lods.len()),
            material: object % 3,
            world_from_object: Similarity::IDENTITY,
            two_sided: false,
        });
        lods.push(levels);
    }
    meshes.push(tessellate(ParametricSurface::Sphere, 64, 32));
    instances.push(Instance {
        mesh: meshes.len() - 1,
        lod: None,
        material: 3,
        world_from_object: Similarity {
            scale: ROOT_M,
            ..Similarity::IDENTITY
        },
        two_sided: false,
    });
    let colours = [
        [[0.42, 0.20, 0.07], [0.62, 0.36, 0.14]],
        [[0.30, 0.13, 0.05], [0.52, 0.27, 0.10]],
        [[0.55, 0.33, 0.15], [0.74, 0.52, 0.27]],
        [[0.05, 0.03, 0.02], [0.08, 0.05, 0.03]],
    ];
    let material = |albedo| {
        surface(
            albedo,
            Pattern::Stripes,
            3.0,
            [0.35, 0.045, 0.15],
            seed as u32,
        )
    };
    Scene::build(SceneParts {
        meshes,
        lods,
        instances,
        materials: colours.map(material).into(),
        textures: Vec::new(),
        motions: Vec::new(),
        sky: environment(seed),
        sun: STUDY_SUN,
    })
    .expect("generated parts fit together")
}

/// The strands of one object at each level of detail, appended to `meshes`. Distance alone asks for no less than the
/// finest; what samples cannot show is for the footprint to say.
fn ladder(strands: &[Strand], meshes: &mut Vec<Mesh>) -> LevelOfDetail {
    let start = meshes.len();
    let mut deviations_m = Vec::new();
    for level in 0..LEVELS {
        let stride = 1 << level;
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for strand in strands {
            strand.build(stride, &mut vertices, &mut triangles);
        }
        meshes.push(Mesh::new(&vertices, triangles).expect("strands are finite"));
        let off = strands.iter().map(|s| s.deviation_m(stride));
        deviations_m.push(if level == 0 {
            0.0
        } else {
            // Positions are single precision.
            off.fold(1e-6, f64::max)
        });
    }
    let range: Range<usize> = start..meshes.len();
    let most = (strands.len() * triangles(PIECES)) as f64;
    let fewest = (strands.len() * triangles(PIECES >> (LEVELS - 1))) as f64;
    LevelOfDetail {
        meshes: range,
        deviations_m,
        distance_sq_m2: [4.0, 400.0],
        triangles: [most, fewest],
        triangles_outermost: [most, fewest],
    }
}

/// Round the ball once, near enough that it fills half the height of 60°.
pub(super) fn camera(t: f64) -> Pose {
    orbit(DVec3::ZERO, 2.5, -0.3, 0.5 + t)
}

#[cfg(test)]
mod tests {
    use super::super::solids::volume_if_closed;
    use super::*;

    #[test]
    fn strands_close_at_every_level() {
        for level in 0..LEVELS {
            for k in 0..20 {
                let (mut vertices, mut faces) = (Vec::new(), Vec::new());
                Strand::new(3, k, 20).build(1 << level, &mut vertices, &mut faces);
                assert_eq!(faces.len(), triangles(PIECES >> level));
                let mesh = Mesh::new(&vertices, faces).unwrap();
                assert!(volume_if_closed(&mesh).unwrap() > 0.0, "{level} {k}");
            }
        }
    }

    #[test]
    fn the_scene_has_the_strands_asked_for() {
        let scene = scene(1, 500);
        assert_eq!(
            scene.triangle_count(),
            3968 + 500 * triangles(PIECES) as u64
        );
        let [low, high] = scene.bounds().unwrap();
        assert!(low.min_element() > -2.2 && high.max_element() < 2.2);
        for lod in scene.lods() {
            assert!(lod.deviations_m.is_sorted());
            assert!(lod.deviations_m[LEVELS - 1] < 0.4);
        }
    }

    /// The bound, against random points of the finest strand and all triangles of the coarse one near them.
    #[test]
    fn no_strand_is_farther_from_its_finest_than_it_says() {
        let random = &mut Stream::new(5, Role::Scene, 0);
        for k in 0..40 {
            let strand = Strand::new(7, k, 40);
            for level in 1..LEVELS {
                let mesh = |stride| {
                    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
                    strand.build(stride, &mut vertices, &mut faces);
                    Mesh::new(&vertices, faces).unwrap()
                };
                let (fine, coarse) = (mesh(1), mesh(1 << level));
                let bound = strand.deviation_m(1 << level);
                let points = |mesh: &Mesh, random: &mut Stream, n: u64| -> Vec<DVec3> {
                    let count = mesh.triangles().len() as u64;
                    let point = |_| {
                        let t = mesh.triangles()[random.below(count) as usize];
                        let [a, b, c] = t.map(|i| mesh.position(i));
                        let (s, t) = (random.uniform(), random.uniform());
                        let (s, t) = if s + t > 1.0 {
                            (1.0 - s, 1.0 - t)
                        } else {
                            (s, t)
                        };
                        a + (b - a) * s + (c - a) * t
                    };
                    (0..n).map(point).collect()
                };
                // Points of the coarse one are dense enough that the nearest is off by little.
                let near = points(&coarse, random, 4000);
                for p in points(&fine, random, 40) {
                    let off = near
                        .iter()
                        .map(|q| p.distance(*q))
                        .fold(f64::INFINITY, f64::min);
                    assert!(off <= bound + 6e-3, "{k} {level}: {off} > {bound}");
                }
            }
        }
    }
}
