use glam::DQuat;

use super::*;
use crate::math::{cos, sin, sqrt};
use crate::{exp_so3, math};

const GAP: Nanos = Nanos(100_000_000);

fn tracker(predictor: HeadPredictor) -> HeadTracker {
    HeadTracker::new(predictor, GAP).unwrap()
}

fn sample(t: Nanos, pose: Pose) -> Sample<Pose> {
    Sample {
        t,
        value: Some(pose),
    }
}

/// A turn of A·sin 2πft about Y and a movement of B·sin 2πft along X.
struct Sway {
    deg: f64,
    metres: f64,
    hz: f64,
}

impl Sway {
    fn phase(&self, t: Nanos) -> f64 {
        std::f64::consts::TAU * self.hz * t.as_secs()
    }

    fn pose(&self, t: Nanos) -> Pose {
        let s = sin(self.phase(t));
        let angle = math::to_rad(self.deg) * s;
        Pose::new(DVec3::X * (self.metres * s), exp_so3(DVec3::Y * angle))
    }

    fn twist(&self, t: Nanos) -> Twist {
        let rate = std::f64::consts::TAU * self.hz * cos(self.phase(t));
        Twist {
            velocity: DVec3::X * (self.metres * rate),
            angular_velocity: DVec3::Y * (math::to_rad(self.deg) * rate),
        }
    }
}

/// RMS errors of rotation [deg] and translation [m] over ten whole periods of 1 Hz, sampled at 1 kHz.
fn rms(predictor: HeadPredictor, sway: &Sway, ahead: Nanos, measured: bool) -> (f64, f64) {
    let mut head = tracker(predictor);
    let (mut turned, mut moved) = (0.0, 0.0);
    // The first period tells the velocities.
    for ms in 0..11_000 {
        let t = Nanos(ms * 1_000_000);
        if measured {
            head.observe_moving(t, sway.pose(t), sway.twist(t));
        } else {
            head.observe(sample(t, sway.pose(t)));
        }
        if ms >= 1000 {
            let (got, want) = (head.predict(t + ahead).unwrap(), sway.pose(t + ahead));
            turned += got.angle_to_deg(want) * got.angle_to_deg(want);
            moved += (got.position - want.position).length_squared();
        }
    }
    (sqrt(turned / 1e4), sqrt(moved / 1e4))
}

const SWAY: Sway = Sway {
    deg: 20.0,
    metres: 0.1,
    hz: 1.0,
};

/// |e^{ix} − 1 − v| for the velocity v that a predictor assumes, over √2: the RMS error for amplitude 1.
fn closed_form(x: f64, re: f64, im: f64) -> f64 {
    let (re, im) = (cos(x) - 1.0 - re, sin(x) - im);
    sqrt(0.5 * (re * re + im * im))
}

#[test]
fn a_constant_pose_has_its_closed_form() {
    for ms in [5.0, 16.7, 60.0] {
        let ahead = Nanos::from_ms(ms);
        let want = std::f64::consts::SQRT_2 * sin(std::f64::consts::PI * ahead.as_secs()).abs();
        let (deg, m) = rms(HeadPredictor::Constant, &SWAY, ahead, false);
        assert!(
            (deg - 20.0 * want).abs() < 1e-6 && (m - 0.1 * want).abs() < 1e-6,
            "{ms}: {deg} {m}"
        );
        assert_eq!(
            rms(HeadPredictor::Constant, &SWAY, ahead, true),
            (deg, m),
            "it uses no velocity"
        );
    }
    let (deg, _) = rms(HeadPredictor::Constant, &SWAY, Nanos::from_ms(16.7), false);
    assert!((deg - 1.4832).abs() < 1e-3, "{deg}");
}

