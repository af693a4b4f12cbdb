use foveasim_models::math::sin;
use foveasim_models::{Pose, Role, Stream};
use glam::{DQuat, DVec3};

use super::solids::Solids;
use super::{environment, surface};
use crate::{
    Instance, Material, ParametricSurface, Pattern, Scene, SceneParts, Similarity, Sun, look_at,
    tessellate,
};

/// Half the room's width and length, and its height \[m\].
const HALF: [f64; 2] = [5.0, 8.0];
const HEIGHT_M: f64 = 3.6;
/// Thickness of walls, floor and ceiling \[m\].
const WALL_M: f64 = 0.2;
/// Height of the fence \[m\], and where it runs along z.
const FENCE_M: f64 = 1.25;
const FENCE_X: f64 = -1.4;
/// Where the grille stands, its half width and half height \[m\].
const GRILLE: DVec3 = DVec3::new(1.9, 0.62, -0.9);
const GRILLE_HALF: [f64; 2] = [0.95, 0.3];

/// The sun comes in by the windows.
const SUN: Sun = Sun {
    direction: DVec3::new(0.80, 0.52, 0.18),
    radiance: [1.05, 0.95, 0.80],
};

/// Floor and ceiling, walls with windows on the right, columns and beams.
fn building() -> [Solids; 2] {
    let [mut floor, mut walls] = [Solids::default(), Solids::default()];
    let [x, z] = HALF;
    let half = WALL_M / 2.0;
    floor.block(DVec3::new(0.0, -half, 0.0), DVec3::new(x, half, z));
    walls.block(
        DVec3::new(0.0, HEIGHT_M + half, 0.0),
        DVec3::new(x, half, z),
    );
    let middle = HEIGHT_M / 2.0;
    walls.block(
        DVec3::new(-x - half, middle, 0.0),
        DVec3::new(half, middle, z),
    );
    for end in [-1.0, 1.0] {
        walls.block(
            DVec3::new(0.0, middle, end * (z + half)),
            DVec3::new(x, middle, half),
        );
    }
    // The right wall: a sill, a lintel and posts, with bars between.
    walls.block(DVec3::new(x + half, 0.5, 0.0), DVec3::new(half, 0.5, z));
    walls.block(DVec3::new(x + half, 3.3, 0.0), DVec3::new(half, 0.3, z));
    for post in 0..9 {
        let at = -z + 2.0 * z * f64::from(post) / 8.0;
        walls.block(DVec3::new(x + half, 2.0, at), DVec3::new(half, 1.0, 0.12));
    }
    for side in [-3.4, 3.4] {
        for k in 0..4 {
            let at = DVec3::new(side, 0.0, -6.0 + 4.0 * f64::from(k));
            let profile = [
                [0.0, 0.0],
                [0.3, 0.0],
                [0.3, 0.2],
                [0.2, 0.32],
                [0.17, HEIGHT_M - 0.4],
                [0.3, HEIGHT_M - 0.2],
                [0.3, HEIGHT_M],
                [0.0, HEIGHT_M],
            ];
            walls.lathe(Pose::new(at, DQuat::IDENTITY), &profile, 48);
        }
    }
    for k in 0..4 {
        let at = DVec3::new(0.0, HEIGHT_M - 0.12, -6.0 + 4.0 * f64::from(k));
        walls.block(at, DVec3::new(x, 0.12, 0.1));
    }
    [floor, walls]
}

/// A fence along the room: three rails and `bars` round bars, and thin ones before the windows.
fn fence(bars: u32) -> Solids {
    let mut s = Solids::default();
    let length = HALF[1] - 0.4;
    for height in [0.12, FENCE_M * 0.55, FENCE_M] {
        s.block(
            DVec3::new(FENCE_X, height, 0.0),
            DVec3::new(0.02, 0.015, length),
        );
    }
    let spacing = 2.0 * length / f64::from(bars);
    for bar in 0..bars {
        let z = -length + spacing * (f64::from(bar) + 0.5);
        let radius = 0.008_f64.min(0.3 * spacing);
        s.rod(
            DVec3::new(FENCE_X, 0.0, z),
            DVec3::new(FENCE_X, FENCE_M + 0.12, z),
            radius,
            8,
        );
        let window = HALF[0] + WALL_M / 2.0;
        s.rod(
            DVec3::new(window, 0.98, z),
            DVec3::new(window, 3.02, z),
            radius * 0.6,
            6,
        );
    }
    s
}

