use fearless_simd::prelude::*;
use foveasim_models::{Msaa, Work};

use super::Kernel;
use super::blocks::{BLOCK_AT, BLOCKS, CELL_OF, quads};
use super::edge::Edge;
use super::lanes::three;
use super::wide::{F, I, M, Simd, U, max, min, piece, splat, two};
use crate::msaa::offsets;
use crate::project::SUBSAMPLES;
use crate::raster::{Object, SetUpTriangle};
use crate::tile::{
    ALL, BLOCK, BLOCKS_ACROSS, CELL, CELLS_ACROSS, LANES, LIST, LaneSet, SampleTile, TileBuffers,
};

/// A cell's farthest depth is looked up anew after this many blocks in it have been drawn to.
const STALE: u8 = 16;

/// Finds the nearest triangle at each position of visibility of a tile's samples.
pub(crate) struct RasterizeTile<'a> {
    pub(crate) tile: &'a SampleTile,
    /// Those that meet the tile.
    pub(crate) triangles: &'a [SetUpTriangle],
    pub(crate) objects: &'a [Object],
    pub(crate) msaa: Msaa,
    /// Whether what lies behind all that a cell shows is left out.
    pub(crate) skip_occluded: bool,
    pub(crate) buffers: &'a mut TileBuffers,
    pub(crate) work: &'a mut Work,
}

impl Kernel for RasterizeTile<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        match self.msaa {
            Msaa::One => self.draw::<S, 1>(simd, [[0, 0]]),
            Msaa::Four => self.draw::<S, 4>(simd, offsets::FOUR),
        }
    }
}

impl RasterizeTile<'_> {
    #[inline(always)]
    fn draw<S: Simd, const P: usize>(self, simd: S, offsets: [[i32; 2]; P]) {
        let buffers = self.buffers;
        let mut drawing = Drawing::<P> {
            triangles: self.triangles,
            objects: self.objects,
            skip_occluded: self.skip_occluded,
            depth: blocks(&mut buffers.depth),
            slot: blocks(&mut buffers.slot),
            valid: buffers
                .valid
                .as_slice()
                .try_into()
                .expect("a tile of blocks"),
            farthest: &mut buffers.farthest,
            changed: &mut buffers.changed,
            found: &mut buffers.found,
        };
        let mut counts = Counts::default();
        drawing.all(simd, self.tile, &offsets, &mut counts);
        self.work.triangles_occluded += counts.triangles_occluded;
        self.work.cells_occluded += counts.cells_occluded;
        self.work.samples_tested += counts.blocks_tested * LANES as u64;
        self.work.samples_covered += counts.samples_covered;
        self.work.quads += counts.quads;
    }
}

/// The blocks of a tile, `P` positions each: a fixed number, so that no place in them need be checked.
#[inline(always)]
fn blocks<T, const P: usize>(rows: &mut [T]) -> &mut [[T; P]; BLOCKS] {
    let blocks = rows.as_chunks_mut().0;
    (&mut blocks[..BLOCKS])
        .try_into()
        .expect("a tile of blocks")
}

/// A tile being drawn, at `P` positions of visibility per sample.
struct Drawing<'a, const P: usize> {
    triangles: &'a [SetUpTriangle],
    objects: &'a [Object],
    skip_occluded: bool,
    depth: &'a mut [[[f32; LANES]; P]; BLOCKS],
    slot: &'a mut [[[u32; LANES]; P]; BLOCKS],
    valid: &'a [LaneSet; BLOCKS],
    farthest: &'a mut [f32; CELLS],
    changed: &'a mut [u8; CELLS],
    found: &'a mut [u32; LIST],
}

/// Cells of a tile.
const CELLS: usize = (CELLS_ACROSS * CELLS_ACROSS) as usize;

