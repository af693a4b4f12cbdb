use std::sync::Arc;

use glam::UVec2;

use super::region::cells;
use crate::ModelError;

/// Where shading is evaluated.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Shading {
    /// Nowhere: only visibility is found, for other passes to share.
    Nowhere,
    /// Once for each sample and each triangle visible in it.
    PerSample,
    /// Once for each block of samples and each triangle visible in it (variable-rate shading).
    Coarse(TileRates),
}

/// Shading rates of square tiles of samples.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TileRates {
    lattice: UVec2,
    tile: u32,
    rates: Arc<[ShadingRate]>,
}

/// Samples across and down that share an evaluation of shading: each 1, 2 or 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ShadingRate {
    /// Across.
    pub x: u32,
    /// Down.
    pub y: u32,
}

impl ShadingRate {
    /// Every sample by itself.
    pub const FULL: Self = Self { x: 1, y: 1 };

    /// A rate.
    ///
    /// # Errors
    /// If a side is not 1, 2 or 4.
    pub fn new(x: u32, y: u32) -> Result<Self, ModelError> {
        if [x, y].iter().all(|side| matches!(side, 1 | 2 | 4)) {
            return Ok(Self { x, y });
        }
        let value = format!("{x}x{y}");
        Err(ModelError::range(
            "shading rate",
            value,
            "1, 2 or 4 samples a side",
        ))
    }
}

impl TileRates {
    /// Cuts `lattice` into tiles of `tile` samples and asks for the rate of each, by column and row.
    ///
    /// # Errors
    /// If a tile is not 4, 8, 16, 32 or 64 samples (all rates divide them).
    pub fn new(
        lattice: UVec2,
        tile: u32,
        mut rate: impl FnMut(UVec2) -> ShadingRate,
    ) -> Result<Self, ModelError> {
        if !matches!(tile, 4 | 8 | 16 | 32 | 64) {
            let valid = "4, 8, 16, 32 or 64 samples";
            return Err(ModelError::range(
                "shading-rate tile",
                tile.to_string(),
                valid,
            ));
        }
        let tiles = cells(lattice, UVec2::splat(tile));
        let rates = (0..tiles.y)
            .flat_map(|y| (0..tiles.x).map(move |x| UVec2::new(x, y)))
            .map(&mut rate)
            .collect();
        Ok(Self {
            lattice,
            tile,
            rates,
        })
    }

    /// The lattice that they are for.
    pub fn lattice(&self) -> UVec2 {
        self.lattice
    }

    /// Samples along each side of a tile.
    pub fn tile(&self) -> u32 {
        self.tile
    }

    /// The rate at a sample of the lattice.
    ///
    /// # Panics
    /// If there is no such sample.
    pub fn rate(&self, sample: UVec2) -> ShadingRate {
        assert!(sample.cmplt(self.lattice).all(), "no sample {sample}");
        let place = sample / self.tile;
        self.rates[(place.y * self.lattice.x.div_ceil(self.tile) + place.x) as usize]
    }

    /// Tiles: the first sample of each, one past its last, and its rate.
    fn tiles(&self) -> impl Iterator<Item = (UVec2, UVec2, ShadingRate)> {
        let across = self.lattice.x.div_ceil(self.tile).max(1) as usize;
        self.rates.iter().enumerate().map(move |(i, rate)| {
            let first = UVec2::new((i % across) as u32, (i / across) as u32) * self.tile;
            (first, (first + self.tile).min(self.lattice), *rate)
        })
    }

    /// Blocks of shading.
    pub(super) fn blocks(&self) -> u64 {
        let blocks = |from: u32, to: u32, side: u32| u64::from((to - from).div_ceil(side));
        self.tiles()
            .map(|(from, to, rate)| blocks(from.x, to.x, rate.x) * blocks(from.y, to.y, rate.y))
            .sum()
    }

    /// Blocks of shading that hold a sample for which `is_live` holds.
    pub(super) fn blocks_where(&self, is_live: impl Fn(UVec2) -> bool) -> u64 {
        let mut blocks = 0;
        for (from, to, rate) in self.tiles() {
            for by in (from.y..to.y).step_by(rate.y as usize) {
                for bx in (from.x..to.x).step_by(rate.x as usize) {
                    let live = (by..(by + rate.y).min(to.y)).any(|sy| {
                        (bx..(bx + rate.x).min(to.x)).any(|sx| is_live(UVec2::new(sx, sy)))
                    });
                    blocks += u64::from(live);
                }
            }
        }
        blocks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CellMask, Eye, Region, SamplePlan};

    #[test]
    fn blocks_of_shading_are_counted() {
        let lattice = UVec2::new(20, 9);
        let rate = |tile: UVec2| match tile.x {
            0 => ShadingRate::FULL,
            1 => ShadingRate { x: 2, y: 4 },
            _ => ShadingRate { x: 4, y: 4 },
        };
        let rates = TileRates::new(lattice, 8, rate).unwrap();
        // Rows 0-7 and row 8: 64 + 8, then 4 × 2 + 4 × 1, then 1 × 2 + 1.
        let mut pass = SamplePlan::full(Eye::Cyclopean, lattice).passes.remove(0);
        pass.shading = Shading::Coarse(rates);
        assert_eq!(pass.shadings(), 72 + 12 + 3);
        assert_eq!(pass.samples(), 180);
        let mask = CellMask::new(lattice, UVec2::splat(16), |c| c == UVec2::ZERO);
        pass.region = Region::Cells(mask);
        assert_eq!(pass.shadings(), 72 + 12);
        assert!(TileRates::new(lattice, 12, rate).is_err());
        assert!(ShadingRate::new(3, 1).is_err() && ShadingRate::new(4, 2).is_ok());
    }
}
