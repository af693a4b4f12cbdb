use std::fmt;
use std::str::FromStr;

use glam::{DVec2, UVec2};

use super::cells::{self, Cells};
use super::estimate::Estimate;
use super::mosaic::{self, Density, Tally};
use super::need::Need;
use super::text::{Setting, settings};
use super::{Aim, Method, PlanCache, Request, Screen};
use crate::{ModelError, SamplePlan};

/// Settings of separable rate maps (Metal's `MTLRasterizationRateMap`), written `rates[:setting]…`:
///
/// | setting | meaning |
/// |---|---|
/// | `bands=N` | bands along each axis, 1 to 256 (32) |
/// | `tracked`, `fixed`, `fixed=DEG` | whether it follows the gaze (see [`Aim`]) |
///
/// The display is cut into bands of columns and bands of rows, a multiple of four pixels wide, each
/// with a rate of 1, ¾, ½ or ¼ samples per pixel along its axis. Columns and rows are chosen apart, so a
/// band is as fine as its sharpest place, over the whole other axis, needs: the fine bands make a
/// cross whose arms are finer along one axis than the eye asks for, which is what a separable map costs.
///
/// [`Display`](fmt::Display) writes what differs from the default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RatesSettings {
    bands: u32,
    aim: Aim,
}

const BANDS: &str = "a whole number from 1 to 256";

impl RatesSettings {
    /// At most `bands` bands along each axis.
    ///
    /// # Errors
    /// If `bands` is not from 1 to 256.
    pub fn new(bands: u32, aim: Aim) -> Result<Self, ModelError> {
        if !(1..=256).contains(&bands) {
            return Err(ModelError::range("bands", bands, BANDS));
        }
        Ok(Self { bands, aim })
    }

    /// At most how many bands along each axis.
    pub fn bands(&self) -> u32 {
        self.bands
    }

    /// Whether it follows the gaze.
    pub fn aim(&self) -> Aim {
        self.aim
    }

    pub(super) fn with_aim(self, aim: Aim) -> Self {
        Self { aim, ..self }
    }

    /// Which samples are drawn.
    pub(super) fn plan(&self, request: &Request, cache: Option<&PlanCache>) -> SamplePlan {
        let screen = (&request.viewport).into();
        let need = request.need(&screen, cache);
        let (cell, [x, y]) = self.rates(&need);
        let densities: Vec<Density> = y
            .iter()
            .flat_map(|&y| x.iter().map(move |&x| Density { x, y }))
            .collect();
        mosaic::plan(Method::Rates(*self).to_string(), request, cell, &densities)
    }

    /// The same with fractions of samples.
    pub(super) fn estimate(&self, need: &Need<'_>) -> Estimate {
        let (cell, [x, y]) = self.rates(need);
        let size = cells::pixels(need.screen);
        let mut tally = Tally::default();
        for (j, &y) in y.iter().enumerate() {
            let rows = width(size.y, cell.y, j);
            for (i, &x) in x.iter().enumerate() {
                tally.add(Density { x, y }, width(size.x, cell.x, i) * rows);
            }
        }
        tally.estimate()
    }

    /// The bands' width and height \[px\], and samples per four pixels of each column and each row.
    fn rates(&self, need: &Need<'_>) -> (UVec2, [Vec<u32>; 2]) {
        let cell = self.cell(need.screen);
        let cells = Cells::new(need, cell);
        let count = cells.count();
        let mut finest = [count.x, count.y].map(|n| vec![f64::INFINITY; n as usize]);
        for (i, spacing) in cells.spacings(ENOUGH).enumerate() {
            let (x, y) = (i % count.x as usize, i / count.x as usize);
            finest[0][x] = finest[0][x].min(spacing.x);
            finest[1][y] = finest[1][y].min(spacing.y);
        }
        (
            cell,
            finest.map(|axis| axis.into_iter().map(per_four).collect()),
        )
    }

    /// Whole multiples of four pixels, so that every rate has whole samples in a band.
    fn cell(&self, screen: &Screen) -> UVec2 {
        let fours: DVec2 = cells::pixels(screen) / (4.0 * f64::from(self.bands));
        (fours.ceil().max(DVec2::ONE) * 4.0).as_uvec2()
    }
}

/// With samples so far apart \[px\], one in four pixels is drawn: the coarsest rate.
const ENOUGH: f64 = 4.0;

/// The fewest samples per four pixels that keep to a spacing \[px\].
fn per_four(spacing: f64) -> u32 {
    (1..4).find(|k| 4.0 / f64::from(*k) <= spacing).unwrap_or(4)
}

/// Pixels of the `index`-th band of `band` pixels out of `size`.
fn width(size: f64, band: u32, index: usize) -> f64 {
    let band = f64::from(band);
    (size - band * index as f64).min(band)
}

impl Default for RatesSettings {
    fn default() -> Self {
        Self {
            bands: 32,
            aim: Aim::Tracked,
        }
    }
}

impl FromStr for RatesSettings {
    type Err = ModelError;

    /// Reads what follows `rates:`.
    fn from_str(text: &str) -> Result<Self, ModelError> {
        let mut read = Self::default();
        for setting in settings(text) {
            read = match setting {
                Setting("bands", Some(value)) => {
                    let bands = value.parse();
                    let bands = bands.map_err(|_| ModelError::range("bands", value, BANDS))?;
                    Self::new(bands, read.aim)?
                }
                other => read.with_aim(other.aim("setting of rates", &["bands="])?),
            };
        }
        Ok(read)
    }
}

impl fmt::Display for RatesSettings {
    /// What follows `rates`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self != Self::default().with_aim(self.aim) {
            write!(f, ":bands={}", self.bands)?;
        }
        self.aim.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_keep_to_a_spacing() {
        let cases = [
            (0.3, 4),
            (1.0, 4),
            (1.33, 4),
            (1.34, 3),
            (2.0, 2),
            (3.9, 2),
            (4.0, 1),
            (1e9, 1),
        ];
        for (spacing, wanted) in cases {
            assert_eq!(per_four(spacing), wanted, "{spacing}");
        }
    }
}