impl<const P: usize> Drawing<'_, P> {
    #[inline(always)]
    fn all<S: Simd>(
        &mut self,
        simd: S,
        tile: &SampleTile,
        offsets: &[[i32; 2]; P],
        counts: &mut Counts,
    ) {
        let lane_x = I::from_slice(simd, &[0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3]);
        let lane_y = I::from_slice(simd, &[0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3]);
        let lanes = Lanes {
            x: lane_x,
            y: lane_y,
            fx: lane_x.to_float(),
            fy: lane_y.to_float(),
        };
        let origin = [tile.origin.x as i32, tile.origin.y as i32];
        let last = [tile.size.x as i32 - 1, tile.size.y as i32 - 1];
        for (t, place) in self.triangles.iter().zip(1..) {
            let [x0, y0] = two(
                #[inline(always)]
                |k| (i32::from(t.bounds[k][0]) - origin[k]).max(0),
            );
            let [x1, y1] = two(
                #[inline(always)]
                |k| (i32::from(t.bounds[k][1]) - origin[k]).min(last[k]),
            );
            let cells = [[x0 / CELL, x1 / CELL], [y0 / CELL, y1 / CELL]];
            let across = cells[0][1] - cells[0][0] + 1;
            let down = cells[1][1] - cells[1][0] + 1;
            let depth = piece(
                simd,
                #[inline(always)]
                || Depth::<S, P>::new(simd, t, origin, offsets, &lanes, place),
            );
            if t.is_small && across * down <= 4 {
                if self.skip_occluded && self.hidden(simd, cells, t.depth_range[1]) {
                    counts.triangles_occluded += 1;
                    continue;
                }
                let blocks = [[x0 / 4, x1 / 4], [y0 / 4, y1 / 4]];
                piece(
                    simd,
                    #[inline(always)]
                    || self.small(simd, t, &depth, origin, offsets, &lanes, blocks, counts),
                );
            } else {
                let bounds = [[x0, x1], [y0, y1]];
                piece(
                    simd,
                    #[inline(always)]
                    || self.large(simd, t, &depth, origin, offsets, &lanes, bounds, counts),
                );
            }
        }
    }

    /// Whether all that the cells show is nearer than `nearest` 1/w.
    #[inline(always)]
    fn hidden<S: Simd>(&mut self, simd: S, cells: [[i32; 2]; 2], nearest: f32) -> bool {
        for cy in cells[1][0]..=cells[1][1] {
            for cx in cells[0][0]..=cells[0][1] {
                let cell = (cy * CELLS_ACROSS + cx) as usize % CELLS;
                if nearest < self.farthest[cell] {
                    continue;
                }
                if self.changed[cell] < STALE {
                    return false;
                }
                self.changed[cell] = 0;
                self.farthest[cell] = piece(
                    simd,
                    #[inline(always)]
                    || self.least(simd, [cx, cy]),
                );
                if nearest >= self.farthest[cell] {
                    return false;
                }
            }
        }
        true
    }

    /// Least 1/w of a cell.
    #[inline(always)]
    fn least<S: Simd>(&self, simd: S, [cx, cy]: [i32; 2]) -> f32 {
        let mut least = splat(simd, f32::MAX);
        for by in cy * CELL / 4..(cy + 1) * CELL / 4 {
            let first = by as usize * BLOCKS_ACROSS as usize + (cx * CELL / 4) as usize;
            // The two blocks of a cell's row lie side by side.
            for block in first..first + 2 {
                let block = block % BLOCKS;
                match self.valid[block] {
                    ALL => {
                        for depth in &self.depth[block] {
                            least = min(F::from_slice(simd, depth), least);
                        }
                    }
                    0 => {}
                    _ => return 0.0,
                }
            }
        }
        least
            .to_array()
            .into_iter()
            .fold(f32::MAX, |a, b| if b < a { b } else { a })
    }

    /// A triangle of a few cells: all blocks of its bounds are tested.
    #[inline(always)]
    fn small<S: Simd>(
        &mut self,
        simd: S,
        t: &SetUpTriangle,
        depth: &Depth<S, P>,
        origin: [i32; 2],
        offsets: &[[i32; 2]; P],
        lanes: &Lanes<S>,
        [[bx0, bx1], [by0, by1]]: [[i32; 2]; 2],
        counts: &mut Counts,
    ) {
        let [a, b, c] = t.corners;
        let first = [
            (origin[0] + bx0 * BLOCK[0] as i32) * SUBSAMPLES + SUBSAMPLES / 2,
            (origin[1] + by0 * BLOCK[1] as i32) * SUBSAMPLES + SUBSAMPLES / 2,
        ];
        let zero = I::splat(simd, 0);
        // To the next block of the row, and to the first block of the next row.
        let mut steps = [[zero; 3]; 2];
        let mut values = [[zero; P]; 3];
        for (k, (from, to)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
            let d = [to[0] - from[0], to[1] - from[1]];
            let p = [first[0] - from[0], first[1] - from[1]];
            let top_left = d[1] < 0 || (d[1] == 0 && d[0] > 0);
            let value = d[0] * p[1] - d[1] * p[0] - i32::from(!top_left);
            let across = along(simd, lanes, [-d[1], d[0]]);
            for (values, o) in values[k].iter_mut().zip(offsets) {
                // All values at one position are congruent: see [`Edge`].
                let at = (value + d[0] * o[1] - d[1] * o[0]) >> SUBSAMPLES.ilog2();
                *values = across + at;
            }
            let [across, down] = [-d[1] * BLOCK[0] as i32, d[0] * BLOCK[1] as i32];
            steps[0][k] = I::splat(simd, across);
            steps[1][k] = I::splat(simd, down - (bx1 - bx0) * across);
        }
        // First which blocks are covered, in one loop without a branch for each: trip counts and
        // coverage are hard to foresee. Then those.
        let blocks = (bx1 - bx0 + 1) * (by1 - by0 + 1);
        let mut block = by0 * BLOCKS_ACROSS as i32 + bx0;
        let mut left = bx1 - bx0;
        let mut count = 0;
        for _ in 0..blocks {
            let [first, second, third] = &values;
            for (p, ((a, b), c)) in first.iter().zip(second).zip(third).enumerate() {
                let inside = inside(simd, [*a, *b, *c]);
                self.found[count % LIST] = inside | (p as u32) << 16 | (block as u32) << 24;
                count += usize::from(inside != 0);
            }
            let wraps = left == 0;
            let step = &steps[usize::from(wraps)];
            for k in 0..3 {
                for value in &mut values[k] {
                    *value = piece(
                        simd,
                        #[inline(always)]
                        || *value + step[k],
                    );
                }
            }
            let back = bx1 - bx0;
            block += if wraps {
                BLOCKS_ACROSS as i32 - back
            } else {
                1
            };
            left = if wraps { back } else { left - 1 };
        }
        self.blocks(simd, count, depth, counts);
        counts.blocks_tested += blocks as u64 * P as u64;
    }

    /// Any triangle: cell by cell.
    #[inline(always)]
    fn large<S: Simd>(
        &mut self,
        simd: S,
        t: &SetUpTriangle,
        depth: &Depth<S, P>,
        origin: [i32; 2],
        offsets: &[[i32; 2]; P],
        lanes: &Lanes<S>,
        [[x0, x1], [y0, y1]]: [[i32; 2]; 2],
        counts: &mut Counts,
    ) {
        let [a, b, c] = t.corners;
        let edges = [
            Edge::<P>::new(a, b, origin, offsets),
            Edge::<P>::new(b, c, origin, offsets),
            Edge::<P>::new(c, a, origin, offsets),
        ];
        let [Some(e0), Some(e1), Some(e2)] = edges else {
            return;
        };
        let edges = [e0, e1, e2];
        let across = three(
            #[inline(always)]
            |k| along(simd, lanes, edges[k].step),
        );
        for cell_y in y0 / CELL..=y1 / CELL {
            for cell_x in x0 / CELL..=x1 / CELL {
                let (x, y) = (cell_x * CELL, cell_y * CELL);
                let over = three(
                    #[inline(always)]
                    |k| edges[k].over_cell(x, y),
                );
                if over[0][0] < 0 || over[1][0] < 0 || over[2][0] < 0 {
                    continue;
                }
                let here = [[cell_x; 2], [cell_y; 2]];
                if self.skip_occluded && self.hidden(simd, here, t.depth_range[1]) {
                    counts.cells_occluded += 1;
                    continue;
                }
                let accepted = (over[0][1] | over[1][1] | over[2][1]) >= 0;
                let (first_x, last_x) = (x0.max(x) / 4, x1.min(x + CELL - 1) / 4);
                let (first_y, last_y) = (y0.max(y) / 4, y1.min(y + CELL - 1) / 4);
                let (mut bx, mut by, mut count) = (first_x, first_y, 0);
                while by <= last_y {
                    let block = by * BLOCKS_ACROSS as i32 + bx;
                    let (x, y) = (bx * BLOCK[0] as i32, by * BLOCK[1] as i32);
                    for p in 0..P {
                        let inside = piece(
                            simd,
                            #[inline(always)]
                            || {
                                let at = three(
                                    #[inline(always)]
                                    |k| across[k] + edges[k].at(p, x, y),
                                );
                                inside(simd, at)
                            },
                        );
                        let inside = if accepted { ALL.into() } else { inside };
                        self.found[count % LIST] = inside | (p as u32) << 16 | (block as u32) << 24;
                        count += usize::from(inside != 0);
                    }
                    counts.blocks_tested += P as u64;
                    let wraps = bx == last_x;
                    bx = if wraps { first_x } else { bx + 1 };
                    by += i32::from(wraps);
                }
                self.blocks(simd, count, depth, counts);
            }
        }
    }

    /// Depth test of the first `count` blocks found to be covered.
    #[inline(always)]
    fn blocks<S: Simd>(&mut self, simd: S, count: usize, depth: &Depth<S, P>, counts: &mut Counts) {
        let mut any_tie = 0;
        for place in 0..count.min(LIST) {
            piece(
                simd,
                #[inline(always)]
                || any_tie |= self.block(simd, self.found[place], depth, counts),
            );
        }
        if any_tie != 0 {
            self.break_ties(count, depth);
        }
    }

    /// Depth test of one of them; the lanes whose depth was there before.
    #[inline(always)]
    fn block<S: Simd>(
        &mut self,
        simd: S,
        found: u32,
        depth: &Depth<S, P>,
        counts: &mut Counts,
    ) -> u32 {
        let (inside, p, block) = parts::<P>(found);
        let covered = inside & self.valid[block];
        let lanes = M::from_bitmask(simd, covered.into());
        counts.samples_covered += u64::from(covered.count_ones());
        let at = piece(
            simd,
            #[inline(always)]
            || depth.at(p, block),
        );
        let stored = F::from_slice(simd, &self.depth[block][p]);
        // What is not covered is farther than anything.
        let at = lanes.select(at, splat(simd, -1.0));
        let ties = at.simd_eq(stored).to_bitmask() as u32;
        // Written whether or not anything changes, which is hard to foresee; and the greater of two
        // values, not a store of some lanes, which some processors are slow at.
        let nearer = at.simd_gt(stored);
        counts.quads += quads(nearer.to_bitmask() as LaneSet);
        max(at, stored).store_slice(&mut self.depth[block][p]);
        let slots = U::from_slice(simd, &self.slot[block][p]);
        nearer
            .select(depth.slot, slots)
            .store_slice(&mut self.slot[block][p]);
        let changed = &mut self.changed[CELL_OF[block] as usize % CELLS];
        *changed = changed.saturating_add(1);
        ties
    }

    /// Of equal depths, the triangle that comes first in the scene stays.
    #[cold]
    #[inline(never)]
    fn break_ties<S: Simd>(&mut self, count: usize, depth: &Depth<S, P>) {
        let name = |slot: u32| {
            let t = &self.triangles[slot as usize - 1];
            (self.objects[t.object as usize].instance, t.index())
        };
        for found in &self.found[..count.min(LIST)] {
            let (inside, p, block) = parts::<P>(*found);
            let covered = inside & self.valid[block];
            let at = depth.at(p, block).to_array();
            for lane in (0..LANES).filter(|lane| covered >> lane & 1 != 0) {
                let slot = &mut self.slot[block][p][lane];
                let ties = at[lane] == self.depth[block][p][lane];
                if ties && *slot != 0 && name(depth.place) < name(*slot) {
                    *slot = depth.place;
                }
            }
        }
    }
}

