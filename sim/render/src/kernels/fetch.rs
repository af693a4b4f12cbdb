use fearless_simd::f32x4;
use fearless_simd::prelude::*;

use super::Kernel;
use super::wide::{F, I, Simd, WIDTH, max, min, piece, splat};
use crate::texels::{Sum, Texels};

/// Reads the colours of a display row from places of a lattice.
pub(crate) struct FetchRow<'a> {
    pub(crate) texels: &'a Texels,
    /// The sample whose cell holds the place, instead of what stands between four.
    pub(crate) nearest: bool,
    /// Places of the row's pixels, and of as many as fill the last lanes, in lattice steps.
    pub(crate) xs: &'a [f32],
    pub(crate) ys: &'a [f32],
    pub(crate) row: &'a mut [[f32; 3]],
}

/// The two samples beside each place along one axis, and the share of the second.
struct Beside<S: Simd> {
    low: I<S>,
    high: I<S>,
    share: F<S>,
}

impl Kernel for FetchRow<'_> {
    /// How many samples were read.
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> u64 {
        let texels = self.texels;
        let [columns, rows] = texels.size.to_array();
        let pixels = self.row.len() as u64;
        if self.nearest {
            for ((out, x), y) in self.row.iter_mut().zip(self.xs).zip(self.ys) {
                let [r, g, b, _] = owner(texels, *x, *y);
                *out = [r, g, b];
            }
            return pixels;
        }
        let places = self.xs.chunks_exact(WIDTH).zip(self.ys.chunks_exact(WIDTH));
        for (out, (xs, ys)) in self.row.chunks_mut(WIDTH).zip(places) {
            let (x, y) = (F::from_slice(simd, xs), F::from_slice(simd, ys));
            let across = piece(
                simd,
                #[inline(always)]
                || clamped(simd, x, columns),
            );
            let down = piece(
                simd,
                #[inline(always)]
                || {
                    if texels.wraps {
                        wrapped(simd, y, rows)
                    } else {
                        clamped(simd, y, rows)
                    }
                },
            );
            let (upper, lower) = (down.low * columns as i32, down.high * columns as i32);
            let corners = [
                (upper + across.low).to_array(),
                (upper + across.high).to_array(),
                (lower + across.low).to_array(),
                (lower + across.high).to_array(),
            ];
            let (fx, fy) = (across.share.to_array(), down.share.to_array());
            for (k, out) in out.iter_mut().enumerate() {
                let load = |i: usize| &texels.rgba[corners[i][k] as usize];
                let [a, b, c, d] = [load(0), load(1), load(2), load(3)];
                let lanes = |v: &[f32; 4]| f32x4::from_slice(simd, v);
                let (va, vc) = (lanes(a), lanes(c));
                let upper = va + (lanes(b) - va) * fx[k];
                let lower = vc + (lanes(d) - vc) * fx[k];
                let [r, g, b_, live] = (upper + (lower - upper) * fy[k]).to_array();
                // What is not live counts, if at all, by less than rounding.
                *out = if live == 1.0 {
                    [r, g, b_]
                } else {
                    let own = owner(texels, xs[k], ys[k]);
                    partly([*a, *b, *c, *d], own, [fx[k], fy[k]])
                };
            }
        }
        4 * pixels
    }
}

/// The sample whose cell holds a place.
#[inline(always)]
fn owner(texels: &Texels, x: f32, y: f32) -> [f32; 4] {
    // The casts saturate, and make 0 of NaN.
    let x = (x as u32).min(texels.size.x - 1);
    let y = (y as u32).min(texels.size.y - 1);
    texels.live_near(x, y)
}

/// Between four samples of which some are not live.
#[cold]
fn partly(corners: [[f32; 4]; 4], own: [f32; 4], [fx, fy]: [f32; 2]) -> [f32; 3] {
    let (gx, gy) = (1.0 - fx, 1.0 - fy);
    let mut sum = Sum::around(own);
    for (texel, weight) in corners
        .into_iter()
        .zip([gx * gy, fx * gy, gx * fy, fx * fy])
    {
        sum.add(texel, weight);
    }
    sum.mean()
}

/// Samples lie in the middles of their cells; beyond the first and the last there is nothing.
#[inline(always)]
fn clamped<S: Simd>(simd: S, at: F<S>, count: u32) -> Beside<S> {
    let last = (count - 1) as f32;
    let p = min(max(at - 0.5, splat(simd, 0.0)), splat(simd, last));
    let whole = p.floor();
    let low: I<S> = whole.to_int();
    Beside {
        low,
        high: (low + 1).min(I::splat(simd, count as i32 - 1)),
        share: p - whole,
    }
}

/// As [`clamped`], where the last borders on the first.
#[inline(always)]
fn wrapped<S: Simd>(simd: S, at: F<S>, count: u32) -> Beside<S> {
    let count = count as i32;
    let p = min(
        max(at + 0.5, splat(simd, 0.5)),
        splat(simd, count as f32 + 0.5),
    );
    let whole = p.floor();
    let next: I<S> = whole.to_int();
    let (zero, all) = (I::splat(simd, 0), I::splat(simd, count));
    Beside {
        low: next.simd_eq(0).select(all, next) - 1,
        high: next.simd_ge(count).select(zero, next),
        share: p - whole,
    }
}
