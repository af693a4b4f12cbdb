//! Measures by ring of eccentricity, on images whose answers are known.

use foveasim_models::{Image, Viewport, linear_from_srgb, math};
use foveasim_quality::{Comparison, QualityError, Rings, compare};
use glam::{DVec2, DVec3, UVec2};

const SIZE: UVec2 = UVec2::new(320, 240);

fn viewport() -> Viewport {
    Viewport::symmetric(SIZE, 0.9).unwrap()
}

/// An image of 8-bit grey levels.
fn grey(level: impl Fn(u32, u32) -> u8) -> Image {
    let mut image = Image::filled(SIZE, [0.0; 3]);
    for y in 0..SIZE.y {
        for x in 0..SIZE.x {
            let linear = linear_from_srgb(f64::from(level(x, y)) / 255.0) as f32;
            image.rgb[(y * SIZE.x + x) as usize] = [linear; 3];
        }
    }
    image
}

fn brighter_outside(degrees: f64, gaze: DVec3) -> Comparison {
    let reference = grey(|_, _| 100);
    let image = grey(|x, y| {
        let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        if viewport().eccentricity_deg(px, gaze) < degrees {
            100
        } else {
            110
        }
    });
    compare(&image, &reference).unwrap()
}

#[test]
fn a_difference_shows_in_its_ring_only() {
    let gaze = DVec3::new(0.2, -0.1, -1.0);
    let comparison = brighter_outside(20.0, gaze);
    let rings = comparison
        .rings(&viewport(), gaze * 3.0, &Rings::default())
        .unwrap();
    assert_eq!(
        rings.iter().map(|r| r.pixels).sum::<u64>(),
        u64::from(SIZE.x * SIZE.y)
    );
    for ring in &rings {
        if ring.from_deg < 20.0 {
            assert_eq!(ring.psnr_db, Some(f64::INFINITY), "{ring:?}");
            assert_eq!(ring.bias, Some(0.0));
        } else {
            // Ten grey levels everywhere: 20·log₁₀ 25.5. Luma of a grey is a rounded sum of three.
            assert!(
                (ring.psnr_db.unwrap() - 28.130_803_608_679_1).abs() < 1e-9,
                "{ring:?}"
            );
            assert!((ring.bias.unwrap() - 10.0).abs() < 1e-11);
        }
    }
    assert!(rings[0].ssim.unwrap() == 1.0 && rings[5].ssim.unwrap() < 1.0);
    assert!(comparison.whole.bias > 0.0 && comparison.whole.psnr_luma_db.is_finite());
}

#[test]
fn a_ring_covers_its_solid_angle() {
    // About the axis a ring between e0 and e1 is an annulus of tangents on the image plane.
    let comparison = brighter_outside(5.0, DVec3::NEG_Z);
    let rings = Rings::new(vec![5.0, 15.0, 30.0]).unwrap();
    let found = comparison.rings(&viewport(), DVec3::NEG_Z, &rings).unwrap();
    let area = |deg: f64| std::f64::consts::PI * math::tan_deg(deg) * math::tan_deg(deg);
    let pixel = viewport().pixel_tan();
    for ring in &found[..2] {
        let expected = (area(ring.to_deg.unwrap()) - area(ring.from_deg)) / (pixel.x * pixel.y);
        // Gauss's circle problem: the count is off by far less than the circumference in pixels.
        assert!(
            (ring.pixels as f64 / expected - 1.0).abs() < 2e-3,
            "{ring:?} {expected}"
        );
    }
}

#[test]
fn a_ring_without_pixels_says_so() {
    let rings = Rings::new(vec![0.0, 80.0]).unwrap();
    let found = brighter_outside(5.0, DVec3::NEG_Z)
        .rings(&viewport(), DVec3::NEG_Z, &rings)
        .unwrap();
    assert_eq!(
        (
            found[1].pixels,
            found[1].psnr_db,
            found[1].ssim,
            found[1].bias
        ),
        (0, None, None, None)
    );
}

#[test]
fn equal_images_are_infinitely_close() {
    let image = grey(|x, y| (x ^ y) as u8);
    let whole = compare(&image, &image).unwrap().whole;
    assert_eq!(
        (whole.psnr_luma_db, whole.psnr_rgb_db),
        (f64::INFINITY, f64::INFINITY)
    );
    assert_eq!((whole.ssim, whole.bias, whole.max_abs), (1.0, 0.0, 0.0));
}

#[test]
fn what_makes_no_sense_is_refused() {
    for edges in [
        vec![],
        vec![5.0, 2.0],
        vec![0.0, f64::NAN],
        vec![-1.0, 3.0],
        vec![0.0, 90.0],
    ] {
        assert!(matches!(
            Rings::new(edges),
            Err(QualityError::RingEdges { .. })
        ));
    }
    let comparison = brighter_outside(5.0, DVec3::NEG_Z);
    let gaze = DVec3::new(f64::NAN, 0.0, -1.0);
    let refused = comparison.rings(&viewport(), gaze, &Rings::default());
    assert!(matches!(refused, Err(QualityError::Gaze { .. })));
    let other = Viewport::symmetric(UVec2::new(100, 50), 0.9).unwrap();
    let refused = comparison.rings(&other, DVec3::NEG_Z, &Rings::default());
    assert!(matches!(refused, Err(QualityError::ViewportDiffers { .. })));
}
