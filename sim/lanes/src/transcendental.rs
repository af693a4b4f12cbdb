//! Logarithm, power and angle in lanes, from the operations that IEEE 754 defines alone.

use fearless_simd::prelude::*;

use crate::wide::{F, I, Simd, U, max, min, piece, splat};

/// log₂ of a positive normal number, within 3·10⁻⁷ + 10⁻⁷·|log₂ x|.
///
/// x = 2ᵉ·m with m from √½ to √2; log₂ m = 2/ln 2 · artanh s, s = (m − 1)/(m + 1), |s| < 0.172. The
/// series is cut after s⁹: what is left out is below 10⁻⁹.
#[inline(always)]
pub fn log2<S: Simd>(x: F<S>) -> F<S> {
    let simd = x.simd;
    piece(
        simd,
        #[inline(always)]
        || {
            let bits: U<S> = x.bitcast();
            // The bits of √½: what is above it goes to the next exponent.
            let shifted = bits - 0x3f35_04f3;
            let exponent: I<S> = shifted.bitcast::<I<S>>() >> 23;
            let mantissa: F<S> = ((shifted & 0x007f_ffff) + 0x3f35_04f3).bitcast();
            let s = (mantissa - 1.0) / (mantissa + 1.0);
            let q = s * s;
            let series = q * (q * (q * (q * (1.0 / 9.0) + 1.0 / 7.0) + 0.2) + 1.0 / 3.0) + 1.0;
            exponent.to_float::<F<S>>() + s * series * (2.0 * std::f32::consts::LOG2_E)
        },
    )
}

/// a·2ˣ for x from −126 to 126 (others are taken there), within 1.5·10⁻⁷ of it, relatively, and half as much where
/// x is near 0.
///
/// 2ˣ = 2ⁿ·e^(f·ln 2) with |f| ≤ ½; the exponential series is cut after the seventh power: what is left out
/// is below 10⁻⁸. Its 1 is added last, as a·2ⁿ, which is exact: what rounding does to the rest counts less.
#[inline(always)]
pub fn times_exp2<S: Simd>(a: F<S>, x: F<S>) -> F<S> {
    let simd = x.simd;
    piece(
        simd,
        #[inline(always)]
        || {
            let x = min(max(x, splat(simd, -126.0)), splat(simd, 126.0));
            let whole = (x + 0.5).floor();
            let f = (x - whole) * std::f32::consts::LN_2;
            let tail = f * (f * (f * (1.0 / 5040.0) + 1.0 / 720.0) + 1.0 / 120.0) + 1.0 / 24.0;
            let beyond_one = f * (f * (f * (f * tail + 1.0 / 6.0) + 0.5) + 1.0);
            let scale: F<S> = ((whole.to_int::<I<S>>() + 127) << 23).bitcast();
            let scaled = a * scale;
            scaled + scaled * beyond_one
        },
    )
}

