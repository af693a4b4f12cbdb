use fearless_simd::prelude::*;
use foveasim_models::Work;

use super::Kernel;
use super::blocks::quads;
use super::lanes::three;
use super::wide::{F, I, M, Simd, U, WIDTH, max, min, piece, splat, two};
use crate::placed::{BLOCKS, BLOCKS_IN, BLOCKS_OF_CELL, CELLS, PlacedTile};
use crate::project::SUBSAMPLES;
use crate::raster::{Object, SetUpTriangle};
use crate::tile::{ALL, LANES, LaneSet, TileBuffers};

/// A cell's farthest depth is looked up anew after this many blocks in it have been drawn to.
const STALE: u8 = 16;

/// Positions farther than this from a small triangle's first corner along an axis are moved that near
/// \[sub-samples\]. Such a triangle extends over less than half of it, so what is moved was outside of the
/// triangle's bounds and stays outside; and edge functions then fit 31 bits: two products below
/// 2¹⁴ · 2¹⁵, and a constant below 2 · 2¹⁴ · 2¹⁴.
const FARTHEST: i32 = 1 << 15;

/// Finds the nearest triangle at each position of visibility of a tile whose samples lie anywhere on the
/// display: [`RasterizeTile`](super::RasterizeTile) for lattices that are bent.
///
/// Triangles are those of the display's own grid, in display pixels. Whether one covers a position, and how
/// near it is there, is decided by the arithmetic of [`SetUpTriangle::covers`] and
/// [`SetUpTriangle::inverse_w`]. Cells and blocks are left out by the bounds of the very positions in
/// them, so nothing is missed, whatever the map.
pub(crate) struct RasterizePlaced<'a> {
    pub(crate) placed: &'a PlacedTile,
    /// Those that may meet the tile.
    pub(crate) triangles: &'a [SetUpTriangle],
    pub(crate) objects: &'a [Object],
    /// Whether what lies behind all that a cell shows is left out.
    pub(crate) skip_occluded: bool,
    pub(crate) buffers: &'a mut TileBuffers,
    pub(crate) work: &'a mut Work,
}

impl Kernel for RasterizePlaced<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let positions = self.placed.at.len() / BLOCKS;
        let mut drawing = Drawing {
            placed: self.placed,
            objects: self.objects,
            triangles: self.triangles,
            skip_occluded: self.skip_occluded,
            positions,
            buffers: self.buffers,
            work: Work::default(),
        };
        for (t, place) in self.triangles.iter().zip(1..) {
            piece(
                simd,
                #[inline(always)]
                || drawing.triangle(simd, t, place),
            );
        }
        *self.work += drawing.work;
    }
}

/// A tile being drawn.
struct Drawing<'a> {
    placed: &'a PlacedTile,
    objects: &'a [Object],
    triangles: &'a [SetUpTriangle],
    skip_occluded: bool,
    positions: usize,
    buffers: &'a mut TileBuffers,
    work: Work,
}

/// A triangle as the blocks of a tile need it.
struct Target<'a> {
    t: &'a SetUpTriangle,
    /// One more than its place in the tile's list.
    place: u32,
    /// Bounds of its corners, along x and y \[sub-samples\].
    bounds: [[i32; 2]; 2],
    /// Edges: differences along x and y, and the value at the first corner, less one where an edge does
    /// not own the positions on it.
    edges: [([i64; 2], i64); 3],
}

