//! Kernel foveated rendering and lens-matched shading: their maps against reference values computed
//! independently in high precision, and what their plans promise.

use foveasim_models::foveation::{Aim, Method, Request};
use foveasim_models::{
    Acuity, Eye, GazeDirection, Lattice, LogPolar, Map, Resolve, SamplePlan, Shading, Viewport,
    Visibility,
};
use glam::{DVec2, UVec2};
use proptest::prelude::*;
use serde_json::Value;

fn reference() -> Value {
    serde_json::from_str(include_str!("data/log_polar.json")).unwrap()
}

/// A configuration's display and gaze.
fn configuration(reference: &Value, name: &Value) -> (UVec2, DVec2, f64) {
    let found = &reference["configurations"][name.as_str().unwrap()];
    let pair = |key: &str| {
        let at = |k: usize| found[key][k].as_f64().unwrap();
        DVec2::new(at(0), at(1))
    };
    let log_reach = found["log_reach"].as_f64().unwrap();
    (pair("size").as_uvec2(), pair("gaze"), log_reach)
}

/// Rows of a table with the map they are about: the paper's buffer of W/σ × H/σ.
fn rows(reference: &Value, table: &str) -> Vec<(LogPolar, Vec<f64>)> {
    let rows = reference[table]["rows"].as_array().unwrap();
    let row = |row: &Value| {
        let (display, gaze, log_reach) = configuration(reference, &row[0]);
        let numbers = row.as_array().unwrap()[1..].iter();
        let numbers: Vec<f64> = numbers.map(|v| v.as_f64().unwrap()).collect();
        let samples = display.as_dvec2() / numbers[1];
        let map = LogPolar::new(gaze, display, numbers[0], samples).unwrap();
        assert!((map.log_reach() - log_reach).abs() < 1e-14 * log_reach);
        (map, numbers[2..].to_vec())
    };
    rows.iter().map(row).collect()
}

#[track_caller]
fn close(what: &str, ours: f64, wanted: f64, relative: f64) {
    let error = (ours / wanted - 1.0).abs();
    assert!(error <= relative, "{what}: {ours}, wanted {wanted}");
}

