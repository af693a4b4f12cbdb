use foveasim_models::math::to_rad;
use foveasim_models::{Pose, ScanSkew};
use glam::{DQuat, DVec3};

/// A scan during which the eye moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanMotion {
    /// The eye at the end of the scan.
    pub end: Pose,
    /// When which pixel lights.
    pub skew: ScanSkew,
}

/// Where a head that turns to the left and up by so many degrees a second, about one axis, and moves to the right, up and
/// backwards by so many metres a second is after `seconds`, as seen from where it was.
pub fn head_after(turn_deg_per_s: [f64; 2], shift_m_per_s: [f64; 3], seconds: f64) -> Pose {
    let [left, up] = turn_deg_per_s;
    let axis = DVec3::new(up, left, 0.0);
    let turn = match axis.try_normalize() {
        Some(unit) => DQuat::from_axis_angle(unit, to_rad(axis.length() * seconds)),
        None => DQuat::IDENTITY,
    };
    Pose::new(DVec3::from(shift_m_per_s) * seconds, turn)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_turn_to_the_left_and_up() {
        let pose = head_after([90.0, 0.0], [0.0, 0.0, -2.0], 0.5);
        let ahead = pose.direction(DVec3::NEG_Z);
        assert!(ahead.x < -0.7 && ahead.y.abs() < 1e-12, "{ahead}");
        assert_eq!(pose.position, DVec3::new(0.0, 0.0, -1.0));
        let up = head_after([0.0, 30.0], [0.0; 3], 1.0).direction(DVec3::NEG_Z);
        assert!((up.y - 0.5).abs() < 1e-12, "{up}");
        assert_eq!(head_after([0.0; 2], [0.0; 3], 9.0), Pose::IDENTITY);
    }
}