/// Change of an edge function of these steps over the lanes of a block.
#[inline(always)]
fn along<S: Simd>(simd: S, lanes: &Lanes<S>, step: [i32; 2]) -> I<S> {
    piece(
        simd,
        #[inline(always)]
        || lanes.x * step[0] + lanes.y * step[1],
    )
}

/// Where none of three edge functions is negative.
#[inline(always)]
fn inside<S: Simd>(simd: S, [a, b, c]: [I<S>; 3]) -> u32 {
    piece(
        simd,
        #[inline(always)]
        || (a | b | c).simd_ge(I::splat(simd, 0)).to_bitmask() as u32,
    )
}

/// Lanes, position and block of an entry of the list of covered blocks.
#[inline(always)]
fn parts<const P: usize>(found: u32) -> (LaneSet, usize, usize) {
    let p = found as usize >> 16 & 0xff;
    (found as LaneSet, p % P, (found >> 24) as usize % BLOCKS)
}

/// Work done so far, kept in registers.
#[derive(Default)]
struct Counts {
    triangles_occluded: u64,
    cells_occluded: u64,
    /// At each position of visibility.
    blocks_tested: u64,
    samples_covered: u64,
    quads: u64,
}

/// Places of a block's samples relative to its first.
struct Lanes<S: Simd> {
    x: I<S>,
    y: I<S>,
    fx: F<S>,
    fy: F<S>,
}