#[test]
fn true_velocity_has_its_closed_form() {
    for ms in [5.0, 16.7, 60.0] {
        let ahead = Nanos::from_ms(ms);
        let x = std::f64::consts::TAU * ahead.as_secs();
        let want = closed_form(x, 0.0, x);
        let (deg, m) = rms(HeadPredictor::AngularVelocity, &SWAY, ahead, true);
        assert!(
            (deg - 20.0 * want).abs() < 1e-6 && (m - 0.1 * want).abs() < 1e-6,
            "{ms}: {deg} {m}"
        );
    }
    let (deg, _) = rms(
        HeadPredictor::AngularVelocity,
        &SWAY,
        Nanos::from_ms(16.7),
        true,
    );
    assert!((deg - 0.0778).abs() < 1e-4, "{deg}");
}

/// The velocity between two samples h apart is that at their middle and a little less: (1 − e^{−iωh})/h.
#[test]
fn backward_differences_have_their_closed_form() {
    for ms in [5.0, 16.7, 60.0] {
        let ahead = Nanos::from_ms(ms);
        let (x, wh) = (
            std::f64::consts::TAU * ahead.as_secs(),
            std::f64::consts::TAU * 1e-3,
        );
        let steps = ahead.as_secs() / 1e-3;
        let want = closed_form(x, steps * (1.0 - cos(wh)), steps * sin(wh));
        let (deg, m) = rms(HeadPredictor::AngularVelocity, &SWAY, ahead, false);
        assert!(
            (deg - 20.0 * want).abs() < 1e-6 && (m - 0.1 * want).abs() < 1e-6,
            "{ms}: {deg} {m}"
        );
        // By components it is the same in position, and in a turn to third order in its angle.
        let (by_parts, same) = rms(HeadPredictor::Linear, &SWAY, ahead, false);
        assert!((same - m).abs() < 1e-12);
        let angle = math::to_rad(20.0) * x;
        assert!(
            (by_parts - deg).abs() < math::to_deg(angle * angle * angle / 12.0),
            "{by_parts} {deg}"
        );
    }
}

#[test]
fn acceleration_and_filters_come_closer_on_smooth_motion() {
    let ahead = Nanos::from_ms(30.0);
    let deg = |p| rms(p, &SWAY, ahead, false).0;
    let [constant, _, steady, accelerated, kalman, smoothed] = HeadPredictor::ALL.map(deg);
    assert!(accelerated < 0.2 * steady && steady < 0.15 * constant);
    assert!(
        kalman < 0.3 * constant && smoothed < 0.15 * constant,
        "{kalman} {smoothed}"
    );
}

/// A head that turns about a tilted axis and moves steadily, between rotations of both signs of w.
#[test]
fn steady_motion_is_predicted_exactly() {
    let pose = |t: Nanos| {
        let s = t.as_secs();
        let turn = exp_so3(DVec3::new(0.5, 1.0, -0.3) * s) * DQuat::from_rotation_x(0.4);
        let turn = if t.0 % 3 == 0 { -turn } else { turn };
        Pose::new(DVec3::new(1.0, 2.0, -0.5) * s, turn)
    };
    for predictor in HeadPredictor::ALL {
        let mut head = tracker(predictor);
        // Irregular steps of 8 to 16 ms; smoothing takes even ones.
        let even = matches!(predictor, HeadPredictor::DoubleExponential(_));
        let mut t = Nanos::ZERO;
        for k in 0..300 {
            t += Nanos::from_ms(if even {
                10.0
            } else {
                8.0 + f64::from(k * 5 % 9)
            });
            head.observe(sample(t, pose(t)));
        }
        let later = t + Nanos::from_ms(30.0);
        let (got, want) = (head.predict(later).unwrap(), pose(later));
        let (mm, deg) = (
            1e3 * (got.position - want.position).length(),
            got.angle_to_deg(want),
        );
        let (bound_mm, bound_deg) = match predictor {
            HeadPredictor::Constant => (70.0, 2.1),
            HeadPredictor::AngularVelocity | HeadPredictor::Acceleration => (1e-9, 1e-9),
            // Components of a quaternion do not go along lines; a filter forgets its start.
            HeadPredictor::Linear => (1e-9, 0.02),
            _ => (0.01, 0.02),
        };
        assert!(
            mm < bound_mm && deg < bound_deg,
            "{}: {mm} {deg}",
            predictor.name()
        );
    }
}

