use glam::DVec3;

use super::double_exponential::DoubleExponential;
use super::kalman::Kalman;
use super::motion::Turn;
use super::{KalmanNoise, Motion, Twist};
use crate::error::in_range;
use crate::{ModelError, Nanos, Pose, Sample, log_so3, unknown_name};

/// How a head's pose is predicted from all samples so far.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum HeadPredictor {
    /// The newest pose stays.
    Constant,
    /// Position and each component of the quaternion go on along a line through the two newest poses.
    Linear,
    /// Velocity and angular velocity between the two newest poses go on: a screw-free twist on
    /// ℝ³ × SO(3). For a turn about one axis it is the linear predictor of the angle.
    AngularVelocity,
    /// Acceleration and angular acceleration among the three newest poses go on too.
    Acceleration,
    /// A Kalman filter of constant velocity and white acceleration.
    Kalman(KalmanNoise),
    /// Double exponential smoothing (LaViola 2003) with this weight of the newest sample, 0.001 to
    /// 0.999.
    DoubleExponential(f64),
}

impl HeadPredictor {
    /// Every predictor, with default settings. A weight of 0.7 suits the 60 to 90 Hz of headsets' own poses;
    /// higher rates take a lower one.
    pub const ALL: [Self; 6] = [
        Self::Constant,
        Self::Linear,
        Self::AngularVelocity,
        Self::Acceleration,
        Self::Kalman(KalmanNoise {
            position_m: 0.0005,
            acceleration_m_per_s2: 3.0,
            rotation_deg: 0.05,
            angular_acceleration_deg_per_s2: 500.0,
        }),
        Self::DoubleExponential(0.7),
    ];

    /// Short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Linear => "linear",
            Self::AngularVelocity => "angular-velocity",
            Self::Acceleration => "acceleration",
            Self::Kalman(_) => "kalman",
            Self::DoubleExponential(_) => "double-exponential",
        }
    }

    /// Checks its settings.
    ///
    /// # Errors
    /// If one is out of range; the error names it.
    pub fn validate(self) -> Result<(), ModelError> {
        match self {
            Self::Kalman(noise) => {
                noise.validate()?;
            }
            Self::DoubleExponential(weight) => {
                in_range("double-exponential weight", weight, 0.001..=0.999)?;
            }
            _ => {}
        }
        Ok(())
    }
}

impl std::str::FromStr for HeadPredictor {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let found = Self::ALL.into_iter().find(|p| p.name() == text);
        found.ok_or_else(|| unknown_name("predictor", text, &Self::ALL.map(Self::name)))
    }
}

/// Samples that come sooner than this after the one before tell no velocity: clocks jitter by more, and
/// rounding is divided by less.
const SHORTEST_STEP: Nanos = Nanos(100_000);

/// A predictor that follows a head.
#[derive(Debug, Clone)]
pub struct HeadTracker {
    predictor: HeadPredictor,
    /// Across a hole longer than this no velocity is known.
    max_gap: Nanos,
    /// The newest samples with a value, newest first.
    newest: [Option<(Nanos, Pose)>; 3],
    filter: Option<Filter>,
    motion: Option<Motion>,
    lost: bool,
}

#[derive(Debug, Clone)]
enum Filter {
    Kalman(Box<Kalman>),
    DoubleExponential(DoubleExponential),
}

impl HeadTracker {
    /// A predictor that has seen nothing.
    ///
    /// # Errors
    /// If a setting of the predictor is out of range ([`HeadPredictor::validate`]).
    pub fn new(predictor: HeadPredictor, max_gap: Nanos) -> Result<Self, ModelError> {
        predictor.validate()?;
        Ok(Self {
            predictor,
            max_gap,
            newest: [None; 3],
            filter: None,
            motion: None,
            lost: false,
        })
    }

    /// Takes a sample, later than those before: one that is not later by 0.1 ms tells no
    /// velocity, and all predictors but the constant one pass it over. After a
    /// missing one, and after a hole, the head counts as still until two samples tell its velocity again.
    pub fn observe(&mut self, sample: Sample<Pose>) {
        let Some(pose) = sample.value else {
            self.lost = true;
            return;
        };
        let t = sample.t;
        if let Some((last, _)) = self.newest[0] {
            let least = match self.predictor {
                HeadPredictor::Constant => Nanos::ZERO,
                _ => SHORTEST_STEP,
            };
            if t - last < least {
                return;
            }
            if self.lost || t - last > self.max_gap {
                self.newest = [None; 3];
                self.filter = None;
            }
        }
        self.lost = false;
        self.newest = [Some((t, pose)), self.newest[0], self.newest[1]];
        self.motion = Some(self.estimate(t, pose));
    }

