use foveasim_models::{Pose, Role, Stream};
use glam::{DQuat, DVec3};

use crate::study::ground_seed;
use crate::{
    Instance, LevelOfDetail, Material, Mesh, ParametricSurface, Pattern, Similarity, Surface,
    terrain_height, tessellation_ladder,
};

/// Objects along each side of the grid (Guenter 2012, §5: "a 20×20 grid").
const GRID: u32 = 20;
/// Distance between neighbouring objects \[m\].
const SPACING_M: f64 = 8.0;
/// Materials shared by the objects.
const MATERIALS: u64 = 24;

/// The shapes of the objects.
pub(crate) const SHAPES: [ParametricSurface; 6] = [
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

/// MaxTriCount of the inner and middle layers and of the outer one (Guenter 2012, §6).
const MOST_TRIANGLES: [u32; 2] = [20_000, 8_000];
/// MinTriCount of all layers. The paper gives none.
const FEWEST_TRIANGLES: u32 = 400;
/// Ladders go on to this many triangles for samples too coarse to show more.
const COARSEST_TRIANGLES: u32 = 100;
/// MinDistSq and MaxDistSq, as distances \[m\]. The paper gives neither; these make about 250,000
/// triangles in view in the mean of the fly-through, as it reports (249,277 with seed 1).
const DISTANCE_M: [f64; 2] = [6.0, 58.0];
/// Triangles of the mesh that stands for a whole ladder.
const TYPICAL_TRIANGLES: usize = 1500;

/// What one of the objects is and where.
pub(crate) struct StudyObject {
    /// Index in [`SHAPES`].
    pub(crate) shape: usize,
    /// Index in [`materials`].
    pub(crate) material: usize,
    pub(crate) world_from_object: Similarity,
}

/// All objects, row by row.
pub(crate) fn objects(seed: u64) -> Vec<StudyObject> {
    let ground = ground_seed(seed);
    let mut objects = Vec::with_capacity((GRID * GRID) as usize);
    for j in 0..GRID {
        for i in 0..GRID {
            let random = &mut Stream::new(seed, Role::Scene, u64::from(1000 + j * GRID + i));
            objects.push(floating_object(random, [i, j], ground));
        }
    }
    objects
}

fn floating_object(random: &mut Stream, [i, j]: [u32; 2], ground: u32) -> StudyObject {
    let centred = |k: u32| (f64::from(k) - f64::from(GRID - 1) / 2.0) * SPACING_M;
    let (x, z) = (centred(i), centred(j));
    let y = terrain_height(x, z, ground) + random.range(4.0, 7.5);
    let axis = DVec3::new(random.range(-1.0, 1.0), 1.0, random.range(-1.0, 1.0)).normalize();
    let orientation = DQuat::from_axis_angle(axis, random.range(0.0, std::f64::consts::TAU));
    StudyObject {
        shape: random.below(SHAPES.len() as u64) as usize,
        material: random.below(MATERIALS) as usize,
        world_from_object: Similarity {
            pose: Pose::new(DVec3::new(x, y, z), orientation.normalize()),
            scale: random.range(1.3, 2.1),
        },
    }
}

/// The ladders of all shapes, appended to `meshes`.
pub(crate) fn ladders(meshes: &mut Vec<Mesh>) -> Vec<LevelOfDetail> {
    let [most, most_outermost] = MOST_TRIANGLES.map(f64::from);
    let fewest = f64::from(FEWEST_TRIANGLES);
    SHAPES
        .map(|shape| {
            let first = meshes.len();
            let ladder = tessellation_ladder(shape, MOST_TRIANGLES[0], COARSEST_TRIANGLES);
            let deviations_m = ladder
                .iter()
                .map(|step| step.deviation_m.max(step.shading_m))
                .collect();
            meshes.extend(ladder.into_iter().map(|step| step.mesh));
            LevelOfDetail {
                meshes: first..meshes.len(),
                deviations_m,
                distance_sq_m2: DISTANCE_M.map(|d| d * d),
                triangles: [most, fewest],
                triangles_outermost: [most_outermost, fewest],
            }
        })
        .into()
}

/// The objects as instances whose ladders are `lods` and whose materials follow `first_material`.
pub(crate) fn instances(
    seed: u64,
    meshes: &[Mesh],
    lods: &[LevelOfDetail],
    first_material: usize,
) -> Vec<Instance> {
    let typical: Vec<usize> = lods
        .iter()
        .map(|lod| {
            let small = |mesh: &Mesh| mesh.triangles().len() <= TYPICAL_TRIANGLES;
            lod.meshes.start + meshes[lod.meshes.clone()].partition_point(|m| !small(m))
        })
        .collect();
    objects(seed)
        .into_iter()
        .map(|object| Instance {
            mesh: typical[object.shape],
            lod: Some(object.shape),
            material: first_material + object.material,
            two_sided: false,
            world_from_object: object.world_from_object,
        })
        .collect()
}

/// The materials of the objects.
pub(crate) fn materials(seed: u64) -> impl Iterator<Item = Material> {
    (0..MATERIALS).map(move |k| surface(seed, k))
}

/// Object material `k`: every third diffuse, every third glossy, every third mirror-like.
fn surface(seed: u64, k: u64) -> Material {
    let random = &mut Stream::new(seed, Role::Scene, 1 + k);
    let mut colour = |low: f64, high: f64| {
        // Saturated: one channel high, one low, one anywhere.
        let mut c = [high, low, random.range(low, high)];
        c.rotate_left(random.below(3) as usize);
        c.map(|v| v as f32)
    };
    let albedo = [colour(0.06, 0.75), colour(0.03, 0.55)];
    let pattern = match random.below(5) {
        0 => Pattern::Plain,
        1 => Pattern::Checker,
        2 => Pattern::Stripes,
        3 => Pattern::Marble,
        _ => Pattern::Patches,
    };
    let frequency = match pattern {
        Pattern::Checker | Pattern::Stripes => 4.0 + random.below(8) as f64,
        _ => random.range(1.5, 4.0),
    } as f32;
    let (roughness, f0, environment) = match k % 3 {
        0 => (random.range(0.6, 1.0), 0.04, 0.0),
        1 => (random.range(0.15, 0.4), 0.05, 0.7),
        _ => (random.range(0.05, 0.15), random.range(0.3, 0.8), 1.0),
    };
    Material::Surface(Surface {
        albedo,
        pattern,
        frequency,
        roughness: roughness as f32,
        f0: f0 as f32,
        environment: environment as f32,
        seed: random.next_u64() as u32,
    })
}
