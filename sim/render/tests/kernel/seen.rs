//! What samples see.

use foveasim_assets::Scene;
use foveasim_models::{Msaa, Pose, SamplePlan, View};
use foveasim_render::{RenderOptions, Simd, Skip, trace, visibility, visibility_at};
use glam::{DVec2, DVec3, UVec2};

use crate::common::{soup, study_view, unlit, view};
use crate::{STUDY, kernel, plans, published};

/// A plan by rasterization and by rays; how many samples show a triangle.
fn agree(scene: &Scene, view: &View, plan: &SamplePlan, options: &RenderOptions) -> usize {
    let mut seen = 0;
    let foveasim_models::Visibility::Own(msaa) = plan.passes[0].visibility else {
        unreachable!("plans are made so")
    };
    for position in 0..msaa.positions() as usize {
        let drawn = visibility_at(scene, view, plan, 0, position, options).unwrap();
        let traced = trace(scene, view, plan, 0, position, options).unwrap();
        let other = drawn.iter().zip(&traced).position(|(a, b)| a != b);
        if let Some(k) = other {
            panic!(
                "{} position {position} sample {k}: drawn {:?}, traced {:?}",
                plan.method, drawn[k], traced[k]
            );
        }
        seen += drawn.iter().flatten().count();
    }
    seen
}

#[test]
fn placed_samples_see_what_rays_see() {
    for (width, height) in [(160, 90), (67, 131)] {
        let view = study_view(width, height);
        let mut seen = 0;
        for (k, plan) in plans(view.optics.size).into_iter().enumerate() {
            let mut plan = if k % 3 == 0 {
                plan.with_msaa(Msaa::Four)
            } else {
                plan
            };
            if k % 2 == 0 {
                plan.passes[0].offset = DVec2::new(0.3, -0.44);
            }
            seen += agree(&STUDY, &view, &plan, &RenderOptions::default());
        }
        assert!(seen > 50_000, "{seen}");
    }
}

/// Loose triangles of all sizes: through the near plane, larger than the image, thinner than a sub-sample.
#[test]
fn loose_triangles_are_not_missed() {
    let random = &mut foveasim_models::Stream::new(5, foveasim_models::Role::Scene, 1);
    for round in 0..4 {
        let triangles: Vec<[DVec3; 3]> = (0..900)
            .map(|_| {
                let size = [0.01, 0.2, 2.5, 400.0][random.below(4) as usize];
                let mut point = |x: f64, z: f64| {
                    let [a, b] = [0; 2].map(|_| random.range(-x, x));
                    DVec3::new(a, b, random.range(-z, z))
                };
                let centre = point(3.0, 4.6) - DVec3::Z * 4.0;
                let corners = [(); 3].map(|()| centre + point(size, size));
                let [a, b, c] = corners;
                match round % 2 {
                    0 => corners,
                    _ => [a, b, b + (c - b) * 1e-4],
                }
            })
            .collect();
        let scene = unlit(vec![soup(&triangles)], [1.0; 3], [0.0; 3]);
        let view = view(120 + 7 * round, 90, Pose::IDENTITY);
        for plan in plans(view.optics.size) {
            let options = RenderOptions {
                skip: if round < 2 { Skip::ALL } else { Skip::NONE },
                ..RenderOptions::default()
            };
            agree(&scene, &view, &plan, &options);
        }
    }
}

#[test]
fn what_is_skipped_is_not_missed() {
    let view = study_view(80, 45);
    for plan in plans(view.optics.size).into_iter().step_by(4) {
        let all = visibility(&STUDY, &view, &plan, 0, &RenderOptions::default()).unwrap();
        let none = RenderOptions {
            skip: Skip {
                back_faces: true,
                ..Skip::NONE
            },
            simd: Simd::Scalar,
            ..RenderOptions::default()
        };
        let none = visibility(&STUDY, &view, &plan, 0, &none).unwrap();
        assert!(all == none, "{}", plan.method);
    }
}

/// The first pass of the published form is full resolution's.
#[test]
fn the_published_form_sees_what_full_resolution_sees() {
    let view = study_view(160, 90);
    let options = RenderOptions::default();
    let direct = kernel(view.optics.size, 2.0, 1.0, DVec2::new(70.0, 50.0));
    let published = published(&direct);
    let full = SamplePlan::full(view.eye, view.optics.size);
    let found = visibility(&STUDY, &view, &published, 0, &options).unwrap();
    assert_eq!(
        found,
        visibility(&STUDY, &view, &full, 0, &options).unwrap()
    );

    // Texels where a sample spans at most a pixel are full resolution's pixels, to the bit.
    let options = RenderOptions {
        keep_passes: true,
        ..options
    };
    let texels = &foveasim_render::render(&STUDY, &view, &published, &options)
        .unwrap()
        .passes[1];
    let pixels = foveasim_render::render(&STUDY, &view, &full, &options)
        .unwrap()
        .image;
    let mut compared = 0;
    for y in 0..texels.size.y {
        for x in 0..texels.size.x {
            let at = direct.position(0, UVec2::new(x, y));
            let steps = direct.passes[0]
                .map
                .steps(DVec2::new(x.into(), y.into()) + 0.5);
            let is_fine = steps.x_axis.length().max(steps.y_axis.length()) <= 1.0;
            if is_fine && direct.passes[0].region.is_live(UVec2::new(x, y)) {
                // Positions are rounded to 1/256 of a pixel before the pixel is looked up.
                let at = ((at * 256.0 + 0.5).floor() / 256.0).as_uvec2();
                let (texel, pixel) = (y * texels.size.x + x, at.y * 160 + at.x);
                assert_eq!(texels.rgb[texel as usize], pixels.rgb[pixel as usize]);
                compared += 1;
            }
        }
    }
    assert!(compared > 200, "{compared}");
}
