use foveasim_models::math::{cos, sin};
use foveasim_models::{Pose, Role, Stream};
use glam::{DQuat, DVec3};

use super::solids::Solids;
use super::{environment, orbit, surface};
use crate::{
    Instance, Key, Material, Motion, Pattern, Repeat, STUDY_SUN, Scene, SceneParts, Similarity,
    Track,
};

/// Blades of the rotor.
const BLADES: u32 = 7;
/// Pieces along a blade.
const BLADE_PIECES: usize = 24;
/// Where the hub is \[m\]; the rotor turns about its z axis.
const HUB: DVec3 = DVec3::new(0.0, 1.5, 0.0);
/// Where blades end before they sweep back, and the radius of the duct around them \[m\].
const TIP_M: f64 = 0.97;
const DUCT_M: f64 = 1.04;
/// Wires of the guard before the rotor.
const WIRES: u32 = 9;

/// A part that has the z axis for its own.
fn along_z(position: DVec3) -> Pose {
    Pose::new(position, DQuat::from_rotation_arc(DVec3::Y, DVec3::Z))
}

/// Duct, stand, struts, motor, guard, bolts and pipes.
fn housing(seed: u64) -> Solids {
    let mut s = Solids::default();
    let (inner, outer, depth) = (DUCT_M, DUCT_M + 0.13, 0.22);
    let lip = [
        [inner, -depth],
        [outer, -depth],
        [outer, depth],
        [outer + 0.06, depth],
        [outer + 0.06, depth + 0.05],
        [inner, depth + 0.05],
        [inner, -depth],
    ];
    s.lathe(along_z(HUB), &lip, 96);
    // Stand.
    s.block(DVec3::new(0.0, 0.08, 0.0), DVec3::new(1.35, 0.08, 0.5));
    for side in [-1.0, 1.0] {
        s.block(
            DVec3::new(side * 1.02, 0.62, 0.0),
            DVec3::new(0.09, 0.46, 0.16),
        );
    }
    // The motor and the struts that hold it.
    let motor = [
        [0.0, -0.62],
        [0.2, -0.62],
        [0.25, -0.55],
        [0.25, -0.2],
        [0.0, -0.2],
    ];
    s.lathe(along_z(HUB), &motor, 48);
    for strut in 0..5 {
        let angle = std::f64::consts::TAU * (f64::from(strut) + 0.25) / 5.0;
        let out = DVec3::new(cos(angle), sin(angle), 0.0);
        let back = DVec3::new(0.0, 0.0, -0.3);
        let from = HUB + back + out * 0.2;
        s.rod(from, HUB + back * 0.6 + out * (DUCT_M + 0.05), 0.028, 16);
    }
    // The guard: rings and spokes of thin wire.
    for wire in 1..=WIRES {
        let r = 0.12 + (DUCT_M - 0.12) * f64::from(wire) / f64::from(WIRES);
        let z = depth + 0.08 - 0.03 * (r / DUCT_M) * (r / DUCT_M);
        let w = 0.0035;
        let round = [
            [r - w, z - w],
            [r + w, z - w],
            [r + w, z + w],
            [r - w, z + w],
            [r - w, z - w],
        ];
        s.lathe(along_z(HUB), &round, 96);
    }
    for spoke in 0..12 {
        let angle = std::f64::consts::TAU * f64::from(spoke) / 12.0;
        let out = DVec3::new(cos(angle), sin(angle), 0.0);
        let z = DVec3::new(0.0, 0.0, depth + 0.065);
        s.rod(
            HUB + z + out * 0.12,
            HUB + z + out * (DUCT_M + 0.08),
            0.005,
            8,
        );
    }
    // Bolts on the lip.
    for bolt in 0..24 {
        let angle = std::f64::consts::TAU * (f64::from(bolt) + 0.5) / 24.0;
        let at = HUB + DVec3::new(cos(angle), sin(angle), 0.0) * (outer + 0.02);
        let z = DVec3::new(0.0, 0.0, depth + 0.05);
        s.rod(at + z * 0.9, at + z + DVec3::Z * 0.02, 0.016, 6);
    }
    // Pipes from the stand up behind the duct.
    let random = &mut Stream::new(seed, Role::Scene, 20_000);
    for _ in 0..14 {
        let x = random.range(-1.15, 1.15);
        let z = random.range(-0.45, -0.3);
        let knee = DVec3::new(x, random.range(0.5, 2.7), z);
        let radius = random.range(0.012, 0.035);
        s.rod(DVec3::new(x, 0.1, z), knee, radius, 12);
        let end = DVec3::new(random.range(-0.2, 0.2), 1.5, -0.6);
        s.rod(knee, end, radius * 0.8, 12);
    }
    s
}

