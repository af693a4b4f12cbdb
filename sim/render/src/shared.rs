use glam::UVec2;

use crate::placed::PlacedTile;
use crate::project::SUBSAMPLES;
use crate::raster::{PassTriangles, SetUpTriangle};
use crate::tile::{LANES, TileBuffers};

/// What the samples of a pass see, kept for a later pass that shades it elsewhere: a visibility buffer
/// (Burns and Hunt 2013), from which all that a G-buffer holds can be had.
#[derive(Debug)]
pub(crate) struct SharedVisibility {
    /// Samples of the pass that found it.
    pub(crate) size: UVec2,
    /// Positions of visibility per sample.
    pub(crate) positions: usize,
    /// Row by row, for each sample its positions: one more than the triangle's number; 0 for the sky.
    pub(crate) number: Vec<u32>,
    /// 1/w there \[1/m\].
    pub(crate) inverse_w: Vec<f32>,
    /// The triangles that are numbered.
    pub(crate) triangles: PassTriangles,
}

/// Memory that a worker uses to look tiles up.
#[derive(Debug, Default)]
pub(crate) struct LookUp {
    /// For each triangle of the pass, its slot in this tile; 0 if it has none.
    slot_of: Vec<u32>,
    /// The triangles that have one.
    numbers: Vec<u32>,
}

impl SharedVisibility {
    /// Fills the buffers of a tile with what the samples see whose cells hold its positions, and moves
    /// these to the middles of the cells: what is seen there is shaded there.
    pub(crate) fn look_up(
        &self,
        placed: &mut PlacedTile,
        buffers: &mut TileBuffers,
        triangles: &mut Vec<SetUpTriangle>,
        scratch: &mut LookUp,
    ) {
        scratch.slot_of.resize(self.triangles.count() + 1, 0);
        for number in scratch.numbers.drain(..) {
            scratch.slot_of[number as usize] = 0;
        }
        triangles.clear();
        let across = self.size.x as usize;
        for (block, valid) in buffers.valid.iter().enumerate() {
            for lane in (0..LANES).filter(|lane| valid >> lane & 1 != 0) {
                let cell = [0, 1].map(|k| {
                    let c = &mut placed.middle[block][k][lane];
                    let cell = *c / SUBSAMPLES;
                    *c = cell * SUBSAMPLES + SUBSAMPLES / 2;
                    cell as usize
                });
                let first = (cell[1] * across + cell[0]) * self.positions;
                for p in 0..self.positions {
                    let number = self.number[first + p];
                    let to = block * self.positions + p;
                    buffers.depth[to][lane] = self.inverse_w[first + p];
                    buffers.slot[to][lane] = match number {
                        0 => 0,
                        _ => {
                            let slot = &mut scratch.slot_of[number as usize];
                            if *slot == 0 {
                                triangles.push(*self.triangles.number(number as usize - 1));
                                scratch.numbers.push(number);
                                *slot = triangles.len() as u32;
                            }
                            *slot
                        }
                    };
                }
            }
        }
    }
}
