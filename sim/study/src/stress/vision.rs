//! Angles, tangents, acuity and the floor of all methods.

use foveasim_models::foveation::{FloorDensity, Screen, dominance_speedup, ideal_samples};
use foveasim_models::math::{atan_deg, tan_deg};
use foveasim_models::{Acuity, GazeDirection, Viewport};
use glam::{DVec2, DVec3, UVec2};

use super::big::Big;
use super::{Check, Draw, Trial, relative};

pub(super) const CHECKS: &[Check] = &[
    Check {
        quantity: "tangent of half a field of view",
        precision: "f64",
        against: "256 bits, over its condition x(1 + tan² x)/tan x",
        over: "1e-12 to 179.999999 degrees",
        unit: "relative",
        tolerance: 6e-16,
        costs: 20,
        trial: half_tangent,
    },
    Check {
        quantity: "field of view of a viewport",
        precision: "f64",
        against: "256 bits",
        over: "tangents of 1e-9 to 1e9 to either side",
        unit: "relative",
        tolerance: 1e-15,
        costs: 20,
        trial: field_of_view,
    },
    Check {
        quantity: "pixel angle straight ahead",
        precision: "f64",
        against: "256 bits",
        over: "to 179 degrees, 1 to 65536 pixels",
        unit: "relative",
        tolerance: 1e-15,
        costs: 20,
        trial: sharpness,
    },
    Check {
        quantity: "eccentricity of a pixel",
        precision: "f64",
        against: "256 bits",
        over: "gaze anywhere, pixels to 1e-9 beside it, to 179 degrees",
        unit: "deg",
        tolerance: 1e-13,
        costs: 20,
        trial: eccentricity,
    },
    Check {
        quantity: "gaze direction to vector and back",
        precision: "f64",
        against: "identity",
        over: "all directions",
        unit: "deg",
        tolerance: 1e-13,
        costs: 1,
        trial: gaze,
    },
    Check {
        quantity: "minimum angle of resolution",
        precision: "f64",
        against: "256 bits",
        over: "slopes 1e-9 to 10, 0 to 180 degrees",
        unit: "relative",
        tolerance: 3e-16,
        costs: 10,
        trial: acuity,
    },
    Check {
        quantity: "gain of eye dominance (Meng 2020, Eq. 9)",
        precision: "f64",
        against: "256 bits",
        over: "sigma 1e-30 to 1e30",
        unit: "relative",
        tolerance: 1e-15,
        costs: 10,
        trial: dominance,
    },
    Check {
        quantity: "ideal samples where the display limits",
        precision: "f64",
        against: "its pixels",
        over: "1 to 179 degrees, gaze anywhere, slope 1e-9",
        unit: "relative",
        tolerance: 1e-11,
        costs: 500,
        trial: ideal_is_display,
    },
    Check {
        quantity: "ideal samples of a screen and of its parts",
        precision: "f64",
        against: "their sum",
        over: "1 to 179 degrees, slopes 1e-4 to 3",
        unit: "relative",
        tolerance: 2e-6,
        costs: 500,
        trial: ideal_adds_up,
    },
];

fn half_tangent(draw: &mut Draw, step: u32) -> Vec<Trial> {
    let fov = match step {
        0 => 179.999_999,
        1 => 1e-12,
        _ => draw.range(1e-6, 179.999_999),
    };
    let angle = Big::new(fov) / Big::new(2.0) * Big::pi() / Big::new(180.0);
    let exact = angle.tan();
    let one = Big::new(1.0);
    let condition = angle * (one + exact.clone() * exact.clone()) / exact.clone();
    let error = exact.relative(tan_deg(fov / 2.0)) / condition.to_f64();
    Trial::of(error, format!("{fov:e} deg"))
}

fn field_of_view(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let tan = draw.magnitude(1e-9, 1e9);
    let size = UVec2::new(draw.pixels(), 1000);
    let Ok(viewport) = Viewport::new(size, [-tan, tan, 1.0, -1.0]) else {
        return Vec::new();
    };
    let exact = Big::new(tan).atan() * Big::new(360.0) / Big::pi();
    let inverse = atan_deg(tan) * 2.0;
    let error = exact
        .relative(viewport.fov_deg().x)
        .max(exact.relative(inverse));
    Trial::of(error, format!("tangent {tan:e}"))
}

fn sharpness(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let (tan, pixels) = (draw.magnitude(1e-6, 115.0), draw.pixels());
    let Ok(viewport) = Viewport::symmetric(UVec2::splat(pixels), tan) else {
        return Vec::new();
    };
    let step = Big::new(4.0) * Big::new(tan) / Big::new(f64::from(pixels));
    let exact = step.atan() * Big::new(180.0) / Big::pi();
    let error = exact.relative(viewport.sharpness_deg());
    Trial::of(error, format!("tangent {tan:e}, {pixels} pixels"))
}

