use foveasim_models::Pose;
use glam::{DQuat, DVec3};

const HALF_ROOT: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Axes that devices have, each turned into ours (+X right, +Y up, −Z forward).
#[derive(Debug, Clone, Copy)]
pub(super) enum Axes {
    /// +X right, +Y up, +Z forward: left-handed, as in Unity.
    Unity,
    /// +X left, +Y up, +Z forward: SRanipal, Tobii Glasses, Aria's central pupil frame.
    LeftUpForward,
    /// +X right, +Y down, +Z forward: a camera's.
    RightDownForward,
}

impl Axes {
    /// A direction or a place.
    pub(super) fn vector(self, v: DVec3) -> DVec3 {
        match self {
            Self::Unity => DVec3::new(v.x, v.y, -v.z),
            Self::LeftUpForward => DVec3::new(-v.x, v.y, -v.z),
            Self::RightDownForward => DVec3::new(v.x, -v.y, -v.z),
        }
    }

    /// An angular velocity, or the vector part of a rotation: its sign turns round in a mirror.
    pub(super) fn axial(self, v: DVec3) -> DVec3 {
        match self {
            Self::Unity => -self.vector(v),
            _ => self.vector(v),
        }
    }
}

/// What the poses of a file turn into what.
#[derive(Debug, Clone, Copy)]
pub(super) enum PoseFrame {
    /// A head in Unity's world, both with [`Axes::Unity`].
    Unity,
    /// A device in a world whose +Z is up; the rotation from our head axes to the device's.
    ZUp(DQuat),
}

impl PoseFrame {
    /// A camera's optical frame (+X right, +Y down, +Z forward): half a turn about X, which is exact.
    pub(super) const CAMERA: Self = Self::ZUp(DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0));
    /// Aria's device frame, that of its left camera: +Z forward; −X is up in the published recording
    /// (the world's up has the mean (−0.98, 0.03, −0.13) there).
    pub(super) const ARIA: Self = Self::ZUp(DQuat::from_xyzw(HALF_ROOT, -HALF_ROOT, 0.0, 0.0));
    /// EuRoC's body frame, that of its IMU: +X up, +Y right, +Z forward (Burri et al. 2016, Fig. 4).
    pub(super) const EUROC: Self = Self::ZUp(DQuat::from_xyzw(HALF_ROOT, HALF_ROOT, 0.0, 0.0));

    /// The pose in our frames. A world whose +Z is up is turned by −90° about X.
    pub(super) fn pose(self, p: DVec3, q: DQuat) -> Pose {
        match self {
            Self::Unity => {
                let v = Axes::Unity.axial(q.xyz());
                Pose::new(
                    Axes::Unity.vector(p),
                    DQuat::from_xyzw(v.x, v.y, v.z, q.w).normalize(),
                )
            }
            Self::ZUp(device_from_head) => {
                let ours_from_theirs = DQuat::from_xyzw(-HALF_ROOT, 0.0, 0.0, HALF_ROOT);
                Pose::new(
                    DVec3::new(p.x, p.z, -p.y),
                    (ours_from_theirs * q * device_from_head).normalize(),
                )
            }
        }
    }
}

/// Unity's Euler angles \[deg\]: about Z, then X, then Y, of a frame that does not turn with them.
pub(super) fn unity_euler(deg: DVec3) -> DQuat {
    let [x, y, z] = deg.to_array().map(foveasim_models::math::to_rad);
    DQuat::from_rotation_y(y) * DQuat::from_rotation_x(x) * DQuat::from_rotation_z(z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unity_turns_right_and_looks_down() {
        let pose = |deg| PoseFrame::Unity.pose(DVec3::new(1.0, 2.0, 3.0), unity_euler(deg));
        let right = pose(DVec3::new(0.0, 90.0, 0.0));
        assert_eq!(right.position, DVec3::new(1.0, 2.0, -3.0));
        assert!((right.direction(DVec3::NEG_Z) - DVec3::X).length() < 1e-15);
        let down = pose(DVec3::new(30.0, 0.0, 0.0)).direction(DVec3::NEG_Z);
        assert!((down - DVec3::new(0.0, -0.5, -0.75f64.sqrt())).length() < 1e-15);
        // A head rolled by +90° has its top to the left.
        let rolled = pose(DVec3::new(0.0, 0.0, 90.0)).direction(DVec3::Y);
        assert!((rolled - DVec3::NEG_X).length() < 1e-15, "{rolled}");
        // Yaw is applied last: the direction of a pitched head goes about the vertical.
        let both = pose(DVec3::new(30.0, 90.0, 0.0)).direction(DVec3::NEG_Z);
        assert!((both - DVec3::new(0.75f64.sqrt(), -0.5, 0.0)).length() < 1e-15);
    }

    #[test]
    fn devices_look_where_their_axes_say() {
        for (frame, up, right) in [
            (PoseFrame::CAMERA, DVec3::NEG_Y, DVec3::X),
            (PoseFrame::ARIA, DVec3::NEG_X, DVec3::NEG_Y),
            (PoseFrame::EUROC, DVec3::X, DVec3::Y),
        ] {
            // A device that is not turned looks along its world's +Z, which is up.
            let pose = frame.pose(DVec3::ZERO, DQuat::IDENTITY);
            let ours = |v: DVec3| DVec3::new(v.x, v.z, -v.y);
            assert!((pose.direction(DVec3::NEG_Z) - DVec3::Y).length() < 1e-15);
            assert!((pose.direction(DVec3::Y) - ours(up)).length() < 1e-15);
            assert!((pose.direction(DVec3::X) - ours(right)).length() < 1e-15);
        }
    }
}
