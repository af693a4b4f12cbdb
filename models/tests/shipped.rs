//! Counts of the methods that ship today, on every preset.

use foveasim_models::foveation::{Aim, Estimate, Method, Request, Screen};
use foveasim_models::{Acuity, EyePanel, GazeDirection, Resolve, SamplePlan, Shading, presets};
use glam::DVec2;

fn method(text: &str) -> Method {
    text.parse().unwrap()
}

fn panels() -> Vec<(String, EyePanel)> {
    let mut panels = Vec::new();
    for name in presets::display_names() {
        let display = presets::display(name).unwrap();
        panels.extend(
            display
                .eyes
                .iter()
                .map(|eye| (name.to_owned(), eye.clone())),
        );
    }
    panels
}

fn both(method: Method, request: &Request) -> (SamplePlan, Estimate) {
    let screen = Screen::from(&request.viewport);
    let gaze = method.aim().gaze(request.gaze, request.ahead);
    let own = method.of_eye(request.eye);
    let estimate = own.estimate(&screen, request.acuity, gaze, request.margin_deg);
    (method.plan(request).unwrap(), estimate.unwrap())
}

/// A drawn plan has whole samples and whole blocks: more than the estimate by at most a row and a column
/// of each pass, and for rates of ¾, whose grid ends up to a pixel and a third beyond the display,
/// another.
#[test]
fn plans_count_what_estimates_say() {
    for (name, panel) in panels() {
        for text in [
            "vrs",
            "vrs:tile=8",
            "vrs:tile=32:max=2",
            "vrs:fixed",
            "fdm",
            "fdm:tile=8:fixed=5",
            "fdm:tile=32",
            "rates",
            "rates:bands=9",
            "rates:bands=256:fixed",
            "quad",
            "quad:fixed",
            "quad:auto",
            "quad:auto:peripheral=0.3",
            "quad:focus=0.6:peripheral=0.7",
            "kfr:2:4",
            "kfr:1.8:0.25:published",
            "kfr:3:1:fixed",
            "efr:2:3:alpha=0.5",
            "lms:0.5:0.7",
        ] {
            for gaze in [
                panel.ahead(),
                GazeDirection::new(17.0, -11.0),
                GazeDirection::new(-60.0, 40.0),
            ] {
                let request = Request {
                    gaze,
                    ..Request::ahead(&panel)
                };
                let (plan, estimate) = both(method(text), &request);
                let what = format!("{name} {text} {gaze:?}");
                let count = plan.count();
                assert_eq!(count.passes.len(), estimate.passes.len(), "{what}");
                let size = panel.viewport.size.as_dvec2();
                let border = 2.0 * (size.x + size.y);
                for (drawn, closed) in count.passes.iter().zip(&estimate.passes) {
                    for (drawn, closed) in [
                        (drawn.samples, closed.samples),
                        (drawn.shadings, closed.shadings),
                    ] {
                        let more = drawn as f64 - closed;
                        assert!(
                            more.abs() <= border,
                            "{what}: {drawn} drawn, {closed} closed"
                        );
                    }
                }
                let (drawn, closed) = (count.shadings() as f64, estimate.shadings());
                assert!(
                    (drawn / closed - 1.0).abs() < 0.01,
                    "{what}: {drawn} drawn, {closed} closed"
                );
                assert_eq!(
                    plan.method.parse::<Method>().unwrap(),
                    method(text),
                    "{what}"
                );
            }
        }
    }
}

/// methods.md: peripheral 0.5 and a focus of 35 % of each side cost 0.3725 of full.
#[test]
fn quad_views_cost_what_is_published() {
    let display = presets::display("lg-w2363d").unwrap();
    let request = Request::ahead(display.primary());
    let (plan, estimate) = both(method("quad"), &request);
    assert!((estimate.samples() / estimate.display_pixels - 0.3725).abs() < 1e-12);
    assert_eq!(plan.count().samples(), 672 * 378 + 960 * 540);
    assert_eq!(plan.resolve, Resolve::Mosaic);
    // In a corner the focus is pushed back inside, whole.
    let gaze = display.primary().viewport.gaze_at(DVec2::new(3.0, 1075.0));
    let (plan, estimate) = both(
        method("quad"),
        &Request {
            gaze,
            ..request.clone()
        },
    );
    assert!((estimate.samples() / estimate.display_pixels - 0.3725).abs() < 1e-12);
    assert_eq!(plan.count().passes[0].samples, 672 * 378);
    // A fixed focus covers wherever a tracked one would be, so it needs the more the farther eyes turn.
    let focus = |reach: f64| {
        let text = format!("quad:fixed={reach}");
        both(method(&text), &request).1.passes[0].samples
    };
    assert!((focus(0.0) / estimate.display_pixels - 0.1225).abs() < 1e-12);
    assert!(focus(5.0) > focus(0.0) && focus(15.0) > focus(5.0));
    assert!((focus(60.0) / estimate.display_pixels - 1.0).abs() < 1e-12);
}

