//! Kernels and coefficients that are found: every pixel keeps to the acuity line, and nothing that does has
//! fewer samples. Both by brute force, over pixels and over settings.

use foveasim_models::foveation::{KernelSearch, LensSearch, Method, Request};
use foveasim_models::{Acuity, Eye, GazeDirection, SamplePlan, Viewport, presets};
use glam::{DVec2, UVec2};

/// How far the worst pixel is above its limit, as a factor: every `stride`th pixel of every `stride`th row
/// and those at the edges are looked at, outside the disc of a pixel about the gaze, where log-polar maps have
/// no inverse.
fn worst(plan: &SamplePlan, request: &Request, stride: usize) -> f64 {
    let size = request.viewport.size;
    let gaze = request.viewport.project(request.gaze.vector());
    let edged = |n: u32| (0..n).step_by(stride).chain([n - 1]);
    let mut worst = 0.0f64;
    for y in edged(size.y) {
        for x in edged(size.x) {
            let px = UVec2::new(x, y).as_dvec2() + 0.5;
            if gaze.is_none_or(|gaze| gaze.distance(px) > 1.0) {
                let place = request.place(px);
                let longest = place.longest(plan.shading_steps(request, px));
                worst = worst.max(longest / place.limit_deg());
            }
        }
    }
    worst
}

fn request(size: [u32; 2], half_width_tan: f64, gaze: GazeDirection, margin_deg: f64) -> Request {
    Request {
        eye: Eye::Cyclopean,
        viewport: Viewport::symmetric(size.into(), half_width_tan).unwrap(),
        acuity: Acuity::default(),
        gaze,
        ahead: GazeDirection::AHEAD,
        margin_deg,
    }
}

/// Images, gazes and margins of different kinds.
fn situations() -> Vec<Request> {
    let quest = presets::display("quest-pro").unwrap();
    let lg = presets::display("lg-w2363d").unwrap();
    let sharp = Request {
        acuity: Acuity::new(0.022).unwrap(),
        ..Request::ahead(lg.primary())
    };
    vec![
        Request::ahead(quest.primary()),
        sharp,
        request([1280, 1440], 1.19, GazeDirection::new(20.0, -15.0), 2.0),
        request([640, 360], 1.0, GazeDirection::new(80.0, 40.0), 0.0),
        request([333, 1001], 0.4, GazeDirection::new(-30.0, 0.0), 5.0),
    ]
}

#[test]
fn found_kernels_keep_to_the_line() {
    for request in situations() {
        let search = KernelSearch::new(std::slice::from_ref(&request)).unwrap();
        let best = search.best().unwrap();
        let given = [4.0, 1.0, 0.5].map(|alpha| search.at_alpha(alpha));
        for found in given.into_iter().flatten().chain([best]) {
            let method = Method::Kfr(found.settings);
            let plan = method.plan(&request).unwrap();
            let worst = worst(&plan, &request, 7);
            // What the search leaves in reserve, and what buffers are larger for having whole samples.
            assert!(worst <= 1.0, "{method} at {:?}: {worst}", request.gaze);
            assert!(worst >= 0.97, "{method} at {:?}: {worst}", request.gaze);
            // Whole samples at the border.
            let sides = request.viewport.size.as_dvec2().element_sum() / found.settings.sigma();
            let drawn = plan.count().samples() as f64;
            assert!(
                (drawn - found.samples).abs() < 2.0 * sides,
                "{method}: {drawn}, {found:?}"
            );
            assert!(found.samples >= best.samples * (1.0 - 1e-3), "{method}");
        }
    }
}

/// No kernel of a fine grid that meets every limit has fewer samples.
#[test]
fn no_kernel_is_better() {
    let gaze = GazeDirection::new(10.0, -6.0);
    let request = request([320, 360], 1.0, gaze, 1.0);
    let search = KernelSearch::new(std::slice::from_ref(&request)).unwrap();
    let best = search.best().unwrap();
    let mut least = f64::INFINITY;
    for a in 0..10 {
        let alpha = 0.24 * 1.1f64.powi(a);
        for s in 0..30 {
            let sigma = 0.6 * 1.02f64.powi(s);
            let method: Method = format!("kfr:{sigma}:{alpha}").parse().unwrap();
            let plan = method.plan(&request).unwrap();
            // Those that could be better are looked at pixel by pixel.
            let samples = plan.count().samples() as f64;
            if samples < 1.02 * best.samples && worst(&plan, &request, 2) <= 1.0 {
                least = least.min(samples);
            }
        }
    }
    assert!(least > 0.985 * best.samples, "{least}, {best:?}");
}

#[test]
fn several_gazes_at_once() {
    let at = |x: f64, y: f64| {
        let base = request([320, 360], 1.0, GazeDirection::AHEAD, 1.0);
        let gaze = base
            .viewport
            .gaze_at(DVec2::new(x, y) * base.viewport.size.as_dvec2());
        Request { gaze, ..base }
    };
    let all = at(0.5, 0.5).wherever();
    let found = KernelSearch::new(&all).unwrap().best().unwrap();
    let method = Method::Kfr(found.settings);
    for k in 0..40 {
        let request = at(
            (0.377 * f64::from(k)).fract(),
            (0.618 * f64::from(k)).fract(),
        );
        let worst = worst(&method.plan(&request).unwrap(), &request, 2);
        // Between the gazes looked at.
        assert!(worst <= 1.01, "{:?}: {worst}", request.gaze);
    }
    assert!(KernelSearch::new(&[]).is_err() && LensSearch::new(&[]).is_err());
}

#[test]
fn found_lenses_keep_to_the_line_and_no_other_is_better() {
    for request in situations() {
        let found = LensSearch::new(std::slice::from_ref(&request))
            .unwrap()
            .best()
            .unwrap();
        let method = Method::Lms(found.settings);
        let plan = method.plan(&request).unwrap();
        let at_best = worst(&plan, &request, 7);
        assert!(at_best <= 1.0 + 1e-9, "{method}: {at_best}");
        // Larger coefficients in any proportion do not, but for what is left in reserve.
        let [a, b] = found.settings.coefficients();
        for (more_a, more_b) in [(0.02, 0.0), (0.0, 0.02), (0.1, -0.1), (-0.1, 0.1)] {
            let (a, b) = ((a + more_a).max(0.0), (b + more_b).max(0.0));
            let method: Method = format!("lms:{a}:{b}").parse().unwrap();
            let plan = method.plan(&request).unwrap();
            let samples = plan.count().samples() as f64;
            let better = samples < 0.985 * found.samples;
            assert!(
                !better || worst(&plan, &request, 7) > 1.0,
                "{method}: {samples} of {found:?}"
            );
        }
    }
}
