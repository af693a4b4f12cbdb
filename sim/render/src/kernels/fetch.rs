use fearless_simd::f32x4;
use fearless_simd::prelude::*;

use super::Kernel;
use super::lanes::Simd;
use crate::texels::{Sum, Texels};

/// Reads the colours of a display row from places of a lattice.
pub(crate) struct FetchRow<'a> {
    pub(crate) texels: &'a Texels,
    /// The sample whose cell holds the place, instead of what stands between four.
    pub(crate) nearest: bool,
    /// Places of at least the row's pixels, in lattice steps.
    pub(crate) xs: &'a [f32],
    pub(crate) ys: &'a [f32],
    pub(crate) row: &'a mut [[f32; 3]],
}

/// The two samples beside a place along one axis, and the share of the second.
#[derive(Clone, Copy)]
struct Beside {
    low: u32,
    high: u32,
    share: f32,
}

impl Kernel for FetchRow<'_> {
    /// How many samples were read.
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> u64 {
        let texels = self.texels;
        let (columns, rows) = (texels.size.x, texels.size.y);
        let mut fetches = 0;
        for ((out, x), y) in self.row.iter_mut().zip(self.xs).zip(self.ys) {
            // The casts saturate, and make 0 of NaN.
            let own = [(*x as u32).min(columns - 1), (*y as u32).min(rows - 1)];
            if self.nearest {
                let [r, g, b, _] = texels.live_near(own[0], own[1]);
                *out = [r, g, b];
                fetches += 1;
                continue;
            }
            let across = clamped(*x, columns);
            let down = if texels.wraps {
                wrapped(*y, rows)
            } else {
                clamped(*y, rows)
            };
            fetches += 4;
            let corners = [
                texels.at(across.low, down.low),
                texels.at(across.high, down.low),
                texels.at(across.low, down.high),
                texels.at(across.high, down.high),
            ];
            let [a, b, c, d] = corners;
            if a[3] + b[3] + c[3] + d[3] == 4.0 {
                let load = |v: &[f32; 4]| f32x4::from_slice(simd, v);
                let (a, b, c, d) = (load(&a), load(&b), load(&c), load(&d));
                let upper = a + (b - a) * across.share;
                let lower = c + (d - c) * across.share;
                let [r, g, b, _] = (upper + (lower - upper) * down.share).to_array();
                *out = [r, g, b];
                continue;
            }
            let (fx, fy) = (across.share, down.share);
            let weights = [
                (1.0 - fx) * (1.0 - fy),
                fx * (1.0 - fy),
                (1.0 - fx) * fy,
                fx * fy,
            ];
            let mut sum = Sum::around(texels.live_near(own[0], own[1]));
            for (texel, weight) in corners.into_iter().zip(weights) {
                sum.add(texel, weight);
            }
            *out = sum.mean();
        }
        fetches
    }
}

/// Samples lie in the middles of their cells; beyond the first and the last there is nothing.
#[inline(always)]
fn clamped(at: f32, count: u32) -> Beside {
    let p = at - 0.5;
    let p = if p > 0.0 { p } else { 0.0 };
    let low = (p as u32).min(count - 1);
    let share = p - low as f32;
    Beside {
        low,
        high: (low + 1).min(count - 1),
        share: if share < 1.0 { share } else { 1.0 },
    }
}

/// As [`clamped`], where the last borders on the first.
#[inline(always)]
fn wrapped(at: f32, count: u32) -> Beside {
    // From ½ on, so that truncation rounds down.
    let p = at + 0.5;
    let next = p as u32;
    let share = p - next as f32;
    let below = |k: u32| if k >= count { k - count } else { k };
    Beside {
        low: below(next.min(count) + count - 1),
        high: below(next.min(count)),
        share,
    }
}
