use glam::{DVec2, UVec2};

use super::Kernel;
use super::lanes::Simd;
use crate::project::SUBSAMPLES;
use crate::tile::{BLOCK, BLOCKS_ACROSS, LANES};

/// Positions that are the product of what depends on the column and what depends on the row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PolarTable {
    /// For each column, the distance from the centre \[display pixels\].
    pub(crate) radius: Vec<f64>,
    /// For each row, the unit vector from the centre.
    pub(crate) direction: Vec<DVec2>,
}

/// Finds where the samples of a tile lie, given by tables in double precision: the position of a sample is
/// centre + radius · direction, rounded to sub-samples. Two roundings of 2⁻⁵³ before that one.
pub(crate) struct PlacePolar<'a> {
    pub(crate) table: &'a PolarTable,
    /// \[display pixels\]
    pub(crate) centre: DVec2,
    /// Lattice index of the tile's first sample.
    pub(crate) origin: UVec2,
    /// Size of the display; positions beyond are moved onto it.
    pub(crate) display: UVec2,
    /// For each block, where its positions are written: every `stride`-th, from `first` on.
    pub(crate) out: &'a mut [[[i32; LANES]; 2]],
    pub(crate) first: usize,
    pub(crate) stride: usize,
}

impl Kernel for PlacePolar<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let places = self.out.iter_mut().skip(self.first).step_by(self.stride);
        for (block, out) in places.enumerate() {
            let block = block as u32;
            let x = self.origin.x + block % BLOCKS_ACROSS * BLOCK[0];
            let y = self.origin.y + block / BLOCKS_ACROSS * BLOCK[1];
            // Lanes beyond the lattice repeat its last sample.
            let (mut radius, mut direction) = ([0.0; 4], [DVec2::ZERO; 4]);
            for k in 0..4 {
                let column = (x as usize + k).min(self.table.radius.len() - 1);
                let row = (y as usize + k).min(self.table.direction.len() - 1);
                radius[k] = self.table.radius[column];
                direction[k] = self.table.direction[row];
            }
            let mut at = [[0.0; LANES]; 2];
            for lane in 0..LANES {
                at[0][lane] = self.centre.x + radius[lane % 4] * direction[lane / 4].x;
                at[1][lane] = self.centre.y + radius[lane % 4] * direction[lane / 4].y;
            }
            for axis in 0..2 {
                for lane in 0..LANES {
                    out[axis][lane] = sub_sample(at[axis][lane], self.display[axis]);
                }
            }
        }
    }
}

/// The sub-sample nearest to a display position \[px\], on a display of `size` pixels: positions beyond its
/// edge are moved onto it. The cast saturates, and makes 0 of NaN.
#[inline(always)]
pub(crate) fn sub_sample(px: f64, size: u32) -> i32 {
    let nearest = (px * f64::from(SUBSAMPLES) + 0.5).floor() as i32;
    nearest.clamp(0, size as i32 * SUBSAMPLES - 1)
}
