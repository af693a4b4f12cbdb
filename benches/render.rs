//! The study scene at 1920×1080: full resolution and layers, vector and scalar kernels.
//!
//! `cargo bench --bench render`

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use foveasim::assets::{study_camera, study_scene};
use foveasim::models::foveation::{Method, Request};
use foveasim::models::{View, presets};
use foveasim::render::{RenderOptions, Simd, render};

fn study_scene_1080p(c: &mut Criterion) {
    let display = presets::display("lg-w2363d").expect("a preset");
    let request = Request::ahead(display.primary());
    let scene = study_scene(1);
    let view = View::still(request.eye, request.viewport, study_camera(0.093, 1));
    let mut group = c.benchmark_group("study_scene_1080p");
    group.sample_size(10);
    for (method, simd) in [
        ("full", Simd::Auto),
        ("layers:3", Simd::Auto),
        ("full", Simd::Scalar),
    ] {
        let plan = method
            .parse::<Method>()
            .and_then(|m| m.plan(&request))
            .expect("a method of this display");
        let options = RenderOptions {
            simd,
            ..RenderOptions::default()
        };
        group.bench_function(format!("{method} {simd:?}"), |b| {
            b.iter(|| render(&scene, black_box(&view), &plan, &options).expect("a drawable plan"));
        });
    }
    group.finish();
}

criterion_group!(benches, study_scene_1080p);
criterion_main!(benches);