    /// Takes a sample whose velocities were measured, by an IMU say. All predictors but the constant one
    /// go on with them, as [`HeadPredictor::AngularVelocity`] does.
    pub fn observe_moving(&mut self, t: Nanos, pose: Pose, twist: Twist) {
        self.observe(Sample {
            t,
            value: Some(pose),
        });
        if self.predictor != HeadPredictor::Constant {
            self.motion = Some(Motion::steady(t, pose, twist));
        }
    }

    /// How the head moves as far as is known; `None` before the first sample with a value.
    pub fn motion(&self) -> Option<Motion> {
        self.motion
    }

    /// Whether, since the start and the last loss or hole, it has seen the three samples from which any predictor
    /// tells how the head moves.
    pub fn is_settled(&self) -> bool {
        self.newest[2].is_some() && !self.lost
    }

    /// The pose expected at `t`; `None` before the first sample with a value.
    pub fn predict(&self, t: Nanos) -> Option<Pose> {
        self.motion.map(|motion| motion.at(t))
    }

    fn estimate(&mut self, t: Nanos, pose: Pose) -> Motion {
        match self.predictor {
            HeadPredictor::Constant => Motion::still(t, pose),
            HeadPredictor::Linear => self.linear(t, pose),
            HeadPredictor::AngularVelocity => match self.newest[1] {
                Some((before, then)) => Motion::repeating(t, pose, before, then),
                None => Motion::still(t, pose),
            },
            HeadPredictor::Acceleration => self.accelerated(t, pose),
            HeadPredictor::Kalman(noise) => {
                match &mut self.filter {
                    Some(Filter::Kalman(kalman)) => {
                        kalman.observe(t, pose);
                        return kalman.motion();
                    }
                    filter => *filter = Some(Filter::Kalman(Box::new(Kalman::new(noise, t, pose)))),
                }
                Motion::still(t, pose)
            }
            HeadPredictor::DoubleExponential(alpha) => {
                match &mut self.filter {
                    Some(Filter::DoubleExponential(smoothed)) => {
                        smoothed.observe(t, pose);
                        return smoothed.motion();
                    }
                    filter => {
                        let smoothed = DoubleExponential::new(alpha, t, pose);
                        *filter = Some(Filter::DoubleExponential(smoothed));
                    }
                }
                Motion::still(t, pose)
            }
        }
    }

    /// Mean velocities from the sample before number `i` (0 the newest) to it, and the time between \[s\].
    fn twist(&self, i: usize) -> Option<(Twist, f64)> {
        let ((t, now), (before, then)) = (self.newest[i]?, self.newest[i + 1]?);
        let s = (t - before).as_secs();
        let turned = log_so3(now.orientation * then.orientation.conjugate());
        let twist = Twist {
            velocity: (now.position - then.position) / s,
            angular_velocity: turned / s,
        };
        Some((twist, s))
    }

    fn linear(&self, t: Nanos, pose: Pose) -> Motion {
        let still = Motion::still(t, pose);
        let (Some((twist, s)), Some((_, then))) = (self.twist(0), self.newest[1]) else {
            return still;
        };
        // Of the two signs of a rotation the one that is nearer.
        let q = then.orientation;
        let q = if q.dot(pose.orientation) < 0.0 { -q } else { q };
        Motion {
            velocity: twist.velocity,
            turn: Turn::Components((pose.orientation - q) / s),
            ..still
        }
    }

    /// The mean velocities of the two last steps hold at their middles; their difference is the
    /// acceleration, which brings the velocity from the middle of the last step to its end.
    fn accelerated(&self, t: Nanos, pose: Pose) -> Motion {
        let Some((twist, s)) = self.twist(0) else {
            return Motion::still(t, pose);
        };
        let Some((before, s_before)) = self.twist(1) else {
            return Motion::steady(t, pose, twist);
        };
        let between = 0.5 * (s + s_before);
        let change = |now: DVec3, then: DVec3| (now - then) / between;
        let acceleration = change(twist.velocity, before.velocity);
        let angular = change(twist.angular_velocity, before.angular_velocity);
        Motion {
            velocity: twist.velocity + acceleration * (0.5 * s),
            acceleration,
            turn: Turn::Axis {
                rate: twist.angular_velocity + angular * (0.5 * s),
                acceleration: angular,
            },
            ..Motion::still(t, pose)
        }
    }
}

#[cfg(test)]
mod tests;
