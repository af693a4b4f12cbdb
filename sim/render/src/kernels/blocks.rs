//! What never changes about the blocks of a tile, looked up instead of worked out.

use crate::tile::{BLOCK, BLOCKS_ACROSS, CELL, CELLS_ACROSS, LANES, LaneSet, TILE_SAMPLES};

/// Blocks of a tile.
pub(super) const BLOCKS: usize = TILE_SAMPLES / LANES;

/// The cell of each block.
pub(super) const CELL_OF: [u8; BLOCKS] = {
    let mut cells = [0; BLOCKS];
    let mut block = 0;
    while block < BLOCKS {
        let x = block as i32 % BLOCKS_ACROSS as i32 * BLOCK[0] as i32;
        let y = block as i32 / BLOCKS_ACROSS as i32 * BLOCK[1] as i32;
        cells[block] = (y / CELL * CELLS_ACROSS + x / CELL) as u8;
        block += 1;
    }
    cells
};

/// For each set of lanes of two rows of a block, how many quads of 2 × 2 samples they are of: lanes 0, 1, 4, 5
/// are one, the others the second.
const QUADS: [u8; 256] = {
    let mut quads = [0; 256];
    let mut lanes = 0;
    while lanes < 256 {
        quads[lanes] = (lanes & 0x33 != 0) as u8 + (lanes & 0xcc != 0) as u8;
        lanes += 1;
    }
    quads
};

/// How many quads of 2 × 2 samples a set of lanes is of.
#[inline(always)]
pub(super) fn quads(lanes: LaneSet) -> u64 {
    let [upper, lower] = lanes.to_le_bytes();
    u64::from(QUADS[usize::from(upper)] + QUADS[usize::from(lower)])
}

/// First sample of each block.
pub(super) const BLOCK_AT: [[f32; 2]; BLOCKS] = {
    let mut at = [[0.0; 2]; BLOCKS];
    let mut block = 0;
    while block < BLOCKS {
        let across = BLOCKS_ACROSS as usize;
        at[block] = [
            (block % across * BLOCK[0] as usize) as f32,
            (block / across * BLOCK[1] as usize) as f32,
        ];
        block += 1;
    }
    at
};
