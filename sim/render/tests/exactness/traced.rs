//! The rasterizer sees what rays see, sample for sample.

use foveasim_assets::{Scene, study_camera};
use foveasim_models::{Msaa, Pose, SamplePlan, View};
use foveasim_render::{RenderError, RenderOptions, Simd, Skip, trace, visibility, visibility_at};
use glam::{DQuat, DVec2, DVec3};

use crate::common::{layers, study_view, view};
use crate::{METHODS, STUDY, full, loose_triangles, options, plan, varied};

/// All passes and positions of a plan, by both; how many samples show a triangle.
fn agree(scene: &Scene, view: &View, plan: &SamplePlan, options: &RenderOptions) -> usize {
    let mut seen = 0;
    for (index, pass) in plan.passes.iter().enumerate() {
        let foveasim_models::Visibility::Own(msaa) = pass.visibility else {
            unreachable!("plans are made so")
        };
        for position in 0..msaa.positions() as usize {
            let drawn = visibility_at(scene, view, plan, index, position, options).unwrap();
            let traced = trace(scene, view, plan, index, position, options).unwrap();
            let other = drawn.iter().zip(&traced).position(|(a, b)| a != b);
            if let Some(k) = other {
                panic!(
                    "{} pass {index} position {position} sample {k}: drawn {:?}, traced {:?}",
                    plan.method, drawn[k], traced[k]
                );
            }
            seen += drawn.iter().flatten().count();
        }
    }
    seen
}

const OFFSET: DVec2 = DVec2::new(0.3, -0.44);

#[test]
fn every_method_on_the_study_scene() {
    let view = study_view(120, 68);
    for method in METHODS {
        let plan = varied(plan(method, &view), Msaa::Four, OFFSET);
        let seen = agree(&STUDY, &view, &plan, &options());
        assert!(seen > 1000, "{method}: {seen}");
    }
}

#[test]
fn the_study_scene_from_several_places() {
    for (t, width) in [(0.02, 500), (0.51, 97), (0.87, 256)] {
        let view = view(width, width * 9 / 16, study_camera(t, 1));
        let seen = agree(&STUDY, &view, &full(&view), &options());
        assert!(seen > 1000, "{t}: {seen}");
    }
}

#[test]
fn loose_triangles_through_the_near_plane() {
    let size = [(160, 90), (33, 101)];
    for seed in 0..6 {
        let scene = loose_triangles(seed, 700);
        let (width, height) = size[seed as usize % 2];
        let view = view(width, height, Pose::IDENTITY);
        // Beside the narrow image: its innermost layer is empty.
        let gaze = DVec2::new(50.0, 40.0);
        let layered = layers(&view, gaze, &[(1.0, 12.0), (2.3, 20.0), (7.0, 0.0)]);
        for plan in [full(&view), layered] {
            for msaa in [Msaa::One, Msaa::Four] {
                for (near_m, back_faces) in [(0.05, true), (1.7, false)] {
                    let options = RenderOptions {
                        near_m,
                        simd: if seed < 2 { Simd::Scalar } else { Simd::Auto },
                        skip: Skip {
                            back_faces,
                            ..Skip::ALL
                        },
                        ..options()
                    };
                    let plan = varied(plan.clone(), msaa, OFFSET * f64::from(seed as u32 % 2));
                    let seen = agree(&scene, &view, &plan, &options);
                    assert!(seen > 100, "seed {seed}: {seen}");
                }
            }
        }
    }
}

/// Four positions of visibility are samples moved there: coverage and depth have no other notion of place.
#[test]
fn positions_are_offsets() {
    // Direct3D 11.3 functional specification, §19.2, in sixteenths.
    let pattern = [[-2.0, -6.0], [6.0, -2.0], [-6.0, 2.0], [2.0, 6.0]];
    let scene = loose_triangles(11, 500);
    let views = [view(128, 80, Pose::IDENTITY), study_view(128, 80)];
    for (scene, view) in [&scene, &STUDY].into_iter().zip(&views) {
        let four = varied(full(view), Msaa::Four, DVec2::ZERO);
        for (position, at) in pattern.into_iter().enumerate() {
            let one = varied(full(view), Msaa::One, DVec2::from_array(at) / 16.0);
            let moved = visibility(scene, view, &one, 0, &options()).unwrap();
            let seen = visibility_at(scene, view, &four, 0, position, &options()).unwrap();
            assert!(moved == seen, "position {position}");
        }
    }
}

/// A ray along an axis has directions of zero.
#[test]
fn rays_along_the_axis() {
    let scene = loose_triangles(3, 300);
    let turned = Pose::new(DVec3::ZERO, DQuat::from_rotation_x(0.2));
    let view = view(65, 33, turned);
    assert!(agree(&scene, &view, &full(&view), &options()) > 500);
}

#[test]
fn positions_that_are_not_there_are_refused() {
    let view = study_view(32, 18);
    let plan = full(&view);
    for (pass, position) in [(1, 0), (0, 1), (0, usize::MAX)] {
        let drawn = visibility_at(&STUDY, &view, &plan, pass, position, &options());
        let traced = trace(&STUDY, &view, &plan, pass, position, &options());
        for error in [drawn.unwrap_err(), traced.unwrap_err()] {
            assert!(matches!(error, RenderError::Pass { .. }), "{error}");
        }
    }
}
