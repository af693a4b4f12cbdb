use fearless_simd::prelude::*;
use foveasim_models::Work;

use super::Kernel;
use super::blocks::quads;
use super::bound::{PARTS, TileBlocks, block_of};
use super::lanes::{Simd, three};
use super::wide::{F, I, M, U, max, min, piece, splat};
use crate::moving::{Counts, Outlines, Target};
use crate::placed::PlacedTile;
use crate::project::SUBSAMPLES;
use crate::raster::Object;
use crate::tile::{CELLS_ACROSS, LANES, LaneSet, TileBuffers};

/// A cell's farthest depth is looked up anew after this many blocks in it have been drawn to.
const STALE: u8 = 16;
/// Blocks of a cell each way.
const CELL_BLOCKS: usize = 2;
/// Blocks across a tile.
const ACROSS: usize = 16;

/// Finds the nearest triangle at each sample of a tile whose samples look at places and times of their own.
///
/// Whether a triangle covers a sample, and how near it is there, is decided by the arithmetic of [`Target::sees`]. Blocks of
/// samples are left out by [`TileBlocks`], or by a published bound.
pub(crate) struct RasterizeMoving<'a> {
    pub(crate) placed: &'a PlacedTile,
    pub(crate) blocks: &'a TileBlocks,
    /// Those that may meet the tile.
    pub(crate) triangles: &'a [&'a Target],
    /// What a published bound leaves of the lattice; ours decides without.
    pub(crate) outlines: Option<&'a Outlines>,
    pub(crate) objects: &'a [Object],
    /// Nothing nearer is drawn: the largest 1/w.
    pub(crate) nearest: f32,
    /// Whether what lies behind all that a cell shows is left out.
    pub(crate) skip_occluded: bool,
    pub(crate) buffers: &'a mut TileBuffers,
    /// Tests and hits of each sample and triangle, where they are asked for.
    pub(crate) counts: Option<&'a mut Counts>,
    pub(crate) work: &'a mut Work,
}

impl Kernel for RasterizeMoving<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let mut drawing = Drawing {
            placed: self.placed,
            blocks: self.blocks,
            triangles: self.triangles,
            objects: self.objects,
            nearest: self.nearest,
            skip_occluded: self.skip_occluded,
            buffers: self.buffers,
            counts: self.counts,
            work: Work::default(),
        };
        for (index, t) in self.triangles.iter().enumerate() {
            match self.outlines {
                None => piece(
                    simd,
                    #[inline(always)]
                    || drawing.triangle(simd, t, index as u32 + 1),
                ),
                Some(outlines) => {
                    for block in outlines.blocks(index) {
                        let place = index as u32 + 1;
                        piece(
                            simd,
                            #[inline(always)]
                            || drawing.block_unless_hidden(simd, block.into(), t, place),
                        );
                    }
                }
            }
        }
        *self.work += drawing.work;
    }
}

/// A tile being drawn.
struct Drawing<'a> {
    placed: &'a PlacedTile,
    blocks: &'a TileBlocks,
    triangles: &'a [&'a Target],
    objects: &'a [Object],
    nearest: f32,
    skip_occluded: bool,
    buffers: &'a mut TileBuffers,
    counts: Option<&'a mut Counts>,
    work: Work,
}

