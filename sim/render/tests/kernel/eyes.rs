//! Two eyes at once.

use foveasim_assets::study_camera;
use foveasim_models::foveation::{Method, Request};
use foveasim_models::{Acuity, Display, EyePanel, SamplePlan, View};
use foveasim_render::{RenderOptions, Skip, StereoFrame, render_stereo};
use glam::{DVec3, UVec2};

use crate::STUDY;

/// The panels of a headset with small images, canted or not.
fn panels(cant_deg: f64) -> [EyePanel; 2] {
    let text = format!(
        "name = \"two\"\n[hmd]\npanel_px = [120, 130]\nfov_deg = [45.0, 38.0, 42.0, 44.0]\ncant_deg = {cant_deg}\n[scan]\nrefresh_hz = 90.0"
    );
    let spec = foveasim_models::presets::parse_display(&text, "test").unwrap();
    let display = Display::try_from(spec).unwrap();
    <[EyePanel; 2]>::try_from(display.eyes).unwrap()
}

fn draw(panels: &[EyePanel; 2], method: &str, options: &RenderOptions) -> StereoFrame {
    let head = study_camera(0.4, 1);
    // Both eyes look at one point two metres away.
    let point = DVec3::new(0.2, -0.1, -2.0);
    let method: Method = method.parse().unwrap();
    let plan = |panel: &EyePanel| -> SamplePlan {
        let request = Request {
            gaze: panel.looking_at(point),
            acuity: Acuity::default(),
            ..Request::ahead(panel)
        };
        method.plan(&request).unwrap()
    };
    let views: [View; 2] = [0, 1].map(|k| panels[k].view(head));
    let plans = [0, 1].map(|k| plan(&panels[k]));
    let plans = [&plans[0], &plans[1]];
    render_stereo(&STUDY, head, [&views[0], &views[1]], plans, options).unwrap()
}

const METHODS: [&str; 6] = [
    "full",
    "layers:3",
    "vrs",
    "kfr:1.8:1",
    "efr:2:3:published",
    "lms:0.4:0.4",
];

#[test]
fn what_eyes_share_changes_no_picture() {
    for cant_deg in [0.0, 8.0] {
        let panels = panels(cant_deg);
        for method in METHODS {
            let together = draw(&panels, method, &RenderOptions::default());
            let options = RenderOptions {
                skip: Skip {
                    repeated_for_eyes: false,
                    repeated_vertices: cant_deg > 0.0,
                    ..Skip::ALL
                },
                ..RenderOptions::default()
            };
            let apart = draw(&panels, method, &options);
            for (a, b) in together.eyes.iter().zip(&apart.eyes) {
                assert!(a.image == b.image, "{method}, cant {cant_deg}");
                assert_eq!(a.work.samples_shaded, b.work.samples_shaded);
            }
            assert!(together.eyes[0].image != together.eyes[1].image);
            assert!(together.shared.vertices > 10_000 && together.shared.choices > 100);
            assert_eq!(apart.shared, foveasim_render::StereoShared::default());
            let rows = together.work.rows().into_iter();
            let of_eyes = together.eyes[0]
                .work
                .rows()
                .into_iter()
                .zip(together.eyes[1].work.rows());
            for ((name, total), (left, right)) in rows.zip(of_eyes) {
                let shared = if name == "vertices" {
                    together.shared.vertices
                } else {
                    0
                };
                assert_eq!(total, left.1 + right.1 + shared, "{name}");
            }
            assert!(together.work.vertices < apart.work.vertices);
        }
    }
}

/// By way of the head vertices are rounded once more: outlines move by less than a sub-sample, and the
/// pictures are those that each eye has by itself but there.
#[test]
fn eyes_see_what_each_sees_alone() {
    let panels = panels(5.0);
    let options = RenderOptions {
        lod: foveasim_assets::LodRule::Finest,
        ..RenderOptions::default()
    };
    let both = draw(&panels, "full", &options);
    let head = study_camera(0.4, 1);
    for (panel, frame) in panels.iter().zip(&both.eyes) {
        let plan = SamplePlan::full(panel.eye, panel.viewport.size);
        let view = panel.view(head);
        let alone = foveasim_render::render(&STUDY, &view, &plan, &options).unwrap();
        let pairs = alone.image.rgb.iter().zip(&frame.image.rgb);
        let far = pairs.filter(|(a, b)| (0..3).any(|c| (a[c] - b[c]).abs() > 0.02));
        let share = far.count() as f64 / alone.image.rgb.len() as f64;
        assert!(share < 0.01, "{share}");
    }
}

#[test]
fn dominance_takes_its_sigma_from_the_eye() {
    let frame = draw(&panels(0.0), "efr:2:3", &RenderOptions::default());
    let shaded = frame
        .eyes
        .map(|eye| eye.work.samples_shaded + eye.work.samples_sky);
    // The right eye is dominant unless said otherwise; a few samples lie beyond the display.
    let ratio = shaded[1] as f64 / shaded[0] as f64;
    assert!((ratio - 2.25).abs() < 0.1, "{ratio}");
}

#[test]
fn views_that_are_no_pair_are_refused() {
    let panels = panels(0.0);
    let head = study_camera(0.1, 1);
    let [left, right] = [0, 1].map(|k| panels[k].view(head));
    let [a, b] = [0, 1].map(|k| SamplePlan::full(panels[k].eye, UVec2::new(120, 130)));
    let options = RenderOptions::default();
    let swapped = render_stereo(&STUDY, head, [&right, &left], [&b, &a], &options);
    let error = swapped.unwrap_err().to_string();
    assert!(error.contains("right and left"), "{error}");
    let mut two = b.clone();
    two.passes.push(two.passes[0].clone());
    assert!(render_stereo(&STUDY, head, [&left, &right], [&a, &two], &options).is_err());
    two.passes.pop();
    assert!(render_stereo(&STUDY, head, [&left, &right], [&a, &two], &options).is_ok());
}
