use glam::UVec2;
use rayon::prelude::*;

use crate::MaskSpec;

/// Places in a pixel along each axis at which density is taken. At one, cells of two or three pixels line up along the
/// pixels' rows and columns, and a grid shows.
pub(crate) const FINE: u32 = 2;

/// One ray, in the whole numbers that density is kept in: sums are exact in any order.
pub(crate) const ONE: u64 = 1 << 24;

/// Φ of the parts of every pixel of a mask, [`FINE`] × [`FINE`] each, in units of 1/[`ONE`] rays.
pub(crate) struct Phi {
    size: UVec2,
    /// Of the lower right quarter: the others mirror it.
    quarter: Vec<u32>,
}

impl Phi {
    pub(crate) fn new(spec: &MaskSpec) -> Self {
        let quarter_px = spec.display_px * FINE;
        let part = ONE as f64 / f64::from(FINE * FINE);
        let row = |y: u32| {
            (0..quarter_px.x).map(move |x| {
                let from_gaze = (UVec2::new(x, y).as_dvec2() + 0.5) / f64::from(FINE);
                let r = foveasim_models::math::sqrt(from_gaze.length_squared());
                (spec.density.at(r) * part + 0.5) as u32
            })
        };
        let rows: Vec<Vec<u32>> = (0..quarter_px.y)
            .into_par_iter()
            .map(|y| row(y).collect())
            .collect();
        Self {
            size: spec.mask_px() * FINE,
            quarter: rows.concat(),
        }
    }

    /// Parts along each axis.
    pub(crate) fn size(&self) -> UVec2 {
        self.size
    }

    /// Φ of the parts of row `y`, from left to right.
    pub(crate) fn row(&self, y: u32) -> impl Iterator<Item = u32> + '_ {
        let half = self.size / 2;
        let from_middle = if y < half.y {
            half.y - 1 - y
        } else {
            y - half.y
        };
        let width = half.x as usize;
        let quarter = &self.quarter[from_middle as usize * width..][..width];
        quarter.iter().rev().chain(quarter).copied()
    }

    /// Σ Φ.
    pub(crate) fn total(&self) -> u64 {
        4 * self.quarter.iter().map(|&v| u64::from(v)).sum::<u64>()
    }
}
