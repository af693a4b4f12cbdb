//! Promises of drawn plans and of the floor, for any image, gaze and acuity.

use foveasim_models::foveation::{
    FloorDensity, LayersSettings, Method, Request, Screen, Weights, ideal_samples,
};
use foveasim_models::{
    Acuity, Affine, Eye, Feather, GazeDirection, Lattice, Map, Pass, Resolve, SamplePlan, Viewport,
    presets,
};
use glam::{DVec2, UVec2};
use proptest::prelude::*;

fn grid(pass: &Pass) -> (UVec2, Affine) {
    match (pass.lattice, pass.map) {
        (Lattice::Grid(size), Map::Affine(map)) => (size, map),
        other => panic!("layers are affine grids, not {other:?}"),
    }
}

fn feather(plan: &SamplePlan) -> Option<&Feather> {
    match &plan.resolve {
        Resolve::Feather(feather) => Some(feather),
        _ => None,
    }
}

/// Tangents of the image's edges, pixels, and everything else a request holds.
fn requests() -> impl Strategy<Value = (Request, LayersSettings)> {
    let edges = (0.05f64..2.0, 0.05f64..2.0, 0.05f64..2.0, 0.05f64..2.0);
    let size = (1u32..2500, 1u32..2500);
    let gaze = (-80.0f64..80.0, -70.0f64..70.0);
    let method = (
        1usize..7,
        any::<bool>(),
        any::<bool>(),
        prop::option::of(1.0f64..6.0),
    );
    (
        edges,
        size,
        gaze,
        method,
        0.0f64..0.08,
        prop_oneof![Just(0.0), 0.0f64..20.0],
    )
        .prop_map(
            |((l, r, u, d), (w, h), (az, el), (n, strict, half, pin), slope, margin_deg)| {
                let mut settings = LayersSettings::new(n).unwrap();
                if strict {
                    settings.blending = foveasim_models::foveation::Blending::Strict;
                }
                if half {
                    settings.weights = Weights::Half;
                }
                settings.second_scale = pin.filter(|_| n > 1);
                let request = Request {
                    eye: Eye::Left,
                    viewport: Viewport::new(UVec2::new(w, h), [-l, r, u, -d]).unwrap(),
                    acuity: Acuity::new(slope).unwrap(),
                    gaze: GazeDirection::new(az, el),
                    ahead: GazeDirection::AHEAD,
                    margin_deg,
                };
                (request, settings)
            },
        )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn drawn_layers_keep_their_promises(case in requests(), picks in prop::collection::vec((0.0f64..1.0, 0.0f64..1.0), 60)) {
        let (request, settings) = case;
        let method = Method::Layers(settings);
        let plan = method.plan(&request).unwrap();
        prop_assert_eq!(&plan.method, &method.to_string());
        prop_assert_eq!(plan.method.parse::<Method>().unwrap(), method);
        prop_assert!(!plan.passes.is_empty() && plan.passes.len() <= settings.count);
        let edge = request.viewport.size.as_dvec2();
        for (i, pass) in plan.passes.iter().enumerate() {
            let (size, map) = grid(pass);
            prop_assert!(size.min_element() >= 1 && map.scale.min_element() >= 1.0 - 1e-12);
            let covers = map.covers(size);
            prop_assert!(covers.min.min_element() >= 0.0, "pass {} starts off the screen", i);
            prop_assert!((covers.max - edge).max_element() <= 1e-9, "pass {} ends off the screen", i);
            if pass.cadence.every.get() == 1 {
                prop_assert_eq!(map.scale, DVec2::ONE);
                prop_assert_eq!(map.origin.fract(), DVec2::ZERO);
            }
        }
        let last = grid(plan.passes.last().unwrap());
        prop_assert!((last.1.covers(last.0).area() / (edge.x * edge.y) - 1.0).abs() < 1e-12);
        // Never fewer than the closed form, which rounds nothing.
        let screen = Screen::from(&request.viewport);
        let estimate =
            method.estimate(&screen, request.acuity, request.gaze, request.margin_deg).unwrap();
        prop_assert!(plan.count().samples() as f64 >= estimate.samples() * (1.0 - 1e-9));
        prop_assert!(estimate.samples().is_finite() && estimate.samples_staggered() > 0.0);

        let Some(feather) = feather(&plan) else { return Ok(()) };
        prop_assert_eq!(feather.edges_tan.len() + 1, plan.passes.len());
        for (pass, [inner, outer]) in plan.passes.iter().zip(&feather.edges_tan) {
            prop_assert!(0.0 < *inner && inner < outer && outer.is_finite());
            let (size, map) = grid(pass);
            for (x, y) in &picks {
                let px = (DVec2::new(*x, *y) * edge).floor() + 0.5;
                let d = request.viewport.direction(px);
                let along = d.dot(feather.gaze);
                if !(along > 0.0 && d.cross(feather.gaze).length() < outer * along) {
                    continue;
                }
                // A pixel that shows this pass reads inside its lattice, or at the screen's edge.
                let at = map.lattice_from_display(px);
                let covers = map.covers(size);
                for axis in 0..2 {
                    let (p, n) = (at[axis], f64::from(size[axis]));
                    prop_assert!(p > 0.0 && p < n + 1e-9, "outside its lattice");
                    prop_assert!(p >= 0.5 - 1e-9 || covers.min[axis] == 0.0);
                    prop_assert!(p <= n - 0.5 + 1e-9 || covers.max[axis] >= edge[axis] - 1e-9);
                }
            }
        }
    }

    /// A wider margin never needs fewer samples, and never fewer than the floor needs.
    #[test]
    fn margins_only_add((request, settings) in requests(), more in 0.0f64..10.0) {
        let settings = LayersSettings { second_scale: None, weights: Weights::Unit, ..settings };
        let screen = Screen::from(&request.viewport);
        let (acuity, margin) = (request.acuity, request.margin_deg);
        let samples = |m| settings.design(&screen, acuity, m).unwrap().samples();
        prop_assert!(samples(margin + more) >= samples(margin) * (1.0 - 1e-9));
        let floor = |m| {
            let gaze = request.gaze;
            ideal_samples(&screen, acuity, gaze, m, FloorDensity::PerSolidAngle).unwrap()
        };
        let (narrow, wide) = (floor(margin), floor(margin + more));
        prop_assert!(narrow > 0.0 && wide >= narrow * (1.0 - 1e-6));
        prop_assert!(wide <= screen.pixels() * (1.0 + 1e-6));
        // Straight ahead the layers' own counts cannot be below it either, but for ω* = atan 2p < 2p.
        let ahead = GazeDirection::AHEAD;
        let ideal = ideal_samples(&screen, acuity, ahead, margin, FloorDensity::PerSolidAngle).unwrap();
        let p = screen.pixel_tan().max_element();
        prop_assert!(samples(margin) * (1.0 + 4.0 * p * p) >= ideal * (1.0 - 1e-6));
    }

    /// Rays start elsewhere when the screen is cut in four, so the parts' sum tests all of the
    /// integral's geometry.
    #[test]
    fn the_floor_is_additive((request, _) in requests(), cut in (0.1f64..0.9, 0.1f64..0.9)) {
        let v = request.viewport;
        prop_assume!(v.size.min_element() >= 10);
        let cut = UVec2::new((f64::from(v.size.x) * cut.0) as u32, (f64::from(v.size.y) * cut.1) as u32);
        let floor = |v: &Viewport, density| {
            ideal_samples(&Screen::from(v), request.acuity, request.gaze, request.margin_deg, density).unwrap()
        };
        let step = v.pixel_tan();
        let part = |from: UVec2, to: UVec2| {
            let x = |k: u32| v.tan[0] + step.x * f64::from(k);
            let y = |k: u32| v.tan[2] - step.y * f64::from(k);
            Viewport::new(to - from, [x(from.x), x(to.x), y(from.y), y(to.y)]).unwrap()
        };
        let parts = [
            part(UVec2::ZERO, cut),
            part(UVec2::new(cut.x, 0), UVec2::new(v.size.x, cut.y)),
            part(UVec2::new(0, cut.y), UVec2::new(cut.x, v.size.y)),
            part(cut, v.size),
        ];
        let density = FloorDensity::PerSolidAngle;
        let sum: f64 = parts.iter().map(|p| floor(p, density)).sum();
        let whole = floor(&v, density);
        prop_assert!((sum / whole - 1.0).abs() < 2e-6, "whole {}, parts {}", whole, sum);
    }
}

