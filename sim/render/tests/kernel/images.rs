//! Images made of bent lattices.

use foveasim_assets::{Scene, Sky};
use foveasim_models::{Filter, Image, Interpolation, Msaa, Resolve, SamplePlan};
use foveasim_render::{RenderOptions, Simd, render};
use glam::{DVec2, UVec2};

use crate::common::{sphere_scene, study_view, view};
use crate::{BILINEAR, STUDY, kernel, plans, published};

fn bits(image: &Image) -> Vec<u32> {
    image.rgb.iter().flatten().map(|v| v.to_bits()).collect()
}

/// Every way to reconstruct.
fn filters() -> Vec<Filter> {
    let mut filters = Vec::new();
    for interpolation in Interpolation::ALL {
        for smooth_from in [None, Some(0), Some(9)] {
            for mips in [false, true] {
                if interpolation == Interpolation::Gather && (mips || smooth_from.is_some()) {
                    continue;
                }
                filters.push(Filter {
                    interpolation,
                    smooth_from,
                    mips,
                });
            }
        }
    }
    filters
}

fn forms(display: UVec2) -> Vec<SamplePlan> {
    let mut forms = plans(display);
    forms.extend(plans(display).iter().take(3).map(published));
    let four = forms[0].clone().with_msaa(Msaa::Four);
    forms.push(four);
    let four = published(&plans(display)[1]).with_msaa(Msaa::Four);
    forms.push(four);
    forms
}

#[test]
fn one_colour_stays_that_colour_to_the_bit() {
    let colour = [0.3, 0.7, 0.123_456];
    let scene = sphere_scene(colour, colour);
    let sizes = [(37, 23), (1, 1), (1, 40), (2, 3), (129, 65)];
    for (width, height) in sizes {
        let view = view(width, height, foveasim_models::Pose::IDENTITY);
        for (k, plan) in forms(view.optics.size).into_iter().enumerate() {
            let filters = filters();
            let filters = if width == 37 {
                &filters[..]
            } else {
                &filters[k % filters.len()..=k % filters.len()]
            };
            for filter in filters {
                let mut plan = plan.clone();
                plan.resolve = Resolve::Inverse(*filter);
                let frame = render(&scene, &view, &plan, &RenderOptions::default()).unwrap();
                let wrong = frame.image.rgb.iter().position(|rgb| *rgb != colour);
                assert_eq!(
                    wrong, None,
                    "{} {filter:?} at {width} x {height}",
                    plan.method
                );
                assert_eq!(frame.work.pixels_resolved, u64::from(width * height));
            }
        }
    }
}

/// Samples that are shaded are those that the plan counts, in either form.
#[test]
fn the_plan_counts_what_is_drawn() {
    let view = study_view(160, 90);
    for plan in plans(view.optics.size) {
        for plan in [published(&plan), plan] {
            let frame = render(&STUDY, &view, &plan, &RenderOptions::default()).unwrap();
            let shaded = frame.work.samples_shaded + frame.work.samples_sky;
            assert_eq!(shaded, plan.count().shadings(), "{}", plan.method);
            let last = plan.passes.last().unwrap();
            let dead = last.lattice.samples() - last.live();
            assert_eq!(frame.work.samples_dead, dead);
            assert!(
                frame
                    .image
                    .rgb
                    .iter()
                    .flatten()
                    .all(|c| c.is_finite() && *c >= 0.0)
            );
        }
    }
}

#[test]
fn threads_and_instructions_do_not_matter() {
    let view = study_view(160, 90);
    for (k, mut plan) in forms(view.optics.size).into_iter().enumerate() {
        plan.resolve = Resolve::Inverse(filters()[(5 * k + 3) % filters().len()]);
        let draw = |threads: usize, simd| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let options = RenderOptions {
                simd,
                ..RenderOptions::default()
            };
            let frame = pool
                .unwrap()
                .install(|| render(&STUDY, &view, &plan, &options));
            let frame = frame.unwrap();
            (bits(&frame.image), frame.work)
        };
        let one = draw(1, Simd::Auto);
        assert!(one == draw(2, Simd::Auto), "{}", plan.method);
        assert!(one == draw(7, Simd::Scalar), "{}", plan.method);
    }
}

