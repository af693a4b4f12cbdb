use fearless_simd::prelude::*;
use foveasim_models::Work;

use super::Kernel;
use super::lanes::{F, Simd, i32x8, max, min, splat, u32x8};
use crate::project::SUBSAMPLES;
use crate::raster::{SetUpTriangle, TriangleRef};
use crate::tile::{BLOCK, BLOCKS_ACROSS, SampleTile, TILE, TileBuffers};

/// Samples along each side of a cell, the unit of coarse acceptance and rejection.
const CELL: i32 = 8;

/// Finds the nearest triangle at each sample of a tile.
pub(crate) struct RasterizeTile<'a> {
    pub(crate) tile: &'a SampleTile,
    pub(crate) bin: &'a [TriangleRef],
    pub(crate) lists: &'a [Vec<SetUpTriangle>],
    pub(crate) buffers: &'a mut TileBuffers,
    pub(crate) work: &'a mut Work,
}

impl Kernel for RasterizeTile<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        self.buffers.clear(self.tile);
        for (place, name) in self.bin.iter().enumerate() {
            let triangle = name.get(self.lists);
            if let Some(triangle) = TileTriangle::new(simd, triangle, self.tile, place as u32 + 1) {
                triangle.draw(simd, self.buffers, self.work);
            }
        }
    }
}

/// An edge function over the samples of a tile, in units of the sub-sample grid divided by 256: at
/// sample (x, y) it is `at_origin + x·step[0] + y·step[1]`, and its sign is exact.
///
/// Between neighbouring samples an edge function changes by multiples of 256, so all its values in a
/// tile are congruent mod 256 and the low 8 bits can be dropped without losing the sign.
#[derive(Clone, Copy)]
struct Edge {
    at_origin: i32,
    step: [i32; 2],
}

impl Edge {
    /// Inside everywhere.
    const ACCEPTED: Self = Self {
        at_origin: 0,
        step: [0, 0],
    };

    /// The edge from `a` to `b`; `None` if no sample of the tile at sample `origin` is inside.
    #[inline(always)]
    fn new(a: [i32; 2], b: [i32; 2], origin: [i32; 2]) -> Option<Self> {
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
        let value = value.div_euclid(i64::from(SUBSAMPLES));
        let step = [-d[1], d[0]];
        let last = i64::from(TILE) - 1;
        let reach =
            |pick: fn(i64, i64) -> i64| value + pick(0, step[0] * last) + pick(0, step[1] * last);
        if reach(Ord::max) < 0 {
            return None;
        }
        if reach(Ord::min) >= 0 {
            return Some(Self::ACCEPTED);
        }
        // It crosses the tile, so |value| is at most 63·(|step x| + |step y|) < 2³¹ (see GUARD_SAMPLES).
        Some(Self {
            at_origin: value as i32,
            step: step.map(|s| s as i32),
        })
    }

    #[inline(always)]
    fn at(&self, x: i32, y: i32) -> i32 {
        self.at_origin + x * self.step[0] + y * self.step[1]
    }

    /// Greatest and least value in the cell whose first sample is (x, y).
    #[inline(always)]
    fn over_cell(&self, x: i32, y: i32) -> [i32; 2] {
        let value = self.at(x, y);
        let [dx, dy] = self.step.map(|s| s * (CELL - 1));
        [value + dx.max(0) + dy.max(0), value + dx.min(0) + dy.min(0)]
    }
}

/// A triangle as one tile sees it.
struct TileTriangle<S: Simd> {
    edges: [Edge; 3],
    /// Values at the lanes of a block relative to its first sample.
    edge_lanes: [i32x8<S>; 3],
    /// First and last sample within the bounds, along x and y.
    bounds: [[i32; 2]; 2],
    /// Offset of the tile's first sample from the first corner [samples].
    offset: [f32; 2],
    lane_x: F<S>,
    lane_y: F<S>,
    depth: [f32; 3],
    depth_range: [F<S>; 2],
    slot: u32x8<S>,
}

