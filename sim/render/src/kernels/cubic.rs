//! Catmull-Rom interpolation: cubic convolution with a = −½ (Keys 1981, eq. 15). Unlike linear
//! interpolation it keeps what is fine when an image is taken from an image again and again.

use glam::DVec2;

use super::lanes::{F, Simd};

/// Weights of the four samples around a place that lies `f` (0 to 1) after the second of them.
#[inline(always)]
pub(super) fn cubic<S: Simd>(f: F<S>) -> [F<S>; 4] {
    let f2 = f * f;
    [
        f * (f * (f * -0.5 + 1.0) - 0.5),
        f2 * (f * 1.5 - 2.5) + 1.0,
        f * (f * (f * -1.5 + 2.0) + 0.5),
        f2 * (f * 0.5 - 0.5),
    ]
}

/// [`cubic`] of one place.
#[inline(always)]
pub(super) fn cubic_of(f: f32) -> [f32; 4] {
    let f2 = f * f;
    [
        f * (f * (f * -0.5 + 1.0) - 0.5),
        f2 * (f * 1.5 - 2.5) + 1.0,
        f * (f * (f * -1.5 + 2.0) + 0.5),
        f2 * (f * 0.5 - 0.5),
    ]
}

/// What samples that were all taken beside the middles of their cells show in those middles: weights
/// of the 3×3 samples around, a row of them times a column.
///
/// Where samples move in their cells from frame to frame, the picture moves with them. Blending that
/// with a history at rest leaves a part of it: taken back to the middle, the picture rests, and the mean
/// over frames is the picture seen through this kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Centre {
    /// Of the sample to the left, and to the right; what is left to 1 is the sample's own.
    across: [f32; 2],
    /// Of the one above, and below.
    down: [f32; 2],
}

impl Centre {
    /// For samples taken `offset` beside the middle \[samples\], each part within ±½; `None` if that
    /// is the middle.
    pub(crate) fn of(offset: DVec2) -> Option<Self> {
        let axis = |o: f64| {
            let [before, own, after] = [o - 1.0, o, o + 1.0].map(keys);
            // The kernel reaches over two samples to either side, of which three are there.
            [before, after].map(|w| (w / (before + own + after)) as f32)
        };
        (offset != DVec2::ZERO).then(|| Self {
            across: axis(offset.x),
            down: axis(offset.y),
        })
    }

    /// The middles of a row's cells, from the row and those above and below (itself, where there is
    /// none). NaN stands for a sample that was not drawn; it and what lies beyond the row count as the
    /// sample itself.
    ///
    /// Differences are weighed, so that one colour everywhere gives that very colour.
    #[inline(always)]
    pub(super) fn row(
        &self,
        [above, row, below]: [&[[f32; 3]]; 3],
        column: &mut Vec<f32>,
        out: &mut Vec<f32>,
    ) {
        let [above, row, below] = [above, row, below].map(|r| r.as_flattened());
        let n = row.len();
        column.resize(n + 6, f32::NAN);
        column[..3].fill(f32::NAN);
        column[n + 3..].fill(f32::NAN);
        let middle = &mut column[3..n + 3];
        for i in 0..n {
            let (up, down) = (known(above[i] - row[i]), known(below[i] - row[i]));
            middle[i] = row[i] + (self.down[0] * up + self.down[1] * down);
        }
        out.resize(n, 0.0);
        let out = &mut out[..n];
        let (left, own, right) = (&column[..n], &column[3..n + 3], &column[6..n + 6]);
        for i in 0..n {
            let (before, after) = (known(left[i] - own[i]), known(right[i] - own[i]));
            let v = own[i] + (self.across[0] * before + self.across[1] * after);
            out[i] = if v < 0.0 { 0.0 } else { v };
        }
    }
}

/// A difference, 0 if there is none.
#[inline(always)]
fn known(difference: f32) -> f32 {
    if difference.is_nan() { 0.0 } else { difference }
}

/// Keys' kernel, within two samples.
fn keys(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        (1.5 * x - 2.5) * x * x + 1.0
    } else {
        ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::lanes::splat;
    use super::*;
    use crate::kernels::{Kernel, dispatch};

    struct Weights(f32);

    impl Kernel for Weights {
        type Output = [f32; 4];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> [f32; 4] {
            cubic(splat(simd, self.0)).map(
                #[inline(always)]
                |w| w[0],
            )
        }
    }

    #[test]
    fn lanes_weigh_as_the_kernel_does() {
        for k in 0..=16 {
            let f = f64::from(k) / 16.0;
            let weights = dispatch(crate::Simd::Auto, Weights(f as f32));
            assert_eq!(weights, cubic_of(f as f32));
            let expected = [1.0 + f, f, 1.0 - f, 2.0 - f].map(keys);
            for (w, e) in weights.into_iter().zip(expected) {
                assert!((f64::from(w) - e).abs() < 1e-6, "{f}: {w} {e}");
            }
        }
    }

    #[test]
    fn middles_follow_slopes_and_keep_what_is_even() {
        let centre = Centre::of(DVec2::new(0.25, -0.375)).unwrap();
        let (mut column, mut out) = (Vec::new(), Vec::new());
        // Samples of a slope, taken beside the middles: the three-sample kernel gives a slope back to
        // within what its missing fourth sample is worth (its weight is below 0.07).
        let at = |x: f32, y: f32| [5.0 + 0.5 * (x + 0.25) + 0.25 * (y - 0.375), 0.7, 0.0];
        let row = |y: f32| -> Vec<[f32; 3]> { (0..9).map(|x| at(x as f32, y)).collect() };
        let rows = [row(0.0), row(1.0), row(2.0)];
        let rows = [&rows[0][..], &rows[1], &rows[2]];
        centre.row(rows, &mut column, &mut out);
        for x in 1..8 {
            let expected = 5.0 + 0.5 * x as f32 + 0.25;
            assert!(
                (out[3 * x] - expected).abs() < 0.2 * 0.75,
                "{x}: {}",
                out[3 * x]
            );
            assert_eq!((out[3 * x + 1], out[3 * x + 2]), (0.7, 0.0));
        }
        // What was not drawn is left out, and stays so.
        let mut holed = rows.map(<[_]>::to_vec);
        (holed[0][4], holed[1][2]) = ([f32::NAN; 3], [f32::NAN; 3]);
        centre.row([&holed[0], &holed[1], &holed[2]], &mut column, &mut out);
        for x in 0..9 {
            assert_eq!(out[3 * x + 1].is_nan(), x == 2);
            assert!(x == 2 || out[3 * x + 1] == 0.7);
        }
        assert_eq!(Centre::of(DVec2::ZERO), None);
    }
}
