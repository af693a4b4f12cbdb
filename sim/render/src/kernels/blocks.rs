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

/// How many quads of 2 × 2 samples a set of lanes is of.
#[inline(always)]
pub(super) fn quads(lanes: LaneSet) -> u64 {
    // To the left lane of each pair, then to the upper one of each pair of pairs.
    let pairs = lanes | lanes >> 1;
    let quads = (pairs | pairs >> BLOCK[0]) & 0x0505;
    u64::from(quads.count_ones())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quads_are_pairs_of_rows_and_columns() {
        for lanes in 0..=LaneSet::MAX {
            let mut seen = [false; 4];
            for lane in (0..LANES).filter(|lane| lanes >> lane & 1 != 0) {
                seen[lane / 8 * 2 + lane % 4 / 2] = true;
            }
            let expected = seen.iter().filter(|seen| **seen).count() as u64;
            assert_eq!(quads(lanes), expected, "{lanes:b}");
        }
    }
}
