use foveasim_assets::{Detail, Irradiance, Scene};
use foveasim_models::{View, Work};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::kernels::WIDTH;
use crate::{Focus, RenderOptions};

/// What surfaces are lit by besides sun and sky as they are; empty where nothing is asked for.
#[derive(Debug, Default)]
pub(crate) struct Illumination {
    /// What the sun sees, the closest look first.
    pub(crate) shadows: Vec<ShadowMap>,
    /// Light of the sky by normal.
    pub(crate) irradiance: Option<Irradiance>,
    pub(crate) work: Work,
}

impl Illumination {
    /// What the options ask for. Shadows are of the meshes that the display's own pixels would show.
    pub(crate) fn new(scene: &Scene, view: &View, options: &RenderOptions) -> Self {
        let lighting = &options.lighting;
        let irradiance = lighting
            .image_based
            .then(|| scene.sky().irradiance(scene.sun()));
        let Some(asked) = &lighting.shadows else {
            return Self {
                irradiance,
                ..Self::default()
            };
        };
        let detail = Detail {
            rule: options.lod,
            outermost: false,
            sample_tan: view.optics.pixel_tan().min_element(),
            error_samples: options.lod_error,
        };
        let light_from_world = light_from_world(scene.sun().direction);
        let eye = view.poses[0].position;
        let triangles: Vec<[DVec3; 3]> = (0..scene.instances().len())
            .into_par_iter()
            .flat_map_iter(|index| {
                let instance = &scene.instances()[index];
                let mesh = &scene.meshes()[scene.mesh_for(index, eye, detail)];
                let at =
                    |k: u32| light_from_world * instance.world_from_object.point(mesh.position(k));
                let points: Vec<DVec3> = (0..mesh.vertex_count() as u32).map(at).collect();
                let corners = |t: &[u32; 3]| t.map(|k| points[k as usize]);
                mesh.triangles().iter().map(corners).collect::<Vec<_>>()
            })
            .collect();
        let whole = triangles
            .iter()
            .flatten()
            .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| {
                [low.min(*p), high.max(*p)]
            });
        if triangles.is_empty() {
            return Self {
                irradiance,
                ..Self::default()
            };
        }
        let around = |focus: &Focus| {
            let centre = light_from_world * focus.centre;
            [centre - focus.radius_m, centre + focus.radius_m]
        };
        let parts = asked.focus.iter().map(around).chain([whole]);
        let shadows: Vec<ShadowMap> = parts
            .map(|part| ShadowMap::new(part, asked.size, light_from_world, &triangles))
            .collect();
        let maps = shadows.len() as u64;
        Self {
            irradiance,
            work: Work {
                shadow_triangles: maps * triangles.len() as u64,
                shadow_texels: maps * u64::from(asked.size) * u64::from(asked.size),
                ..Work::default()
            },
            shadows,
        }
    }
}

/// How near to the sun things are, seen along its light.
#[derive(Debug, PartialEq)]
pub(crate) struct ShadowMap {
    size: u32,
    /// World to texels, and to how far towards the sun \[m\]: three rows of a matrix and what is added.
    map_from_world: [[f32; 4]; 3],
    /// Length of a texel \[m\].
    texel_m: f32,
    /// The greatest of each texel's middle; −∞ where nothing is.
    nearest: Vec<f32>,
}

/// Rows of the display that one thread fills at a time.
const BAND: usize = 32;
/// Surfaces are lifted by so many texels along their normals, and towards the sun, so that they do not shade themselves
/// where the map is coarser than they are bent.
const LIFT_TEXELS: f32 = 1.5;

/// Right, up and towards the sun.
fn light_from_world(towards: DVec3) -> DMat3 {
    let back = towards.normalize();
    let right = back.any_orthonormal_vector();
    DMat3::from_cols(right, back.cross(right), back).transpose()
}

