use fearless_simd::prelude::*;
use foveasim_models::{Msaa, Work};

use super::Kernel;
use super::lanes::{F, Simd, i32x8, mask32x8, max, min, splat, three, two, u32x8};
use crate::msaa::offsets;
use crate::project::SUBSAMPLES;
use crate::raster::{Object, PassTriangles, SetUpTriangle, TriangleRef};
use crate::tile::{BLOCK, BLOCKS_ACROSS, CELL, CELLS_ACROSS, SampleTile, TILE, TileBuffers};

/// A cell's farthest depth is looked up anew after this many triangles have changed it.
const STALE: u8 = 4;

/// Finds the nearest triangle at each position of visibility of a tile's samples.
pub(crate) struct RasterizeTile<'a> {
    pub(crate) tile: &'a SampleTile,
    pub(crate) triangles: &'a PassTriangles,
    /// Those that meet the tile.
    pub(crate) names: &'a [TriangleRef],
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
    fn draw<S: Simd, const P: usize>(mut self, simd: S, offsets: [[i32; 2]; P]) {
        let lane_x = i32x8::from_slice(simd, &[0, 1, 2, 3, 0, 1, 2, 3]);
        let lane_y = i32x8::from_slice(simd, &[0, 0, 0, 0, 1, 1, 1, 1]);
        let lanes = Lanes {
            x: lane_x,
            y: lane_y,
            fx: lane_x.to_float(),
            fy: lane_y.to_float(),
        };
        let all = self.triangles;
        let names = self.names;
        let origin = [self.tile.origin.x as i32, self.tile.origin.y as i32];
        let last = [self.tile.size.x as i32 - 1, self.tile.size.y as i32 - 1];
        for (name, place) in names.iter().zip(1..) {
            let t = all.get(*name);
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
            let depth = Depth::<S, P>::new(simd, t, origin, &offsets, &lanes, place);
            if t.is_small && across * down <= 4 {
                if self.skip_occluded && self.hidden(simd, cells, t.depth_range[1], P) {
                    self.work.triangles_occluded += 1;
                    continue;
                }
                let blocks = [[x0 / 4, x1 / 4], [y0 / 2, y1 / 2]];
                self.small(simd, t, &depth, origin, &offsets, &lanes, blocks);
                for cy in cells[1][0]..=cells[1][1] {
                    for cx in cells[0][0]..=cells[0][1] {
                        let cell = (cy * CELLS_ACROSS + cx) as usize;
                        self.buffers.changed[cell] = self.buffers.changed[cell].saturating_add(1);
                    }
                }
            } else {
                let bounds = [[x0, x1], [y0, y1]];
                self.large(simd, t, &depth, origin, &offsets, &lanes, bounds);
            }
        }
    }

    /// Whether all that the cells show is nearer than `nearest` 1/w.
    #[inline(always)]
    fn hidden<S: Simd>(
        &mut self,
        simd: S,
        cells: [[i32; 2]; 2],
        nearest: f32,
        positions: usize,
    ) -> bool {
        for cy in cells[1][0]..=cells[1][1] {
            for cx in cells[0][0]..=cells[0][1] {
                let cell = (cy * CELLS_ACROSS + cx) as usize;
                if nearest < self.buffers.farthest[cell] {
                    continue;
                }
                if self.buffers.changed[cell] < STALE {
                    return false;
                }
                self.buffers.changed[cell] = 0;
                self.buffers.farthest[cell] = self.farthest(simd, [cx, cy], positions);
                if nearest >= self.buffers.farthest[cell] {
                    return false;
                }
            }
        }
        true
    }

    /// Least 1/w of a cell.
    #[inline(always)]
    fn farthest<S: Simd>(&self, simd: S, [cx, cy]: [i32; 2], positions: usize) -> f32 {
        let mut least = splat(simd, f32::MAX);
        for by in cy * CELL / 2..(cy + 1) * CELL / 2 {
            let first = by as usize * BLOCKS_ACROSS as usize + (cx * CELL / 4) as usize;
            // The two blocks of a cell's row lie side by side.
            let range = first * positions * 8..(first + 2) * positions * 8;
            for (k, depth) in self.buffers.depth[range].chunks_exact(8).enumerate() {
                if self.buffers.valid[first + k / positions] == 0xff {
                    least = min(F::from_slice(simd, depth), least);
                } else if self.buffers.valid[first + k / positions] != 0 {
                    return 0.0;
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
    fn small<S: Simd, const P: usize>(
        &mut self,
        simd: S,
        t: &SetUpTriangle,
        depth: &Depth<S, P>,
        origin: [i32; 2],
        offsets: &[[i32; 2]; P],
        lanes: &Lanes<S>,
        [[bx0, bx1], [by0, by1]]: [[i32; 2]; 2],
    ) {
        let [a, b, c] = t.corners;
        let first = [
            (origin[0] + bx0 * BLOCK[0] as i32) * SUBSAMPLES + SUBSAMPLES / 2,
            (origin[1] + by0 * BLOCK[1] as i32) * SUBSAMPLES + SUBSAMPLES / 2,
        ];
        let mut step = [[0; 2]; 3];
        let mut rows = [[i32x8::splat(simd, 0); P]; 3];
        for (k, (from, to)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
            let d = [to[0] - from[0], to[1] - from[1]];
            let p = [first[0] - from[0], first[1] - from[1]];
            let top_left = d[1] < 0 || (d[1] == 0 && d[0] > 0);
            let value = d[0] * p[1] - d[1] * p[0] - i32::from(!top_left);
            let across = lanes.y * d[0] - lanes.x * d[1];
            for (row, o) in rows[k].iter_mut().zip(offsets) {
                // All values at one position are congruent: see [`Edge`].
                let at = (value + d[0] * o[1] - d[1] * o[0]) >> SUBSAMPLES.ilog2();
                *row = across + at;
            }
            step[k] = [-d[1] * BLOCK[0] as i32, d[0] * BLOCK[1] as i32];
        }
        let zero = i32x8::splat(simd, 0);
        // First which blocks are covered, without a branch for each; then those.
        let mut count = 0;
        for by in by0..=by1 {
            let mut values = rows;
            for bx in bx0..=bx1 {
                for p in 0..P {
                    let signs = values[0][p] | values[1][p] | values[2][p];
                    let inside = signs.simd_ge(zero).to_bitmask() as u32;
                    let name = inside | (p as u32) << 8 | (bx as u32) << 16 | (by as u32) << 24;
                    self.buffers.found[count] = name;
                    count += usize::from(inside != 0);
                    for k in 0..3 {
                        values[k][p] = values[k][p] + step[k][0];
                    }
                }
            }
            for k in 0..3 {
                for row in &mut rows[k] {
                    *row = *row + step[k][1];
                }
            }
        }
        for k in 0..count {
            let name = self.buffers.found[k];
            let [inside, p, bx, by] = name.to_le_bytes();
            let (p, bx, by) = (p as usize, i32::from(bx), i32::from(by));
            let block = (by * BLOCKS_ACROSS as i32 + bx) as usize;
            let inside = mask32x8::from_bitmask(simd, u64::from(inside));
            self.block(simd, block, [bx, by], p, inside, depth);
        }
        let blocks = ((bx1 - bx0 + 1) * (by1 - by0 + 1)) as u64;
        self.work.samples_tested += blocks * 8 * P as u64;
    }

    /// Any triangle: cell by cell.
    #[inline(always)]
    fn large<S: Simd, const P: usize>(
        &mut self,
        simd: S,
        t: &SetUpTriangle,
        depth: &Depth<S, P>,
        origin: [i32; 2],
        offsets: &[[i32; 2]; P],
        lanes: &Lanes<S>,
        [[x0, x1], [y0, y1]]: [[i32; 2]; 2],
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
            |k| lanes.x * edges[k].step[0] + lanes.y * edges[k].step[1],
        );
        let zero = i32x8::splat(simd, 0);
        let everywhere = zero.simd_ge(zero);
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
                if self.skip_occluded && self.hidden(simd, here, t.depth_range[1], P) {
                    self.work.cells_occluded += 1;
                    continue;
                }
                let accepted = (over[0][1] | over[1][1] | over[2][1]) >= 0;
                for by in y0.max(y) / 2..=y1.min(y + CELL - 1) / 2 {
                    for bx in x0.max(x) / 4..=x1.min(x + CELL - 1) / 4 {
                        let block = (by * BLOCKS_ACROSS as i32 + bx) as usize;
                        let (x, y) = (bx * BLOCK[0] as i32, by * BLOCK[1] as i32);
                        for p in 0..P {
                            let inside = if accepted {
                                everywhere
                            } else {
                                let signs = (across[0] + edges[0].at(p, x, y))
                                    | (across[1] + edges[1].at(p, x, y))
                                    | (across[2] + edges[2].at(p, x, y));
                                signs.simd_ge(zero)
                            };
                            self.block(simd, block, [bx, by], p, inside, depth);
                        }
                        self.work.samples_tested += 8 * P as u64;
                    }
                }
                let cell = (cell_y * CELLS_ACROSS + cell_x) as usize;
                self.buffers.changed[cell] = self.buffers.changed[cell].saturating_add(1);
            }
        }
    }

    /// Depth test at one position of the samples of a block that are inside the triangle.
    #[inline(always)]
    fn block<S: Simd, const P: usize>(
        &mut self,
        simd: S,
        block: usize,
        [bx, by]: [i32; 2],
        p: usize,
        inside: mask32x8<S>,
        depth: &Depth<S, P>,
    ) {
        let covered = inside.to_bitmask() as u32 & u32::from(self.buffers.valid[block]);
        if covered == 0 {
            return;
        }
        self.work.samples_covered += u64::from(covered.count_ones());
        let at = depth.at(simd, p, bx * BLOCK[0] as i32, by * BLOCK[1] as i32);
        let first = (block * P + p) * 8;
        let stored = F::from_slice(simd, &self.buffers.depth[first..first + 8]);
        let nearer = inside & at.simd_gt(stored);
        let ties = (inside & at.simd_eq(stored)).to_bitmask() as u32 & covered;
        if ties != 0 {
            self.tie(first, ties, depth.place);
        }
        let seen = nearer.to_bitmask() as u32 & covered;
        if seen == 0 {
            return;
        }
        // Lanes 0, 1, 4, 5 are one quad of 2 × 2 samples, the others the second.
        let quads = u64::from(seen & 0x33 != 0) + u64::from(seen & 0xcc != 0);
        self.work.quads += quads;
        nearer
            .select(at, stored)
            .store_slice(&mut self.buffers.depth[first..first + 8]);
        let slots = u32x8::from_slice(simd, &self.buffers.slot[first..first + 8]);
        nearer
            .select(depth.slot, slots)
            .store_slice(&mut self.buffers.slot[first..first + 8]);
    }

    /// Of equal depths, the triangle that comes first in the scene stays.
    #[inline(never)]
    fn tie(&mut self, first: usize, lanes: u32, place: u32) {
        let name = |slot: u32| {
            let t = self.triangles.get(self.names[slot as usize - 1]);
            (self.objects[t.object as usize].instance, t.index())
        };
        for lane in (0..8).filter(|lane| lanes >> lane & 1 != 0) {
            let old = self.buffers.slot[first + lane];
            if old != 0 && name(place) < name(old) {
                self.buffers.slot[first + lane] = place;
            }
        }
    }
}

