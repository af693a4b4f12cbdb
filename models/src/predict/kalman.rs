use glam::DVec3;
use nalgebra::{Matrix2, RowVector2};

use super::Motion;
use super::motion::Turn;
use crate::error::above;
use crate::math::to_rad;
use crate::{ModelError, Nanos, Pose, exp_so3, log_so3};

/// What a Kalman filter takes a head and its tracker to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KalmanNoise {
    /// Standard deviation of a tracked position, each axis \[m\].
    pub position_m: f64,
    /// Standard deviation of the head's acceleration between samples, each axis \[m/s²\].
    pub acceleration_m_per_s2: f64,
    /// Standard deviation of a tracked orientation, each axis \[deg\].
    pub rotation_deg: f64,
    /// Standard deviation of the head's angular acceleration between samples, each axis \[deg/s²\].
    pub angular_acceleration_deg_per_s2: f64,
}

impl Default for KalmanNoise {
    /// A headset's tracker with noise below a millimetre and of a twentieth of a degree, and a head that
    /// looks about: 500 deg/s² and 3 m/s² are usual in free viewing.
    fn default() -> Self {
        Self {
            position_m: 0.0005,
            acceleration_m_per_s2: 3.0,
            rotation_deg: 0.05,
            angular_acceleration_deg_per_s2: 500.0,
        }
    }
}

impl KalmanNoise {
    /// Checks every number.
    ///
    /// # Errors
    /// If one is not above 0 or not finite; the error names it.
    pub fn validate(self) -> Result<Self, ModelError> {
        above("position_m", self.position_m, 0.0, 1e3)?;
        above(
            "acceleration_m_per_s2",
            self.acceleration_m_per_s2,
            0.0,
            1e6,
        )?;
        above("rotation_deg", self.rotation_deg, 0.0, 180.0)?;
        let turn = self.angular_acceleration_deg_per_s2;
        above("angular_acceleration_deg_per_s2", turn, 0.0, 1e9)?;
        Ok(self)
    }
}

/// Place and velocity of one axis: white acceleration, constant between samples (Bar-Shalom, Li &
/// Kirubarajan 2001, section 6.3.2).
///
/// The three axes have the same noise, so they share one covariance and one gain.
#[derive(Debug, Clone, Copy)]
struct Axis {
    covariance: Matrix2<f64>,
    /// Variances of a measurement and of the acceleration.
    measured: f64,
    acceleration: f64,
}

/// Standard deviation of a velocity of which nothing is known yet, over that of a measurement \[1/s\].
const UNKNOWN_VELOCITY: f64 = 1e3;

impl Axis {
    fn new(measured: f64, acceleration: f64) -> Self {
        let measured = measured * measured;
        let velocity = UNKNOWN_VELOCITY * UNKNOWN_VELOCITY * measured;
        Self {
            covariance: Matrix2::new(measured, 0.0, 0.0, velocity),
            measured,
            acceleration: acceleration * acceleration,
        }
    }

    /// Goes on by `s` seconds to a measurement; how much of what it differs by goes to place and velocity.
    fn gain(&mut self, s: f64) -> [f64; 2] {
        let f = Matrix2::new(1.0, s, 0.0, 1.0);
        let (s2, s3, s4) = (s * s, s * s * s, s * s * s * s);
        let noise = Matrix2::new(0.25 * s4, 0.5 * s3, 0.5 * s3, s2) * self.acceleration;
        let p = f * self.covariance * f.transpose() + noise;
        let h = RowVector2::new(1.0, 0.0);
        let innovation = p[(0, 0)] + self.measured;
        let k = p * h.transpose() / innovation;
        let p = (Matrix2::identity() - k * h) * p;
        // Rounding must not make it lopsided.
        self.covariance = (p + p.transpose()) * 0.5;
        [k[0], k[1]]
    }
}

/// A head's motion, filtered: its place by a linear filter, its orientation by one whose error is a small
/// rotation (multiplicative; Lefferts, Markley & Shuster 1982).
#[derive(Debug, Clone)]
pub(super) struct Kalman {
    place: Axis,
    turn: Axis,
    motion: Motion,
    rate: DVec3,
}

impl Kalman {
    pub(super) fn new(noise: KalmanNoise, t: Nanos, pose: Pose) -> Self {
        let angular = to_rad(noise.angular_acceleration_deg_per_s2);
        Self {
            place: Axis::new(noise.position_m, noise.acceleration_m_per_s2),
            turn: Axis::new(to_rad(noise.rotation_deg), angular),
            motion: Motion::still(t, pose),
            rate: DVec3::ZERO,
        }
    }

    pub(super) fn observe(&mut self, t: Nanos, pose: Pose) {
        let s = (t - self.motion.t).as_secs();
        let expected = self.motion.at(t);
        let [kp, kv] = self.place.gain(s);
        let [ka, kw] = self.turn.gain(s);
        let moved = pose.position - expected.position;
        let turned = log_so3(pose.orientation * expected.orientation.conjugate());
        self.rate += turned * kw;
        let orientation = exp_so3(turned * ka) * expected.orientation;
        self.motion = Motion {
            t,
            pose: Pose::new(expected.position + moved * kp, orientation.normalize()),
            velocity: self.motion.velocity + moved * kv,
            acceleration: DVec3::ZERO,
            turn: Turn::Axis {
                rate: self.rate,
                acceleration: DVec3::ZERO,
            },
        };
    }

    pub(super) fn motion(&self) -> Motion {
        self.motion
    }
}
