use glam::DQuat;

use crate::math::{atan2, sqrt};
use crate::{Nanos, Pose, Sample};

/// How head pose is predicted for the time a frame is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum PosePredictor {
    /// The newest pose is used as it is.
    #[default]
    Constant,
    /// The velocity and angular velocity between the two newest poses go on.
    Linear,
}

impl PosePredictor {
    /// The pose expected at `t` from the newest pose and the one before it, if any. Without one, or
    /// with one that is not earlier, there is no velocity, and the newest is used as it is. Whether the
    /// two belong together, and how far ahead of them `t` may be, is for the caller to judge.
    pub fn predict(
        self,
        newest: Sample<Pose>,
        before: Option<Sample<Pose>>,
        t: Nanos,
    ) -> Option<Pose> {
        let now = newest.value?;
        let (Self::Linear, Some(before)) = (self, before) else {
            return Some(now);
        };
        let (Some(then), span) = (before.value, newest.t - before.t) else {
            return Some(now);
        };
        if span <= Nanos::ZERO {
            return Some(now);
        }
        let f = (t - newest.t).0 as f64 / span.0 as f64;
        let position = now.position + (now.position - then.position) * f;
        let step = now.orientation * then.orientation.conjugate();
        Some(Pose::new(
            position,
            (rotation_power(step, f) * now.orientation).normalize(),
        ))
    }
}

/// The rotation about the same axis by `f` times the (shorter) angle.
fn rotation_power(q: DQuat, f: f64) -> DQuat {
    let q = if q.w < 0.0 { -q } else { q };
    let axis = q.xyz();
    let sine = sqrt(axis.length_squared());
    if sine < 1e-12 {
        return DQuat::IDENTITY;
    }
    let angle = 2.0 * atan2(sine, q.w);
    DQuat::from_axis_angle(axis / sine, angle * f)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn linear_is_exact_for_constant_velocity() {
        let pose = |s: f64| Sample {
            t: Nanos::from_secs(s),
            value: Some(Pose::new(DVec3::X * s, DQuat::from_rotation_y(2.0 * s))),
        };
        let t = Nanos::from_secs(0.5);
        let got = PosePredictor::Linear
            .predict(pose(0.2), Some(pose(0.1)), t)
            .unwrap();
        let want = pose(0.5).value.unwrap();
        assert!((got.position - want.position).length() < 1e-12);
        assert!(got.angle_to_deg(want) < 1e-10);
        let held = PosePredictor::Constant
            .predict(pose(0.2), Some(pose(0.1)), t)
            .unwrap();
        assert_eq!(held, pose(0.2).value.unwrap());
    }
}