fn eccentricity(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let tan = draw.magnitude(1e-3, 115.0);
    let size = UVec2::new(draw.pixels(), draw.pixels());
    let Ok(viewport) = Viewport::symmetric(size, tan) else {
        return Vec::new();
    };
    let px = DVec2::new(draw.range(0.0, 1.0), draw.range(0.0, 1.0)) * size.as_dvec2();
    let beside = DVec2::new(draw.signed(1e-9, 1.0), draw.signed(1e-9, 1.0));
    let gaze = match draw.below(3) {
        0 => viewport.gaze_at(px + beside).vector(),
        1 => -viewport.gaze_at(px + beside).vector(),
        _ => GazeDirection::new(draw.range(-180.0, 180.0), draw.range(-90.0, 90.0)).vector(),
    };
    let direction = viewport.direction(px);
    let [a, b] = [direction, gaze].map(|v: DVec3| v.to_array().map(Big::new));
    let minor = |i: usize, k: usize| a[i].clone() * b[k].clone() - a[k].clone() * b[i].clone();
    let square = |v: Big| v.clone() * v;
    let cross = square(minor(1, 2)) + square(minor(2, 0)) + square(minor(0, 1));
    let dot = (0..3).fold(Big::new(0.0), |sum, i| sum + a[i].clone() * b[i].clone());
    let exact = cross.sqrt().atan2(&dot) * Big::new(180.0) / Big::pi();
    let error = exact.off(viewport.eccentricity_deg(px, gaze));
    Trial::of(error, format!("{direction} from {gaze}"))
}

fn gaze(draw: &mut Draw, step: u32) -> Vec<Trial> {
    let (azimuth, elevation) = match step {
        0 => (0.0, 0.0),
        1 => (180.0, 0.0),
        2 => (0.0, 90.0),
        3 => (0.0, -90.0),
        _ => (draw.range(-180.0, 180.0), draw.range(-90.0, 90.0)),
    };
    let gaze = GazeDirection::new(azimuth, elevation);
    let error = GazeDirection::from_vector(gaze.vector()).angle_to_deg(gaze);
    Trial::of(error, format!("{azimuth} {elevation} deg"))
}

fn acuity(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let (slope, e) = (draw.magnitude(1e-9, 10.0), draw.range(0.0, 180.0));
    let Ok(acuity) = Acuity::new(slope) else {
        return Vec::new();
    };
    let exact = Big::new(slope) * Big::new(e) + Big::new(acuity.omega_0_deg());
    let error = exact.relative(acuity.mar_deg(e));
    Trial::of(error, format!("slope {slope:e} at {e} deg"))
}

fn dominance(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let (a, b) = (draw.magnitude(1e-30, 1e30), draw.magnitude(1e-30, 1e30));
    let ratio = Big::new(a) / Big::new(b);
    let exact = Big::new(2.0) / (Big::new(1.0) + ratio.clone() * ratio);
    let error = exact.relative(dominance_speedup(a, b));
    Trial::of(error, format!("{a:e} {b:e}"))
}

/// A screen of any field of view, square or a strip.
fn screen(draw: &mut Draw) -> (f64, f64, f64) {
    let fov = draw.range(1.0, 179.0);
    let tan = tan_deg(fov / 2.0);
    (fov, tan, tan * draw.magnitude(0.01, 1.0))
}

fn ideal_is_display(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let (fov, tan, up) = screen(draw);
    let size = UVec2::new(200, 100);
    let gaze = GazeDirection::new(draw.range(-80.0, 80.0), draw.range(-80.0, 80.0));
    let input = format!("{fov} deg, {up:e} up, {gaze:?}");
    let found = Viewport::new(size, [-tan, tan, up, -up]).and_then(|viewport| {
        // So sharp an eye that the display is coarser everywhere.
        let acuity = Acuity::with_foveal(1e-9, 1e-6)?;
        let screen = Screen::from(&viewport);
        ideal_samples(&screen, acuity, gaze, 0.0, FloorDensity::PerSolidAngle)
    });
    match found {
        Ok(samples) => Trial::of(relative(samples, 20_000.0), input),
        Err(error) => Trial::of(f64::INFINITY, format!("{input}: {error}")),
    }
}

fn ideal_adds_up(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let (fov, tan, up) = screen(draw);
    let slope = draw.magnitude(1e-4, 3.0);
    let gaze = GazeDirection::new(draw.range(-60.0, 60.0), draw.range(-60.0, 60.0));
    // Cut between two columns: the pixels are those of the whole.
    let cut = 1 + draw.below(999) as u32;
    let input = format!("{fov} deg, {up:e} up, slope {slope:e}, cut at {cut}, {gaze:?}");
    let edge = |column: u32| tan * (f64::from(column) / 500.0 - 1.0);
    let samples = |from: u32, to: u32| {
        let size = UVec2::new(to - from, 100);
        let viewport = Viewport::new(size, [edge(from), edge(to), up, -up])?;
        let (screen, acuity) = (Screen::from(&viewport), Acuity::new(slope)?);
        ideal_samples(&screen, acuity, gaze, 0.0, FloorDensity::PerSolidAngle)
    };
    match (samples(0, 1000), samples(0, cut), samples(cut, 1000)) {
        (Ok(whole), Ok(left), Ok(right)) => Trial::of(relative(left + right, whole), input),
        _ => Trial::of(f64::INFINITY, input),
    }
}
