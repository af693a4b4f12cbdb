use fearless_simd::prelude::*;
use glam::UVec2;

use super::lanes::{F, Simd, i32x8, splat};
use super::reproject::{Before, Past, ReprojectRow, Warp};

/// Which samples of an earlier lattice are around a place, and by what share.
pub(super) struct Places {
    column: [i32; 8],
    row: [i32; 8],
    share: [[f32; 8]; 2],
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

    #[inline(always)]
    fn add(&mut self, weight: f32, past: &Past, colour: [f32; 3], inverse_w: f32, new: [f32; 3]) {
        // A weight of nothing adds nothing, not even a neighbour's infinity.
        if weight > 0.0 && past.length > 0.0 && (inverse_w - past.inverse_w).abs() <= past.reach {
            self.weight += weight;
            self.length += weight * past.length;
            for c in 0..3 {
                self.difference[c] += weight * (colour[c] - new[c]);
            }
        }
    }
}

impl Places {
    /// Asks the four samples around the place of `lane`.
    #[inline(always)]
    pub(super) fn find(&self, lane: usize, before: Before<'_>, new: [f32; 3]) -> Found {
        let (column, row) = (self.column[lane], self.row[lane]);
        let (fx, fy) = (self.share[0][lane], self.share[1][lane]);
        let inverse_w = self.inverse_w[lane];
        let [across, down] = before.size.to_array();
        let stride = across as usize;
        let mut found = Found::NOTHING;
        for (row, wy) in [(row, 1.0 - fy), (row + 1, fy)] {
            // Negative ones wrap beyond any lattice.
            if row as u32 >= down {
                continue;
            }
            let first = row as usize * stride;
            let past = &before.past[first..first + stride];
            let rgb = &before.rgb[first..first + stride];
            for (column, wx) in [(column, 1.0 - fx), (column + 1, fx)] {
                if let (Some(past), Some(&colour)) = (
                    past.get(column as u32 as usize),
                    rgb.get(column as u32 as usize),
                ) {
                    found.add(wx * wy, past, colour, inverse_w, new);
                }
            }
        }
        found
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
            let first = row.y * row.width;
            let instances = &row.instance[first + start..first + row.width.min(start + 8)];
            for (w, &instance) in which.iter_mut().zip(instances) {
                // The sky is no instance, and rests.
                *w = warp_of_instance
                    .get(instance as usize)
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
    ) -> Places {
        let lanes = [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5];
        let x = F::from_slice(simd, &lanes) + start as f32;
        let y = row.y as f32 + 0.5;
        let mut now = [0.0; 8];
        let first = row.y * row.width;
        let known = &row.inverse_w[first + start..first + row.width.min(start + 8)];
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
        let mut inside = ahead.to_bitmask() as u32;
        for (k, p) in [px, py].into_iter().enumerate() {
            let p = p / ratio;
            let within = p.simd_ge(0.0) & p.simd_le(size[k] as f32);
            inside &= within.to_bitmask() as u32;
            // Behind the eye and not a number are within nothing; what is left fits an integer.
            let p = within.select(p, zero) - 0.5;
            let whole = p.floor();
            (p - whole).store_slice(&mut share[k]);
            let index: i32x8<S> = whole.to_int();
            index.store_slice(if k == 0 { &mut column } else { &mut line });
        }
        let mut inverse_w = [0.0; 8];
        (now / ratio).store_slice(&mut inverse_w);
        Places {
            column,
            row: line,
            share,
            inverse_w,
            inside,
        }
    }
}
