//! The fast SSIM against scikit-image, against its own definition, and against itself on any number
//! of threads.

use foveasim_models::{Role, Stream};
use foveasim_quality::{Plane, QualityError, ssim, ssim_by_definition};
use glam::UVec2;
use proptest::prelude::*;

/// scikit-image on the 8-bit grey pairs in `tests/data`: name, SSIM of the interior, mean of the
/// uncropped map (`full=True`).
const PAIRS: [(&str, f64, f64); 3] = [
    (
        "01_gradient_vs_noisy",
        0.272_927_416_177_187_47,
        0.281_209_797_851_053_1,
    ),
    (
        "02_checker_vs_boxblur3",
        0.765_200_937_075_343_8,
        0.765_369_294_468_927_8,
    ),
    (
        "03_zoneplate_vs_shift1",
        0.739_011_189_764_447_6,
        0.721_485_623_171_503_6,
    ),
];

fn grey(name: &str) -> Plane {
    let path = format!("{}/tests/data/{name}.png", env!("CARGO_MANIFEST_DIR"));
    let image = image::open(&path)
        .unwrap_or_else(|e| panic!("{path}: {e}"))
        .to_luma8();
    let values = image.as_raw().iter().map(|&v| f64::from(v)).collect();
    Plane::new(UVec2::new(image.width(), image.height()), values).unwrap()
}

/// Random values 0 to 255 that resemble each other as far as `noise` allows.
fn random_pair(size: UVec2, noise: f64, seed: u64) -> (Plane, Plane) {
    let mut random = Stream::new(seed, Role::Jitter, 0);
    let n = (size.x * size.y) as usize;
    let a: Vec<f64> = (0..n).map(|_| 255.0 * random.uniform()).collect();
    let b: Vec<f64> = a
        .iter()
        .map(|v| (v + noise * (random.uniform() - 0.5)).clamp(0.0, 255.0))
        .collect();
    (Plane::new(size, a).unwrap(), Plane::new(size, b).unwrap())
}

#[test]
fn equals_scikit_image() {
    for (name, interior, whole) in PAIRS {
        let (a, b) = (grey(&format!("{name}_a")), grey(&format!("{name}_b")));
        for result in [ssim(&a, &b).unwrap(), ssim_by_definition(&a, &b).unwrap()] {
            assert!(
                (result.mean - interior).abs() < 1e-9,
                "{name}: {} not {interior}",
                result.mean
            );
            let mean = foveasim_models::math::mean(result.map.values());
            assert!(
                (mean - whole).abs() < 1e-9,
                "{name}, with border: {mean} not {whole}"
            );
        }
    }
}

#[test]
fn same_bits_on_any_number_of_threads() {
    let (a, b) = random_pair(UVec2::new(203, 331), 40.0, 7);
    let on = |n| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(n)
            .build()
            .unwrap();
        pool.install(|| ssim(&a, &b).unwrap())
    };
    assert_eq!(on(1), on(2));
    assert_eq!(on(1), on(7));
}

#[test]
fn an_image_is_entirely_like_itself() {
    let (a, _) = random_pair(UVec2::new(40, 30), 0.0, 3);
    let result = ssim(&a, &a).unwrap();
    assert_eq!(result.mean, 1.0);
    assert!(result.map.values().iter().all(|&v| v == 1.0));
}

#[test]
fn smaller_than_the_window_is_refused() {
    let (a, _) = random_pair(UVec2::new(10, 50), 0.0, 1);
    let error = ssim(&a, &a).unwrap_err();
    assert_eq!(
        error.to_string(),
        "SSIM of an image of 10 x 50 pixels: both sides must be at least 11, the window's"
    );
    let (b, _) = random_pair(UVec2::new(50, 10), 0.0, 1);
    assert!(matches!(
        ssim(&a, &b),
        Err(QualityError::SizesDiffer { .. })
    ));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// Values reach 510² in the filtered squares, so each of their roundings is up to 510²·2⁻⁵³ and
    /// some tens of them meet in a variance: a few times 10⁻¹⁰, over a denominator of at least C₂ ≈ 58.
    #[test]
    fn fast_equals_definition(
        w in 11u32..40, h in 11u32..150, noise in 0.0f64..300.0, seed in 0u64..1000
    ) {
        let (a, b) = random_pair(UVec2::new(w, h), noise, seed);
        let (fast, slow) = (ssim(&a, &b).unwrap(), ssim_by_definition(&a, &b).unwrap());
        for (f, s) in fast.map.values().iter().zip(slow.map.values()) {
            prop_assert!((f - s).abs() < 2e-11, "{f} not {s}");
        }
        prop_assert!((fast.mean - slow.mean).abs() < 2e-11);
    }
}
