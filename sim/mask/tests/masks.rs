//! What must hold for every mask, and that it depends on nothing but its specification.

use foveasim_mask::{Hysteresis, Interpolation, Mask, MaskSpec, SpacingStatistics, WEIGHT_STEP};
use foveasim_models::RayDensity;
use glam::{DVec2, UVec2};

fn build(spec: &MaskSpec) -> Mask {
    Mask::build(spec, &|_| {}).unwrap()
}

fn densities() -> [RayDensity; 4] {
    [
        RayDensity::gaussian(14.0).unwrap(),
        RayDensity::gaussian(9.0).unwrap().with_floor(0.02).unwrap(),
        RayDensity::of_parts(2.0, 6.0).unwrap(),
        RayDensity::of_parts(0.7, 15.0).unwrap(),
    ]
}

/// Every cell ends with its share of the density, all shares are the whole, and so there are about as many sites as rays.
#[test]
fn cells_hold_their_share() {
    for (k, density) in densities().into_iter().enumerate() {
        for hysteresis in [Hysteresis::PUBLISHED, Hysteresis::AUTHORS] {
            let spec = MaskSpec {
                hysteresis,
                ..MaskSpec::new(UVec2::new(60, 44), density, k as u64)
            };
            let mask = build(&spec);
            let found = mask.convergence();
            let last = found.iterations.last().unwrap();
            assert_eq!((last.split, last.merged), (0, 0));
            assert_eq!(last.sites, mask.sites().len() as u64);
            let [least, most] = last.share;
            assert!(least >= 1.0 - last.width / 2.0 && most <= 1.0 + last.width / 2.0);
            for row in &found.iterations {
                assert_eq!(row.total, found.integral);
            }
            // Rounded to 2⁻²⁴, and taken at the middles of quarters of pixels.
            assert!(
                (found.integral / spec.rays() - 1.0).abs() < 2e-3,
                "{density:?}"
            );
            let (_, ratio, [low, high]) = found.ratio().unwrap();
            assert!(ratio >= low && ratio <= high, "{ratio} {low} {high}");
            let area: f64 = mask.spacing().iter().map(|s| f64::from(s * s)).sum();
            assert!((area - f64::from(mask.size().element_product())).abs() < 0.05);
        }
    }
}

/// Where the density is one ray per pixel, each pixel is a ray.
#[test]
fn the_fovea_is_at_full_rate() {
    let spec = MaskSpec::new(
        UVec2::new(60, 44),
        RayDensity::of_parts(3.0, 6.0).unwrap(),
        7,
    );
    let mask = build(&spec);
    let middle = mask.size().as_dvec2() / 2.0;
    let mut pixels = 0;
    for y in 0..mask.size().y {
        for x in 0..mask.size().x {
            let at = UVec2::new(x, y);
            if (at.as_dvec2() + 0.5).distance(middle) < 10.0 {
                let from = mask.weights().at(at);
                assert_eq!(from.len(), 1);
                assert_eq!(mask.sites()[from[0].site as usize], at.as_dvec2() + 0.5);
                pixels += 1;
            }
        }
    }
    assert!(pixels > 300);
}

