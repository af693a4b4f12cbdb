use glam::DVec3;

use super::Screen;
use super::quadrature::{adaptive, gauss, root};
use super::request::margin;
use crate::math::{DEG_PER_RAD, atan2, cos, exp, log, sin, to_rad};
use crate::{Acuity, GazeDirection, ModelError};

/// What a continuous falloff may not exceed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FloorDensity {
    /// Samples per solid angle: what the eye can tell there, or the display shows there, whichever is
    /// less. The floor.
    #[default]
    PerSolidAngle,
    /// A share (ω*/ω(e))² of each display pixel, with the ω* of the axis everywhere. No floor on a
    /// planar display, whose pixels shrink as cos³ off the axis; for comparison with work that counts
    /// this way.
    PerPixel,
}

/// The relative error [`ideal_samples`] stays within.
pub const IDEAL_RELATIVE_ERROR: f64 = 1e-6;

/// Samples an ideal method needs: one whose density falls off continuously, which every method is
/// compared with.
///
/// N = ∫ min( (2/ω(max(0, e − δ)))², d(θ) ) dΩ over the screen's solid angle in square degrees, with e
/// the angle from `gaze` (eye frame), δ = `margin_deg`, ω the acuity line (two samples per cycle along
/// each axis), and d = 1/(pixel area · cos³θ) the display's own pixels per square degree, θ from the
/// axis. [`FloorDensity::PerPixel`] replaces the first term by d·(ω*/ω)².
///
/// The integral is taken in polar coordinates about the gaze, so that the acuity line's cusp is its
/// origin: along each ray in closed form where the display limits and by Gauss–Legendre pieces in
/// ln ω where the eye does, split where the two densities cross; and over ray directions
/// adaptively between the corners of the screen. Good to [`IDEAL_RELATIVE_ERROR`].
///
/// # Errors
/// If the margin is not from 0 to 90 degrees.
pub fn ideal_samples(
    screen: &Screen,
    acuity: Acuity,
    gaze: GazeDirection,
    margin_deg: f64,
    density: FloorDensity,
) -> Result<f64, ModelError> {
    margin(margin_deg)?;
    let g = gaze.vector();
    let (u, v) = frame(g);
    let [left, right, up, down] = screen.tan();
    let corners = [(left, up), (right, up), (right, down), (left, down)];
    // Rays through the corners, and those that meet an edge's plane at the right angle: there a circle
    // about the gaze first touches the edge, and an integrand may change within a narrow fan.
    let corners = corners.map(|(x, y)| DVec3::new(x, y, -1.0));
    let feet = inwards(screen).map(|n| -n);
    let mut turns: Vec<f64> = corners
        .into_iter()
        .chain(feet)
        .map(|d| atan2(d.dot(v), d.dot(u)))
        .collect();
    turns.sort_by(f64::total_cmp);
    turns.push(turns[0] + std::f64::consts::TAU);
    let floor = Floor {
        screen,
        acuity,
        margin: to_rad(margin_deg),
        density,
        gaze: g,
    };
    // A tenth: at a kink, where a margin or a crossing meets the screen's edge, the estimate of each
    // piece may be too low.
    Ok(adaptive(&turns, IDEAL_RELATIVE_ERROR / 10.0, |turn| {
        floor.along(u * cos(turn) + v * sin(turn))
    }))
}

/// Two unit vectors that make a right-handed frame with the unit vector `g`.
fn frame(g: DVec3) -> (DVec3, DVec3) {
    let side = if g.y.abs() < 0.9 { DVec3::Y } else { DVec3::X };
    let u = side.cross(g).normalize();
    (u, g.cross(u))
}

/// For each edge of the screen the normal of the plane through it and the eye, towards the screen.
fn inwards(screen: &Screen) -> [DVec3; 4] {
    let [left, right, up, down] = screen.tan();
    [
        DVec3::new(1.0, 0.0, left),
        DVec3::new(-1.0, 0.0, -right),
        DVec3::new(0.0, -1.0, -up),
        DVec3::new(0.0, 1.0, down),
    ]
}

struct Floor<'a> {
    screen: &'a Screen,
    acuity: Acuity,
    /// [rad]
    margin: f64,
    density: FloorDensity,
    gaze: DVec3,
}

