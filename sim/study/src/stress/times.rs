//! Clocks and motion over long times.

use foveasim_models::{Motion, Nanos, Pose, Rate, Twist};
use glam::{DQuat, DVec3};

use super::big::Big;
use super::{Check, Draw, Trial};

pub(super) const CHECKS: &[Check] = &[
    Check {
        quantity: "time of the k-th refresh",
        precision: "integer",
        against: "256 bits, rounded down",
        over: "0.001 Hz to 1 MHz, to 290 years before and after",
        unit: "ns",
        tolerance: 0.0,
        costs: 20,
        trial: tick,
    },
    Check {
        quantity: "first refresh at or after a refresh",
        precision: "integer",
        against: "identity",
        over: "0.001 Hz to 1 MHz, to 290 years before and after",
        unit: "refreshes",
        tolerance: 0.0,
        costs: 1,
        trial: first,
    },
    Check {
        quantity: "milliseconds to nanoseconds",
        precision: "f64",
        against: "256 bits",
        over: "to 100 days of either sign",
        unit: "ns",
        tolerance: 1.5,
        costs: 20,
        trial: from_ms,
    },
    Check {
        quantity: "orientation of a head that keeps turning",
        precision: "f64",
        against: "256 bits, over the angle turned",
        over: "1e-6 to 1000 deg/s, to 10 days",
        unit: "relative",
        tolerance: 4e-16,
        costs: 20,
        trial: turning,
    },
];

const YEARS_290_NS: f64 = 9.1e18;

/// A rate, and the number of one of its ticks within 290 years.
fn rate(draw: &mut Draw) -> Option<(Rate, i64)> {
    let rate = Rate::from_hz("rate", draw.magnitude(1e-3, 1e6)).ok()?;
    let most = YEARS_290_NS * 1e-9 * rate.hz();
    let k = draw.signed(1.0, most.max(2.0)).min(most).max(-most);
    Some((rate, k as i64))
}

fn tick(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let Some((rate, k)) = rate(draw) else {
        return Vec::new();
    };
    let exact = Big::int(i128::from(k)) * Big::new(1e15) / Big::int(rate.micro_hz().into());
    let past = exact - Big::int(rate.tick(k).0.into());
    // From 0 to below 1 is right.
    let error = if past >= Big::new(0.0) && past < Big::new(1.0) {
        0.0
    } else {
        past.abs().to_f64()
    };
    Trial::of(error, format!("tick {k} of {} Hz", rate.hz()))
}

fn first(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let Some((rate, k)) = rate(draw) else {
        return Vec::new();
    };
    let off = rate.first_at_or_after(rate.tick(k)) - k;
    // Rates above 1 GHz would have several ticks in a nanosecond; there are none.
    let consecutive = rate.ticks(k).nth(3) == Some(rate.tick(k + 3));
    let error = if consecutive {
        off.abs() as f64
    } else {
        f64::INFINITY
    };
    Trial::of(error, format!("tick {k} of {} Hz", rate.hz()))
}

fn from_ms(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let ms = draw.signed(1e-9, 8.64e9);
    let exact = Big::new(ms) * Big::new(1e6);
    let error = (exact - Big::int(Nanos::from_ms(ms).0.into()))
        .abs()
        .to_f64();
    Trial::of(error, format!("{ms:e} ms"))
}

fn turning(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let rate = draw.magnitude(1e-6, 1000.0).to_radians();
    let t = Nanos(draw.magnitude(1.0, 8.64e14) as i64);
    let twist = Twist {
        velocity: DVec3::ZERO,
        angular_velocity: DVec3::Y * rate,
    };
    let pose = Pose::new(DVec3::ZERO, DQuat::IDENTITY);
    let q = Motion::steady(Nanos::ZERO, pose, twist).at(t).orientation;
    let half = Big::new(rate) * Big::int(t.0.into()) / Big::new(2e9);
    let (sine, cosine) = (half.sin(), half.cos());
    // The sine of half the angle between the two.
    let off = (sine * Big::new(q.w) - cosine * Big::new(q.y))
        .abs()
        .to_f64();
    let angle = half.to_f64();
    Trial::of(
        off / (1.0 + angle),
        format!("{rate:e} rad/s for {} s", t.as_secs()),
    )
}