impl Drawing<'_> {
    #[inline(always)]
    fn triangle<S: Simd>(&mut self, simd: S, t: &Target, place: u32) {
        let mut parts = piece(
            simd,
            #[inline(always)]
            || self.blocks.parts.may_cover(simd, t),
        );
        while parts != 0 {
            let part = parts.trailing_zeros() as usize % PARTS;
            parts &= parts - 1;
            if self.skip_occluded && self.hides_part(simd, part, t.depth_range[1]) {
                self.work.cells_occluded += 4;
                continue;
            }
            let mut blocks = piece(
                simd,
                #[inline(always)]
                || self.blocks.blocks[part].may_cover(simd, t),
            );
            while blocks != 0 {
                let lane = blocks.trailing_zeros() as usize % LANES;
                blocks &= blocks - 1;
                piece(
                    simd,
                    #[inline(always)]
                    || self.block(simd, block_of(part, lane), t, place),
                );
            }
        }
    }

    /// Whether all four cells of a part show nothing but what is nearer than `nearest` 1/w.
    #[inline(always)]
    fn hides_part<S: Simd>(&mut self, simd: S, part: usize, nearest: f32) -> bool {
        let across = CELLS_ACROSS as usize;
        let first = part / 4 * 2 * across + part % 4 * 2;
        for cell in [first, first + 1, first + across, first + across + 1] {
            if !self.hides(simd, cell, nearest) {
                return false;
            }
        }
        true
    }

    #[inline(always)]
    fn hides<S: Simd>(&mut self, simd: S, cell: usize, nearest: f32) -> bool {
        if nearest < self.buffers.farthest[cell] {
            return true;
        }
        if self.buffers.changed[cell] < STALE {
            return false;
        }
        self.buffers.changed[cell] = 0;
        self.buffers.farthest[cell] = piece(
            simd,
            #[inline(always)]
            || self.least(simd, cell),
        );
        nearest < self.buffers.farthest[cell]
    }

    /// Least 1/w of a cell.
    #[inline(always)]
    fn least<S: Simd>(&self, simd: S, cell: usize) -> f32 {
        let across = CELLS_ACROSS as usize;
        let first = cell / across * CELL_BLOCKS * ACROSS + cell % across * CELL_BLOCKS;
        let mut least = splat(simd, f32::MAX);
        for block in [first, first + 1, first + ACROSS, first + ACROSS + 1] {
            let valid = self.buffers.valid[block];
            if valid == 0 {
                continue;
            }
            let drawn = M::from_bitmask(simd, valid.into());
            let depth = F::from_slice(simd, &self.buffers.depth[block]);
            least = min(drawn.select(depth, splat(simd, f32::MAX)), least);
        }
        least
            .to_array()
            .into_iter()
            .fold(f32::MAX, |a, b| if b < a { b } else { a })
    }

    #[inline(always)]
    fn block_unless_hidden<S: Simd>(&mut self, simd: S, block: usize, t: &Target, place: u32) {
        let (x, y) = (block % ACROSS / CELL_BLOCKS, block / ACROSS / CELL_BLOCKS);
        let cell = y * CELLS_ACROSS as usize + x;
        if self.skip_occluded && self.hides(simd, cell, t.depth_range[1]) {
            self.work.cells_occluded += 1;
            return;
        }
        self.block(simd, block, t, place);
    }

    /// Coverage and depth of one block.
    #[inline(always)]
    fn block<S: Simd>(&mut self, simd: S, block: usize, t: &Target, place: u32) {
        let valid = self.buffers.valid[block];
        self.work.samples_tested += LANES as u64;
        let looks = piece(
            simd,
            #[inline(always)]
            || Looks::of(simd, self.placed, block, t.moves),
        );
        let (inside, depth) = piece(
            simd,
            #[inline(always)]
            || looks.sees(simd, t, self.nearest),
        );
        let covered = inside & valid;
        self.work.samples_covered += u64::from(covered.count_ones());
        if let Some(counts) = &mut self.counts {
            counts.add(place, block, valid, covered);
        }
        if covered == 0 {
            return;
        }
        let lanes = M::from_bitmask(simd, covered.into());
        let stored = F::from_slice(simd, &self.buffers.depth[block]);
        // What is not covered is farther than anything.
        let depth = lanes.select(depth, splat(simd, -1.0));
        let ties = depth.simd_eq(stored).to_bitmask() as u32;
        let nearer = depth.simd_gt(stored);
        self.work.quads += quads(nearer.to_bitmask() as LaneSet);
        max(depth, stored).store_slice(&mut self.buffers.depth[block]);
        let slots = U::from_slice(simd, &self.buffers.slot[block]);
        nearer
            .select(U::splat(simd, place), slots)
            .store_slice(&mut self.buffers.slot[block]);
        if ties != 0 {
            self.break_ties(ties, block, place);
        }
        let (x, y) = (block % ACROSS / CELL_BLOCKS, block / ACROSS / CELL_BLOCKS);
        let changed = &mut self.buffers.changed[y * CELLS_ACROSS as usize + x];
        *changed = changed.saturating_add(1);
    }

    /// Of equal depths, the triangle that comes first in the scene stays.
    #[cold]
    #[inline(never)]
    fn break_ties(&mut self, mut ties: u32, block: usize, place: u32) {
        let name = |slot: u32| {
            let t = &self.triangles[slot as usize - 1];
            (self.objects[t.object as usize].instance, t.triangle)
        };
        while ties != 0 {
            let lane = ties.trailing_zeros() as usize;
            ties &= ties - 1;
            let slot = &mut self.buffers.slot[block][lane];
            if *slot != 0 && name(place) < name(*slot) {
                *slot = place;
            }
        }
    }
}

