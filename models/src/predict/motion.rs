use glam::{DQuat, DVec3};

use crate::math::{atan2, sqrt};
use crate::{Nanos, Pose, exp_so3};

/// How a head moves at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist {
    /// Velocity in the world \[m/s\].
    pub velocity: DVec3,
    /// Angular velocity in the world \[rad/s\].
    pub angular_velocity: DVec3,
}

/// A pose at a time and how it goes on from there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// When the head is where `pose` says.
    pub t: Nanos,
    /// Where it is then.
    pub pose: Pose,
    /// Velocity \[m/s\].
    pub velocity: DVec3,
    /// Acceleration \[m/s²\].
    pub acceleration: DVec3,
    /// How it turns.
    pub(super) turn: Turn,
}

/// How an orientation goes on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Turn {
    /// Not at all, nor does it move.
    Still,
    /// By the same rotation and shift \[m\] in every `span`.
    Step {
        rotation: DQuat,
        shift: DVec3,
        span: Nanos,
    },
    /// About an axis of the world: angular velocity \[rad/s\] and acceleration \[rad/s²\].
    Axis { rate: DVec3, acceleration: DVec3 },
    /// Each component of the quaternion along a line \[1/s\], brought back to length 1.
    Components(DQuat),
}

impl Motion {
    /// A head that stays.
    pub fn still(t: Nanos, pose: Pose) -> Self {
        Self {
            t,
            pose,
            velocity: DVec3::ZERO,
            acceleration: DVec3::ZERO,
            turn: Turn::Still,
        }
    }

    /// A head that makes the step from pose `then` at an earlier time to `pose` over and over: constant
    /// velocity, and constant angular velocity on SO(3) by the shorter way.
    pub(super) fn repeating(t: Nanos, pose: Pose, before: Nanos, then: Pose) -> Self {
        let shift = pose.position - then.position;
        Self {
            velocity: shift / (t - before).as_secs(),
            turn: Turn::Step {
                rotation: pose.orientation * then.orientation.conjugate(),
                shift,
                span: t - before,
            },
            ..Self::still(t, pose)
        }
    }

    /// A head that goes on as it moves: constant velocity, and constant angular velocity on SO(3).
    pub fn steady(t: Nanos, pose: Pose, twist: Twist) -> Self {
        Self {
            velocity: twist.velocity,
            turn: Turn::Axis {
                rate: twist.angular_velocity,
                acceleration: DVec3::ZERO,
            },
            ..Self::still(t, pose)
        }
    }

    /// The pose at `t`, before or after.
    pub fn at(&self, t: Nanos) -> Pose {
        let s = (t - self.t).as_secs();
        let half = 0.5 * s * s;
        let position = self.pose.position + self.velocity * s + self.acceleration * half;
        let q = self.pose.orientation;
        let orientation = match self.turn {
            Turn::Still => return self.pose,
            Turn::Step {
                rotation,
                shift,
                span,
            } => {
                // Of whole nanoseconds, and of the step itself: exact where a step ends.
                let f = (t - self.t).0 as f64 / span.0 as f64;
                let orientation = rotation_power(rotation, f) * q;
                return Pose::new(self.pose.position + shift * f, orientation.normalize());
            }
            Turn::Axis { rate, acceleration } => exp_so3(rate * s + acceleration * half) * q,
            Turn::Components(rate) => q + rate * s,
        };
        Pose::new(position, orientation.normalize())
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
