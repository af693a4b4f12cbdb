use glam::{DVec2, UVec2};

use super::Screen;
use super::cover::TanBox;
use super::need::Need;

/// A screen cut into cells of whole pixels from the top left; those at the right and lower edge may be
/// cut short.
pub(super) struct Cells<'a> {
    need: &'a Need<'a>,
    size: DVec2,
    cell: DVec2,
}

/// More cells than this are not looked at one by one by [`Cells::survey`].
const MOST_SURVEYED: f64 = 131_072.0;

impl<'a> Cells<'a> {
    pub(super) fn new(need: &'a Need<'a>, cell: UVec2) -> Self {
        let (size, cell) = (pixels(need.screen), cell.as_dvec2());
        Self { need, size, cell }
    }

    /// How many, across and down.
    pub(super) fn count(&self) -> UVec2 {
        (self.size / self.cell).ceil().as_uvec2().max(UVec2::ONE)
    }

    /// The spacing allowed in each cell, row by row.
    pub(super) fn spacings(&self) -> impl Iterator<Item = DVec2> {
        let count = self.count();
        (0..count.y)
            .flat_map(move |y| (0..count.x).map(move |x| UVec2::new(x, y)))
            .map(|index| self.spacing_from(index.as_dvec2() * self.cell).0)
    }

    /// The spacing allowed in each cell and its pixels (of which there may be fractions); their sum is
    /// the screen. Where there are very many cells, as many as can be afforded of that size, evenly
    /// spread, stand for all: then counts are good to about 1e-3.
    pub(super) fn survey(&self, mut visit: impl FnMut(DVec2, f64)) {
        let count = (self.size / self.cell).ceil().max(DVec2::ONE);
        let share = (MOST_SURVEYED / (count.x * count.y)).min(1.0).sqrt();
        let whole = share >= 1.0;
        let looked_at = (count * share).floor().max(DVec2::ONE);
        let pixels = self.size.x * self.size.y / (looked_at.x * looked_at.y);
        for y in 0..looked_at.y as u64 {
            for x in 0..looked_at.x as u64 {
                let index = DVec2::new(x as f64, y as f64);
                if whole {
                    let (spacing, pixels) = self.spacing_from(index * self.cell);
                    visit(spacing, pixels);
                } else {
                    let middle = (index + 0.5) / looked_at * self.size;
                    let (spacing, _) = self.spacing_from(middle - self.cell / 2.0);
                    visit(spacing, pixels);
                }
            }
        }
    }

    /// The spacing allowed in the cell that begins at pixel position `first`, and its pixels.
    fn spacing_from(&self, first: DVec2) -> (DVec2, f64) {
        let last = (first + self.cell).min(self.size);
        let first = first.max(DVec2::ZERO);
        let area = area(self.need.screen, first, last);
        let pixels = last - first;
        (self.need.spacing(area), pixels.x * pixels.y)
    }
}

/// Pixels across and down: exactly whole where the screen is of a display, whose tangents give them back
/// but for rounding. A sliver of a pixel would be a cell of its own.
pub(super) fn pixels(screen: &Screen) -> DVec2 {
    let size = screen.size_px();
    let whole = size.round();
    let is_whole = (size - whole).abs().cmple(whole * 1e-12);
    DVec2::select(is_whole, whole, size)
}

/// The tangents of a rectangle of pixels.
fn area(screen: &Screen, first: DVec2, last: DVec2) -> TanBox {
    let (a, b) = (screen.direction(first), screen.direction(last));
    TanBox {
        min: DVec2::new(a.x, b.y),
        max: DVec2::new(b.x, a.y),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Acuity, GazeDirection};

    fn coarse_share(width_px: f64) -> (f64, f64) {
        let screen = Screen::planar(width_px, 1.0, 0.6).unwrap();
        let need = Need {
            screen: &screen,
            acuity: Acuity::default(),
            gaze: GazeDirection::new(11.0, 7.0).vector(),
            margin_deg: 2.0,
        };
        let (mut coarse, mut all) = (0.0, 0.0);
        Cells::new(&need, UVec2::splat(8)).survey(|spacing, pixels| {
            all += pixels;
            coarse += pixels * f64::from(spacing.max_element() >= 0.004 * width_px);
        });
        assert!((all / screen.pixels() - 1.0).abs() < 1e-9);
        (coarse / all, screen.pixels() / 64.0)
    }

    /// A survey of some cells says what a survey of all does.
    #[test]
    fn very_many_cells_are_sampled() {
        let (all, count) = coarse_share(3700.0);
        assert!(count <= MOST_SURVEYED);
        let (some, count) = coarse_share(1e5);
        assert!(count > 100.0 * MOST_SURVEYED);
        // Cells here are 27 times smaller, which moves the border by half a cell of the former.
        assert!(
            all > 0.2 && all < 0.9 && (some - all).abs() < 0.004,
            "{all}, {some}"
        );
    }
}