impl ShadowMap {
    /// Of the part of the world between two corners, in the light's frame.
    fn new(
        [low, high]: [DVec3; 2],
        size: u32,
        light_from_world: DMat3,
        triangles: &[[DVec3; 3]],
    ) -> Self {
        let extent = (high - low).truncate().max_element().max(1e-6);
        let per_m = f64::from(size) / extent;
        let middle = (low + high) / 2.0;
        let half = f64::from(size) / 2.0;
        let place = |p: DVec3| {
            [
                (p.x - middle.x) * per_m + half,
                (p.y - middle.y) * per_m + half,
            ]
        };
        let row = |axis: usize, scale: f64, add: f64| {
            let r = light_from_world.row(axis) * scale;
            [r.x as f32, r.y as f32, r.z as f32, add as f32]
        };
        let mut nearest = vec![f32::NEG_INFINITY; size as usize * size as usize];
        let side = size as usize;
        nearest
            .par_chunks_mut(BAND * side)
            .enumerate()
            .for_each(|(band, rows)| {
                for [a, b, c] in triangles {
                    draw(
                        [place(*a), place(*b), place(*c)],
                        [a.z, b.z, c.z],
                        [band * BAND, side],
                        rows,
                    );
                }
            });
        Self {
            size,
            map_from_world: [
                row(0, per_m, half - middle.x * per_m),
                row(1, per_m, half - middle.y * per_m),
                row(2, 1.0, 0.0),
            ],
            texel_m: (1.0 / per_m) as f32,
            nearest,
        }
    }

    /// How much of the sun's light reaches a place, 0 to 1; `None` beyond the map.
    fn light(&self, world: [f32; 3], normal: [f32; 3]) -> Option<f32> {
        let lift = LIFT_TEXELS * self.texel_m;
        let p = [0, 1, 2].map(|k| world[k] + normal[k] * lift);
        let [u, v, towards] = self
            .map_from_world
            .map(|[x, y, z, add]| x * p[0] + y * p[1] + z * p[2] + add);
        let (u, v, towards) = (u - 0.5, v - 0.5, towards + lift);
        let last = (self.size - 1) as f32;
        if !(u >= 0.0 && v >= 0.0 && u < last && v < last) {
            return None;
        }
        let (x, y) = (u as usize, v as usize);
        let (fx, fy) = (u - x as f32, v - y as f32);
        let free = |x: usize, y: usize| {
            let nearest = self.nearest[y * self.size as usize + x];
            if nearest > towards { 0.0 } else { 1.0 }
        };
        let (upper, lower) = (
            free(x, y) + fx * (free(x + 1, y) - free(x, y)),
            free(x, y + 1) + fx * (free(x + 1, y + 1) - free(x, y + 1)),
        );
        Some(upper + fy * (lower - upper))
    }
}

/// How much of the sun's light reaches places, by the closest look that has them. No lanes, so it is one function for all
/// materials.
#[inline(never)]
pub(crate) fn sunlight(
    maps: &[ShadowMap],
    world: [[f32; WIDTH]; 3],
    normal: [[f32; WIDTH]; 3],
) -> [f32; WIDTH] {
    let mut light = [1.0; WIDTH];
    for (lane, light) in light.iter_mut().enumerate() {
        let (p, n) = (world.map(|c| c[lane]), normal.map(|c| c[lane]));
        // Beyond them all, nothing is known to be in the way.
        *light = maps.iter().find_map(|map| map.light(p, n)).unwrap_or(1.0);
    }
    light
}

/// Raises texels to where a triangle is, in the rows from `first` on of `side` texels each. The greatest of all is the same in
/// any order.
fn draw(p: [[f64; 2]; 3], z: [f64; 3], [first, side]: [usize; 2], rows: &mut [f32]) {
    let range = |axis: usize, from: usize, count: usize| {
        let least = p[0][axis].min(p[1][axis]).min(p[2][axis]);
        let most = p[0][axis].max(p[1][axis]).max(p[2][axis]);
        // The casts saturate.
        let start = ((least - 0.5).ceil().max(0.0) as usize).clamp(from, from + count);
        let end = (((most - 0.5).floor() + 1.0).max(0.0) as usize).clamp(from, from + count);
        start..end
    };
    let ys = range(1, first, rows.len() / side);
    if ys.is_empty() {
        return;
    }
    let edge = |a: [f64; 2], b: [f64; 2], x: f64, y: f64| {
        (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])
    };
    let area = edge(p[0], p[1], p[2][0], p[2][1]);
    if area == 0.0 {
        return;
    }
    for y in ys {
        for x in range(0, 0, side) {
            let (cx, cy) = (x as f64 + 0.5, y as f64 + 0.5);
            let b = edge(p[2], p[0], cx, cy) / area;
            let c = edge(p[0], p[1], cx, cy) / area;
            if b >= 0.0 && c >= 0.0 && b + c <= 1.0 {
                let towards = (z[0] + b * (z[1] - z[0]) + c * (z[2] - z[0])) as f32;
                let texel = &mut rows[(y - first) * side + x];
                if towards > *texel {
                    *texel = towards;
                }
            }
        }
    }
}
