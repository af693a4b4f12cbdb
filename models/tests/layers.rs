//! Eccentricity layers against reference values computed independently in high precision.

use foveasim_models::foveation::{
    Coverage, Estimate, FloorDensity, LayerDesign, LayersSettings, Method, Screen, Weights,
    ideal_samples,
};
use foveasim_models::{Acuity, GazeDirection, SLOPE_A, SLOPE_B};
use serde_json::Value;

/// The reference's own tolerances: P to 1e-6, radii to 5e-4 degrees.
const P_RELATIVE: f64 = 1e-6;
const RADIUS_DEG: f64 = 5e-4;

fn reference() -> Value {
    serde_json::from_str(include_str!("data/guenter_layers.json")).unwrap()
}

/// LG W2363D at 59 cm (Guenter 2012, §5).
fn study() -> Screen {
    Screen::planar(1920.0, 0.51 / 2.0 / 0.59, 1080.0 / 1920.0).unwrap()
}

fn acuity(slope: f64) -> Acuity {
    Acuity::new(slope).unwrap()
}

/// `mA_0.0275_n3star` and the like: acuity, number of layers, s2.
fn set_up(key: &str) -> (Acuity, LayersSettings) {
    let slope = if key.starts_with("mA_") {
        SLOPE_A
    } else {
        SLOPE_B
    };
    let n = key.split("_n").nth(1).unwrap();
    let mut settings = LayersSettings::new(n[..1].parse().unwrap()).unwrap();
    settings.second_scale = key.contains("star").then_some(2.0);
    (acuity(slope), settings)
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap())
        .collect()
}

#[track_caller]
fn close(what: &str, ours: f64, wanted: &Value, relative: f64) {
    let wanted = wanted.as_f64().unwrap();
    assert!(
        (ours / wanted - 1.0).abs() <= relative,
        "{what}: {ours}, wanted {wanted}"
    );
}

#[track_caller]
fn all_close(what: &str, ours: &[f64], wanted: &Value, relative: f64) {
    assert_eq!(
        ours.len(),
        wanted.as_array().unwrap().len(),
        "{what}: {ours:?}"
    );
    ours.iter()
        .zip(wanted.as_array().unwrap())
        .for_each(|(o, w)| close(what, *o, w, relative));
}

fn radii(design: &LayerDesign) -> Vec<f64> {
    design
        .layers()
        .iter()
        .filter_map(|l| l.eccentricity_deg)
        .collect()
}

#[track_caller]
fn radii_close(what: &str, design: &LayerDesign, wanted: &Value, tolerance: f64) {
    let (ours, wanted) = (radii(design), numbers(wanted));
    assert_eq!(ours.len(), wanted.len(), "{what}");
    for (o, w) in ours.iter().zip(&wanted) {
        assert!(
            (o - w).abs() <= tolerance,
            "{what}: {ours:?}, wanted {wanted:?}"
        );
    }
}

#[test]
fn study_display_designs() {
    for (key, case) in reference()["study_layers"].as_object().unwrap() {
        for (name, weights) in [("unit", Weights::Unit), ("half", Weights::Half)] {
            let (acuity, settings) = set_up(key);
            let design = LayersSettings {
                weights,
                ..settings
            }
            .design(&study(), acuity, 0.0)
            .unwrap();
            let (case, what) = (&case[name], format!("{key} {name}"));
            // The minimum itself is flat, so far better than the reference's tolerance.
            close(&what, design.weighted_samples(), &case["P"], 1e-9);
            radii_close(&what, &design, &case["e"], RADIUS_DEG);
            let column = |f: fn(&foveasim_models::foveation::LayerSpec) -> f64| -> Vec<f64> {
                design.layers().iter().map(f).collect()
            };
            // Counts per layer move with the radii: 5e-4 of 1.85 degrees, squared.
            all_close(&what, &column(|l| l.scale), &case["s"], 3e-4);
            all_close(&what, &column(|l| l.width), &case["D"], 3e-4);
            all_close(&what, &column(|l| l.samples), &case["Pi"], 6e-4);
            let both = if weights == Weights::Unit {
                P_RELATIVE
            } else {
                3e-6
            };
            close(&what, design.ratio(), &case["ratio_w1"], both);
            close(
                &what,
                design.ratio_staggered(),
                &case["ratio_half_weighted"],
                1e-5,
            );
        }
    }
}

/// methods.md §2's δ row: the ratio shrinks fast with tracking error.
#[test]
fn margins_cost_samples() {
    let three = LayersSettings::new(3).unwrap();
    for (margin, wanted) in [
        (0.0, 8.498),
        (1.0, 6.641),
        (2.0, 5.255),
        (3.0, 4.218),
        (5.0, 2.837),
    ] {
        let ratio = three
            .design(&study(), acuity(SLOPE_A), margin)
            .unwrap()
            .ratio();
        assert!(
            (ratio - wanted).abs() < 6e-4,
            "margin {margin}: {ratio}, wanted {wanted}"
        );
    }
}

#[test]
fn strict_blending_costs_samples() {
    let Method::Layers(strict) = "layers:3:strict".parse().unwrap() else {
        unreachable!()
    };
    let ratio = strict
        .design(&study(), acuity(SLOPE_A), 0.0)
        .unwrap()
        .ratio();
    assert!((ratio - 4.51).abs() < 5e-3, "{ratio}");
}

