use glam::{DQuat, DVec3};

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
            turn: Turn::Axis {
                rate: DVec3::ZERO,
                acceleration: DVec3::ZERO,
            },
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
            Turn::Axis { rate, acceleration } => exp_so3(rate * s + acceleration * half) * q,
            Turn::Components(rate) => q + rate * s,
        };
        Pose::new(position, orientation.normalize())
    }
}