/// Pixels per sub-sample.
const PER_SAMPLE: f32 = 1.0 / SUBSAMPLES as f32;

/// Where and when the samples of a block look.
struct Looks<S: Simd> {
    u: F<S>,
    v: F<S>,
    t: F<S>,
}

impl<S: Simd> Looks<S> {
    #[inline(always)]
    fn of(simd: S, placed: &PlacedTile, block: usize, moves: bool) -> Self {
        let at = &placed.at[block];
        Self {
            u: I::from_slice(simd, &at[0]).to_float::<F<S>>() * PER_SAMPLE,
            v: I::from_slice(simd, &at[1]).to_float::<F<S>>() * PER_SAMPLE,
            t: match placed.time.get(block) {
                Some(time) if moves => F::from_slice(simd, time),
                _ => splat(simd, 0.0),
            },
        }
    }

    #[inline(always)]
    fn form(&self, n: &[[f32; 3]; 3], moves: bool) -> F<S> {
        let at = three(
            #[inline(always)]
            |c| match moves {
                true => (self.t * n[2][c] + n[1][c]) * self.t + n[0][c],
                false => splat(self.t.simd, n[0][c]),
            },
        );
        (self.u * at[0] + self.v * at[1]) + at[2]
    }

    /// Lanes that see a triangle, and 1/w of it there.
    #[inline(always)]
    fn sees(&self, simd: S, target: &Target, nearest: f32) -> (LaneSet, F<S>) {
        let zero = splat(simd, 0.0);
        let [x, y] = target.bounds;
        let within = self.u.simd_ge(x[0])
            & self.u.simd_le(x[1])
            & self.v.simd_ge(y[0])
            & self.v.simd_le(y[1]);
        let [d0, d1, d2, d3] = target.volume;
        let volume = match target.moves {
            true => ((self.t * d3 + d2) * self.t + d1) * self.t + d0,
            false => splat(simd, d0),
        };
        let e = three(
            #[inline(always)]
            |i| {
                piece(
                    simd,
                    #[inline(always)]
                    || self.form(&target.edges[i], target.moves),
                )
            },
        );
        let mut front = volume.simd_lt(zero);
        let mut back = match target.both_faces {
            true => volume.simd_gt(zero),
            false => M::from_bitmask(simd, 0),
        };
        for e in e {
            front &= e.simd_le(zero);
            back &= e.simd_ge(zero);
        }
        let seen = within & (front | back);
        if seen.to_bitmask() == 0 {
            return (0, zero);
        }
        let depth = piece(
            simd,
            #[inline(always)]
            || self.form(&target.plane, target.moves) / volume,
        );
        let [low, high] = target.depth_range;
        let depth = max(min(depth, splat(simd, high)), splat(simd, low));
        let seen = seen & depth.simd_le(splat(simd, nearest));
        (seen.to_bitmask() as LaneSet, depth)
    }
}
