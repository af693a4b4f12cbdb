use fearless_simd::f32x4;
use fearless_simd::prelude::*;
use glam::UVec2;

use super::cubic::cubic;
use super::lanes::{F, Simd, i32x8, splat};
use super::reproject::{Before, ReprojectRow, SAME_SURFACE, Warp};

/// Which samples of an earlier lattice are around a place, and by what share.
pub(super) struct Places {
    column: [i32; 8],
    row: [i32; 8],
    share: [[f32; 8]; 2],
    /// Weights of four samples along each axis.
    cubic: [[[f32; 8]; 4]; 2],
    /// 1/w expected there.
    inverse_w: [f32; 8],
    /// Lanes whose place lies on the earlier lattice and ahead of the eye.
    pub(super) inside: u32,
}

/// What the samples around a place remember of a surface, each times its weight.
pub(super) struct Found {
    /// Differences from the new colour.
    pub(super) difference: [f32; 3],
    pub(super) length: f32,
    pub(super) weight: f32,
}

impl Found {
    pub(super) const NOTHING: Self = Self {
        difference: [0.0; 3],
        length: 0.0,
        weight: 0.0,
    };
}

/// Whether a sample that remembers `nearest` shows the surface expected at 1/w. What was not drawn
/// remembers NaN, and shows nothing.
#[inline(always)]
fn shows(nearest: f32, inverse_w: f32) -> bool {
    (nearest - inverse_w).abs() <= SAME_SURFACE * inverse_w
}

impl Places {
    /// Asks the samples around the place of `lane`: the sixteen, if `sixteen`, where all of them were
    /// drawn and the four in the middle show the surface; else those of the four that do.
    #[inline(always)]
    pub(super) fn find<S: Simd>(
        &self,
        simd: S,
        lane: usize,
        before: Before<'_>,
        new: [f32; 3],
        sixteen: bool,
    ) -> Found {
        if sixteen {
            let found = self.of_sixteen(simd, lane, before, new);
            if found.weight > 0.0 {
                return found;
            }
        }
        self.of_four(lane, before, new)
    }

    /// Shares of the four samples around a place, the upper two first.
    #[inline(always)]
    fn shares(&self, lane: usize) -> [f32; 4] {
        let (fx, fy) = (self.share[0][lane], self.share[1][lane]);
        let (gx, gy) = (1.0 - fx, 1.0 - fy);
        [gx * gy, fx * gy, gx * fy, fx * fy]
    }

    /// Linear along both axes, of what shows the surface.
    #[inline(always)]
    fn of_four(&self, lane: usize, before: Before<'_>, new: [f32; 3]) -> Found {
        let (column, row) = (self.column[lane], self.row[lane]);
        let inverse_w = self.inverse_w[lane];
        let [across, down] = before.size.to_array();
        let mut found = Found::NOTHING;
        for (k, weight) in self.shares(lane).into_iter().enumerate() {
            // Negative ones wrap beyond any lattice.
            let (x, y) = (
                (column + (k & 1) as i32) as u32,
                (row + (k >> 1) as i32) as u32,
            );
            if x >= across || y >= down {
                continue;
            }
            let at = y as usize * across as usize + x as usize;
            // A weight of nothing adds nothing, not even a neighbour's infinity.
            if weight > 0.0 && shows(before.nearest[at], inverse_w) {
                found.weight += weight;
                found.length += weight * before.length[at];
                let colour = before.rgb[at];
                for (c, difference) in found.difference.iter_mut().enumerate() {
                    *difference += weight * (colour[c] - new[c]);
                }
            }
        }
        found
    }