/// Where one density is below the other everywhere the integral has a closed form.
#[test]
fn floor_limits() {
    let flat = Acuity::new(0.0).unwrap();
    for (az, el) in [
        (0.0, 0.0),
        (12.0, -9.0),
        (70.0, 50.0),
        (90.0, 0.0),
        (-135.0, 20.0),
    ] {
        let gaze = GazeDirection::new(az, el);
        let floor =
            |screen: &Screen, density| ideal_samples(screen, flat, gaze, 0.0, density).unwrap();
        // A display coarser than the eye everywhere: its own pixels.
        let coarse = Screen::planar(640.0, 1.2, 0.75).unwrap();
        let pixels = floor(&coarse, FloorDensity::PerSolidAngle);
        assert!(
            (pixels / coarse.pixels() - 1.0).abs() < 1e-6,
            "{az},{el}: {pixels}"
        );
        // Finer everywhere: (2/ω₀)² per square degree of 4·asin(ab/√((1+a²)(1+b²))).
        let fine = Screen::planar(1e6, 1.2, 0.75).unwrap();
        let (a, b) = (1.2f64, 0.9f64);
        let steradians = 4.0 * (a * b / ((1.0 + a * a) * (1.0 + b * b)).sqrt()).asin();
        let wanted = 96.0 * 96.0 * steradians.to_degrees().to_degrees();
        let samples = floor(&fine, FloorDensity::PerSolidAngle);
        assert!(
            (samples / wanted - 1.0).abs() < 1e-6,
            "{az},{el}: {samples}, wanted {wanted}"
        );
    }
}