impl Floor<'_> {
    /// ∫ density · sin e de along the great circle that leaves the gaze towards unit vector
    /// `towards`, within the screen.
    fn along(&self, towards: DVec3) -> f64 {
        let Some([from, to]) = self.on_screen(towards) else {
            return 0.0;
        };
        let mut total = 0.0;
        let knee = self.margin.clamp(from, to);
        // Within the margin the eye's density is constant; beyond, it changes evenly in ln ω.
        for (a, b) in [(from, knee), (knee, to)] {
            if a < b {
                total += self.piece(towards, a, b);
            }
        }
        total
    }

    /// The part of the great circle on the screen: angles from the gaze [rad], within 0..π. Each edge
    /// of the screen and the eye span a plane, on one side of which the screen lies.
    fn on_screen(&self, towards: DVec3) -> Option<[f64; 2]> {
        use std::f64::consts::{FRAC_PI_2, PI, TAU};
        let (mut from, mut to) = (0.0, PI);
        for n in inwards(self.screen) {
            // n·(g·cos e + t·sin e) ≥ 0 within a right angle of its maximum.
            let mut peak = atan2(n.dot(towards), n.dot(self.gaze));
            if peak < -FRAC_PI_2 {
                peak += TAU;
            }
            from = f64::max(from, peak - FRAC_PI_2);
            to = f64::min(to, peak + FRAC_PI_2);
        }
        (from < to).then_some([from, to])
    }

    /// Part of [`Floor::along`] without the knee.
    fn piece(&self, towards: DVec3, a: f64, b: f64) -> f64 {
        // How finely crossings are looked for, and how many Gauss pieces a whole ray takes: in ln ω the
        // integrand is smooth, and a piece spans at most a factor e³ of ω.
        const PROBES: usize = 12;
        const PIECES: f64 = 4.0;
        let slope = self.acuity.slope();
        let omega_0 = to_rad(self.acuity.omega_0_deg());
        let curved = a >= self.margin && slope * (b - a) > 1e-3 * omega_0;
        // e as a function of the variable of integration x, and de/dx.
        let (x0, x1) = if curved {
            (
                log(slope * (a - self.margin) + omega_0),
                log(slope * (b - self.margin) + omega_0),
            )
        } else {
            (a, b)
        };
        let angle = |x: f64| {
            if curved {
                let omega = exp(x);
                (self.margin + (omega - omega_0) / slope, omega / slope)
            } else {
                (x, 1.0)
            }
        };
        let excess = |x: f64| {
            let e = angle(x).0;
            let (eye, display) = self.densities(towards, e, sin(e), cos(e));
            log(eye / display)
        };
        // From `from` to `to` one of the two limits.
        let run = |from: f64, to: f64, display_limits: bool| {
            if display_limits {
                return self.display_samples(towards, angle(from).0, angle(to).0);
            }
            let pieces = ((to - from) / (x1 - x0) * PIECES).ceil().max(1.0);
            let width = (to - from) / pieces;
            let ends = (0..pieces as u32).map(|k| from + width * f64::from(k));
            let piece = |from: f64| {
                gauss(from, from + width, |x| {
                    let (e, rate) = angle(x);
                    let (sine, cosine) = (sin(e), cos(e));
                    self.densities(towards, e, sine, cosine).0 * sine * rate
                })
            };
            ends.map(piece).sum()
        };
        let mut total = 0.0;
        let (mut from, mut display_limits) = (x0, excess(x0) >= 0.0);
        let mut previous = x0;
        for probe in 1..=PROBES {
            let x = x0 + (x1 - x0) * probe as f64 / PROBES as f64;
            if (excess(x) >= 0.0) != display_limits {
                // Where the densities differ by a millionth it does not matter which one is taken.
                let crossing = root(previous, x, 1e-6, excess);
                total += run(from, crossing, display_limits);
                (from, display_limits) = (crossing, !display_limits);
            }
            previous = x;
        }
        total + run(from, x1, display_limits)
    }

    /// ∫ display density · sin e de along the great circle: with cos θ = p·cos e + q·sin e,
    /// ∫ sin e / cos³θ de = sin²e / (2p·cos²θ) = −cos e·(p·cos e + 2q·sin e) / (2q²·cos²θ), up to a
    /// constant.
    fn display_samples(&self, towards: DVec3, from: f64, to: f64) -> f64 {
        let (p, q) = (-self.gaze.z, -towards.z);
        let antiderivative = |e: f64| {
            let (sine, cosine) = (sin(e), cos(e));
            let from_axis = p * cosine + q * sine;
            let squared = 2.0 * from_axis * from_axis;
            if p.abs() >= q.abs() {
                sine * sine / (p * squared)
            } else {
                -cosine * (p * cosine + 2.0 * q * sine) / (q * q * squared)
            }
        };
        let pixel = self.screen.pixel_tan();
        (antiderivative(to) - antiderivative(from)) / (pixel.x * pixel.y)
    }

    /// What the eye and the display allow at angle `e` [rad] along the great circle \[per sr\].
    fn densities(&self, towards: DVec3, e: f64, sine: f64, cosine: f64) -> (f64, f64) {
        let from_axis = -(self.gaze.z * cosine + towards.z * sine);
        let pixel = self.screen.pixel_tan();
        let display = 1.0 / (pixel.x * pixel.y * (from_axis * from_axis * from_axis).max(1e-300));
        let omega_deg = self.acuity.mar_deg((e - self.margin) * DEG_PER_RAD);
        let eye = match self.density {
            FloorDensity::PerSolidAngle => {
                let per_radian = 2.0 * DEG_PER_RAD / omega_deg;
                per_radian * per_radian
            }
            FloorDensity::PerPixel => {
                let share = self.screen.sharpness_deg() / omega_deg;
                display * share * share
            }
        };
        (eye, display)
    }
}
