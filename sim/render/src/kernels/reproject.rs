use fearless_simd::f32x4;
use fearless_simd::prelude::*;
use foveasim_models::Work;
use glam::UVec2;

use super::Kernel;
use super::cubic::Centre;
use super::extremes::Extremes;
use super::lanes::{Simd, put_triple, triple};
use super::place::{Gathered, Places};

/// By what part 1/w may differ within a surface, from sample to sample and from what is expected of an
/// earlier image: what is nearer than this part of the distance before another surface passes for it.
/// Tighter, and grazing ground loses its history; only the clamp tells what is closer together.
pub(super) const SAME_SURFACE: f32 = 1.0 / 8.0;
/// Least share of the bilinear weights that must show the surface: the samples that are left are
/// otherwise almost a whole sample away along both axes.
const LEAST_WEIGHT: f32 = 1.0 / 16.0;

/// Where a point was: (x, y, 1) and 1/w of a sample give, row by row, x, y and 1 of the earlier
/// lattice times the ratio of the earlier to the present w.
pub(crate) type Warp = [f32; 12];

/// An earlier image of a pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Before<'a> {
    pub(crate) size: UVec2,
    pub(crate) rgb: &'a [[f32; 3]],
    /// Frames that each colour is a mean of; 0 where nothing was drawn.
    pub(crate) length: &'a [f32],
    /// 1/w of the surface that each sample follows \[1/m\]; NaN where nothing was drawn.
    pub(crate) nearest: &'a [f32],
    /// Whether there is no sample where nothing was drawn.
    pub(crate) all_drawn: bool,
}

/// Where the history of a sample is.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Source<'a> {
    /// There is none.
    Nowhere,
    /// At the same place.
    InPlace(Before<'a>),
    /// Where the sample was.
    Moved {
        before: Before<'a>,
        /// The first one is for what did not move.
        warps: &'a [Warp],
        /// Which one each instance takes; empty if nothing moved.
        warp_of_instance: &'a [u32],
        /// Whether the history is pulled into the range of colours around the sample.
        clamp: bool,
        /// Whether what lies between samples is found by Catmull-Rom interpolation; linear, if not.
        cubic: bool,
        /// How new samples are taken to the middles of their cells, if they are.
        centre: Option<Centre>,
    },
}

/// Memory of a thread.
#[derive(Debug, Default)]
pub(crate) struct ReprojectScratch {
    extremes: Extremes,
    column: Vec<f32>,
    /// The row's new colours, in the middles of their cells.
    new: Vec<f32>,
}

/// Blends a row of new samples with their history. A new colour of NaN was not drawn.
pub(crate) struct ReprojectRow<'a> {
    pub(crate) y: usize,
    pub(crate) width: usize,
    /// All new samples.
    pub(crate) rgb: &'a [[f32; 3]],
    pub(crate) inverse_w: &'a [f32],
    /// Instances; empty if nothing moved.
    pub(crate) instance: &'a [u32],
    pub(crate) source: Source<'a>,
    /// Most frames that a history counts for.
    pub(crate) longest: f32,
    pub(crate) scratch: &'a mut ReprojectScratch,
    /// The row's colours, and what is remembered of them, as in [`Before`].
    pub(crate) out: &'a mut [[f32; 3]],
    pub(crate) out_length: &'a mut [f32],
    pub(crate) out_nearest: &'a mut [f32],
}

impl Kernel for ReprojectRow<'_> {
    type Output = Work;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> Work {
        let mut work = Work::default();
        if self.is_empty() {
            self.out.fill([0.0; 3]);
            self.out_length.fill(0.0);
            self.out_nearest.fill(f32::NAN);
            return work;
        }
        self.surfaces();
        match self.source {
            Source::Nowhere => self.start(),
            Source::InPlace(before) => self.in_place(before, &mut work),
            Source::Moved {
                before,
                warps,
                warp_of_instance,
                clamp,
                cubic,
                centre,
            } => {
                let around = rows(self.rgb, self.y, self.width);
                if clamp {
                    let [above, row, below] = around.map(|r| r.as_flattened());
                    self.scratch.extremes.find::<3>(above, row, below);
                }
                let ReprojectScratch { column, new, .. } = &mut *self.scratch;
                match centre {
                    Some(centre) => centre.row(around, column, new),
                    None => {
                        new.clear();
                        new.extend_from_slice(around[1].as_flattened());
                    }
                }
                for start in (0..self.width).step_by(8) {
                    let warp = Gathered::new(simd, &self, start, warps, warp_of_instance);
                    let places = warp.places(simd, &self, start, before.size, cubic);
                    self.eight(simd, start, &places, before, [clamp, cubic], &mut work);
                }
            }
        }
        work
    }
}

/// A row and its neighbours; the row itself, where there is none.
#[inline(always)]
fn rows<T>(all: &[T], y: usize, width: usize) -> [&[T]; 3] {
    let last = all.len() / width - 1;
    [y.saturating_sub(1), y, (y + 1).min(last)].map(|y| &all[y * width..(y + 1) * width])
}

