use fearless_simd::f32x4;
use fearless_simd::prelude::*;
use glam::UVec2;

use super::cubic::cubic;
use super::lanes::{F, Simd, i32x8, splat, triple};
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

/// What the samples around a place remember of a surface.
pub(super) struct Found<S: Simd> {
    /// Red, green and blue; the fourth number is none.
    pub(super) colour: f32x4<S>,
    /// Frames that it is a mean of, times `weight`.
    pub(super) length: f32,
    /// Share of the samples around the place, by their weights, that show the surface.
    pub(super) weight: f32,
}

/// Whether a sample that remembers `nearest` shows the surface expected at 1/w. What was not drawn
/// remembers NaN, and shows nothing.
#[inline(always)]
fn shows(nearest: f32, inverse_w: f32) -> bool {
    (nearest - inverse_w).abs() <= SAME_SURFACE * inverse_w
}

#[inline(always)]
fn four<S: Simd>(simd: S, all: &[f32], at: usize) -> f32x4<S> {
    f32x4::from_slice(simd, &all[at..at + 4])
}

/// The mean of four with weights that add up to 1, of which the second's is not given: differences
/// from that one are averaged, so that equal colours give that very colour.
#[inline(always)]
fn weigh<S: Simd>([a, b, c, d]: [f32x4<S>; 4], [wa, wc, wd]: [f32; 3]) -> f32x4<S> {
    b + (((a - b) * wa + (c - b) * wc) + (d - b) * wd)
}

/// As [`weigh`], of four triples from the `k`-th on.
#[inline(always)]
fn weigh_row<S: Simd>(simd: S, all: &[f32], k: usize, weights: [f32; 3]) -> f32x4<S> {
    let row = &all[3 * k..3 * k + 12];
    // Three numbers each, and one of no use; the last must not reach beyond the row.
    let last = four(simd, row, 8);
    let triples = [
        four(simd, row, 0),
        four(simd, row, 3),
        four(simd, row, 6),
        last.slide::<1>(last),
    ];
    weigh(triples, weights)
}

impl Places {
    /// Weights along an axis of the first, third and last of four samples.
    #[inline(always)]
    fn weights(&self, axis: usize, lane: usize) -> [f32; 3] {
        let w = &self.cubic[axis];
        [w[0][lane], w[2][lane], w[3][lane]]
    }

    /// Asks the samples around the place of `lane`: the sixteen, if `sixteen`, where all of them were
    /// drawn and the four in the middle show the surface; else those of the four that do, whose weight
    /// is at least `least`.
    #[inline(always)]
    pub(super) fn find<S: Simd>(
        &self,
        simd: S,
        lane: usize,
        before: Before<'_>,
        new: f32x4<S>,
        sixteen: bool,
        least: f32,
    ) -> Option<Found<S>> {
        let found = if sixteen {
            self.of_sixteen(simd, lane, before)
        } else {
            None
        };
        match found {
            None => self.of_four(simd, lane, before, new, least),
            found => found,
        }
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
    fn of_four<S: Simd>(
        &self,
        simd: S,
        lane: usize,
        before: Before<'_>,
        new: f32x4<S>,
        least: f32,
    ) -> Option<Found<S>> {
        let (column, row) = (self.column[lane], self.row[lane]);
        let inverse_w = self.inverse_w[lane];
        let [across, down] = before.size.to_array();
        let (mut length, mut all) = (0.0, 0.0);
        // Differences are averaged, so that equal colours give that very colour.
        let mut difference = f32x4::splat(simd, 0.0);
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
                all += weight;
                length += weight * before.length[at];
                let colour = triple(simd, before.rgb.as_flattened(), at);
                difference += (colour - new) * weight;
            }
        }
        if all < least {
            return None;
        }
        Some(Found {
            colour: new + difference * (1.0 / all),
            length,
            weight: all,
        })
    }

    /// Catmull-Rom along both axes.
    #[inline(always)]
    fn of_sixteen<S: Simd>(&self, simd: S, lane: usize, before: Before<'_>) -> Option<Found<S>> {
        let (column, row) = (self.column[lane], self.row[lane]);
        let [across, down] = before.size.to_array();
        if column < 1 || row < 1 {
            return None;
        }
        let (column, row) = (column as u32, row as u32);
        if column.saturating_add(2) >= across || row.saturating_add(2) >= down {
            return None;
        }
        let stride = across as usize;
        let first = (row as usize - 1) * stride + column as usize - 1;
        let (second, third) = (first + stride, first + 2 * stride);
        let upper = four(simd, before.nearest, second);
        let lower = four(simd, before.nearest, third);
        let expected = f32x4::splat(simd, self.inverse_w[lane]);
        let near = expected * SAME_SURFACE;
        let shows = (upper - expected).abs().simd_le(near) & (lower - expected).abs().simd_le(near);
        if shows.to_bitmask() as u32 & 0b0110 != 0b0110 {
            return None;
        }
        if !before.all_drawn {
            let top = four(simd, before.nearest, first);
            let bottom = four(simd, before.nearest, third + stride);
            let sum = (top + bottom) + (upper + lower);
            if !sum.simd_eq(sum).all_true() {
                return None;
            }
        }

        let colours = before.rgb.as_flattened();
        let across = self.weights(0, lane);
        let rows = [
            weigh_row(simd, colours, first, across),
            weigh_row(simd, colours, second, across),
            weigh_row(simd, colours, third, across),
            weigh_row(simd, colours, third + stride, across),
        ];
        let colour = weigh(rows, self.weights(1, lane));
        let mut length = 0.0;
        for (k, share) in self.shares(lane).into_iter().enumerate() {
            length += share * before.length[first + (1 + k / 2) * stride + 1 + k % 2];
        }
        Some(Found {
            colour,
            length,
            weight: 1.0,
        })
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
