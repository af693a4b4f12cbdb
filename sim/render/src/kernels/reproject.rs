use foveasim_models::Work;
use glam::UVec2;

use super::Kernel;
use super::extremes::Extremes;
use super::lanes::Simd;
use super::place::{Found, Gathered};

/// By how much 1/w may differ, beyond what the surface's slope explains: what is nearer than this part
/// of the distance behind another surface passes for it. Rounding and a level of detail that changed
/// need far less.
const DEPTH_TOLERANCE: f32 = 1.0 / 128.0;
/// Least share of the bilinear weights that must show the surface: the samples that are left are
/// otherwise almost a whole sample away along both axes.
const LEAST_WEIGHT: f32 = 1.0 / 16.0;

/// What a sample of the history knows besides its colour.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Past {
    /// Frames that the colour is a mean of; 0 where nothing was drawn.
    pub(crate) length: f32,
    /// Middle of the 1/w around it [1/m].
    pub(crate) inverse_w: f32,
    /// How far from the middle the 1/w of a surface seen near it may lie [1/m].
    pub(crate) reach: f32,
}

/// Where a point was: (x, y, 1) and 1/w of a sample give, row by row, x, y and 1 of the earlier
/// lattice times the ratio of the earlier to the present w.
pub(crate) type Warp = [f32; 12];

/// An earlier image of a pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Before<'a> {
    pub(crate) size: UVec2,
    pub(crate) rgb: &'a [[f32; 3]],
    pub(crate) past: &'a [Past],
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
    },
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
    pub(crate) scratch: &'a mut Extremes,
    /// The row's colours and their history.
    pub(crate) out: &'a mut [[f32; 3]],
    pub(crate) out_past: &'a mut [Past],
}

impl Kernel for ReprojectRow<'_> {
    type Output = Work;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> Work {
        let mut work = Work::default();
        self.surfaces();
        match self.source {
            Source::Nowhere => self.start(),
            Source::InPlace(before) => self.in_place(before, &mut work),
            Source::Moved {
                before,
                warps,
                warp_of_instance,
                clamp,
            } => {
                if clamp {
                    let [above, row, below] = rows(self.rgb, self.y, self.width);
                    self.scratch.find::<3>(
                        above.as_flattened(),
                        row.as_flattened(),
                        below.as_flattened(),
                    );
                }
                for start in (0..self.width).step_by(8) {
                    let warp = Gathered::new(simd, &self, start, warps, warp_of_instance);
                    self.eight(simd, start, &warp, before, clamp, &mut work);
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
    /// Remembers which 1/w are seen around each sample.
    ///
    /// On a plane 1/w is linear over the lattice. A later sample may look for this surface from up to
    /// two samples away along each axis: one to the neighbour that it is interpolated from, and one
    /// between two jittered positions. The greatest and least 1/w of 3×3 samples differ by the change
    /// over two samples, so their whole difference to either side of the middle covers that.
    #[inline(always)]
    fn surfaces(&mut self) {
        let [above, row, below] = rows(self.inverse_w, self.y, self.width);
        self.scratch.find::<1>(above, row, below);
        let found = self.scratch.least.iter().zip(&self.scratch.greatest);
        for (past, (&least, &greatest)) in self.out_past.iter_mut().zip(found) {
            past.inverse_w = 0.5 * (least + greatest);
            past.reach = greatest - least + DEPTH_TOLERANCE * past.inverse_w;
        }
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
        let past = &before.past[first..first + self.width];
        for x in 0..self.width {
            let new = self.new_row()[x];
            self.put(x, new, old[x], past[x].length);
            work.samples_in_place += u64::from(past[x].length > 0.0 && !new[0].is_nan());
        }
    }

    /// Stores the mean of a new colour and a history of `length` frames.
    #[inline(always)]
    fn put(&mut self, x: usize, new: [f32; 3], old: [f32; 3], length: f32) {
        if new[0].is_nan() {
            (self.out[x], self.out_past[x].length) = ([0.0; 3], 0.0);
            return;
        }
        let length = if length < self.longest {
            length
        } else {
            self.longest
        };
        let weight = length / (length + 1.0);
        // Where old and new agree the result is that very number, not one close to it.
        self.out[x] = std::array::from_fn(|c| new[c] + weight * (old[c] - new[c]));
        self.out_past[x].length = length + 1.0;
    }

    /// Blends the samples from column `start` on with what was seen of them before.
    #[inline(always)]
    fn eight<S: Simd>(
        &mut self,
        simd: S,
        start: usize,
        warp: &Gathered<S>,
        before: Before<'_>,
        clamp: bool,
        work: &mut Work,
    ) {
        let places = warp.places(simd, self, start, before.size);
        for lane in 0..(self.width - start).min(8) {
            let x = start + lane;
            let new = self.new_row()[x];
            if new[0].is_nan() {
                self.put(x, new, new, 0.0);
                continue;
            }
            work.samples_reprojected += 1;
            let found = match places.inside & (1 << lane) {
                0 => Found::NOTHING,
                _ => places.find(lane, before, new),
            };
            if found.weight < LEAST_WEIGHT {
                work.history_rejected += 1;
                self.put(x, new, new, 0.0);
                continue;
            }
            // Differences are averaged, so that equal colours give that very colour.
            let share = 1.0 / found.weight;
            let mut old: [f32; 3] = std::array::from_fn(|c| new[c] + found.difference[c] * share);
            if clamp {
                let mut clamped = false;
                for (c, old) in old.iter_mut().enumerate() {
                    let low = self.scratch.least[3 * x + c];
                    let high = self.scratch.greatest[3 * x + c];
                    let v = if *old < low { low } else { *old };
                    let v = if v > high { high } else { v };
                    clamped |= v != *old;
                    *old = v;
                }
                work.history_clamped += u64::from(clamped);
            }
            self.put(x, new, old, found.length * share);
        }
    }
}