#[test]
fn there_and_back() {
    let reference = reference();
    let rows = rows(&reference, "there_and_back");
    assert_eq!(rows.len(), 280);
    for (map, row) in rows {
        let (p, wanted) = (DVec2::new(row[0], row[1]), DVec2::new(row[2], row[3]));
        let lattice = map.lattice_from_display(p);
        // The reference asks for 1e-12 of the display's size.
        let error = ((lattice - wanted) / map.samples()).abs().max_element();
        assert!(error < 1e-12, "{map:?} at {p}: {lattice}, wanted {wanted}");
        let away = p.distance(map.gaze_px());
        let back = map.display_from_lattice(lattice);
        if away > 1.0 {
            assert!(back.distance(p) < 1e-9, "{map:?} at {p}: {back}");
        } else {
            assert!((back.distance(map.gaze_px()) - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn inverse() {
    let reference = reference();
    for (map, row) in rows(&reference, "inverse") {
        let at = DVec2::new(row[0], row[1]) * map.samples();
        let wanted = DVec2::new(row[2], row[3]);
        let found = map.display_from_lattice(at);
        assert!(
            found.distance(wanted) < 1e-9,
            "{map:?} at {at}: {found}, wanted {wanted}"
        );
    }
}

#[test]
fn density() {
    let reference = reference();
    for (map, row) in rows(&reference, "density") {
        let [outwards, around] = map.step_lengths(map.x_at(row[0]));
        let what = format!("{map:?} at {}", row[0]);
        close(&what, 1.0 / outwards, row[1], 1e-9);
        close(&what, 1.0 / around, row[2], 1e-9);
        close(&what, 1.0 / (outwards * around), row[3], 1e-9);
    }
    for (map, row) in rows(&reference, "radius_of_unit_density") {
        close(&format!("{map:?}"), map.dense_within(), row[0], 1e-9);
    }
}

/// The least display at the gaze: nothing is denser than pixels, or everything is.
#[test]
fn density_without_a_crossing() {
    let map = |alpha, samples| {
        let display = UVec2::new(100, 100);
        LogPolar::new(DVec2::splat(50.0), display, alpha, DVec2::splat(samples)).unwrap()
    };
    assert_eq!(map(0.25, 3.0).dense_within(), 0.0);
    let all = map(0.25, 4000.0).dense_within();
    assert!((all - 50.0 * 2f64.sqrt()).abs() < 1e-9);
    let some = map(0.25, 100.0).dense_within();
    let [a, b] = map(0.25, 100.0).step_lengths(map(0.25, 100.0).x_at(some));
    assert!((a * b - 1.0).abs() < 1e-9 && some > 1.0);
}

/// What of the buffer is drawn, and how much of that is spent where samples are denser than pixels.
#[test]
fn utilisation() {
    let reference = reference();
    for row in reference["utilisation"]["rows"].as_array().unwrap() {
        let (display, gaze, _) = configuration(&reference, &row[0]);
        let alpha = row[1].as_f64().unwrap();
        let plan = plan(&format!("kfr:1:{alpha}"), display, gaze);
        let share = plan.count().samples() as f64 / display.as_dvec2().element_product();
        // Cells at the border are whole here: half a sample in each row, and in each column around.
        close("live share", share, row[2].as_f64().unwrap(), 2e-3);
        let Map::LogPolar(map) = plan.passes[0].map else {
            panic!("{:?}", plan.passes[0].map)
        };
        let half = LogPolar::new(gaze, display, alpha, map.samples() / 2.0).unwrap();
        let oversampled = half.x_at(half.dense_within()) / half.samples().x;
        // The reference counts columns of a coarse grid.
        assert!(
            (oversampled - row[3].as_f64().unwrap()).abs() < 1e-3,
            "{oversampled} of {row}"
        );
    }
}

fn plan(method: &str, display: UVec2, gaze_px: DVec2) -> SamplePlan {
    let viewport = Viewport::symmetric(display, 1.0).unwrap();
    plan_for(method, &request(viewport, viewport.gaze_at(gaze_px)))
}

fn request(viewport: Viewport, gaze: GazeDirection) -> Request {
    Request {
        eye: Eye::Left,
        viewport,
        acuity: Acuity::default(),
        gaze,
        ahead: GazeDirection::AHEAD,
        margin_deg: 0.0,
    }
}

fn plan_for(method: &str, request: &Request) -> SamplePlan {
    method.parse::<Method>().unwrap().plan(request).unwrap()
}

#[test]
fn both_forms_shade_the_same_samples() {
    let display = UVec2::new(1280, 1440);
    let at = DVec2::new(320.0, 1000.0);
    let direct = plan("kfr:1.8:4", display, at);
    let published = plan("kfr:1.8:4:published", display, at);
    assert_eq!(
        direct.passes[0].lattice,
        Lattice::Grid(UVec2::new(712, 800))
    );
    assert_eq!(direct.count().samples(), direct.count().shadings());
    assert_eq!(published.count().samples(), 1280 * 1440);
    assert_eq!(published.count().shadings(), direct.count().shadings());
    let [seen, shaded] = &published.passes[..] else {
        panic!("{} passes", published.passes.len())
    };
    assert_eq!((&seen.shading, seen.shadings()), (&Shading::Nowhere, 0));
    assert_eq!(shaded.visibility, Visibility::Shared(0));
    assert_eq!(
        (shaded.map, &shaded.region),
        (direct.passes[0].map, &direct.passes[0].region)
    );
    assert_eq!(published.resolve, direct.resolve);
}

#[test]
fn the_other_eye_is_coarser() {
    let viewport = Viewport::symmetric(UVec2::new(1280, 1440), 1.0).unwrap();
    let count = |method: &str, eye| {
        let request = Request {
            eye,
            ..request(viewport, GazeDirection::AHEAD)
        };
        plan_for(method, &request).count().shadings()
    };
    let [fine, coarse] = ["kfr:2:4", "kfr:3:4"].map(|method| count(method, Eye::Left));
    for (method, left, right, both) in [
        ("efr:2:3", coarse, fine, fine),
        ("efr:2:3:dominant=left", fine, coarse, fine),
    ] {
        let eyes = [Eye::Left, Eye::Right, Eye::Cyclopean].map(|eye| count(method, eye));
        assert_eq!(eyes, [left, right, both], "{method}");
    }
    let saved = 2.0 * fine as f64 / (fine + coarse) as f64;
    assert!((saved / (18.0 / 13.0) - 1.0).abs() < 2e-3, "{saved}");
}

#[test]
fn filters_are_passed_on() {
    let display = UVec2::new(640, 480);
    let filter = |method: &str| match plan(method, display, DVec2::new(320.0, 240.0)).resolve {
        Resolve::Inverse(filter) => filter,
        other => panic!("{other:?}"),
    };
    let plain = filter("kfr:2:4");
    assert!(plain.smooth_from.is_none() && !plain.mips);
    let all = filter("kfr:2:4:smooth:mips:filter=nearest");
    assert!(all.smooth_from.unwrap() > 100 && all.mips);
    assert_ne!(all.interpolation, plain.interpolation);
}

/// With A = B = 0 lens-matched shading is full resolution; with more it samples each pixel at most once.
#[test]
fn lens_matched_shading() {
    let display = UVec2::new(641, 480);
    let at = DVec2::new(100.3, 400.0);
    let flat = plan("lms:0:0", display, at);
    assert_eq!(flat.count().samples(), 641 * 480);
    for (x, y) in [(0, 0), (640, 479), (100, 400)] {
        let px = UVec2::new(x, y);
        assert_eq!(flat.position(0, px), px.as_dvec2() + 0.5);
    }
    let mut before = flat.count().samples();
    for a in ["0.3", "1", "3", "20"] {
        let samples = plan(&format!("lms:{a}:{a}"), display, at).count().samples();
        assert!(samples < before, "{a}: {samples}");
        before = samples;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    /// Gaze in a corner, off the display or behind the head, kernels of any steepness, odd sizes and single
    /// pixels: every pixel finds a live sample of its own, samples are finite and on the display, and no
    /// more are drawn than the buffer has.
    #[test]
    fn every_pixel_has_a_sample(
        w in prop_oneof![1u32..4, 1u32..300], h in prop_oneof![1u32..4, 1u32..300],
        (az, el) in (-180.0f64..180.0, -90.0f64..90.0), corner: bool, fixed: bool,
        sigma in 0.25f64..8.0, log_alpha in -3.0f64..3.0, (a, b) in (0.0f64..20.0, 0.0f64..20.0),
        method in 0usize..3, picks in prop::collection::vec((0.0f64..1.0, 0.0f64..1.0), 60),
    ) {
        let display = UVec2::new(w, h);
        let viewport = Viewport::new(display, [-1.2, 0.9, 1.0, -0.8]).unwrap();
        let gaze = if corner { viewport.gaze_at(DVec2::ZERO) } else { GazeDirection::new(az, el) };
        let method: Method = match method {
            0 => format!("kfr:{sigma}:{}", log_alpha.exp()),
            1 => format!("kfr:{sigma}:{}:published", log_alpha.exp()),
            _ => format!("lms:{a}:{b}"),
        }.parse().unwrap();
        let method = if fixed { method.with_aim(Aim::FIXED) } else { method };
        let plan = method.plan(&request(viewport, gaze)).unwrap();
        let (index, pass) = (plan.passes.len() - 1, plan.passes.last().unwrap());
        let Lattice::Grid(lattice) = pass.lattice else { panic!("{:?}", pass.lattice) };
        prop_assert!(pass.live() >= 1 && pass.live() <= pass.lattice.samples());
        let pick = |(x, y): (f64, f64), of: UVec2| (DVec2::new(x, y) * of.as_dvec2()).as_uvec2();
        for at in picks {
            let px = pick(at, display).as_dvec2() + 0.5;
            let place = pass.map.lattice_from_display(px);
            prop_assert!(place.is_finite());
            prop_assert!(pass.region.is_live(place.as_uvec2()), "{px} in {pass:?}");
            let sample = pick(at, lattice);
            let position = plan.position(index, sample);
            prop_assert!(position.cmpge(DVec2::ZERO).all() && position.cmple(display.as_dvec2()).all());
            let steps = pass.map.steps(sample.as_dvec2() + 0.5).to_cols_array();
            prop_assert!(!pass.region.is_live(sample) || steps.iter().all(|s| s.is_finite()));
        }
    }
}
