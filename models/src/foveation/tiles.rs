use std::fmt;
use std::str::FromStr;

use super::Aim;
use super::text::{Setting, settings};
use crate::ModelError;

/// Settings of the methods that give each tile of the display a rate of its own, written
/// `vrs[:setting]…` and `fdm[:setting]…`:
///
/// | setting | meaning |
/// |---|---|
/// | `tile=8`, `tile=16`, `tile=32` | pixels along each side of a tile (16) |
/// | `max=1`, `max=2`, `max=4` | the coarsest rate: at most this many pixels a side (4) |
/// | `tracked`, `fixed`, `fixed=DEG` | whether it follows the gaze (see [`Aim`]) |
///
/// [`Display`](fmt::Display) writes what differs from the default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TileSettings {
    tile: u32,
    max: u32,
    aim: Aim,
}

impl TileSettings {
    /// Tiles of `tile` pixels with rates up to `max` pixels a side.
    ///
    /// # Errors
    /// If `tile` is not 8, 16 or 32 (what hardware has) or `max` not 1, 2 or 4.
    pub fn new(tile: u32, max: u32, aim: Aim) -> Result<Self, ModelError> {
        if !matches!(tile, 8 | 16 | 32) {
            return Err(ModelError::range("tile", tile, TILES));
        }
        if !matches!(max, 1 | 2 | 4) {
            return Err(ModelError::range("max", max, RATES));
        }
        Ok(Self { tile, max, aim })
    }

    /// Pixels along each side of a tile.
    pub fn tile(&self) -> u32 {
        self.tile
    }

    /// The most pixels a side that share a sample.
    pub fn max(&self) -> u32 {
        self.max
    }

    /// Whether it follows the gaze.
    pub fn aim(&self) -> Aim {
        self.aim
    }

    pub(super) fn with_aim(self, aim: Aim) -> Self {
        Self { aim, ..self }
    }

    /// No rate is coarser than for this spacing \[px\].
    pub(super) fn enough(&self) -> f64 {
        f64::from(self.max)
    }

    /// The coarsest rate allowed that keeps to a spacing \[px\].
    pub(super) fn side(&self, spacing: f64) -> u32 {
        let fits = |side: &u32| *side <= self.max && f64::from(*side) <= spacing;
        [4, 2].into_iter().find(fits).unwrap_or(1)
    }
}

const TILES: &str = "8, 16 or 32 pixels";
const RATES: &str = "1, 2 or 4 pixels";

impl Default for TileSettings {
    fn default() -> Self {
        Self {
            tile: 16,
            max: 4,
            aim: Aim::Tracked,
        }
    }
}

impl FromStr for TileSettings {
    type Err = ModelError;

    /// Reads what follows `vrs:` or `fdm:`.
    fn from_str(text: &str) -> Result<Self, ModelError> {
        let mut read = Self::default();
        for setting in settings(text) {
            read = match setting {
                Setting("tile", Some(value)) => {
                    let tile = value.parse();
                    let tile = tile.map_err(|_| ModelError::range("tile", value, TILES))?;
                    Self::new(tile, read.max, read.aim)?
                }
                Setting("max", Some(value)) => {
                    let max = value.parse();
                    let max = max.map_err(|_| ModelError::range("max", value, RATES))?;
                    Self::new(read.tile, max, read.aim)?
                }
                other => read.with_aim(other.aim("setting of tiles", &["tile=", "max="])?),
            };
        }
        Ok(read)
    }
}

impl fmt::Display for TileSettings {
    /// What follows `vrs` or `fdm`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let default = Self::default();
        if self.tile != default.tile {
            write!(f, ":tile={}", self.tile)?;
        }
        if self.max != default.max {
            write!(f, ":max={}", self.max)?;
        }
        self.aim.fmt(f)
    }
}
