use glam::UVec2;

use crate::project::SUBSAMPLES;
use crate::tile::{
    BLOCK, BLOCKS_ACROSS, CELL, CELLS_ACROSS, LANES, LaneSet, TILE_SAMPLES, index_of,
};

/// Blocks of a tile.
pub(crate) const BLOCKS: usize = TILE_SAMPLES / LANES;
/// Cells of a tile.
pub(crate) const CELLS: usize = (CELLS_ACROSS * CELLS_ACROSS) as usize;
/// Blocks of a cell.
pub(crate) const BLOCKS_OF_CELL: usize = BLOCKS / CELLS;

/// The blocks of each cell.
pub(crate) const BLOCKS_IN: [[u8; BLOCKS_OF_CELL]; CELLS] = {
    let mut blocks = [[0; BLOCKS_OF_CELL]; CELLS];
    let side = (CELL / BLOCK[0] as i32) as usize;
    let mut cell = 0;
    while cell < CELLS {
        let across = CELLS_ACROSS as usize;
        let first = cell / across * side * BLOCKS_ACROSS as usize + cell % across * side;
        let mut k = 0;
        while k < BLOCKS_OF_CELL {
            blocks[cell][k] = (first + k / side * BLOCKS_ACROSS as usize + k % side) as u8;
            k += 1;
        }
        cell += 1;
    }
    blocks
};

/// Boxes around the positions of many sets of samples, on the display \[sub-samples\].
///
/// They are made of the very positions at which visibility is asked for, after rounding, so none of these
/// lies outside its box, whatever the map: a triangle that is left out because its own bounds miss a box
/// covers no sample of it. A box of no samples is empty: nothing meets it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Boxes<const N: usize> {
    pub(crate) low: [[i32; N]; 2],
    pub(crate) high: [[i32; N]; 2],
}

impl<const N: usize> Boxes<N> {
    pub(crate) const EMPTY: Self = Self {
        low: [[i32::MAX; N]; 2],
        high: [[i32::MIN; N]; 2],
    };

    fn include(&mut self, index: usize, axis: usize, [low, high]: [i32; 2]) {
        self.low[axis][index] = self.low[axis][index].min(low);
        self.high[axis][index] = self.high[axis][index].max(high);
    }

    /// Whether box `index` has a point in common with the given one.
    #[inline(always)]
    pub(crate) fn meets(&self, index: usize, [x, y]: [[i32; 2]; 2]) -> bool {
        // No branches: which of them decides is hard to foresee.
        (self.low[0][index] <= x[1])
            & (self.high[0][index] >= x[0])
            & (self.low[1][index] <= y[1])
            & (self.high[1][index] >= y[0])
    }
}

/// Where the samples of a tile lie on the display, if they do not lie evenly: block by block.
///
/// Positions are rounded to 1/256 of a display pixel, the grid that vertices are snapped to: which
/// triangle covers them is then decided in integers, like everywhere. Rounding moves a sample by
/// at most 1/512 of a pixel along each axis; where that would take it off the display, by twice that.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlacedTile {
    /// Where visibility is asked for: for each block, its lanes at the first position, then at the next
    /// \[sub-samples\].
    pub(crate) at: Vec<[[i32; LANES]; 2]>,
    /// When the samples of each block look, from 0 to 1; empty where all look at once.
    pub(crate) time: Vec<[f32; LANES]>,
    /// Where each sample is shaded \[sub-samples\].
    pub(crate) middle: Vec<[[i32; LANES]; 2]>,
    /// Over how many display pixels, along its longer side, shading averages: at least one.
    pub(crate) width: Vec<[f32; LANES]>,
    pub(crate) of_blocks: Box<Boxes<BLOCKS>>,
    pub(crate) of_cells: Boxes<CELLS>,
    /// Around all samples.
    pub(crate) all: Boxes<1>,
}

impl PlacedTile {
    /// Room for tiles of up to `positions` positions of visibility per sample.
    pub(crate) fn new(positions: usize) -> Self {
        Self {
            at: vec![[[0; LANES]; 2]; BLOCKS * positions],
            time: Vec::new(),
            middle: vec![[[0; LANES]; 2]; BLOCKS],
            width: vec![[1.0; LANES]; BLOCKS],
            of_blocks: Box::new(Boxes::EMPTY),
            of_cells: Boxes::EMPTY,
            all: Boxes::EMPTY,
        }
    }

    /// The same for samples that look at times of their own, at one position each.
    pub(crate) fn at_times() -> Self {
        Self {
            time: vec![[0.0; LANES]; BLOCKS],
            ..Self::new(1)
        }
    }

    /// Where visibility is asked for at `position` of a sample of the tile \[sub-samples\].
    pub(crate) fn position(&self, sample: UVec2, position: usize) -> [i32; 2] {
        let index = index_of(sample.x, sample.y);
        let at = &self.at[index / LANES * (self.at.len() / BLOCKS) + position];
        [at[0][index % LANES], at[1][index % LANES]]
    }

    /// Finds the boxes around the `valid` lanes.
    pub(crate) fn find_boxes(&mut self, valid: &[LaneSet]) {
        let positions = self.at.len() / BLOCKS;
        *self.of_blocks = Boxes::EMPTY;
        self.of_cells = Boxes::EMPTY;
        self.all = Boxes::EMPTY;
        for (cell, blocks) in BLOCKS_IN.iter().enumerate() {
            for block in blocks.map(usize::from) {
                for at in &self.at[block * positions..(block + 1) * positions] {
                    for (axis, lanes) in at.iter().enumerate() {
                        let bounds = bounds(lanes, valid[block]);
                        self.of_blocks.include(block, axis, bounds);
                        self.of_cells.include(cell, axis, bounds);
                        self.all.include(0, axis, bounds);
                    }
                }
            }
        }
    }

    /// Tiles of display pixels that the samples lie in: first and last column, first and last row. None,
    /// if no sample is valid.
    pub(crate) fn tiles(&self, tile: u32) -> Option<[[u32; 2]; 2]> {
        let pixels = tile as i32 * SUBSAMPLES;
        let range = |axis: usize| {
            let (low, high) = (self.all.low[axis][0], self.all.high[axis][0]);
            (low <= high).then(|| [low, high].map(|c| (c / pixels) as u32))
        };
        Some([range(0)?, range(1)?])
    }
}

/// Least and greatest of the valid lanes; an empty range if there are none.
fn bounds(lanes: &[i32; LANES], valid: LaneSet) -> [i32; 2] {
    let (mut low, mut high) = (i32::MAX, i32::MIN);
    for (lane, &c) in lanes.iter().enumerate() {
        let is_valid = valid >> lane & 1 != 0;
        low = low.min(if is_valid { c } else { i32::MAX });
        high = high.max(if is_valid { c } else { i32::MIN });
    }
    [low, high]
}