/// Where samples lie as close as pixels, the image is near the one at full resolution; it comes nearer as
/// sigma falls, and a mean over the samples of a pixel is nearer than one of them where there are many.
#[test]
fn images_come_near_full_resolution() {
    let view = study_view(320, 180);
    let full = SamplePlan::full(view.eye, view.optics.size);
    let options = RenderOptions::default();
    let full = render(&STUDY, &view, &full, &options).unwrap().image;
    let gaze = DVec2::new(160.0, 90.0);
    let error = |plan: &SamplePlan, reach: f64| {
        let image = render(&STUDY, &view, plan, &options).unwrap().image;
        let (mut sum, mut count) = (0.0, 0u32);
        for (k, (a, b)) in image.rgb.iter().zip(&full.rgb).enumerate() {
            let px = DVec2::new((k % 320) as f64 + 0.5, (k / 320) as f64 + 0.5);
            if px.distance(gaze) < reach {
                sum += (0..3)
                    .map(|c| f64::from((a[c] - b[c]).powi(2)))
                    .sum::<f64>();
                count += 3;
            }
        }
        (sum / f64::from(count)).sqrt()
    };
    let at = |sigma, alpha| kernel(view.optics.size, sigma, alpha, gaze);
    assert!(error(&at(1.0, 1.0), 1e3) < error(&at(3.0, 1.0), 1e3));
    let (dense, sparse) = (error(&at(1.8, 1.0), 20.0), error(&at(1.8, 0.25), 20.0));
    assert!(dense < sparse, "{dense} {sparse}");
    let mut averaged = at(1.8, 4.0);
    let plain = error(&averaged, 8.0);
    averaged.resolve = Resolve::Inverse(Filter {
        mips: true,
        ..BILINEAR
    });
    let averaged = error(&averaged, 8.0);
    assert!(plain < 0.05 && averaged < 0.05, "{plain} {averaged}");
}

/// A lattice that wraps shows no seam: a sky that varies smoothly varies as little across the ray where
/// rows begin as elsewhere.
#[test]
fn there_is_no_seam_where_rows_begin() {
    let study: &Scene = &STUDY;
    let sky = Scene::new(
        Vec::new(),
        Vec::new(),
        study.materials().to_vec(),
        study.sky().clone(),
        *study.sun(),
    );
    let Ok(scene) = sky else {
        unreachable!("a sky without things")
    };
    assert!(!matches!(scene.sky(), Sky::Uniform(_)));
    let view = study_view(200, 150);
    let gaze = DVec2::new(60.0, 75.0);
    let plan = kernel(view.optics.size, 3.0, 1.0, gaze);
    let image = render(&scene, &view, &plan, &RenderOptions::default())
        .unwrap()
        .image;
    let full = SamplePlan::full(view.eye, view.optics.size);
    let full = render(&scene, &view, &full, &RenderOptions::default())
        .unwrap()
        .image;
    let step = |image: &Image, x: u32, y: u32| {
        let at = |y: u32| image.rgb[(y * 200 + x) as usize];
        (0..3)
            .map(|c| (at(y + 1)[c] - at(y)[c]).abs())
            .fold(0.0, f32::max)
    };
    let most = |image: &Image| (90..190).map(|x| step(image, x, 74)).fold(0.0, f32::max);
    let others = |image: &Image| {
        let rows = (20..130u32).filter(|y| y.abs_diff(74) > 10);
        rows.flat_map(|y| (90..190).map(move |x| (x, y)))
            .map(|(x, y)| step(image, x, y))
            .fold(0.0, f32::max)
    };
    assert!(most(&image) <= others(&image).max(2.0 * most(&full)));
}
