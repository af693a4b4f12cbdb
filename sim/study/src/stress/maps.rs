//! Lattices and lenses, there and back.

use foveasim_models::raster::Zenon;
use foveasim_models::{Falloff, Lens, LensMatched, LogPolar, Radial, Reach, exp_so3, log_so3};
use glam::{DVec2, DVec3, UVec2};

use super::big::Big;
use super::{Check, Draw, Trial};

pub(super) const CHECKS: &[Check] = &[
    Check {
        quantity: "log-polar lattice to display and back",
        precision: "f64",
        against: "identity, over the distance from the gaze and L·(α + 1/α)",
        over: "alpha 0.05 to 20, gaze to 1e6 pixels off a display of 1 to 65536",
        unit: "relative",
        tolerance: 4e-15,
        costs: 1,
        trial: log_polar,
    },
    Check {
        quantity: "log-polar radius",
        precision: "f64",
        against: "256 bits, over 1 + L·(1 + α)",
        over: "alpha 0.05 to 20, gaze to 1e6 pixels off",
        unit: "relative",
        tolerance: 1e-15,
        costs: 20,
        trial: log_polar_radius,
    },
    Check {
        quantity: "radial lattice to display and back",
        precision: "f64",
        against: "identity, over the diagonal per room beside the gaze",
        over: "exponents 1 to 16, gaze anywhere on a display of 1 to 65536",
        unit: "of the display's diagonal",
        tolerance: 2e-14,
        costs: 1,
        trial: radial,
    },
    Check {
        quantity: "lens-matched lattice to display and back",
        precision: "f64",
        against: "identity, over the growth of w",
        over: "w to 1e6 times, displays of 1 to 65536",
        unit: "of the display's diagonal",
        tolerance: 2e-13,
        costs: 1,
        trial: lens_matched,
    },
    Check {
        quantity: "lens and its inverse",
        precision: "f64",
        against: "identity, where it is not flat",
        over: "coefficients -0.3 to 100",
        unit: "relative",
        tolerance: 4e-15,
        costs: 1,
        trial: lens,
    },
    Check {
        quantity: "when a scan catches a point (Zenon)",
        precision: "f64",
        against: "what is left of the quadratic, over its terms",
        over: "magnitudes 1e-30 to 1e30 of either sign",
        unit: "relative",
        tolerance: 1e-15,
        costs: 1,
        trial: zenon,
    },
    Check {
        quantity: "rotation vector to quaternion and back",
        precision: "f64",
        against: "identity",
        over: "1e-300 to pi rad",
        unit: "relative",
        tolerance: 1e-14,
        costs: 1,
        trial: rotation,
    },
];

/// A kernel over a display, L, and the display's size.
fn kernel(draw: &mut Draw) -> Option<(LogPolar, f64, DVec2)> {
    let size = UVec2::new(draw.pixels(), draw.pixels());
    let gaze = match draw.below(3) {
        0 => DVec2::new(draw.signed(1e-3, 1e6), draw.signed(1e-3, 1e6)),
        1 => DVec2::ZERO,
        _ => size.as_dvec2() * DVec2::new(draw.range(0.0, 1.0), draw.range(0.0, 1.0)),
    };
    let samples = DVec2::new(draw.magnitude(1.0, 1e5), draw.magnitude(1.0, 1e5));
    let map = LogPolar::new(gaze, size, draw.magnitude(0.05, 20.0), samples).ok()?;
    Some((map, map.log_reach(), size.as_dvec2()))
}

fn log_polar(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let Some((map, reach, size)) = kernel(draw) else {
        return Vec::new();
    };
    let px = size * DVec2::new(draw.range(0.0, 1.0), draw.range(0.0, 1.0));
    let away = (px - map.gaze_px()).length();
    if away < 1.0 {
        return Vec::new();
    }
    let back = map.display_from_lattice(map.lattice_from_display(px));
    let condition = reach * (map.alpha() + 1.0 / map.alpha()) + 1.0;
    // Beside what the pixels' own size is rounded to.
    let error = (back - px).length() / (away * condition + map.gaze_px().length());
    Trial::of(error, format!("{px} of {map:?}"))
}

fn log_polar_radius(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let Some((map, reach, _)) = kernel(draw) else {
        return Vec::new();
    };
    let x = map.samples().x * draw.range(1e-6, 1.0);
    let t = Big::new(x) / Big::new(map.samples().x);
    let exact = (t.pow(&Big::new(map.alpha())) * Big::new(reach)).exp();
    let error = exact.relative(map.radius(x)) / (1.0 + reach * (1.0 + map.alpha()));
    Trial::of(error, format!("{x} of {map:?}"))
}