impl<S: Simd> TileTriangle<S> {
    #[inline(always)]
    fn new(simd: S, t: &SetUpTriangle, tile: &SampleTile, slot: u32) -> Option<Self> {
        let origin = [tile.origin.x as i32, tile.origin.y as i32];
        let [a, b, c] = t.corners;
        let edges = [
            Edge::new(a, b, origin)?,
            Edge::new(b, c, origin)?,
            Edge::new(c, a, origin)?,
        ];
        let lane_x = i32x8::from_slice(simd, &[0, 1, 2, 3, 0, 1, 2, 3]);
        let lane_y = i32x8::from_slice(simd, &[0, 0, 0, 0, 1, 1, 1, 1]);
        let size = [tile.size.x as i32, tile.size.y as i32];
        let bounds = t.sample_bounds();
        let bounds = [0, 1].map(|k| {
            [
                (bounds[k][0] - origin[k]).max(0),
                (bounds[k][1] - origin[k]).min(size[k] - 1),
            ]
        });
        // Exact: a multiple of 1/256 below 2¹⁵.
        let offset = [0, 1]
            .map(|k| (origin[k] * SUBSAMPLES + SUBSAMPLES / 2 - a[k]) as f32 / SUBSAMPLES as f32);
        Some(Self {
            edges,
            edge_lanes: [
                lane_x * edges[0].step[0] + lane_y * edges[0].step[1],
                lane_x * edges[1].step[0] + lane_y * edges[1].step[1],
                lane_x * edges[2].step[0] + lane_y * edges[2].step[1],
            ],
            bounds,
            offset,
            lane_x: lane_x.to_float(),
            lane_y: lane_y.to_float(),
            depth: t.depth,
            depth_range: [splat(simd, t.depth_range[0]), splat(simd, t.depth_range[1])],
            slot: u32x8::splat(simd, slot),
        })
    }

    #[inline(always)]
    fn draw(&self, simd: S, buffers: &mut TileBuffers, work: &mut Work) {
        let [[x0, x1], [y0, y1]] = self.bounds;
        for cell_y in y0 / CELL..=y1.div_euclid(CELL) {
            for cell_x in x0 / CELL..=x1.div_euclid(CELL) {
                let (x, y) = (cell_x * CELL, cell_y * CELL);
                let a = self.edges[0].over_cell(x, y);
                let b = self.edges[1].over_cell(x, y);
                let c = self.edges[2].over_cell(x, y);
                if a[0] < 0 || b[0] < 0 || c[0] < 0 {
                    continue;
                }
                let accepted = (a[1] | b[1] | c[1]) >= 0;
                let rows = y0.max(y) / 2..=y1.min(y + CELL - 1) / 2;
                let columns = x0.max(x) / 4..=x1.min(x + CELL - 1) / 4;
                for by in rows {
                    for bx in columns.clone() {
                        self.block(simd, [bx, by], accepted, buffers, work);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn block(
        &self,
        simd: S,
        [bx, by]: [i32; 2],
        accepted: bool,
        buffers: &mut TileBuffers,
        work: &mut Work,
    ) {
        let (x, y) = (bx * BLOCK[0] as i32, by * BLOCK[1] as i32);
        let block = by as usize * BLOCKS_ACROSS as usize + bx as usize;
        work.samples_tested += 8;
        let zero = i32x8::splat(simd, 0);
        let signs = if accepted {
            zero
        } else {
            (self.edge_lanes[0] + self.edges[0].at(x, y))
                | (self.edge_lanes[1] + self.edges[1].at(x, y))
                | (self.edge_lanes[2] + self.edges[2].at(x, y))
        };
        let inside = signs.simd_ge(zero);
        let valid = buffers.valid[block];
        let covered = inside.to_bitmask() as u8 & valid;
        if covered == 0 {
            return;
        }
        work.samples_covered += u64::from(covered.count_ones());
        let dx = self.lane_x + (self.offset[0] + x as f32);
        let dy = self.lane_y + (self.offset[1] + y as f32);
        let depth = dx * self.depth[1] + self.depth[0] + dy * self.depth[2];
        // Extrapolated from the snapped corner, a sliver's depth could leave the triangle.
        let depth = max(min(depth, self.depth_range[1]), self.depth_range[0]);
        let range = block * 8..block * 8 + 8;
        let stored = F::from_slice(simd, &buffers.depth[range.clone()]);
        // Triangles come in the order of the scene: of equal depths the first one stays.
        let nearer = inside & depth.simd_gt(stored);
        nearer
            .select(depth, stored)
            .store_slice(&mut buffers.depth[range.clone()]);
        let slots = u32x8::from_slice(simd, &buffers.slot[range.clone()]);
        nearer
            .select(self.slot, slots)
            .store_slice(&mut buffers.slot[range]);
    }
}
