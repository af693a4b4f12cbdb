use glam::{DQuat, DVec3};

use super::Motion;
use super::motion::Turn;
use crate::{Nanos, Pose};

/// Weight of the newest interval in the running mean.
const INTERVAL_WEIGHT: f64 = 0.1;

/// Smoothed, and smoothed once more: their difference is the trend (LaViola 2003, eqs 1 to 5).
///
/// Quaternions are smoothed by components and brought back to length 1, as there. Samples are taken to be
/// evenly spaced: the interval of the trend is a running mean, which no single late sample throws off.
#[derive(Debug, Clone)]
pub(super) struct DoubleExponential {
    alpha: f64,
    position: [DVec3; 2],
    orientation: [DQuat; 2],
    t: Nanos,
    interval_s: f64,
}

impl DoubleExponential {
    pub(super) fn new(alpha: f64, t: Nanos, pose: Pose) -> Self {
        Self {
            alpha,
            position: [pose.position; 2],
            orientation: [pose.orientation; 2],
            t,
            interval_s: 0.0,
        }
    }

    pub(super) fn observe(&mut self, t: Nanos, pose: Pose) {
        let (a, b) = (self.alpha, 1.0 - self.alpha);
        let step = (t - self.t).as_secs();
        self.interval_s = if self.interval_s > 0.0 {
            self.interval_s + INTERVAL_WEIGHT * (step - self.interval_s)
        } else {
            step
        };
        self.t = t;
        self.position[0] = pose.position * a + self.position[0] * b;
        self.position[1] = self.position[0] * a + self.position[1] * b;
        // Of the two signs of a rotation the one that is nearer.
        let q = pose.orientation;
        let q = if q.dot(self.orientation[0]) < 0.0 {
            -q
        } else {
            q
        };
        self.orientation[0] = q * a + self.orientation[0] * b;
        self.orientation[1] = self.orientation[0] * a + self.orientation[1] * b;
    }

    pub(super) fn motion(&self) -> Motion {
        let [s, s2] = self.orientation;
        let level = s * 2.0 - s2;
        let length = level.length();
        let pose = Pose::new(self.position[0] * 2.0 - self.position[1], level / length);
        if self.interval_s <= 0.0 {
            return Motion::still(self.t, pose);
        }
        let trend = self.alpha / (1.0 - self.alpha) / self.interval_s;
        Motion {
            velocity: (self.position[0] - self.position[1]) * trend,
            turn: Turn::Components((s - s2) * (trend / length)),
            ..Motion::still(self.t, pose)
        }
    }
}