#[test]
fn noise_is_filtered() {
    let noise = |k: i64, salt: i64| {
        let x = (k * 7919 + salt * 104_729).rem_euclid(1009) as f64 / 1009.0;
        x - 0.5
    };
    let error = |predictor| {
        let mut head = tracker(predictor);
        let mut worst = 0.0f64;
        for k in 0..1000i64 {
            let t = Nanos(k * 14_000_000);
            let turn = DVec3::new(noise(k, 1), noise(k, 2), noise(k, 3)) * math::to_rad(0.17);
            head.observe(sample(t, Pose::new(DVec3::ZERO, exp_so3(turn))));
            if k > 100 {
                let still = Pose::IDENTITY;
                worst = worst.max(
                    head.predict(t + Nanos::from_ms(40.0))
                        .unwrap()
                        .angle_to_deg(still),
                );
            }
        }
        worst
    };
    let [constant, linear, _, accelerated, kalman, _] = HeadPredictor::ALL.map(error);
    assert!(
        constant < linear && linear < accelerated,
        "{constant} {linear} {accelerated}"
    );
    assert!(kalman < 0.8 * linear, "{kalman} {linear}");
}

#[test]
fn losses_holes_and_equal_times() {
    let at = |ms: f64| {
        sample(
            Nanos::from_ms(ms),
            Pose::new(DVec3::X * ms, DQuat::IDENTITY),
        )
    };
    for predictor in HeadPredictor::ALL {
        let x = |head: &HeadTracker, ms: f64| head.predict(Nanos::from_ms(ms)).unwrap().position.x;
        let mut head = tracker(predictor);
        assert!(head.predict(Nanos::ZERO).is_none() && head.motion().is_none());
        head.observe(at(0.0));
        assert_eq!(x(&head, 50.0), 0.0, "one sample has no velocity");
        head.observe(at(10.0));
        let before = x(&head, 20.0);
        head.observe(at(10.0));
        head.observe(at(5.0));
        assert_eq!(x(&head, 20.0), before, "what is not later is passed over");
        head.observe(Sample {
            t: Nanos::from_ms(20.0),
            value: None,
        });
        head.observe(at(30.0));
        assert_eq!(x(&head, 60.0), 30.0, "after a loss the head is still");
        head.observe(at(40.0));
        head.observe(at(400.0));
        assert_eq!(x(&head, 500.0), 400.0, "and after a hole");
    }
}

#[test]
fn names_and_settings() {
    for predictor in HeadPredictor::ALL {
        assert_eq!(
            predictor.name().parse::<HeadPredictor>().unwrap(),
            predictor
        );
    }
    let error = "kalmann".parse::<HeadPredictor>().unwrap_err().to_string();
    assert!(error.contains("did you mean `kalman`"), "{error}");
    assert_eq!(
        HeadPredictor::ALL[4],
        HeadPredictor::Kalman(KalmanNoise::default())
    );
    let refused = |p| HeadTracker::new(p, GAP).unwrap_err().to_string();
    assert!(refused(HeadPredictor::DoubleExponential(1.0)).contains("weight = 1"));
    let noise = KalmanNoise {
        rotation_deg: f64::NAN,
        ..KalmanNoise::default()
    };
    assert!(refused(HeadPredictor::Kalman(noise)).contains("rotation_deg = NaN"));
}

#[test]
fn samples_too_soon_are_news_for_the_constant_predictor_alone() {
    for predictor in HeadPredictor::ALL {
        let mut head = tracker(predictor);
        for (us, x) in [(0, 0.0), (50, 1.0)] {
            head.observe(Sample {
                t: Nanos(us * 1000),
                value: Some(Pose::new(DVec3::X * x, DQuat::IDENTITY)),
            });
        }
        let x = head.predict(Nanos::from_ms(20.0)).unwrap().position.x;
        let want = f64::from(u8::from(predictor == HeadPredictor::Constant));
        assert_eq!(x, want, "{predictor:?}");
    }
}
