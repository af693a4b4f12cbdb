use fearless_simd::prelude::*;
use foveasim_assets::Phong;

use super::shade::{Hit, Light};
use super::wide::{F, I, Simd, V3, max, piece, splat};

/// See [`Phong`].
#[inline(always)]
pub(super) fn phong<S: Simd>(simd: S, m: &Phong, light: &Light, hit: &Hit<S>) -> V3<S> {
    let zero = splat(simd, 0.0);
    let (v, l) = (hit.view, V3::splat(simd, light.sun_direction));
    let n_v = hit.normal.dot(v);
    let away = n_v.simd_lt(0.0);
    let sign = away.select(splat(simd, -1.0), splat(simd, 1.0));
    let (n_l, n_v) = (hit.normal.dot(l) * sign, n_v * sign);
    // The light's direction mirrored about the normal is 2 (n·l) n − l.
    let mut lobe = max(n_l * n_v * 2.0 - l.dot(v), zero);
    for _ in 0..m.shininess_log2 {
        lobe = lobe * lobe;
    }
    let mut n_l = max(n_l, zero);
    if !light.shadows.is_empty() {
        let sunlight = light.sunlight(simd, hit);
        (n_l, lobe) = (n_l * sunlight, lobe * sunlight);
    }
    let k = hit.world.scale(splat(simd, m.frequency));
    let colour = V3 {
        x: sin(simd, k.x) * 0.5 + 0.5,
        y: sin(simd, k.y) * 0.5 + 0.5,
        z: sin(simd, k.z) * 0.5 + 0.5,
    };
    let lit = colour.scale(n_l * m.diffuse + m.ambient);
    let shine = lobe * m.specular;
    let sum = V3 {
        x: lit.x + shine,
        y: lit.y + shine,
        z: lit.z + shine,
    };
    sum.mul(V3::splat(simd, light.sun_radiance))
}

/// sin x, within 5e-7 for |x| up to 100 and 2e-6 up to 2¹⁵ (tested); beyond, x is reduced with ever larger error.
#[inline(always)]
pub(super) fn sin<S: Simd>(simd: S, x: F<S>) -> F<S> {
    piece(
        simd,
        #[inline(always)]
        || {
            // x = kπ + r with |r| ≤ π/2; π in three parts, the first two exact in products with small k
            // (Cody and Waite 1980).
            let k = (x * std::f32::consts::FRAC_1_PI + 0.5).floor();
            let r = x - k * 3.140_625 - k * 9.670_257_6e-4 - k * 6.277_114e-7;
            let odd = (k.to_int::<I<S>>() & 1).simd_eq(1);
            let r2 = r * r;
            // The odd polynomial of degree 11 that is nearest to the sine over ±π/2.
            let p = r2 * -2.388_985_9e-8 + 2.752_556_2e-6;
            let p = p * r2 - 1.984_087_4e-4;
            let p = p * r2 + 8.333_331e-3;
            let p = p * r2 - 0.166_666_67;
            let s = r + r * r2 * p;
            odd.select(splat(simd, 0.0) - s, s)
        },
    )
}

#[cfg(test)]
mod tests {
    use super::super::wide::WIDTH;
    use super::super::{Kernel, dispatch};
    use super::*;
    use crate::Simd as Choice;

    struct Sine([f32; WIDTH]);

    impl Kernel for Sine {
        type Output = [f32; WIDTH];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> [f32; WIDTH] {
            sin(simd, F::from_slice(simd, &self.0)).to_array()
        }
    }

    #[test]
    fn sines_are_within_their_bound() {
        let worst = |most: i32, step: f32| {
            let mut worst: f64 = 0.0;
            for i in -most..most {
                let x: [f32; WIDTH] = std::array::from_fn(|k| i as f32 * step + k as f32 * 0.0093);
                let got = dispatch(Choice::Auto, Sine(x));
                assert_eq!(got, dispatch(Choice::Scalar, Sine(x)));
                for (x, got) in x.into_iter().zip(got) {
                    let exact = foveasim_models::math::sin(f64::from(x));
                    worst = worst.max((f64::from(got) - exact).abs());
                }
            }
            worst
        };
        let (near, far) = (worst(10_000, 0.01), worst(40_000, 0.777));
        assert!(near < 5e-7 && far < 2e-6, "{near:e}, {far:e}");
    }
}
