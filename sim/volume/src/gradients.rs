use rayon::prelude::*;

use crate::cells::{Cells, OCCUPIED, SIDE};
use crate::levels::Levels;

/// Cells along each side of a brick.
pub(crate) const BRICK: usize = 8;
/// Voxels along each side: the cells' corners.
pub(crate) const ACROSS: usize = BRICK + 1;
/// Numbers from a voxel to the next along y and z; four for each voxel.
pub(crate) const ROW: usize = 4 * ACROSS;
/// See [`ROW`].
pub(crate) const SLICE: usize = ROW * ACROSS;
/// Numbers of a brick.
pub(crate) const NUMBERS: usize = SLICE * ACROSS;

/// Levels and gradients of the voxels that may be seen, in bricks of 8 × 8 × 8 cells, so that what is read
/// together lies together.
#[derive(Debug)]
pub(crate) struct Gradients {
    /// Brick after brick; in each, x runs fastest, four numbers for each voxel: its level and the
    /// differences of its neighbours along x, y and z.
    pub(crate) bricks: Vec<[i16; NUMBERS]>,
}

impl Gradients {
    /// Computes the bricks in which something may be seen, and writes their numbers, from [`OCCUPIED`] on,
    /// into the states of the cells.
    pub(crate) fn new(levels: &Levels, cells: &mut Cells) -> Self {
        let parts = BRICK / SIDE;
        let count = cells.count.map(|n| n.div_ceil(parts));
        let mut origins = Vec::new();
        for k in 0..count.iter().product() {
            let brick = [
                k % count[0],
                k / count[0] % count[1],
                k / count[0] / count[1],
            ];
            let number = OCCUPIED + origins.len() as u32;
            if mark(cells, brick.map(|b| b * parts), parts, number) {
                origins.push(brick.map(|b| (b * BRICK) as isize));
            }
        }
        let mut bricks = vec![[0i16; NUMBERS]; origins.len()];
        bricks
            .par_iter_mut()
            .zip(&origins)
            .for_each(|(brick, origin)| {
                for (k, voxel) in brick.chunks_exact_mut(4).enumerate() {
                    let at = [k % ACROSS, k / ACROSS % ACROSS, k / ACROSS / ACROSS];
                    let place = std::array::from_fn(|a| origin[a] + at[a] as isize);
                    voxel.copy_from_slice(&levels.with_gradient(place));
                }
            });
        Self { bricks }
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
