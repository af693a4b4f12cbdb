//! Images from what rays saw.

use foveasim_mask::{Interpolation, Mask, MaskError, MaskSpec, PlacedMask, StepLaw};
use foveasim_models::RayDensity;
use glam::{DVec2, UVec2};

const DISPLAY: UVec2 = UVec2::new(75, 50);

fn mask(interpolation: Interpolation) -> Mask {
    let density = RayDensity::gaussian(18.0)
        .unwrap()
        .with_floor(0.01)
        .unwrap();
    let spec = MaskSpec {
        interpolation,
        ..MaskSpec::new(DISPLAY, density, 4)
    };
    Mask::build(&spec, &|_| {}).unwrap()
}

fn gazes() -> impl Iterator<Item = DVec2> {
    let far = DISPLAY.as_dvec2();
    [
        far / 2.0,
        DVec2::ZERO,
        far,
        DVec2::new(0.0, far.y),
        DVec2::new(31.4, 17.9),
        DVec2::new(-1e9, 20.0),
        DVec2::NAN,
    ]
    .into_iter()
}

fn image(placed: &PlacedMask<'_>, of: impl Fn(DVec2) -> [f32; 4]) -> Vec<[f32; 4]> {
    let values: Vec<_> = (0..placed.rays()).map(|k| of(placed.position(k))).collect();
    let mut pixels = vec![[f32::NAN; 4]; DISPLAY.element_product() as usize];
    placed.reconstruct(&values, &mut pixels).unwrap();
    pixels
}

/// What is constant stays so to the bit, wherever the eye looks; all rays are on the display, and no pixel is left out.
#[test]
fn constants_stay_constant() {
    let colour = [0.1, 0.7, 123.456, 1.0];
    for interpolation in Interpolation::ALL {
        let mask = mask(interpolation);
        for gaze in gazes() {
            let placed = PlacedMask::new(&mask, gaze);
            assert!(placed.rays() > 100);
            for k in 0..placed.rays() {
                let at = placed.position(k);
                assert!(at.cmpge(DVec2::ZERO).all() && at.cmple(DISPLAY.as_dvec2()).all());
            }
            assert!(image(&placed, |_| colour).iter().all(|p| *p == colour));
        }
    }
}

/// What is linear stays so within what compact weights allow, but where sites beside the display count.
#[test]
fn linear_images_stay_linear() {
    let mask = mask(Interpolation::Natural);
    let placed = PlacedMask::new(&mask, DVec2::new(40.0, 22.0));
    let pixels = image(&placed, |p| {
        [p.x as f32, p.y as f32, (p.x - 2.0 * p.y) as f32, 1.0]
    });
    let mut worst = 0f32;
    for y in 12..38 {
        for x in 14..61 {
            let [a, b, c, _] = pixels[y * 75 + x];
            let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
            for error in [a - px, b - py, c - (px - 2.0 * py)] {
                worst = worst.max(error.abs());
            }
        }
    }
    // Eight sites, 20 px away, each 2⁻¹⁶ off.
    assert!(worst < 8.0 * 20.0 / 65_536.0, "{worst}");
}

/// The pixels are those that the weights of the shifted mask say, taken one by one.
#[test]
fn pixels_are_what_weights_say() {
    for interpolation in Interpolation::ALL {
        let mask = mask(interpolation);
        for gaze in gazes() {
            let placed = PlacedMask::new(&mask, gaze);
            let pixels = image(&placed, |p| {
                [(p.x * 0.37).sin() as f32, p.y as f32, 0.0, 1.0]
            });
            let origin = DISPLAY - placed.gaze_px();
            for y in 0..DISPLAY.y {
                for x in 0..DISPLAY.x {
                    let from = mask.weights().at(origin + UVec2::new(x, y));
                    let mut expected = 0.0;
                    for n in from {
                        let slot = placed.live().binary_search(&n.site);
                        let at = placed.position(slot.expect("pixels take from live sites"));
                        expected += n.weight * (at.x * 0.37).sin();
                    }
                    let found = f64::from(pixels[(y * DISPLAY.x + x) as usize][0]);
                    assert!(
                        (found - expected).abs() < 2e-6,
                        "{x} {y} {found} {expected}"
                    );
                }
            }
        }
    }
}