/// Places of a block's samples relative to its first.
struct Lanes<S: Simd> {
    x: i32x8<S>,
    y: i32x8<S>,
    fx: F<S>,
    fy: F<S>,
}

/// 1/w of a triangle over a tile.
struct Depth<S: Simd, const P: usize> {
    step: [f32; 2],
    range: [F<S>; 2],
    slot: u32x8<S>,
    place: u32,
    offset: [[f32; 2]; P],
    corner: f32,
    fx: F<S>,
    fy: F<S>,
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
        let offset = offsets.map(|o| {
            [0, 1].map(|k| {
                let from = origin[k] * SUBSAMPLES + SUBSAMPLES / 2 - corner[k] + o[k];
                from as f32 * (1.0 / SUBSAMPLES as f32)
            })
        });
        Self {
            step: [t.depth[1], t.depth[2]],
            range: [splat(simd, t.depth_range[0]), splat(simd, t.depth_range[1])],
            slot: u32x8::splat(simd, place),
            place,
            offset,
            corner: t.depth[0],
            fx: lanes.fx,
            fy: lanes.fy,
        }
    }

    /// At position `p` of the block whose first sample is (x, y).
    #[inline(always)]
    fn at(&self, _simd: S, p: usize, x: i32, y: i32) -> F<S> {
        let dx = self.fx + (self.offset[p][0] + x as f32);
        let dy = self.fy + (self.offset[p][1] + y as f32);
        let depth = dx * self.step[0] + self.corner + dy * self.step[1];
        // Extrapolated from the snapped corner, a sliver's depth could leave the triangle.
        max(min(depth, self.range[1]), self.range[0])
    }
}