impl<'a> Target<'a> {
    #[inline(always)]
    fn new(t: &'a SetUpTriangle, place: u32) -> Self {
        let [a, b, c] = t.corners;
        let bounds = two(
            #[inline(always)]
            |k| [a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k])],
        );
        let edge = |from: [i32; 2], to: [i32; 2]| {
            let d = two(|k| i64::from(to[k]) - i64::from(from[k]));
            let p = two(|k| i64::from(a[k]) - i64::from(from[k]));
            let top_left = d[1] < 0 || (d[1] == 0 && d[0] > 0);
            (d, d[0] * p[1] - d[1] * p[0] - i64::from(!top_left))
        };
        Self {
            t,
            place,
            bounds,
            edges: [edge(a, b), edge(b, c), edge(c, a)],
        }
    }

    /// Whether no position of a box can be inside.
    #[inline(always)]
    fn misses(&self, x: [i32; 2], y: [i32; 2]) -> bool {
        let [ax, ay] = self.t.corners[0];
        let x = x.map(|c| i64::from(c) - i64::from(ax));
        let y = y.map(|c| i64::from(c) - i64::from(ay));
        self.edges.iter().any(|&([dx, dy], at)| {
            let greatest =
                at + dx * if dx > 0 { y[1] } else { y[0] } - dy * if dy > 0 { x[0] } else { x[1] };
            greatest < 0
        })
    }

    /// Lanes that are inside, of a triangle whose edge functions fit 31 bits near it.
    #[inline(always)]
    fn small<S: Simd>(&self, simd: S, at: &[[i32; LANES]; 2]) -> u32 {
        let from = two(
            #[inline(always)]
            |k| {
                let d = I::from_slice(simd, &at[k]) - self.t.corners[0][k];
                d.min(I::splat(simd, FARTHEST))
                    .max(I::splat(simd, -FARTHEST))
            },
        );
        let [p, q, r] = three(
            #[inline(always)]
            |k| {
                let ([dx, dy], value) = self.edges[k];
                from[1] * (dx as i32) - from[0] * (dy as i32) + value as i32
            },
        );
        (p | q | r).simd_ge(I::splat(simd, 0)).to_bitmask() as u32
    }

    /// Lanes that are inside, of any triangle.
    #[inline(always)]
    fn large(&self, at: &[[i32; LANES]; 2]) -> u32 {
        let [ax, ay] = self.t.corners[0];
        let mut inside = 0;
        for (lane, (x, y)) in at[0].iter().zip(&at[1]).enumerate() {
            let (x, y) = (i64::from(*x) - i64::from(ax), i64::from(*y) - i64::from(ay));
            let mut all = 0i64;
            for ([dx, dy], value) in self.edges {
                all |= value + dx * y - dy * x;
            }
            inside |= u32::from(all >= 0) << lane;
        }
        inside
    }

    /// 1/w at these positions.
    #[inline(always)]
    fn depth<S: Simd>(&self, simd: S, at: &[[i32; LANES]; 2]) -> F<S> {
        let from = two(
            #[inline(always)]
            |k| {
                let d = I::from_slice(simd, &at[k]) - self.t.corners[0][k];
                d.to_float::<F<S>>() * (1.0 / SUBSAMPLES as f32)
            },
        );
        let [at, dx, dy] = self.t.depth;
        let depth = from[0] * dx + at + from[1] * dy;
        let [low, high] = self.t.depth_range;
        max(min(depth, splat(simd, high)), splat(simd, low))
    }
}

