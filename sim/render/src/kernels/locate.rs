use fearless_simd::prelude::*;
use foveasim_models::LogPolar;

use super::Kernel;
use super::lanes::Simd;
use super::transcendental::{log2, times_exp2, turns};
use super::wide::{F, WIDTH, max, min, piece, splat};

/// The inverse of a log-polar map in single precision.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PolarInverse {
    gaze_px: [f64; 2],
    /// 1 / 2·log₂ of the farthest distance.
    per_log2: f32,
    /// 1/α.
    inverse_alpha: f32,
    /// Lattice steps outwards and around.
    samples: [f32; 2],
}

impl PolarInverse {
    pub(crate) fn new(map: &LogPolar) -> Self {
        let samples = map.samples();
        Self {
            gaze_px: map.gaze_px().to_array(),
            per_log2: (0.5 * std::f64::consts::LN_2 / map.log_reach()) as f32,
            inverse_alpha: (1.0 / map.alpha()) as f32,
            samples: [samples.x as f32, samples.y as f32],
        }
    }
}

/// Finds where the pixels of a display row lie in a log-polar lattice: for each its lattice x and y, the
/// latter from 0 to below n_y.
///
/// Against [`LogPolar::lattice_from_display`] what a place stands for is off by less than 0.02 pixels, for
/// α from 0.05 to 20 and displays of up to 2000 pixels from gaze to corner; two places within one pixel of the
/// gaze are one, as there.
pub(crate) struct LocateRow<'a> {
    pub(crate) inverse: &'a PolarInverse,
    /// Which row.
    pub(crate) y: u32,
    /// Room for the row, and for as many as fill the last lanes.
    pub(crate) x_out: &'a mut [f32],
    pub(crate) y_out: &'a mut [f32],
}

impl Kernel for LocateRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let i = self.inverse;
        let dy = splat(simd, (f64::from(self.y) + 0.5 - i.gaze_px[1]) as f32);
        let rows = self.x_out.chunks_exact_mut(WIDTH);
        for (k, (x_out, y_out)) in rows.zip(self.y_out.chunks_exact_mut(WIDTH)).enumerate() {
            let first = (k * WIDTH) as f64 + 0.5 - i.gaze_px[0];
            let dx = F::from_slice(simd, &std::array::from_fn::<f32, WIDTH, _>(|k| k as f32))
                + first as f32;
            let square = dx * dx + dy * dy;
            let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
            let x = piece(
                simd,
                #[inline(always)]
                || {
                    // Within one pixel of the gaze r counts as 1.
                    let share = log2(max(square, one)) * i.per_log2;
                    let some = share.simd_gt(0.0);
                    let power = log2(some.select(share, one)) * i.inverse_alpha;
                    some.select(times_exp2(splat(simd, i.samples[0]), power), zero)
                },
            );
            let y = piece(
                simd,
                #[inline(always)]
                || turns(dx, dy) * i.samples[1],
            );
            // Rounding of the product may reach n_y.
            let below = f32::from_bits(i.samples[1].to_bits() - 1);
            x.store_slice(x_out);
            min(y, splat(simd, below)).store_slice(y_out);
        }
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::Map;
    use glam::{DVec2, UVec2};

    use super::*;
    use crate::kernels::dispatch;

    #[test]
    fn places_stand_for_their_pixels() {
        let display = UVec2::new(1280, 1440);
        let samples = display.as_dvec2() / 1.8;
        for alpha in [0.05, 0.25, 1.0, 4.0, 20.0] {
            for gaze in [
                DVec2::new(640.0, 720.0),
                DVec2::new(-3.2, 1500.7),
                DVec2::new(1279.5, 0.5),
            ] {
                let map = LogPolar::new(gaze, display, alpha, samples.ceil()).unwrap();
                let inverse = PolarInverse::new(&map);
                let (mut xs, mut ys) = (vec![0.0; 1280], vec![0.0; 1280]);
                let (mut scalar_xs, mut scalar_ys) = (xs.clone(), ys.clone());
                let mut worst = 0.0f64;
                for y in (0..1440).step_by(7).chain(700..730) {
                    let locate = |simd, xs: &mut [f32], ys: &mut [f32]| {
                        let kernel = LocateRow {
                            inverse: &inverse,
                            y,
                            x_out: xs,
                            y_out: ys,
                        };
                        dispatch(simd, kernel);
                    };
                    locate(crate::Simd::Auto, &mut xs, &mut ys);
                    locate(crate::Simd::Scalar, &mut scalar_xs, &mut scalar_ys);
                    assert_eq!((&xs, &ys), (&scalar_xs, &scalar_ys));
                    for x in 0..1280 {
                        let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                        let found = DVec2::new(xs[x as usize].into(), ys[x as usize].into());
                        assert!(found.y < samples.ceil().y);
                        let back = map.display_from_lattice(found);
                        if px.distance(gaze) >= 1.0 {
                            worst = worst.max(back.distance(px));
                        } else {
                            assert_eq!(found.x, 0.0);
                        }
                        let exact = Map::LogPolar(map).lattice_from_display(px);
                        assert!(exact.is_finite());
                    }
                }
                assert!(worst < 0.02, "alpha {alpha}, gaze {gaze}: {worst} px");
            }
        }
    }
}