/// A grille like a car's: a frame, slats, and uprights behind them.
fn grille(bars: u32) -> Solids {
    let mut s = Solids::default();
    let [x, y] = GRILLE_HALF;
    let rim = 0.03;
    for side in [-1.0, 1.0] {
        s.block(
            GRILLE + DVec3::Y * (side * y),
            DVec3::new(x + rim, rim, 0.04),
        );
        s.block(GRILLE + DVec3::X * (side * x), DVec3::new(rim, y, 0.04));
    }
    let slats = (bars / 4).max(1);
    let spacing = 2.0 * y / f64::from(slats);
    for slat in 0..slats {
        let at = -y + spacing * (f64::from(slat) + 0.5);
        // Slats lean, and bulge forwards in the middle.
        let section = |k: u32| {
            let f = 2.0 * f64::from(k) / 12.0 - 1.0;
            let middle = GRILLE + DVec3::new(f * x, at, 0.10 * (1.0 - f * f));
            let (deep, thin) = (0.02, 0.18 * spacing);
            [[1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]]
                .map(|[a, b]| middle + DVec3::new(0.0, b * thin - 0.3 * a * thin, a * deep))
        };
        let sections: Vec<_> = (0..=12).map(section).collect();
        s.loft(&sections);
    }
    for upright in 1..6 {
        let at = -x + 2.0 * x * f64::from(upright) / 6.0;
        s.rod(
            GRILLE + DVec3::new(at, -y, -0.06),
            GRILLE + DVec3::new(at, y, -0.06),
            0.008,
            8,
        );
    }
    s
}

/// The scene: a hall with columns, a fence of `bars` bars and as many before its windows, and a body with a grille of a
/// quarter as many slats.
pub(super) fn scene(seed: u64, bars: u32) -> Scene {
    let [floor, walls] = building();
    let body = tessellate(
        ParametricSurface::Superellipsoid {
            exponents: [0.45, 0.45],
        },
        96,
        48,
    );
    let ball = tessellate(ParametricSurface::Sphere, 64, 32);
    let mut instances: Vec<Instance> = (0..4)
        .map(|mesh| Instance {
            mesh,
            lod: None,
            material: mesh,
            world_from_object: Similarity::IDENTITY,
            two_sided: false,
        })
        .collect();
    let placed = |mesh, material, position, scale| Instance {
        mesh,
        lod: None,
        material,
        world_from_object: Similarity {
            pose: Pose::new(position, DQuat::IDENTITY),
            scale,
        },
        two_sided: false,
    };
    let behind = GRILLE + DVec3::new(0.0, -0.15, -1.15);
    instances.push(placed(4, 4, behind, 1.08));
    let random = &mut Stream::new(seed, Role::Scene, 30_000);
    for _ in 0..6 {
        let radius = random.range(0.1, 0.3);
        let at = DVec3::new(random.range(-4.2, -2.0), radius, random.range(-6.0, 2.5));
        instances.push(placed(5, 5, at, radius));
    }
    let material = |albedo, pattern, frequency, finish| -> Material {
        surface(albedo, pattern, frequency, finish, seed as u32)
    };
    Scene::build(SceneParts {
        meshes: vec![
            floor.mesh(),
            walls.mesh(),
            fence(bars).mesh(),
            grille(bars).mesh(),
            body,
            ball,
        ],
        lods: Vec::new(),
        instances,
        materials: vec![
            material(
                [[0.42, 0.30, 0.20], [0.22, 0.14, 0.09]],
                Pattern::Checker,
                16.0,
                [0.25, 0.05, 0.5],
            ),
            material(
                [[0.62, 0.60, 0.55], [0.56, 0.53, 0.48]],
                Pattern::Patches,
                1.5,
                [0.8, 0.04, 0.0],
            ),
            material(
                [[0.05, 0.06, 0.07], [0.05, 0.06, 0.07]],
                Pattern::Plain,
                1.0,
                [0.3, 0.05, 0.4],
            ),
            material(
                [[0.60, 0.62, 0.64], [0.60, 0.62, 0.64]],
                Pattern::Plain,
                1.0,
                [0.10, 0.6, 0.9],
            ),
            material(
                [[0.45, 0.03, 0.03], [0.45, 0.03, 0.03]],
                Pattern::Plain,
                1.0,
                [0.08, 0.06, 0.9],
            ),
            material(
                [[0.10, 0.35, 0.20], [0.75, 0.70, 0.55]],
                Pattern::Stripes,
                6.0,
                [0.4, 0.05, 0.3],
            ),
        ],
        textures: Vec::new(),
        motions: Vec::new(),
        sky: environment(seed),
        sun: SUN,
    })
    .expect("generated parts fit together")
}

/// Down the hall towards the grille, swaying.
pub(super) fn camera(t: f64) -> Pose {
    let sway = sin(std::f64::consts::TAU * t);
    let eye = DVec3::new(0.35 + 0.4 * sway, 1.6, 4.2 - 3.0 * t);
    look_at(eye, DVec3::new(0.55 + 0.2 * sway, 1.05, -2.0)).expect("it looks ahead")
}

#[cfg(test)]
mod tests {
    use super::super::solids::volume_if_closed;
    use super::*;

    #[test]
    fn every_part_closes() {
        for bars in [1, 120] {
            for mesh in &scene(1, bars).meshes()[..4] {
                assert!(volume_if_closed(mesh).unwrap() > 0.0);
            }
        }
    }

    #[test]
    fn the_eye_stays_in_the_room() {
        for k in 0..=100 {
            let eye = camera(f64::from(k) / 100.0).position;
            assert!(eye.x.abs() < 3.0 && eye.z.abs() < HALF[1] && eye.y < HEIGHT_M);
            assert!(eye.distance(GRILLE) > 1.5 && eye.x > FENCE_X + 0.5);
        }
    }
}