#[test]
fn at_full_rate_nothing_is_coarse() {
    for (name, panel) in panels() {
        let request = Request::ahead(&panel);
        let pixels = panel.viewport.size.element_product();
        let plan = method("vrs:max=1").plan(&request).unwrap();
        assert_eq!(plan.count().shadings(), u64::from(pixels), "{name}");
        for text in ["fdm:max=1", "quad:auto:peripheral=1"] {
            let plan = method(text).plan(&request).unwrap();
            let full = SamplePlan::full(panel.eye, panel.viewport.size);
            assert_eq!(
                SamplePlan {
                    method: "full".into(),
                    ..plan
                },
                full,
                "{name} {text}"
            );
        }
        // An eye that sees as sharply everywhere as at its centre.
        let sharp = Request {
            acuity: Acuity::with_foveal(0.0, 1e-3).unwrap(),
            ..request
        };
        for text in ["vrs", "fdm", "rates", "quad:auto"] {
            let count = method(text).plan(&sharp).unwrap().count();
            assert_eq!(count.shadings(), u64::from(pixels), "{name} {text}");
        }
    }
}

/// What each method gives up against the one before it, on every preset.
#[test]
fn coarser_control_costs_samples() {
    for (name, panel) in panels() {
        let request = Request::ahead(&panel);
        let shadings = |text: &str| method(text).plan(&request).unwrap().count().shadings();
        // Hardware rates of shading are a part of a density map's.
        assert!(shadings("fdm") <= shadings("vrs"), "{name}");
        // Small tiles follow the acuity line more closely.
        assert!(shadings("fdm:tile=8") <= shadings("fdm:tile=16"), "{name}");
        assert!(shadings("fdm:tile=16") <= shadings("fdm:tile=32"), "{name}");
        assert!(shadings("vrs:max=4") <= shadings("vrs:max=2"), "{name}");
        // Visibility of variable-rate shading is full.
        let count = method("vrs").plan(&request).unwrap().count();
        assert_eq!(count.samples(), count.display_pixels, "{name}");
        assert!(count.shading_ratio() >= 1.0 && count.ratio() == 1.0);
    }
}

/// A separable map is finer in its arms than the eye asks for: more samples than a map of tiles as
/// large with the same rates along each axis would need.
#[test]
fn the_cross_of_a_separable_map_costs() {
    let display = presets::display("lg-w2363d").unwrap();
    let request = Request::ahead(display.primary());
    let ratio = |text: &str| method(text).plan(&request).unwrap().count().ratio();
    assert!(ratio("rates:bands=64") < 0.75 * ratio("fdm:tile=32"));
    // More bands follow the line more closely; one cannot be anything but full.
    assert!(ratio("rates:bands=64") >= ratio("rates:bands=8"));
    assert_eq!(ratio("rates:bands=1"), 1.0);
}

/// Fixed methods do not move, and need more samples for the same quality the farther an eye may turn.
#[test]
fn fixed_methods_stay_and_cost_more() {
    for (name, panel) in panels() {
        for text in ["layers:3", "vrs", "fdm", "rates", "quad", "quad:auto"] {
            let tracked = method(text);
            let mut last = 0;
            for reach_deg in [0.0, 5.0, 15.0, 30.0] {
                let fixed = tracked.with_aim(Aim::Fixed { reach_deg });
                let ahead = Request::ahead(&panel);
                let plan = fixed.plan(&ahead).unwrap();
                let aside = Request {
                    gaze: GazeDirection::new(25.0, 9.0),
                    ..ahead.clone()
                };
                assert_eq!(plan, fixed.plan(&aside).unwrap(), "{name} {text}");
                let shadings = plan.count().shadings();
                assert!(shadings >= last, "{name} {text} {reach_deg}");
                if reach_deg == 0.0 {
                    assert_eq!(shadings, tracked.plan(&ahead).unwrap().count().shadings());
                }
                last = shadings;
            }
        }
    }
}

#[test]
fn rates_are_one_per_tile() {
    let display = presets::display("quest-pro").unwrap();
    let plan = method("vrs:tile=32")
        .plan(&Request::ahead(display.primary()))
        .unwrap();
    let Shading::Coarse(rates) = &plan.passes[0].shading else {
        panic!("{:?}", plan.passes[0].shading)
    };
    assert_eq!((rates.tile(), rates.lattice()), (32, plan.display_px));
    let centre = display.primary().viewport.axis_px().as_uvec2();
    assert_eq!((rates.rate(centre).x, rates.rate(centre).y), (1, 1));
}
