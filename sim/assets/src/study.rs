use foveasim_models::math::{cos, sin};
use foveasim_models::{Pose, Role, Stream};
use glam::{DQuat, DVec3};

use crate::{
    AnalyticSky, Instance, Material, ParametricSurface, Pattern, Scene, Similarity, Sky, Sun,
    Surface, Terrain, terrain_height, terrain_mesh, tessellate,
};

/// Frames of the fly-through (Guenter 2012, §6: 5,377).
pub const STUDY_FRAMES: u32 = 5377;

/// Objects along each side of the grid (Guenter 2012, §5: "a 20×20 grid").
const GRID: u32 = 20;
/// Distance between neighbouring objects \[m\].
const SPACING_M: f64 = 8.0;
/// Squares along each side of the ground: 20,000 triangles.
const GROUND_CELLS: u32 = 100;
/// Materials shared by the objects.
const MATERIALS: u64 = 24;

/// The study scene of Guenter et al. 2012, §5, in a first version: procedurally shaded ground of
/// 20,000 triangles, 20 × 20 parametric objects from diffuse to glossy floating above it, a sky with
/// mountains and clouds. The same seed gives the same scene.
///
/// Objects have one tessellation each (about 1,500 triangles).
pub fn study_scene(seed: u64) -> Scene {
    let ground_seed = ground_seed(seed);
    let mut meshes = vec![terrain_mesh(ground_seed, GROUND_CELLS)];
    let shapes = [
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
    for shape in shapes {
        meshes.push(match shape {
            ParametricSurface::Trefoil { .. } => tessellate(shape, 96, 10),
            ParametricSurface::Torus { .. } => tessellate(shape, 40, 20),
            _ => tessellate(shape, 32, 24),
        });
    }
    let mut materials = vec![Material::Terrain(Terrain {
        seed: ground_seed,
        octaves: 8,
        snow_line_m: 17.0,
    })];
    materials.extend((0..MATERIALS).map(|k| surface(seed, k)));

    let mut instances = vec![Instance {
        mesh: 0,
        material: 0,
        world_from_object: Similarity::at(DVec3::ZERO),
        two_sided: false,
    }];
    for j in 0..GRID {
        for i in 0..GRID {
            let random = &mut Stream::new(seed, Role::Scene, u64::from(1000 + j * GRID + i));
            instances.push(floating_object(
                random,
                [i, j],
                ground_seed,
                shapes.len() as u64,
            ));
        }
    }
    let sky = Sky::Analytic(study_sky(seed));
    Scene::new(meshes, instances, materials, sky, STUDY_SUN).expect("generated parts fit together")
}

/// The sun of the study scene: from the right, in front and above.
pub const STUDY_SUN: Sun = Sun {
    direction: DVec3::new(0.45, 0.62, 0.64),
    radiance: [0.95, 0.88, 0.76],
};

/// The sky of the study scene, with the haze of a landscape of some 400 m.
pub fn study_sky(seed: u64) -> AnalyticSky {
    AnalyticSky {
        seed: ground_seed(seed),
        zenith: [0.10, 0.24, 0.60],
        horizon: [0.55, 0.68, 0.86],
        mountains: [0.16, 0.20, 0.26],
        cloud_cover: 0.45,
        visibility_m: 420.0,
    }
}

/// Where the eye is at `t` of the fly-through (0 to 1): along the street in the middle of the grid,
/// looking ahead and swaying. Values beyond are clamped. `seed` is the scene's.
pub fn study_camera(t: f64, seed: u64) -> Pose {
    let t = if t > 0.0 { t.min(1.0) } else { 0.0 };
    let turn = 2.0 * std::f64::consts::PI;
    let z = 84.0 - 160.0 * t;
    let x = 0.8 * sin(turn * 3.0 * t);
    let ground = terrain_height(x, z, ground_seed(seed));
    let position = DVec3::new(x, ground + 6.0 + 0.6 * sin(turn * 5.0 * t), z);
    let yaw = DQuat::from_axis_angle(DVec3::Y, 0.22 * sin(turn * 2.0 * t));
    let pitch = DQuat::from_axis_angle(DVec3::X, -0.05 + 0.05 * cos(turn * 4.0 * t));
    Pose::new(position, (yaw * pitch).normalize())
}

fn ground_seed(seed: u64) -> u32 {
    Stream::new(seed, Role::Scene, 0).next_u64() as u32
}

fn floating_object(
    random: &mut Stream,
    [i, j]: [u32; 2],
    ground_seed: u32,
    shapes: u64,
) -> Instance {
    let centred = |k: u32| (f64::from(k) - f64::from(GRID - 1) / 2.0) * SPACING_M;
    let (x, z) = (centred(i), centred(j));
    let y = terrain_height(x, z, ground_seed) + random.range(4.0, 7.5);
    let axis = DVec3::new(random.range(-1.0, 1.0), 1.0, random.range(-1.0, 1.0)).normalize();
    let orientation = DQuat::from_axis_angle(axis, random.range(0.0, std::f64::consts::TAU));
    Instance {
        mesh: 1 + random.below(shapes) as usize,
        material: 1 + random.below(MATERIALS) as usize,
        two_sided: false,
        world_from_object: Similarity {
            pose: Pose::new(DVec3::new(x, y, z), orientation.normalize()),
            scale: random.range(1.3, 2.1),
        },
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_seed_gives_the_same_scene() {
        assert_eq!(study_scene(1), study_scene(1));
        assert_ne!(study_scene(1).instances(), study_scene(2).instances());
    }

    #[test]
    fn it_is_the_scene_of_the_paper() {
        let scene = study_scene(1);
        assert_eq!(scene.meshes()[0].triangles().len(), 20_000);
        assert_eq!(scene.instances().len(), 1 + 400);
        assert!(scene.triangle_count() > 400_000);
    }

    #[test]
    fn the_camera_stays_above_ground_and_out_of_objects() {
        let scene = study_scene(1);
        for frame in 0..STUDY_FRAMES {
            let eye = study_camera(f64::from(frame) / f64::from(STUDY_FRAMES), 1).position;
            assert!(eye.y > terrain_height(eye.x, eye.z, ground_seed(1)) + 3.0);
            for i in &scene.instances()[1..] {
                let s = i.world_from_object;
                let (_, radius) = scene.meshes()[i.mesh].bounds();
                assert!(
                    eye.distance(s.pose.position) > radius * s.scale + 0.1,
                    "frame {frame}"
                );
            }
        }
    }

    #[test]
    fn the_camera_takes_any_number() {
        assert_eq!(study_camera(f64::NAN, 1), study_camera(0.0, 1));
        assert_eq!(study_camera(7.0, 1), study_camera(1.0, 1));
    }
}