/// An edge function over the samples of a tile, at each position of visibility, in units of the
/// sub-sample grid divided by 256: at sample (x, y) it is `at_origin + x·step[0] + y·step[1]`, and its
/// sign is exact.
///
/// Between neighbouring samples an edge function changes by multiples of 256, so all its values at one
/// position are congruent mod 256 and the low 8 bits can be dropped without losing the sign.
#[derive(Clone, Copy)]
struct Edge<const P: usize> {
    at_origin: [i32; P],
    step: [i32; 2],
}

impl<const P: usize> Edge<P> {
    /// Inside everywhere.
    const ACCEPTED: Self = Self {
        at_origin: [0; P],
        step: [0, 0],
    };

    /// The edge from `a` to `b`; `None` if no sample of the tile at sample `origin` is inside.
    #[inline(always)]
    fn new(a: [i32; 2], b: [i32; 2], origin: [i32; 2], offsets: &[[i32; 2]; P]) -> Option<Self> {
        let d = [
            i64::from(b[0]) - i64::from(a[0]),
            i64::from(b[1]) - i64::from(a[1]),
        ];
        let half = SUBSAMPLES / 2;
        let p = [0, 1].map(|k| {
            i64::from(origin[k]) * i64::from(SUBSAMPLES) + i64::from(half) - i64::from(a[k])
        });
        // Top-left rule: a sample exactly on an edge belongs to the triangle below or right of it.
        let top_left = d[1] < 0 || (d[1] == 0 && d[0] > 0);
        let value = d[0] * p[1] - d[1] * p[0] - i64::from(!top_left);
        let values = offsets.map(|o| {
            (value + d[0] * i64::from(o[1]) - d[1] * i64::from(o[0])) >> SUBSAMPLES.ilog2()
        });
        let step = [-d[1], d[0]];
        let last = i64::from(TILE) - 1;
        let reach = |pick: fn(i64, i64) -> i64| {
            let value = values.into_iter().reduce(pick).unwrap_or(0);
            value + pick(0, step[0] * last) + pick(0, step[1] * last)
        };
        if reach(Ord::max) < 0 {
            return None;
        }
        if reach(Ord::min) >= 0 {
            return Some(Self::ACCEPTED);
        }
        // It crosses the tile, so |value| is at most 64·(|step x| + |step y|) < 2³¹ (see GUARD_SAMPLES).
        Some(Self {
            at_origin: values.map(|v| v as i32),
            step: step.map(|s| s as i32),
        })
    }

    #[inline(always)]
    fn at(&self, p: usize, x: i32, y: i32) -> i32 {
        self.at_origin[p] + x * self.step[0] + y * self.step[1]
    }

    /// Greatest and least value in the cell whose first sample is (x, y).
    #[inline(always)]
    fn over_cell(&self, x: i32, y: i32) -> [i32; 2] {
        let [dx, dy] = self.step.map(|s| s * (CELL - 1));
        let (mut high, mut low) = (i32::MIN, i32::MAX);
        for p in 0..P {
            let value = self.at(p, x, y);
            high = high.max(value);
            low = low.min(value);
        }
        [high + dx.max(0) + dy.max(0), low + dx.min(0) + dy.min(0)]
    }
}