/// The angle of (x, y) from the x axis towards the y axis in turns, 0 to below 1, within 10⁻⁷; 0 at the
/// origin.
///
/// atan a for a up to 1 by its series, cut after a¹⁵, for |a| ≤ tan 22.5°; above by
/// atan a = π/4 + atan((a − 1)/(a + 1)). What is left out is below 3·10⁻⁹ turns.
#[inline(always)]
pub fn turns<S: Simd>(x: F<S>, y: F<S>) -> F<S> {
    let simd = x.simd;
    piece(
        simd,
        #[inline(always)]
        || {
            let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
            let (ax, ay) = (x.abs(), y.abs());
            let steep = ay.simd_gt(ax);
            let low = steep.select(ax, ay);
            let high = max(steep.select(ay, ax), splat(simd, f32::MIN_POSITIVE));
            let a = low / high;
            let upper = a.simd_gt(0.414_213_57);
            let a = upper.select((a - 1.0) / (a + 1.0), a);
            let q = a * a;
            // 1/2π, so that the angle is in turns from the start.
            const C: [f64; 8] = [
                1.0,
                -1.0 / 3.0,
                1.0 / 5.0,
                -1.0 / 7.0,
                1.0 / 9.0,
                -1.0 / 11.0,
                1.0 / 13.0,
                -1.0 / 15.0,
            ];
            let mut series = zero;
            for c in C.into_iter().rev() {
                series = series * q + (c * (0.5 * std::f64::consts::FRAC_1_PI)) as f32;
            }
            let turns = series * a + upper.select(splat(simd, 0.125), zero);
            let turns = steep.select(splat(simd, 0.25) - turns, turns);
            let turns = x.simd_lt(0.0).select(splat(simd, 0.5) - turns, turns);
            let turns = y.simd_lt(0.0).select(one - turns, turns);
            // Just below the axis the difference rounds up to a whole turn.
            turns.simd_lt(1.0).select(turns, zero)
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wide::WIDTH;
    use crate::{Instructions, Kernel, dispatch};

    /// Values of the three functions at lanes of (x, y), by way of x alone for the first two.
    struct All([f32; WIDTH], [f32; WIDTH]);

    impl Kernel for All {
        type Output = [[f32; WIDTH]; 3];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let (x, y) = (F::from_slice(simd, &self.0), F::from_slice(simd, &self.1));
            [
                log2(x.abs()).to_array(),
                times_exp2(splat(simd, 1.0), x).to_array(),
                turns(x, y).to_array(),
            ]
        }
    }

    /// Within the stated bounds of double precision, and the same bits at every vector level.
    #[test]
    fn functions_are_within_their_bounds() {
        let mut worst = [0.0f64; 3];
        for step in 0..40_000u32 {
            let x: [f32; WIDTH] = std::array::from_fn(|k| {
                let t = f64::from(step * 16 + k as u32) * 0.618_033_988_749_9 % 1.0;
                let size = [1.5, 30.0, 126.0, 5000.0][step as usize % 4];
                ((2.0 * t - 1.0) * size) as f32
            });
            let y: [f32; WIDTH] = std::array::from_fn(|k| {
                let t = f64::from(step * 16 + k as u32) * 0.414_213_562_373 % 1.0;
                ((2.0 * t - 1.0) * 3000.0) as f32
            });
            let [logs, powers, angles] = dispatch(Instructions::Auto, All(x, y));
            let scalar = dispatch(Instructions::Scalar, All(x, y));
            let bits = |v: [[f32; WIDTH]; 3]| v.map(|row| row.map(f32::to_bits));
            assert_eq!(bits([logs, powers, angles]), bits(scalar));
            for k in 0..WIDTH {
                let (px, py) = (f64::from(x[k]), f64::from(y[k]));
                if px.abs() > 1e-30 {
                    let exact = px.abs().log2();
                    let error = (f64::from(logs[k]) - exact).abs();
                    worst[0] = worst[0].max(error / (3e-7 + 1e-7 * exact.abs()));
                }
                if px.abs() <= 126.0 {
                    let error = (f64::from(powers[k]) / px.exp2() - 1.0).abs();
                    worst[1] = worst[1].max(error / 1.5e-7);
                }
                let exact = py.atan2(px) / std::f64::consts::TAU;
                let difference = f64::from(angles[k]) - exact;
                let error = (difference - difference.round()).abs();
                worst[2] = worst[2].max(error / 1e-7);
                assert!((0.0..1.0).contains(&angles[k]));
            }
        }
        assert!(worst.iter().all(|w| *w <= 1.0), "{worst:?}");
        let axes = [1.0, 0.0, -1.0, 0.0, 0.0, 1.0, 2.0, 3.0];
        let (mut x, mut y) = ([0.0; WIDTH], [0.0; WIDTH]);
        x[..5].copy_from_slice(&axes[..5]);
        y[..5].copy_from_slice(&[0.0, 1.0, 0.0, -1.0, 0.0]);
        let [_, _, angles] = dispatch(Instructions::Auto, All(x, y));
        assert_eq!(angles[..5], [0.0, 0.25, 0.5, 0.75, 0.0]);
    }
}
