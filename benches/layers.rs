//! How fast displays are planned: the design of layers, the floor, and a drawable plan.
//!
//! `cargo bench --bench layers`

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use foveasim::models::foveation::{
    FloorDensity, LayersSettings, Method, Request, Screen, ideal_samples,
};
use foveasim::models::{Acuity, GazeDirection, presets};

/// 1,000 displays from 10 to 130 degrees and from a quarter of foveal sharpness to foveal.
fn cells() -> Vec<Screen> {
    let acuity = Acuity::default();
    let cell = |k: u32| {
        let fov = 10.0 + 120.0 * f64::from(k % 40) / 39.0;
        let sharpness = 0.25 + 0.75 * f64::from(k / 40) / 24.0;
        Screen::from_sharpness(fov, acuity, sharpness, 0.75).expect("in range")
    };
    (0..1000).map(cell).collect()
}

fn layers(c: &mut Criterion) {
    let cells = cells();
    let acuity = Acuity::default();
    let mut group = c.benchmark_group("plan");
    group.sample_size(20).throughput(Throughput::Elements(3000));
    group.bench_function("1000 cells, n = 2, 3, 4", |b| {
        let settings = [2, 3, 4].map(|n| LayersSettings::new(n).expect("in range"));
        b.iter(|| {
            let design = |s: &LayersSettings, cell| s.design(cell, acuity, 0.0).expect("no margin");
            let total = |cell| {
                settings
                    .iter()
                    .map(|s| design(s, cell).samples())
                    .sum::<f64>()
            };
            black_box(cells.iter().map(total).sum::<f64>())
        });
    });
    group.throughput(Throughput::Elements(1000));
    for (name, gaze) in [
        ("ahead", GazeDirection::AHEAD),
        ("aside", GazeDirection::new(4.0, 3.0)),
    ] {
        group.bench_function(format!("floor of 1000 cells, gaze {name}"), |b| {
            let floor = |cell| {
                let density = FloorDensity::PerSolidAngle;
                ideal_samples(cell, acuity, gaze, 0.0, density).expect("no margin")
            };
            b.iter(|| black_box(cells.iter().map(floor).sum::<f64>()));
        });
    }
    group.throughput(Throughput::Elements(1));
    group.bench_function("drawable plan, study display, n = 3", |b| {
        let display = presets::display("lg-w2363d").expect("a preset");
        let request = Request::ahead(display.primary());
        let method: Method = "layers:3".parse().expect("a method");
        b.iter(|| black_box(method.plan(black_box(&request)).expect("valid")));
    });
    group.finish();
}

criterion_group!(benches, layers);
criterion_main!(benches);
