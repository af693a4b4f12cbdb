//! SSIM of two 1920×1080 planes, on one thread and on all, and a whole comparison.
//!
//! `cargo bench --bench ssim`. Peers on the same job (2 cores): scikit-image 303 ms, OpenCV with numpy
//! 54 ms.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use foveasim::models::{Image, Role, Stream, Viewport};
use foveasim::quality::{Plane, Rings, compare, ssim};
use glam::{DVec3, UVec2};

const SIZE: UVec2 = UVec2::new(1920, 1080);

fn planes() -> (Plane, Plane) {
    let mut random = Stream::new(1, Role::Jitter, 0);
    let n = SIZE.x as usize * SIZE.y as usize;
    let a: Vec<f64> = (0..n).map(|_| random.range(0.0, 255.0)).collect();
    let b = a
        .iter()
        .map(|v| (v + random.range(0.0, 20.0)).min(255.0))
        .collect();
    let plane = |values| Plane::new(SIZE, values).expect("as many values as pixels, all finite");
    (plane(a), plane(b))
}

fn benches(c: &mut Criterion) {
    let (a, b) = planes();
    let one = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("one thread");
    c.bench_function("ssim/1080p/one_thread", |bench| {
        bench.iter(|| one.install(|| ssim(black_box(&a), &b)));
    });
    c.bench_function("ssim/1080p/all_threads", |bench| {
        bench.iter(|| ssim(black_box(&a), &b))
    });

    let reference = Image::filled(SIZE, [0.3, 0.2, 0.5]);
    let mut image = reference.clone();
    for (i, p) in image.rgb.iter_mut().enumerate() {
        p[0] = (i % 97) as f32 / 97.0;
    }
    c.bench_function("compare/1080p", |bench| {
        bench.iter(|| compare(black_box(&image), &reference));
    });
    let comparison = compare(&image, &reference).expect("equal sizes");
    let viewport = Viewport::symmetric(SIZE, 0.432).expect("a valid image plane");
    c.bench_function("rings/1080p", |bench| {
        bench.iter(|| comparison.rings(black_box(&viewport), DVec3::NEG_Z, &Rings::default()));
    });
}

criterion_group!(ssim_benches, benches);
criterion_main!(ssim_benches);
