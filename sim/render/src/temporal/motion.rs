use foveasim_assets::Similarity;
use foveasim_models::{Map, Pass, View};
use glam::{DMat3, DVec3};

use super::history::Placed;
use crate::kernels::Warp;

/// How the samples of a pass find what they show in an earlier image of it.
///
/// A sample at lattice position p sees the point e + w·R·C·(p, 1): e and R place the eye, C makes the
/// lattice tangents. Divided by w, all steps back to the earlier lattice are linear in (p, 1) and in
/// 1/w: twelve numbers for each way that something moved. With 1/w = 0 (the sky) the direction alone
/// is left.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Motion {
    /// The first one is for what did not move.
    pub(super) warps: Vec<Warp>,
    /// Which one each instance takes; empty if nothing moved.
    pub(super) warp_of_instance: Vec<u32>,
}

impl Motion {
    /// From samples of `now` to samples of `before`, each a pass, its view and what was where.
    pub(super) fn new(now: (&Pass, &View, &Placed), before: (&Pass, &View, &Placed)) -> Self {
        let at = |moved: &Moved| warp((now.0, now.1), (before.0, before.1), moved);
        let mut motion = Self {
            warps: vec![at(&Moved::NOT)],
            warp_of_instance: Vec::new(),
        };
        let (placed, earlier) = (&now.2.world_from_object, &before.2.world_from_object);
        if placed == earlier {
            return motion;
        }
        for (now, before) in placed.iter().zip(earlier) {
            let index = if now == before {
                0
            } else {
                motion.warps.push(at(&Moved::new(now, before)));
                motion.warps.len() - 1
            };
            motion.warp_of_instance.push(index as u32);
        }
        motion
    }
}

/// From where a point of an instance is now to where it was, both in the world.
struct Moved {
    linear: DMat3,
    shift: DVec3,
}

impl Moved {
    const NOT: Self = Self {
        linear: DMat3::IDENTITY,
        shift: DVec3::ZERO,
    };

    fn new(now: &Similarity, before: &Similarity) -> Self {
        let turn = before.pose.orientation * now.pose.orientation.conjugate();
        let linear = DMat3::from_quat(turn.normalize()) * (before.scale / now.scale);
        Self {
            linear,
            shift: before.pose.position - linear * now.pose.position,
        }
    }
}

/// Lattice position (x, y, 1) to direction (tangent right, tangent up, −1).
fn direction_from_lattice(pass: &Pass, view: &View) -> DMat3 {
    let Map::Affine(map) = pass.map else {
        unreachable!("only affine grids pass the checks")
    };
    let step = view.optics.pixel_tan();
    let zero = view.optics.direction(map.origin);
    DMat3::from_cols(
        DVec3::new(step.x * map.scale.x, 0.0, 0.0),
        DVec3::new(0.0, -step.y * map.scale.y, 0.0),
        zero,
    )
}

fn warp(now: (&Pass, &View), before: (&Pass, &View), moved: &Moved) -> Warp {
    let eye_now = now.1.poses[0];
    let eye_before = before.1.poses[0];
    // With (x, y, −1)·w = C·(i, j, 1)·w the inverse of C gives (i, j, 1)·w back.
    let to_lattice = direction_from_lattice(before.0, before.1).inverse();
    let turned = DMat3::from_quat(eye_before.orientation.conjugate());
    let world_from_lattice =
        DMat3::from_quat(eye_now.orientation) * direction_from_lattice(now.0, now.1);
    let position = to_lattice * turned * moved.linear * world_from_lattice;
    let eye = moved.linear * eye_now.position + moved.shift - eye_before.position;
    let by_depth = to_lattice * (turned * eye);
    let mut warp = [0.0; 12];
    for row in 0..3 {
        let p = position.row(row);
        warp[4 * row..4 * row + 4]
            .copy_from_slice(&[p.x, p.y, p.z, by_depth[row]].map(|v| v as f32));
    }
    warp
}
