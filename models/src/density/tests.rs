use glam::{DVec2, UVec2};

use super::*;

fn near(a: f64, b: f64, relative: f64) {
    assert!((a - b).abs() <= relative * b.abs(), "{a} {b}");
}

/// Rays of a Gaussian, σ and share of 1024² (computed independently in high precision).
#[test]
fn rays_of_gaussians() {
    let (size, pixels) = (DVec2::splat(1024.0), UVec2::splat(1024));
    for (sigma, plane, centre, mean) in [
        (
            50.0,
            15_707.963_267_948_966,
            15_707.963_267_948_964,
            0.013_835_797_446_381_4,
        ),
        (
            100.0,
            62_831.853_071_795_864,
            62_831.814_677_058_755,
            0.050_947_040_290_612_415,
        ),
        (
            150.0,
            141_371.669_411_540_7,
            141_190.281_625_084,
            0.105_148_835_269_745_08,
        ),
        (
            200.0,
            251_327.412_287_183_46,
            246_093.551_589_671_7,
            0.170_801_990_351_992_7,
        ),
    ] {
        let density = RayDensity::gaussian(sigma).unwrap();
        near(density.on_plane(), plane, 1e-14);
        near(density.on_display(size), centre, 1e-13);
        near(density.mean_fraction(pixels).unwrap(), mean, 1e-12);
        near(density.in_disc(1e5), plane, 1e-12);
    }
    let sigma = |d: RayDensity| match d {
        RayDensity::Gaussian { sigma_px, .. } => sigma_px,
        RayDensity::Mar { .. } => unreachable!(),
    };
    let unclipped = RayDensity::gaussian_of_fraction(0.08, size).unwrap();
    near(sigma(unclipped), 115.546_026_710_580_38, 1e-13);
    let mean = RayDensity::gaussian_of_mean_fraction(0.08, pixels).unwrap();
    near(sigma(mean), 128.390_074_352_275_2, 1e-9);
}

/// The Gaussian that follows acuity best (computed independently in high precision).
#[test]
fn gaussians_do_not_follow_acuity() {
    use FitTarget::*;
    use FitWeight::*;
    for (slope, target, weight, to, sigma, rms, max, at) in [
        (
            0.0275,
            Acuity,
            Line,
            5.0,
            0.987_098_406_204_523_2,
            0.170_616_035_822_167_22,
            0.277_460_200_822_172_4,
            0.519_75,
        ),
        (
            0.0275,
            Density,
            Line,
            10.0,
            0.364_170_949_092_716_4,
            0.064_205_621_242_356_88,
            0.234_118_996_586_617_4,
            0.201,
        ),
        (
            0.0275,
            Acuity,
            Area,
            20.0,
            1.350_409_735_759_409_4,
            0.069_475_266_139_515_53,
            0.354_800_387_100_874_6,
            0.726,
        ),
        (
            0.0220,
            Density,
            Area,
            30.0,
            0.561_239_008_765_261_6,
            0.012_243_022_635_957_255,
            0.291_370_105_424_146_6,
            0.324,
        ),
        (
            0.0220,
            Acuity,
            Line,
            5.0,
            1.233_086_638_961_231_4,
            0.176_504_943_698_151_03,
            0.277_306_356_753_483_9,
            0.649_25,
        ),
    ] {
        let acuity = crate::Acuity::new(slope).unwrap();
        let fit = GaussianFit::new(acuity, target, weight, to).unwrap();
        near(fit.sigma_deg, sigma, 1e-7);
        near(fit.rms, rms, 2e-4);
        near(fit.max_error, max, 1e-5);
        assert!((fit.max_at_deg - at).abs() <= to / 10_000.0, "{fit:?}");
    }
}

/// Closed forms against sums over a fine grid.
#[test]
fn integrals_are_what_sums_approach() {
    let mar = RayDensity::of_parts(1.4, 30.0).unwrap();
    let bell = RayDensity::gaussian(20.0)
        .unwrap()
        .with_floor(0.01)
        .unwrap();
    let area = Rect {
        min: DVec2::new(-37.0, 4.0),
        max: DVec2::new(55.0, 70.0),
    };
    for density in [mar, bell, RayDensity::of_parts(0.6, 30.0).unwrap()] {
        const FINE: i32 = 8;
        let step = 1.0 / f64::from(FINE);
        let mut sum = 0.0;
        for j in 4 * FINE..70 * FINE {
            for i in -37 * FINE..55 * FINE {
                let at = (DVec2::new(f64::from(i), f64::from(j)) + 0.5) * step;
                sum += density.at(at.length());
            }
        }
        near(density.in_rect(area), sum * step * step, 1e-5);
        let mut disc = 0.0;
        for k in 0..80_000 {
            let r = (f64::from(k) + 0.5) * 1e-3;
            disc += TAU * r * density.at(r) * 1e-3;
        }
        near(density.in_disc(80.0), disc, 1e-6);
    }
}

#[test]
fn acuity_gives_a_plateau_where_pixels_are_coarser_than_the_eye() {
    // 30 pixels per degree: one each 2/60 of a degree, where the fovea could tell 1/96 apart.
    let viewport =
        Viewport::symmetric(UVec2::splat(1024), 512.0 * crate::math::tan_deg(1.0 / 30.0)).unwrap();
    let density = RayDensity::mar(Acuity::default(), &viewport).unwrap();
    let RayDensity::Mar { peak, half_px } = density else {
        unreachable!()
    };
    near(peak, 3.2, 1e-3);
    near(half_px, 0.757_575 * 30.0, 1e-3);
    assert_eq!(density.at(half_px * (peak - 1.0) * 0.99), 1.0);
    assert!(density.at(half_px * (peak - 1.0) * 1.01) < 1.0);
    let (tenth, slope) = RayDensity::mar_of_fraction(0.1, Acuity::default(), &viewport).unwrap();
    near(
        tenth.on_display(DVec2::splat(1024.0)),
        0.1 * 1024.0 * 1024.0,
        1e-9,
    );
    assert!(slope > 0.01 && slope < 1.0, "{slope}");
    assert!(RayDensity::mar_of_fraction(1.1, Acuity::default(), &viewport).is_err());
    assert!(RayDensity::gaussian(f64::NAN).is_err());
    assert!(RayDensity::gaussian_of_fraction(0.0, DVec2::splat(10.0)).is_err());
}
