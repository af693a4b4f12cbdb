use foveasim_models::{Affine, Lattice, Map, Pass, Work};
use glam::UVec2;

use crate::live::Live;

/// Samples along each side of a tile: depth and identity of one fit the first-level cache.
pub(crate) const TILE: u32 = 64;
/// Samples of a tile.
pub(crate) const TILE_SAMPLES: usize = (TILE * TILE) as usize;
/// Samples are kept in blocks of 4 × 4, close together in both directions.
pub(crate) const BLOCK: [u32; 2] = [4, 4];
/// Samples of a block, row by row: its lanes.
pub(crate) const LANES: usize = (BLOCK[0] * BLOCK[1]) as usize;
const _: () = assert!(LANES == crate::kernels::WIDTH);
/// A set of lanes, one bit for each.
pub(crate) type LaneSet = u16;
/// All lanes of a block.
pub(crate) const ALL: LaneSet = LaneSet::MAX;
/// Blocks along a row of blocks.
pub(crate) const BLOCKS_ACROSS: u32 = TILE / BLOCK[0];

/// Samples along each side of a cell, the unit of coarse acceptance and rejection.
pub(crate) const CELL: i32 = 8;
/// Cells along a row of cells.
pub(crate) const CELLS_ACROSS: i32 = TILE as i32 / CELL;

/// More than the blocks of four cells at four positions each: one more, so that the next may be written
/// before it is known whether it counts; and a power of two.
pub(crate) const LIST: usize = 128;

/// A square of samples of one pass, and where they lie on the display: what every kind of visibility
/// and all shading consume. Which kind of map it is, is asked once per tile, not per sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SampleTile {
    /// Lattice index of the first sample.
    pub(crate) origin: UVec2,
    /// Samples across and down, at most [`TILE`]; fewer at the lattice's end.
    pub(crate) size: UVec2,
    /// Lattice position to the display pixels where samples are taken.
    pub(crate) map: Map,
}

impl SampleTile {
    /// The tile at column `x` and row `y` of tiles of a pass.
    pub(crate) fn of(pass: &Pass, x: u32, y: u32) -> Self {
        let Lattice::Grid(grid) = pass.lattice else {
            unreachable!("only grids pass the checks")
        };
        let origin = UVec2::new(x, y) * TILE;
        Self {
            origin,
            size: (grid - origin).min(UVec2::splat(TILE)),
            map: sampled(pass),
        }
    }

    /// From where shading takes its samples to be, to display pixels. Samples that do not lie evenly are
    /// where their [placement](crate::placement::Placement) says, in display pixels.
    pub(crate) fn affine(&self) -> Affine {
        match self.map {
            Map::Affine(map) => map,
            _ => Affine::IDENTITY,
        }
    }
}

/// The map of a pass with its shift, if its samples lie evenly: where they are taken, not what they stand for.
pub(crate) fn sampled(pass: &Pass) -> Map {
    match pass.map {
        Map::Affine(map) => Map::Affine(Affine {
            origin: map.origin + pass.offset * map.scale,
            ..map
        }),
        other => other,
    }
}

/// Place of sample (x, y) in a tile's buffers, for one position of visibility.
#[inline(always)]
pub(crate) fn index_of(x: u32, y: u32) -> usize {
    let block = (y / BLOCK[1]) * BLOCKS_ACROSS + x / BLOCK[0];
    block as usize * LANES + ((y % BLOCK[1]) * BLOCK[0] + x % BLOCK[0]) as usize
}

/// Sample (x, y) at a place in a tile's buffers.
#[inline(always)]
pub(crate) fn position_of(index: usize) -> [u32; 2] {
    let (block, lane) = ((index / LANES) as u32, (index % LANES) as u32);
    [
        block % BLOCKS_ACROSS * BLOCK[0] + lane % BLOCK[0],
        block / BLOCKS_ACROSS * BLOCK[1] + lane / BLOCK[0],
    ]
}

/// What is visible at each position of visibility of a tile's samples: for each block, the lanes of the
/// first position, then of the next.
#[derive(Debug)]
pub(crate) struct TileBuffers {
    /// 1/w of the nearest triangle so far [1/m]; 0 where there is none.
    pub(crate) depth: Vec<[f32; LANES]>,
    /// One more than its place in the tile's list; 0 where there is none.
    pub(crate) slot: Vec<[u32; LANES]>,
    /// For each block, the lanes that are drawn.
    pub(crate) valid: Vec<LaneSet>,
    /// For each cell, a lower bound of 1/w over it.
    pub(crate) farthest: [f32; (CELLS_ACROSS * CELLS_ACROSS) as usize],
    /// For each cell, how many triangles have been drawn in it since that bound was found.
    pub(crate) changed: [u8; (CELLS_ACROSS * CELLS_ACROSS) as usize],
    /// Room for the blocks that a triangle of few cells covers.
    pub(crate) found: [u32; LIST],
}

impl TileBuffers {
    /// For up to `positions` positions of visibility per sample.
    pub(crate) fn new(positions: usize) -> Self {
        Self {
            depth: vec![[0.0; LANES]; TILE_SAMPLES / LANES * positions],
            slot: vec![[0; LANES]; TILE_SAMPLES / LANES * positions],
            valid: vec![ALL; TILE_SAMPLES / LANES],
            farthest: [0.0; (CELLS_ACROSS * CELLS_ACROSS) as usize],
            changed: [0; (CELLS_ACROSS * CELLS_ACROSS) as usize],
            found: [0; LIST],
        }
    }

    /// Empties the buffers for `tile`, of which only `live` samples are drawn. Whether any is; if none,
    /// only the lanes that are drawn are as they must be.
    pub(crate) fn clear(&mut self, tile: &SampleTile, live: &Live<'_>, work: &mut Work) -> bool {
        self.valid.fill(ALL);
        if tile.size != UVec2::splat(TILE) {
            for (block, valid) in self.valid.iter_mut().enumerate() {
                let inside = |lane: usize| {
                    let [x, y] = position_of(block * LANES + lane);
                    x < tile.size.x && y < tile.size.y
                };
                *valid = (0..LANES)
                    .map(|lane| LaneSet::from(inside(lane)) << lane)
                    .sum();
            }
        }
        live.clear(tile, &mut self.valid, work);
        if self.valid.iter().all(|lanes| *lanes == 0) {
            return false;
        }
        self.depth.fill([0.0; LANES]);
        self.slot.fill([0; LANES]);
        self.farthest.fill(0.0);
        self.changed.fill(0);
        true
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::{Eye, SamplePlan};
    use glam::DVec2;

    use super::*;

    #[test]
    fn tiles_say_where_their_samples_are() {
        let mut pass = SamplePlan::full(Eye::Cyclopean, UVec2::new(100, 70))
            .passes
            .remove(0);
        let map = Affine {
            origin: DVec2::new(10.0, -4.0),
            scale: DVec2::splat(2.5),
        };
        pass.map = Map::Affine(map);
        let tile = SampleTile::of(&pass, 1, 1);
        assert_eq!(
            (tile.origin, tile.size),
            (UVec2::new(64, 64), UVec2::new(36, 6))
        );
        assert_eq!((tile.map, tile.affine()), (pass.map, map));
        assert_eq!(SampleTile::of(&pass, 0, 0).size, UVec2::splat(TILE));
    }

    #[test]
    fn block_order_is_a_bijection() {
        for index in 0..TILE_SAMPLES {
            let [x, y] = position_of(index);
            assert_eq!(index_of(x, y), index);
        }
    }
}