fn radial(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let size = UVec2::new(draw.pixels(), draw.pixels());
    let place = |draw: &mut Draw| {
        let share = |draw: &mut Draw| [0.0, 1.0, draw.range(0.0, 1.0)][draw.below(3) as usize];
        size.as_dvec2() * DVec2::new(share(draw), share(draw))
    };
    let (gaze, px) = (place(draw), place(draw));
    let reach = [Reach::Corner, Reach::Boundary][draw.below(2) as usize];
    let falloff = Falloff::Power(draw.magnitude(1.0, 16.0));
    let Ok(map) = Radial::new(gaze, size, falloff, reach, draw.magnitude(1e-3, 64.0)) else {
        return Vec::new();
    };
    let back = map.display_from_lattice(map.lattice_from_display(px));
    // What share of the way to a near edge a place is, is known as well as places are beside that way.
    let beyond = size.as_dvec2() - gaze;
    let rooms = [gaze.x, gaze.y, beyond.x, beyond.y];
    let room = rooms.into_iter().filter(|room| *room > 0.0);
    let room = room.fold(f64::INFINITY, f64::min);
    let diagonal = size.as_dvec2().length();
    let error = (back - px).length() / diagonal / (1.0 + diagonal / room);
    Trial::of(error, format!("{px} of {map:?}"))
}

fn lens_matched(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let size = UVec2::new(draw.pixels(), draw.pixels()).as_dvec2();
    let centre = size * DVec2::new(draw.range(0.0, 1.0), draw.range(0.0, 1.0));
    let growth = DVec2::new(draw.magnitude(1e-6, 1e6), draw.magnitude(1e-6, 1e6)) / size;
    let lattice = size * draw.magnitude(1e-3, 1.0);
    let Ok(map) = LensMatched::new(centre, lattice, growth) else {
        return Vec::new();
    };
    let px = size * DVec2::new(draw.range(0.0, 1.0), draw.range(0.0, 1.0));
    let w = 1.0 + growth.dot((px - centre).abs());
    let back = map.display_from_lattice(map.lattice_from_display(px));
    // Lattice positions are as exact as their distance from the lattice's own origin.
    let shift = 1.0 + lattice.length() / size.length() * w;
    let error = (back - px).length() / (size.length() * w * shift);
    Trial::of(error, format!("{px} of {map:?}"))
}

fn lens(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let mut coefficient = || match draw.below(2) {
        0 => draw.range(-0.3, 0.5),
        _ => draw.magnitude(1e-6, 100.0),
    };
    let coefficients = [coefficient(), coefficient()];
    let size = UVec2::new(1000, 1000);
    let centre = DVec2::splat(500.0);
    let Ok(lens) = Lens::new(centre, 1000.0, coefficients, [1.0; 3], size) else {
        return Vec::new();
    };
    // Up to where it is a tenth as steep as at its middle.
    let r = draw.magnitude(1e-12, 1.0).min(0.7 * lens.grows_to());
    let back = lens.panel_radius(lens.seen_radius(r));
    let error = back.map_or(f64::INFINITY, |back| (back - r).abs() / r);
    Trial::of(error, format!("r = {r:e}, {coefficients:?}"))
}

fn zenon(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let mut pair = || {
        [0, 1].map(|_| match draw.below(6) {
            0 => 0.0,
            1 => draw.range(-1.0, 1.0),
            _ => draw.signed(1e-30, 1e30),
        })
    };
    let zenon = Zenon::new(pair(), pair(), pair());
    let Some(t) = zenon.catch() else {
        return Vec::new();
    };
    let error = if t.is_finite() {
        zenon.residual(t)
    } else {
        // Out of range of f64, and so far outside of the scan.
        0.0
    };
    Trial::of(error, format!("{zenon:?}"))
}

/// Beyond π the shorter way is the other one.
const NEARLY_PI: f64 = std::f64::consts::PI - 1e-7;

fn rotation(draw: &mut Draw, step: u32) -> Vec<Trial> {
    let angle = match step {
        0 => 1e-300,
        1 => NEARLY_PI,
        _ => draw.magnitude(1e-300, NEARLY_PI),
    };
    let axis = DVec3::new(draw.range(-1.0, 1.0), draw.range(-1.0, 1.0), 1.0).normalize();
    let back = log_so3(exp_so3(axis * angle));
    let error = ((back - axis * angle) / angle).length();
    Trial::of(error, format!("{angle:e} rad about {axis}"))
}