/// Figures 12 and 13: a display as sharp as the fovea, 10 to 130 degrees wide.
#[test]
fn prediction_over_field_of_view() {
    for (key, rows) in reference()["fov_curves"].as_object().unwrap() {
        for row in rows.as_array().unwrap() {
            let (acuity, settings) = set_up(key);
            let fov = row["fov"].as_f64().unwrap();
            let what = format!("{key} {fov}");
            let screen = Screen::from_sharpness(fov, acuity, 1.0, 0.75).unwrap();
            close(&what, screen.size_px().x, &row["D_star"], 1e-12);
            close(&what, screen.pixels(), &row["P_star"], 1e-12);
            let design = settings.design(&screen, acuity, 0.0).unwrap();
            close(&what, design.samples(), &row["P"], 1e-9);
            close(&what, design.ratio(), &row["speedup"], P_RELATIVE);
            radii_close(&what, &design, &row["e"], RADIUS_DEG);
        }
    }
}

/// More layers than the paper has, against Newton's method on the literal equations.
#[test]
fn many_layers_reach_the_optimum() {
    for (fov, slope, n, wanted) in [
        (70.0, SLOPE_A, 6, 326_548.496_512_919_66),
        (70.0, SLOPE_A, 8, 307_335.053_037_155),
        (110.0, SLOPE_B, 8, 604_137.000_135_037_8),
    ] {
        let screen = Screen::from_sharpness(fov, acuity(slope), 1.0, 0.75).unwrap();
        let design = LayersSettings::new(n)
            .unwrap()
            .design(&screen, acuity(slope), 0.0)
            .unwrap();
        assert_eq!(design.layers().len(), n);
        assert!(
            (design.samples() / wanted - 1.0).abs() < 1e-9,
            "{fov} {n}: {}",
            design.samples()
        );
    }
}

/// What exhaustive search finds on its grid, dynamic programming finds too.
#[test]
fn grids_agree_with_exhaustive_search() {
    for (key, case) in reference()["brute_force"].as_object().unwrap() {
        let (set, step) = key.rsplit_once('_').unwrap();
        let (acuity, settings) = set_up(set);
        let step = match step.strip_prefix("estar/") {
            Some(parts) => study().reach_deg() / parts.parse::<f64>().unwrap(),
            None => step.trim_end_matches("deg").parse().unwrap(),
        };
        let design = settings
            .design_on_grid(&study(), acuity, 0.0, step)
            .unwrap()
            .unwrap();
        close(key, design.samples(), &case["P"], 1e-12);
        radii_close(key, &design, &case["e"], 1e-9);
    }
}

#[test]
fn gaze_off_centre_is_clipped() {
    for (key, cases) in reference()["gaze_clipping"].as_object().unwrap() {
        let (acuity, settings) = set_up(key);
        let design = settings.design(&study(), acuity, 0.0).unwrap();
        for (place, case) in cases.as_object().unwrap() {
            let what = format!("{key} {place}");
            let px = numbers(&case["gaze"]);
            let gaze = study().direction([px[0], px[1]].into()).normalize();
            let counts =
                |e: &Estimate| -> Vec<f64> { e.passes.iter().map(|p| p.samples).collect() };
            let paper = design.estimate(gaze, Coverage::Paper);
            all_close(
                &what,
                &counts(&paper),
                &case["Pi_translated_clipped"],
                P_RELATIVE,
            );
            close(&what, paper.ratio(), &case["ratio_w1"], P_RELATIVE);
            close(
                &what,
                paper.ratio_staggered(),
                &case["ratio_half"],
                P_RELATIVE,
            );
            let exact = design.estimate(gaze, Coverage::Exact);
            all_close(
                &what,
                &counts(&exact),
                &case["Pi_cone_bbox_clipped"],
                P_RELATIVE,
            );
            close(&what, exact.ratio(), &case["ratio_w1_cone"], P_RELATIVE);
        }
    }
}

/// The slopes at which the staggered ratio equals Guenter's measured 13.3 and 9.8.
#[test]
fn slopes_that_give_the_measured_ratios() {
    for (key, slope) in reference()["slope_for_half_ratio"].as_object().unwrap() {
        let (n, ratio) = key.split_once("_halfweight_ratio_").unwrap();
        let settings = set_up(&format!("any_slope_{n}")).1;
        let design = settings
            .design(&study(), acuity(slope.as_f64().unwrap()), 0.0)
            .unwrap();
        let wanted: f64 = ratio.parse().unwrap();
        assert!(
            (design.ratio_staggered() / wanted - 1.0).abs() < 2e-5,
            "{key}: {}",
            design.ratio_staggered()
        );
    }
}

/// A foveal display 120 degrees wide, slope A, α = ¾: the floor by solid angle and the constant-ω*
/// count per pixel.
#[test]
fn floor_of_a_foveal_display() {
    let screen = Screen::from_sharpness(120.0, acuity(SLOPE_A), 1.0, 0.75).unwrap();
    let ratio = |density| {
        let ideal =
            ideal_samples(&screen, acuity(SLOPE_A), GazeDirection::AHEAD, 0.0, density).unwrap();
        screen.pixels() / ideal
    };
    assert!(
        (ratio(FloorDensity::PerSolidAngle) - 2489.0).abs() < 0.5,
        "{}",
        ratio(FloorDensity::PerSolidAngle)
    );
    assert!(
        (ratio(FloorDensity::PerPixel) - 1752.0).abs() < 0.5,
        "{}",
        ratio(FloorDensity::PerPixel)
    );
}