/// 1/w of a triangle over a tile.
struct Depth<S: Simd, const P: usize> {
    step: [f32; 2],
    range: [F<S>; 2],
    slot: U<S>,
    place: u32,
    corner: f32,
    /// From the first corner to the samples of the tile's first block, at each position.
    from: [[F<S>; 2]; P],
}

impl<S: Simd, const P: usize> Depth<S, P> {
    #[inline(always)]
    fn new(
        simd: S,
        t: &SetUpTriangle,
        origin: [i32; 2],
        offsets: &[[i32; 2]; P],
        lanes: &Lanes<S>,
        place: u32,
    ) -> Self {
        let corner = t.corners[0];
        // Exact: multiples of 1/256 below 2¹⁵.
        let mut from = [[lanes.fx, lanes.fy]; P];
        for (from, o) in from.iter_mut().zip(offsets) {
            for k in 0..2 {
                let shift = origin[k] * SUBSAMPLES + SUBSAMPLES / 2 - corner[k] + o[k];
                from[k] += shift as f32 * (1.0 / SUBSAMPLES as f32);
            }
        }
        Self {
            step: [t.depth[1], t.depth[2]],
            range: [splat(simd, t.depth_range[0]), splat(simd, t.depth_range[1])],
            slot: U::splat(simd, place),
            place,
            corner: t.depth[0],
            from,
        }
    }

    /// At position `p` of a block.
    #[inline(always)]
    fn at(&self, p: usize, block: usize) -> F<S> {
        // Exact, as above.
        let [x, y] = BLOCK_AT[block];
        let dx = self.from[p][0] + x;
        let dy = self.from[p][1] + y;
        let depth = dx * self.step[0] + self.corner + dy * self.step[1];
        // Extrapolated from the snapped corner, a sliver's depth could leave the triangle.
        max(min(depth, self.range[1]), self.range[0])
    }
}