/// Of a smooth picture natural neighbours and triangles leave a fraction of the error of nearest sites; and the fovea, at
/// full rate, is without error.
#[test]
fn smoother_is_closer() {
    let of = |p: DVec2| [(0.5 + 0.5 * (p.x * 0.11).sin() * (p.y * 0.09).cos()) as f32; 4];
    let errors = Interpolation::ALL.map(|interpolation| {
        let mask = mask(interpolation);
        let placed = PlacedMask::new(&mask, DISPLAY.as_dvec2() / 2.0);
        let pixels = image(&placed, of);
        let mut rings = [(0.0, 0); 2];
        for y in 0..DISPLAY.y {
            for x in 0..DISPLAY.x {
                let at = UVec2::new(x, y).as_dvec2() + 0.5;
                let error = pixels[(y * DISPLAY.x + x) as usize][0] - of(at)[0];
                // The gaze is rounded to pixel (38, 25).
                let ring = usize::from(at.distance(DVec2::new(38.0, 25.0)) > 11.0);
                rings[ring] = (rings[ring].0 + f64::from(error * error), rings[ring].1 + 1);
            }
        }
        rings.map(|(sum, count)| (sum / f64::from(count)).sqrt())
    });
    let [nearest, barycentric, natural] = errors;
    assert!(errors.iter().all(|e| e[0] == 0.0), "{errors:?}");
    assert!(natural[1] < 0.3 * nearest[1] && barycentric[1] < 0.3 * nearest[1]);
    assert!(natural[1] < 1.2 * barycentric[1], "{errors:?}");
}

#[test]
fn steps_follow_the_mask() {
    let mask = mask(Interpolation::Natural);
    let placed = PlacedMask::new(&mask, DISPLAY.as_dvec2() / 2.0);
    let law = StepLaw::Spacing {
        scale: 1.0,
        most: 4.0,
    };
    let steps: Vec<f32> = (0..placed.rays()).map(|k| placed.step(k, law)).collect();
    assert!(steps.iter().all(|s| (1.0..=4.0).contains(s)));
    assert!(steps.contains(&1.0) && steps.iter().any(|s| *s > 2.5));
    assert!((0..placed.rays()).all(|k| placed.step(k, StepLaw::Equal) == 1.0));
    let farthest = (0..placed.rays())
        .map(|k| placed.step(k, StepLaw::AUTHORS))
        .fold(0.0, f32::max);
    // Half the diagonal is 45 px, and rays beside the display are a little farther.
    assert!((1.08..1.12).contains(&farthest), "{farthest}");
}

#[test]
fn lengths_are_checked() {
    let mask = mask(Interpolation::Nearest);
    let placed = PlacedMask::new(&mask, DVec2::ZERO);
    let mut pixels = vec![[0.0; 4]; DISPLAY.element_product() as usize];
    let values = vec![[0.0; 4]; placed.rays()];
    let short = placed.reconstruct(&values[1..], &mut pixels);
    assert!(matches!(
        short,
        Err(MaskError::Length {
            what: "values of rays",
            ..
        })
    ));
    let few = placed.reconstruct(&values, &mut pixels[1..]);
    assert!(matches!(few, Err(MaskError::Length { what: "pixels", .. })));
}

#[test]
fn images_do_not_depend_on_threads() {
    let mask = mask(Interpolation::Natural);
    let placed = PlacedMask::new(&mask, DVec2::new(11.0, 45.0));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| image(&placed, |p| [p.x.sin() as f32, p.y as f32, 0.3, 1.0]))
    };
    assert_eq!(with(1), with(3));
}