impl Drawing<'_> {
    #[inline(always)]
    fn triangle<S: Simd>(&mut self, simd: S, t: &SetUpTriangle, place: u32) {
        let target = Target::new(t, place);
        let mut cells = piece(
            simd,
            #[inline(always)]
            || self.cells(simd, target.bounds),
        );
        while cells != 0 {
            let cell = cells.trailing_zeros() as usize;
            cells &= cells - 1;
            if self.skip_occluded && self.hides(simd, cell, t.depth_range[1]) {
                self.work.cells_occluded += 1;
                continue;
            }
            let boxes = &self.placed.of_cells;
            let [x, y] = two(
                #[inline(always)]
                |k| [boxes.low[k][cell], boxes.high[k][cell]],
            );
            if !t.is_small && target.misses(x, y) {
                continue;
            }
            for block in BLOCKS_IN[cell].map(usize::from) {
                if self.placed.of_blocks.meets(block, target.bounds) {
                    piece(
                        simd,
                        #[inline(always)]
                        || self.block(simd, block, cell, &target),
                    );
                }
            }
        }
    }

    /// The cells whose box meets the bounds of a triangle.
    #[inline(always)]
    fn cells<S: Simd>(&self, simd: S, [x, y]: [[i32; 2]; 2]) -> u64 {
        let boxes = &self.placed.of_cells;
        let mut cells = 0;
        for first in (0..CELLS).step_by(WIDTH) {
            let load = |from: &[i32; CELLS]| I::from_slice(simd, &from[first..first + WIDTH]);
            let met = load(&boxes.low[0]).simd_le(x[1])
                & load(&boxes.high[0]).simd_ge(x[0])
                & load(&boxes.low[1]).simd_le(y[1])
                & load(&boxes.high[1]).simd_ge(y[0]);
            cells |= met.to_bitmask() << first;
        }
        cells
    }

    /// Whether all that a cell shows is nearer than `nearest` 1/w.
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
        let mut least = splat(simd, f32::MAX);
        for block in BLOCKS_IN[cell].map(usize::from) {
            let valid = self.buffers.valid[block];
            if valid == 0 {
                continue;
            }
            let drawn = M::from_bitmask(simd, valid.into());
            let first = block * self.positions;
            for depth in &self.buffers.depth[first..first + self.positions] {
                let depth = drawn.select(F::from_slice(simd, depth), splat(simd, f32::MAX));
                least = min(depth, least);
            }
        }
        least
            .to_array()
            .into_iter()
            .fold(f32::MAX, |a, b| if b < a { b } else { a })
    }

    /// Coverage and depth of one block.
    #[inline(always)]
    fn block<S: Simd>(&mut self, simd: S, block: usize, cell: usize, target: &Target<'_>) {
        let valid = self.buffers.valid[block];
        for index in block * self.positions..(block + 1) * self.positions {
            let at = &self.placed.at[index];
            let inside = if target.t.is_small {
                target.small(simd, at)
            } else {
                target.large(at)
            };
            let covered = inside as LaneSet & valid & ALL;
            self.work.samples_tested += LANES as u64;
            if covered == 0 {
                continue;
            }
            self.work.samples_covered += u64::from(covered.count_ones());
            let lanes = M::from_bitmask(simd, covered.into());
            let depth = target.depth(simd, at);
            let stored = F::from_slice(simd, &self.buffers.depth[index]);
            // What is not covered is farther than anything.
            let depth = lanes.select(depth, splat(simd, -1.0));
            let ties = depth.simd_eq(stored).to_bitmask() as u32;
            let nearer = depth.simd_gt(stored);
            self.work.quads += quads(nearer.to_bitmask() as LaneSet);
            max(depth, stored).store_slice(&mut self.buffers.depth[index]);
            let slots = U::from_slice(simd, &self.buffers.slot[index]);
            nearer
                .select(U::splat(simd, target.place), slots)
                .store_slice(&mut self.buffers.slot[index]);
            if ties != 0 {
                self.break_ties(ties, index, target.place);
            }
        }
        let changed = &mut self.buffers.changed[cell];
        *changed = changed.saturating_add(1);
    }

    /// Of equal depths, the triangle that comes first in the scene stays.
    #[cold]
    #[inline(never)]
    fn break_ties(&mut self, mut ties: u32, index: usize, place: u32) {
        let name = |slot: u32| {
            let t = &self.triangles[slot as usize - 1];
            (self.objects[t.object as usize].instance, t.index())
        };
        while ties != 0 {
            let lane = ties.trailing_zeros() as usize;
            ties &= ties - 1;
            let slot = &mut self.buffers.slot[index][lane];
            if *slot != 0 && name(place) < name(*slot) {
                *slot = place;
            }
        }
    }
}

const _: () = assert!(BLOCKS_OF_CELL * CELLS == BLOCKS && CELLS == u64::BITS as usize);