/// Hub and twisted blades about the z axis.
fn rotor() -> Solids {
    let mut s = Solids::default();
    let hub = [
        [0.0, -0.16],
        [0.16, -0.16],
        [0.16, 0.06],
        [0.13, 0.12],
        [0.07, 0.16],
        [0.0, 0.175],
    ];
    s.lathe(along_z(DVec3::ZERO), &hub, 48);
    for blade in 0..BLADES {
        let angle = std::f64::consts::TAU * f64::from(blade) / f64::from(BLADES);
        let turned = DQuat::from_rotation_z(angle);
        let section = |k: usize| {
            let f = k as f64 / BLADE_PIECES as f64;
            let r = 0.12 + (TIP_M - 0.12) * f;
            // A propeller of constant pitch: the angle to its plane falls with the radius.
            let pitch = foveasim_models::math::atan(0.34 / (r + 0.15));
            let sweep = -0.22 * f * f;
            let chord = 0.11 + 0.06 * sin(std::f64::consts::PI * (0.15 + 0.8 * f));
            let across = DVec3::new(0.0, cos(pitch), sin(pitch));
            let through = DVec3::new(0.0, -sin(pitch), cos(pitch));
            let thick = 0.014 * (1.0 - 0.6 * f);
            let middle = DVec3::new(r, sweep, 0.0);
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(|[a, b]| turned * (middle + across * (a * chord) + through * (b * thick)))
        };
        let sections: Vec<_> = (0..=BLADE_PIECES).map(section).collect();
        s.loft(&sections);
    }
    s
}

/// One turn as three thirds: a great arc is never ambiguous.
fn turning(rpm: f64) -> Motion {
    let still = |placement| Track::still(placement).expect("placed in front of the housing");
    let chain = if rpm == 0.0 {
        vec![still(Similarity::at(HUB))]
    } else {
        let period = 60.0 / rpm.abs();
        let third = std::f64::consts::TAU / 3.0 * rpm.signum();
        let key = |k: u32| Key {
            seconds: period * f64::from(k) / 3.0,
            placement: Similarity {
                pose: Pose::new(DVec3::ZERO, DQuat::from_rotation_z(third * f64::from(k))),
                scale: 1.0,
            },
        };
        let turn = Track::new((0..=3).map(key).collect(), Repeat::Every(period));
        vec![still(Similarity::at(HUB)), turn.expect("keys in order")]
    };
    Motion { instance: 2, chain }
}

/// The scene: floor, housing and a rotor of `rpm` turns a minute, positive from the right over the top to the left.
pub(super) fn scene(seed: u64, rpm: f64) -> Scene {
    let mut floor = Solids::default();
    floor.block(DVec3::new(0.0, -0.1, 0.0), DVec3::new(12.0, 0.1, 12.0));
    let at = |mesh: usize, position: DVec3| Instance {
        mesh,
        lod: None,
        material: mesh,
        world_from_object: Similarity::at(position),
        two_sided: false,
    };
    let material = |albedo, pattern, frequency, finish| -> Material {
        surface(albedo, pattern, frequency, finish, seed as u32)
    };
    Scene::build(SceneParts {
        meshes: vec![floor.mesh(), housing(seed).mesh(), rotor().mesh()],
        lods: Vec::new(),
        instances: vec![at(0, DVec3::ZERO), at(1, DVec3::ZERO), at(2, HUB)],
        materials: vec![
            material(
                [[0.34, 0.34, 0.36], [0.20, 0.21, 0.23]],
                Pattern::Checker,
                20.0,
                [0.55, 0.04, 0.2],
            ),
            material(
                [[0.13, 0.25, 0.34], [0.16, 0.30, 0.40]],
                Pattern::Patches,
                9.0,
                [0.3, 0.06, 0.7],
            ),
            material(
                [[0.72, 0.40, 0.06], [0.60, 0.12, 0.05]],
                Pattern::Stripes,
                2.0,
                [0.12, 0.35, 0.9],
            ),
        ],
        textures: Vec::new(),
        motions: vec![turning(rpm)],
        sky: environment(seed),
        sun: STUDY_SUN,
    })
    .expect("generated parts fit together")
}

/// To and fro before the machine.
pub(super) fn camera(t: f64) -> Pose {
    let swing = 0.09 * sin(std::f64::consts::TAU * t);
    orbit(DVec3::new(0.0, 1.4, 0.0), 3.3, 0.1, 0.09 + swing)
}

#[cfg(test)]
mod tests {
    use super::super::solids::volume_if_closed;
    use super::*;

    #[test]
    fn every_part_closes() {
        for mesh in scene(1, 600.0).meshes() {
            assert!(volume_if_closed(mesh).unwrap() > 0.01);
        }
    }

    #[test]
    fn the_rotor_turns_as_fast_as_asked() {
        for rpm in [600.0, -90.0] {
            let scene = scene(1, rpm);
            for seconds in [0.0, 0.004, 0.021, 0.033, 0.099, 0.7] {
                let placed = scene.at(seconds).instances()[2].world_from_object;
                let angle = std::f64::consts::TAU * rpm / 60.0 * seconds;
                let want = HUB + DVec3::new(cos(angle), sin(angle), 0.0);
                let off = placed.point(DVec3::X).distance(want);
                assert!(off < 1e-9, "{rpm} {seconds}: {off}");
            }
        }
        let still = scene(1, 0.0);
        assert_eq!(still.at(0.5).instances(), still.instances());
    }

    #[test]
    fn blades_stay_in_the_duct() {
        let scene = scene(1, 600.0);
        let mesh = &scene.meshes()[2];
        for i in 0..mesh.vertex_count() as u32 {
            let p = mesh.position(i);
            assert!(p.x * p.x + p.y * p.y < DUCT_M * DUCT_M && p.z.abs() < 0.22);
        }
    }
}
