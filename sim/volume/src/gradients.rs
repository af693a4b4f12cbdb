use rayon::prelude::*;

use crate::cells::{Cells, OCCUPIED, SIDE};
use crate::levels::Levels;

/// Cells along each side of a brick.
pub(crate) const BRICK: usize = 8;
/// Numbers of a record: level and differences of a voxel, each beside that of the voxel that is next along z.
pub(crate) const RECORD: usize = 8;
/// Records from one to the next along y: the cells' corners.
pub(crate) const ROW: usize = BRICK + 1;
/// Records from one to the next along z.
pub(crate) const SLICE: usize = ROW * ROW;
/// Records of a brick.
const RECORDS: usize = SLICE * BRICK;
/// Most records: 4 GiB of them. Their numbers fit 32 bits, with those of [`OCCUPIED`].
pub(crate) const MOST: usize = 1 << 28;

/// Levels and gradients of the voxels that may be seen, in bricks of 8 × 8 × 8 cells, so that what is read
/// together lies together.
#[derive(Debug)]
pub(crate) struct Gradients {
    /// Brick after brick; in each, x runs fastest.
    pub(crate) records: Vec<[i16; RECORD]>,
}

impl Gradients {
    /// Computes the bricks in which something may be seen, and writes where they begin, from [`OCCUPIED`] on,
    /// into the states of the cells; `None` if they take more than `most` records.
    pub(crate) fn new(levels: &Levels, cells: &mut Cells, most: usize) -> Option<Self> {
        let parts = BRICK / SIDE;
        let count = cells.count.map(|n| n.div_ceil(parts));
        let mut origins = Vec::new();
        for k in 0..count.iter().product() {
            let brick = [
                k % count[0],
                k / count[0] % count[1],
                k / count[0] / count[1],
            ];
            let number = OCCUPIED + (origins.len() * RECORDS) as u32;
            if mark(cells, brick.map(|b| b * parts), parts, number) {
                origins.push(brick.map(|b| (b * BRICK) as isize));
                if origins.len() * RECORDS > most {
                    return None;
                }
            }
        }
        let mut records = vec![[0; RECORD]; RECORDS * origins.len()];
        records
            .par_chunks_exact_mut(RECORDS)
            .zip(&origins)
            .for_each(|(brick, origin)| fill(brick, levels, *origin));
        Some(Self { records })
    }
}

/// Computes the brick whose first voxel is `origin`.
fn fill(brick: &mut [[i16; RECORD]], levels: &Levels, origin: [isize; 3]) {
    for z in 0..=BRICK {
        for k in 0..SLICE {
            let at = [k % ROW, k / ROW, z];
            let place = std::array::from_fn(|a| origin[a] + at[a] as isize);
            let voxel = levels.with_gradient(place);
            for (number, value) in voxel.into_iter().enumerate() {
                if z < BRICK {
                    brick[z * SLICE + k][2 * number] = value;
                }
                if z > 0 {
                    brick[(z - 1) * SLICE + k][2 * number + 1] = value;
                }
            }
        }
    }
}

/// Gives the occupied parts from `first` on the number of their brick; whether there is one.
fn mark(cells: &mut Cells, first: [usize; 3], parts: usize, number: u32) -> bool {
    let [nx, ny, nz] = cells.count;
    let mut any = false;
    for z in first[2]..(first[2] + parts).min(nz) {
        for y in first[1]..(first[1] + parts).min(ny) {
            for x in first[0]..(first[0] + parts).min(nx) {
                let state = &mut cells.states[(z * ny + y) * nx + x];
                if *state >= OCCUPIED {
                    *state = number;
                    any = true;
                }
            }
        }
    }
    any
}