impl ReprojectRow<'_> {
    /// Whether nothing of the row was drawn.
    #[inline(always)]
    fn is_empty(&self) -> bool {
        self.new_row().iter().all(
            #[inline(always)]
            |rgb| rgb[0].is_nan(),
        )
    }

    /// Chooses the surface that each sample follows: the nearest of the 3×3 around, if that is another
    /// one; else its own.
    ///
    /// An outline lies between samples and moves with what is in front. Samples beside it, too, must
    /// be looked for there: those of the background would find one another where the outline was, and
    /// leave its blended colours behind (Karis 2014, "High-quality temporal supersampling").
    #[inline(always)]
    fn surfaces(&mut self) {
        let [above, row, below] = rows(self.inverse_w, self.y, self.width);
        self.scratch.extremes.find::<1>(above, row, below);
        let greatest = &self.scratch.extremes.greatest[..self.width];
        let out = &mut self.out_nearest[..self.width];
        for x in 0..self.width {
            // Not a number, what was not drawn stays so.
            let other = greatest[x] - row[x] > SAME_SURFACE * greatest[x];
            out[x] = if other { greatest[x] } else { row[x] };
        }
    }

    /// The instance that the sample of column `x` follows.
    #[inline(always)]
    pub(super) fn instance_followed(&self, x: usize) -> u32 {
        let depths = rows(self.inverse_w, self.y, self.width);
        let instances = rows(self.instance, self.y, self.width);
        let followed = self.out_nearest[x];
        // Itself first.
        if depths[1][x] == followed || followed.is_nan() {
            return instances[1][x];
        }
        let columns = x.saturating_sub(1)..(x + 2).min(self.width);
        let mut around = (0..3).flat_map(|k| columns.clone().map(move |x| (k, x)));
        around
            .find(|&(k, x)| depths[k][x] == followed)
            .map_or(instances[1][x], |(k, x)| instances[k][x])
    }

    #[inline(always)]
    fn new_row(&self) -> &[[f32; 3]] {
        &self.rgb[self.y * self.width..(self.y + 1) * self.width]
    }

    /// Every sample is the first of its kind.
    #[inline(always)]
    fn start(&mut self) {
        for x in 0..self.width {
            let new = self.new_row()[x];
            self.put(x, new, new, 0.0);
        }
    }

    #[inline(always)]
    fn in_place(&mut self, before: Before<'_>, work: &mut Work) {
        let first = self.y * self.width;
        let old = &before.rgb[first..first + self.width];
        let length = &before.length[first..first + self.width];
        for x in 0..self.width {
            let new = self.new_row()[x];
            self.put(x, new, old[x], length[x]);
            work.samples_in_place += u64::from(length[x] > 0.0 && !new[0].is_nan());
        }
    }

    /// What a history of `length` frames weighs, and how many frames it counts for.
    #[inline(always)]
    fn weight(&self, length: f32) -> (f32, f32) {
        let length = if length < self.longest {
            length
        } else {
            self.longest
        };
        (length / (length + 1.0), length)
    }

    /// Stores the mean of a new colour and a history of `length` frames.
    #[inline(always)]
    fn put(&mut self, x: usize, new: [f32; 3], old: [f32; 3], length: f32) {
        if new[0].is_nan() {
            (self.out[x], self.out_length[x]) = ([0.0; 3], 0.0);
            return;
        }
        let (weight, length) = self.weight(length);
        // Where old and new agree the result is that very number, not one close to it.
        self.out[x] = std::array::from_fn(|c| new[c] + weight * (old[c] - new[c]));
        self.out_length[x] = length + 1.0;
    }

    /// Blends the samples from column `start` on with what was seen of them before.
    #[inline(always)]
    fn eight<S: Simd>(
        &mut self,
        simd: S,
        start: usize,
        places: &Places,
        before: Before<'_>,
        [clamp, cubic]: [bool; 2],
        work: &mut Work,
    ) {
        let zero = f32x4::splat(simd, 0.0);
        for lane in 0..(self.width - start).min(8) {
            let x = start + lane;
            if self.scratch.new[3 * x].is_nan() {
                (self.out[x], self.out_length[x]) = ([0.0; 3], 0.0);
                continue;
            }
            work.samples_reprojected += 1;
            let new = triple(simd, &self.scratch.new, x);
            let found = match places.inside & (1 << lane) {
                0 => None,
                _ => places.find(simd, lane, before, new, cubic, LEAST_WEIGHT),
            };
            let Some(found) = found else {
                work.history_rejected += 1;
                self.out[x] = [new[0], new[1], new[2]];
                self.out_length[x] = 1.0;
                continue;
            };
            let mut old = found.colour.simd_lt(zero).select(zero, found.colour);
            if clamp {
                let low = triple(simd, &self.scratch.extremes.least, x);
                let high = triple(simd, &self.scratch.extremes.greatest, x);
                let v = old.simd_lt(low).select(low, old);
                let v = v.simd_gt(high).select(high, v);
                let same = v.simd_eq(old).to_bitmask() as u32;
                work.history_clamped += u64::from(same & 0b111 != 0b111);
                old = v;
            }
            // What only some of the samples around show lies to one side of the place, and is the same
            // for the next sample that comes into sight there: it must not grow old. So a length
            // counts by the fourth power of their share.
            let sure = found.weight * (found.weight * found.weight);
            let (weight, length) = self.weight(found.length * sure);
            // Where old and new agree the result is that very number, not one close to it.
            let mean = new + (old - new) * weight;
            self.out_length[x] = length + 1.0;
            put_triple(self.out.as_flattened_mut(), x, mean);
        }
    }
}