/// The sum over pixels that methods.md §2 calls "per pixel", and the integral it stands for.
#[test]
fn per_pixel_floor_is_the_sum_over_pixels() {
    let display = presets::display("lg-w2363d").unwrap();
    let v = display.primary().viewport;
    let (acuity, gaze) = (Acuity::default(), v.gaze_at(DVec2::new(400.0, 200.0)));
    let mut sum = 0.0;
    for y in 0..v.size.y {
        for x in 0..v.size.x {
            let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let omega = acuity.mar_deg(v.eccentricity_deg(px, gaze.vector()) - 1.0);
            let share = v.sharpness_deg() / omega;
            sum += (share * share).min(1.0);
        }
    }
    let integral =
        ideal_samples(&Screen::from(&v), acuity, gaze, 1.0, FloorDensity::PerPixel).unwrap();
    // The midpoint rule on 2 million pixels.
    assert!((integral / sum - 1.0).abs() < 1e-5, "{integral}, sum {sum}");
}

#[test]
fn extremes_stay_finite() {
    for fov in [1e-3, 10.0, 90.0, 179.0, 179.99] {
        for slope in [0.0, 1e-9, 0.0275, 10.0] {
            for fraction in [1e-3, 0.4, 1.0, 1e3] {
                let acuity = Acuity::new(slope).unwrap();
                let Ok(screen) = Screen::from_sharpness(fov, acuity, fraction, 0.75) else {
                    continue;
                };
                let density = FloorDensity::PerSolidAngle;
                let ideal =
                    ideal_samples(&screen, acuity, GazeDirection::AHEAD, 0.0, density).unwrap();
                assert!(ideal > 0.0 && ideal <= screen.pixels() * (1.0 + 1e-6));
                for n in [1, 2, 5, 16] {
                    let design = LayersSettings::new(n)
                        .unwrap()
                        .design(&screen, acuity, 0.0)
                        .unwrap();
                    let what = format!("{fov} deg, slope {slope}, {fraction} foveal, n = {n}");
                    assert!(
                        design.ratio().is_finite() && design.ratio() >= 1.0,
                        "{what}"
                    );
                    assert!(design.layers().iter().all(|l| l.scale >= 1.0), "{what}");
                    let above = design.samples() * (1.0 + 1e-3) >= ideal;
                    assert!(
                        above,
                        "{what}: {} below the floor {ideal}",
                        design.samples()
                    );
                }
            }
        }
    }
}

#[test]
fn gaze_off_the_screen_leaves_the_outer_layer() {
    let display = presets::display("lg-w2363d").unwrap();
    let method: Method = "layers:3".parse().unwrap();
    for gaze in [
        GazeDirection::new(60.0, 0.0),
        GazeDirection::new(180.0, 0.0),
    ] {
        let request = Request {
            gaze,
            ..Request::ahead(display.primary())
        };
        let plan = method.plan(&request).unwrap();
        assert_eq!(plan.passes.len(), 1);
        assert_eq!(feather(&plan).unwrap().edges_tan.len(), 0);
        assert!(plan.count().ratio() > 20.0);
    }
    let request = Request {
        gaze: GazeDirection::new(f64::NAN, 0.0),
        ..Request::ahead(display.primary())
    };
    assert!(method.plan(&request).is_err());
    let request = Request {
        margin_deg: -1.0,
        ..Request::ahead(display.primary())
    };
    assert!(method.plan(&request).is_err());
}

/// A display coarser than the eye gains nothing near its centre, and nothing at all if small.
#[test]
fn coarse_displays_merge_layers() {
    let screen = Screen::planar(200.0, 0.2, 0.75).unwrap();
    let design = LayersSettings::new(4)
        .unwrap()
        .design(&screen, Acuity::default(), 0.0)
        .unwrap();
    assert_eq!(design.layers().len(), 1);
    assert_eq!(design.ratio(), 1.0);
    let size = UVec2::new(200, 150);
    let request = Request {
        eye: Eye::Cyclopean,
        viewport: Viewport::symmetric(size, 0.2).unwrap(),
        acuity: Acuity::default(),
        gaze: GazeDirection::AHEAD,
        ahead: GazeDirection::AHEAD,
        margin_deg: 0.0,
    };
    let plan = "layers:4"
        .parse::<Method>()
        .unwrap()
        .plan(&request)
        .unwrap();
    assert_eq!(
        (plan.count().samples(), plan.resolve),
        (200 * 150, Resolve::Direct)
    );
}

/// Coarser than the eye everywhere, although ω grows sixty-fold along a ray.
#[test]
fn a_very_coarse_display_is_its_own_floor() {
    let size = UVec2::splat(10);
    let edges = [-1.820_059, 0.731_641, 1.073_261, -1.665_219];
    let screen = Screen::from(&Viewport::new(size, edges).unwrap());
    let acuity = Acuity::new(0.011_238_481).unwrap();
    for el in [0.0, 20.0, 41.838] {
        let gaze = GazeDirection::new(0.0, el);
        let ideal = ideal_samples(&screen, acuity, gaze, 0.0, FloorDensity::PerSolidAngle).unwrap();
        assert!((ideal - 100.0).abs() < 1e-8, "{el}: {ideal}");
    }
}