/// Every pixel has weights, of whole parts that sum up to one; linear functions come back within what quantised weights
/// allow, but where cells are cut by the edge.
#[test]
fn every_pixel_has_its_sites() {
    for interpolation in Interpolation::ALL {
        for density in densities() {
            let spec = MaskSpec {
                interpolation,
                ..MaskSpec::new(UVec2::new(60, 44), density, 3)
            };
            let mask = build(&spec);
            let middle = mask.size().as_dvec2() / 2.0;
            let mut exact = 0;
            for y in 0..mask.size().y {
                for x in 0..mask.size().x {
                    let at = UVec2::new(x, y);
                    let q = at.as_dvec2() + 0.5;
                    let from = mask.weights().at(at);
                    let parts: f64 = from.iter().map(|n| n.weight / WEIGHT_STEP).sum();
                    assert_eq!(parts, 65_536.0);
                    assert!(from.iter().all(|n| n.weight <= from[0].weight));
                    let place = |n: &foveasim_mask::Neighbour| mask.sites()[n.site as usize];
                    let back: DVec2 = from.iter().map(|n| n.weight * place(n)).sum();
                    let reach = from
                        .iter()
                        .map(|n| place(n).distance(q))
                        .fold(0.0, f64::max);
                    // Sites whose weight is less than a part are left out: they lie about a spacing away.
                    let near = f64::from(mask.spacing()[from[0].site as usize]);
                    let allowed = WEIGHT_STEP * 8.0 * reach.max(2.0 * near);
                    if interpolation != Interpolation::Nearest && back.distance(q) <= allowed {
                        exact += 1;
                    } else if interpolation == Interpolation::Nearest {
                        assert_eq!(from.len(), 1);
                        let nearest = |s: &DVec2| s.distance_squared(q);
                        let least = mask
                            .sites()
                            .iter()
                            .map(nearest)
                            .fold(f64::INFINITY, f64::min);
                        assert_eq!(nearest(&place(&from[0])), least);
                    } else {
                        let edge = (middle - (q - middle).abs()).min_element();
                        assert!(edge < 3.0 * reach.max(near), "{at} {from:?}");
                    }
                }
            }
            if interpolation != Interpolation::Nearest {
                // Cells of the narrowest density reach the edge from half way.
                assert!(
                    exact > mask.size().element_product() / 3,
                    "{exact} {density:?}"
                );
            }
        }
    }
}

#[test]
fn masks_do_not_depend_on_threads() {
    let spec = MaskSpec::new(UVec2::new(90, 70), RayDensity::gaussian(16.0).unwrap(), 11);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| build(&spec))
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
    let other = build(&MaskSpec { seed: 12, ..spec });
    assert_ne!(one.sites(), other.sites());
    assert_ne!(spec.key(), other.spec().key());
}

/// Sites keep their distance, have no preferred direction, and pairs no preferred distance but the first.
#[test]
fn no_grid_shows() {
    let spec = MaskSpec::new(UVec2::new(200, 200), RayDensity::gaussian(60.0).unwrap(), 2);
    let found = SpacingStatistics::of(&build(&spec));
    let mut looked_at = 0;
    for ring in found
        .rings
        .iter()
        .filter(|r| r.from_px >= 1.5 && r.sites >= 100)
    {
        let at_random = 4.0 / (ring.sites as f64).sqrt();
        assert!(ring.aligned.iter().all(|a| *a < at_random), "{ring:?}");
        assert!(ring.nearest[0] > 0.5 && ring.nearest[1] > 0.7, "{ring:?}");
        looked_at += ring.sites;
    }
    assert!(looked_at > 500);
    for [distance, ratio] in &found.pairs.bins {
        let wanted = match distance {
            d if *d < 0.4 => 0.0..=0.05,
            d if *d > 2.2 => 0.8..=1.2,
            _ => 0.0..=2.8,
        };
        assert!(wanted.contains(ratio), "{distance} {ratio}");
    }
}

#[test]
fn what_no_mask_can_be_built_from_is_refused() {
    let refused = |spec: &MaskSpec| Mask::build(spec, &|_| {}).unwrap_err().to_string();
    let spec = MaskSpec::new(UVec2::new(60, 44), RayDensity::gaussian(14.0).unwrap(), 0);
    for size in [
        UVec2::ZERO,
        UVec2::new(7, 100),
        UVec2::new(u32::MAX, 8),
        UVec2::splat(8000),
    ] {
        let spec = MaskSpec {
            display_px: size,
            ..spec
        };
        assert!(refused(&spec).contains("sides from 8 to 8192"));
    }
    let step = Hysteresis {
        start: 0.5,
        step: 0.0,
    };
    assert!(
        refused(&MaskSpec {
            hysteresis: step,
            ..spec
        })
        .contains("hysteresis")
    );
    let few = RayDensity::gaussian(0.5).unwrap();
    assert!(
        refused(&MaskSpec {
            density: few,
            ..spec
        })
        .contains("rays of a mask")
    );
    let many = MaskSpec {
        display_px: UVec2::splat(2048),
        ..spec
    };
    let many = MaskSpec {
        density: RayDensity::gaussian(1e4).unwrap(),
        ..many
    };
    assert!(refused(&many).contains("rays of a mask"));
}