    /// Catmull-Rom along both axes.
    #[inline(always)]
    fn of_sixteen<S: Simd>(
        &self,
        simd: S,
        lane: usize,
        before: Before<'_>,
        new: [f32; 3],
    ) -> Found {
        let (column, row) = (self.column[lane], self.row[lane]);
        let [across, down] = before.size.to_array();
        let fits = |at: i32, size: u32| at >= 1 && (at as u32).saturating_add(2) < size;
        if !(fits(column, across) && fits(row, down)) {
            return Found::NOTHING;
        }
        let stride = across as usize;
        let first = (row as usize - 1) * stride + column as usize - 1;
        let nearest = |k: usize| &before.nearest[first + k * stride..][..4];
        let inverse_w = self.inverse_w[lane];
        let (upper, lower) = (nearest(1), nearest(2));
        let all_show = [upper[1], upper[2], lower[1], lower[2]]
            .into_iter()
            .all(|n| shows(n, inverse_w));
        let load = |row: &[f32]| f32x4::from_slice(simd, row);
        let sum = (load(nearest(0)) + load(nearest(3))) + (load(upper) + load(lower));
        let all_drawn = sum.simd_eq(sum).all_true();
        if !(all_show && all_drawn) {
            return Found::NOTHING;
        }

        // Four samples of three values are three vectors; differences, as everywhere.
        let colours = before.rgb.as_flattened();
        let [r, g, b] = new;
        let own = [[r, g, b, r], [g, b, r, g], [b, r, g, b]].map(
            #[inline(always)]
            |v| load(&v),
        );
        let mut sums = [f32x4::splat(simd, 0.0); 3];
        for (k, weights) in self.cubic[1].iter().enumerate() {
            let row = &colours[3 * (first + k * stride)..][..12];
            for (v, sum) in sums.iter_mut().enumerate() {
                *sum += (load(&row[4 * v..4 * v + 4]) - own[v]) * weights[lane];
            }
        }
        let w = [0, 1, 2, 3].map(
            #[inline(always)]
            |k| self.cubic[0][k][lane],
        );
        let weights = [
            [w[0], w[0], w[0], w[1]],
            [w[1], w[1], w[2], w[2]],
            [w[2], w[3], w[3], w[3]],
        ];
        let mut parts = [0.0; 12];
        for (v, sum) in sums.into_iter().enumerate() {
            (sum * load(&weights[v])).store_slice(&mut parts[4 * v..4 * v + 4]);
        }
        let lengths = [stride + 1, stride + 2, 2 * stride + 1, 2 * stride + 2].map(
            #[inline(always)]
            |k| before.length[first + k],
        );
        let mut length = 0.0;
        for (share, l) in self.shares(lane).into_iter().zip(lengths) {
            length += share * l;
        }
        Found {
            difference: std::array::from_fn(
                #[inline(always)]
                |c| (parts[c] + parts[c + 3]) + (parts[c + 6] + parts[c + 9]),
            ),
            length,
            weight: 1.0,
        }
    }
}

/// The warps of eight samples, entry by entry.
pub(super) struct Gathered<S: Simd>([F<S>; 12]);

impl<S: Simd> Gathered<S> {
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        row: &ReprojectRow<'_>,
        start: usize,
        warps: &[Warp],
        warp_of_instance: &[u32],
    ) -> Self {
        let mut which = [0; 8];
        if !warp_of_instance.is_empty() {
            for (w, x) in which.iter_mut().zip(start..row.width) {
                // The sky is no instance, and rests.
                *w = warp_of_instance
                    .get(row.instance_followed(x) as usize)
                    .map_or(0, |&w| w as usize);
            }
        }
        if which == [which[0]; 8] {
            let warp = &warps[which[0]];
            return Self(std::array::from_fn(
                #[inline(always)]
                |k| splat(simd, warp[k]),
            ));
        }
        Self(std::array::from_fn(
            #[inline(always)]
            |k| F::from_slice(simd, &which.map(|w| warps[w][k])),
        ))
    }

    /// Where the samples from column `start` on were.
    #[inline(always)]
    pub(super) fn places(
        &self,
        simd: S,
        row: &ReprojectRow<'_>,
        start: usize,
        size: UVec2,
        sixteen: bool,
    ) -> Places {
        let lanes = [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5];
        let x = F::from_slice(simd, &lanes) + start as f32;
        let y = row.y as f32 + 0.5;
        let mut now = [0.0; 8];
        let known = &row.out_nearest[start..row.width.min(start + 8)];
        now[..known.len()].copy_from_slice(known);
        let now = F::from_slice(simd, &now);
        let m = &self.0;
        // The lattice's own coordinates first: they are exact where nothing turned.
        let axis = |k: usize| m[k] * x + m[k + 1] * y + m[k + 2] + m[k + 3] * now;
        let [px, py, ratio] = [axis(0), axis(4), axis(8)];
        let ahead = ratio.simd_gt(1e-6);
        let zero = splat(simd, 0.0);
        let [mut column, mut line] = [[0; 8]; 2];
        let mut share = [[0.0; 8]; 2];
        let mut weights = [[[0.0; 8]; 4]; 2];
        let mut inside = ahead.to_bitmask() as u32;
        for (k, p) in [px, py].into_iter().enumerate() {
            let p = p / ratio;
            let within = p.simd_ge(0.0) & p.simd_le(size[k] as f32);
            inside &= within.to_bitmask() as u32;
            // Behind the eye and not a number are within nothing; what is left fits an integer.
            let p = within.select(p, zero) - 0.5;
            let whole = p.floor();
            let part = p - whole;
            part.store_slice(&mut share[k]);
            if sixteen {
                for (stored, w) in weights[k].iter_mut().zip(cubic(part)) {
                    w.store_slice(stored);
                }
            }
            let index: i32x8<S> = whole.to_int();
            index.store_slice(if k == 0 { &mut column } else { &mut line });
        }
        let mut inverse_w = [0.0; 8];
        (now / ratio).store_slice(&mut inverse_w);
        Places {
            column,
            row: line,
            share,
            cubic: weights,
            inverse_w,
            inside,
        }
    }
}
