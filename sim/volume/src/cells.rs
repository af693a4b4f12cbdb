use rayon::prelude::*;

use crate::levels::Levels;
use crate::table::Table;

/// Voxel cells along each side of a part of the volume that is skipped as a whole.
pub(crate) const SIDE: usize = 4;
/// log₂ of it.
pub(crate) const SIDE_BITS: u32 = 2;
/// Content that is not empty, from this number on; below are empty parts, and how far emptiness reaches.
pub(crate) const OCCUPIED: u32 = 128;

/// The volume in parts of 4 × 4 × 4 cells (between eight voxels each), and what is known of each.
#[derive(Debug)]
pub(crate) struct Cells {
    /// Parts along x, y and z.
    pub(crate) count: [usize; 3],
    /// Below [`OCCUPIED`]: nothing is seen in the part, nor in any that is so many parts away, diagonals
    /// counted as one. Else something may be.
    pub(crate) states: Vec<u32>,
}

impl Cells {
    /// Asks for each part whether the transfer function shows anything of it, or of the voxels right
    /// about it: a place that is taken to be in it through rounding is as empty as it is.
    pub(crate) fn new(levels: &Levels, table: &Table, skip_empty: bool) -> Self {
        let count = levels.dims.map(|n| (n - 1).div_ceil(SIDE));
        let mut states = vec![OCCUPIED; count.iter().product()];
        if skip_empty {
            let slice = count[0] * count[1];
            states
                .par_chunks_mut(slice)
                .enumerate()
                .for_each(|(z, slice)| {
                    for (k, state) in slice.iter_mut().enumerate() {
                        let part = [k % count[0], k / count[0], z];
                        let [low, high] = range(levels, part);
                        if !table.shows(low, high) {
                            *state = OCCUPIED - 1;
                        }
                    }
                });
            reach(&mut states, count);
        }
        Self { count, states }
    }

    /// Parts in which something may be seen.
    pub(crate) fn occupied(&self) -> usize {
        self.states.iter().filter(|s| **s >= OCCUPIED).count()
    }
}

/// Least and greatest level of a part and of the voxels right about it.
fn range(levels: &Levels, part: [usize; 3]) -> [i16; 2] {
    let from = part.map(|p| (p * SIDE).saturating_sub(1));
    let to: [usize; 3] = std::array::from_fn(|a| (part[a] * SIDE + SIDE + 2).min(levels.dims[a]));
    let (mut low, mut high) = (i16::MAX, i16::MIN);
    for z in from[2]..to[2] {
        for y in from[1]..to[1] {
            let row = (z * levels.dims[1] + y) * levels.dims[0];
            for level in &levels.levels[row + from[0]..row + to[0]] {
                low = low.min(*level);
                high = high.max(*level);
            }
        }
    }
    [low, high]
}

/// Writes into each empty part how many parts around it are empty, too: two sweeps, as every shortest way
/// to an occupied part, or out of the volume, goes through a neighbour's.
fn reach(states: &mut [u32], count: [usize; 3]) {
    let [nx, ny, nz] = count.map(|n| n as isize);
    let index = |x: isize, y: isize, z: isize| ((z * ny + y) * nx + x) as usize;
    let mut sweep = |forward: bool| {
        let turn = |k: isize, n: isize| if forward { k } else { n - 1 - k };
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let [x, y, z] = [turn(x, nx), turn(y, ny), turn(z, nz)];
                    let here = index(x, y, z);
                    if states[here] >= OCCUPIED {
                        continue;
                    }
                    let step = if forward { -1 } else { 1 };
                    // The thirteen neighbours that the sweep has met.
                    for dz in -1..=1 {
                        for dy in -1..=1 {
                            for dx in -1..=1 {
                                let met = (dz, dy, dx) < (0, 0, 0);
                                if !met {
                                    continue;
                                }
                                let to = [x - step * dx, y - step * dy, z - step * dz];
                                let inside =
                                    to.iter().zip([nx, ny, nz]).all(|(k, n)| (0..n).contains(k));
                                // Beyond the border there is nothing to see.
                                if !inside {
                                    continue;
                                }
                                let there = states[index(to[0], to[1], to[2])];
                                let reach = if there >= OCCUPIED { 0 } else { there + 1 };
                                states[here] = states[here].min(reach);
                            }
                        }
                    }
                }
            }
        }
    };
    sweep(true);
    sweep(false);
}
