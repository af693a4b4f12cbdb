use std::rc::Rc;

use glam::{DVec2, UVec2};

use super::Screen;
use super::cover::TanBox;
use super::need::{Need, Sight};
use super::plan_cache::Sights;

/// A screen cut into cells of whole pixels from the top left; those at the right and lower edge may be
/// cut short.
pub(super) struct Cells<'a> {
    need: &'a Need<'a>,
    size: DVec2,
    cell: DVec2,
    /// What all cells look like, where that is kept.
    kept: Option<Rc<Sights>>,
}

/// More cells than this are not looked at one by one by [`Cells::survey`].
const MOST_SURVEYED: f64 = 131_072.0;

/// Cells along each side of a block.
const BLOCK: u32 = 8;

/// The spacing allowed in all of each block of cells, where that is enough.
struct Blocks {
    across: u32,
    spacings: Vec<Option<DVec2>>,
}

impl Blocks {
    /// Of the block that cell `index` is in; none beyond the last.
    fn of(&self, index: UVec2) -> Option<DVec2> {
        let block = index / BLOCK;
        let place = block.y * self.across + block.x;
        self.spacings.get(place as usize).copied().flatten()
    }
}

impl<'a> Cells<'a> {
    pub(super) fn new(need: &'a Need<'a>, cell: UVec2) -> Self {
        let mut cells = Self {
            need,
            size: pixels(need.screen),
            cell: cell.as_dvec2(),
            kept: None,
        };
        let count = cells.count().as_dvec2();
        if let Some(cache) = need.cache
            && count.x * count.y <= MOST_SURVEYED
        {
            let make = || cells.sights();
            cells.kept = Some(cache.sights(need.screen, need.gaze, cell, make));
        }
        cells
    }

    /// What every cell looks like, and every block.
    fn sights(&self) -> Sights {
        let all = |count: UVec2| {
            let row = move |y: u32| (0..count.x).map(move |x| UVec2::new(x, y));
            (0..count.y).flat_map(row)
        };
        Sights {
            cells: all(self.count()).map(|index| self.sight(index)).collect(),
            blocks: all(self.block_count())
                .map(|b| self.block_sight(b))
                .collect(),
        }
    }

    /// What cell `index` looks like.
    fn sight(&self, index: UVec2) -> Sight {
        match &self.kept {
            Some(sights) => sights.cells[(index.y * self.count().x + index.x) as usize],
            None => self.sight_from(index.as_dvec2() * self.cell),
        }
    }

    fn block_count(&self) -> UVec2 {
        let count = self.count();
        UVec2::new(count.x.div_ceil(BLOCK), count.y.div_ceil(BLOCK))
    }

    /// What block `index` looks like.
    fn block_sight(&self, index: UVec2) -> Sight {
        if let Some(sights) = &self.kept {
            return sights.blocks[(index.y * self.block_count().x + index.x) as usize];
        }
        let side = self.cell * f64::from(BLOCK);
        let first = index.as_dvec2() * side;
        let last = (first + side).min(self.size);
        self.need.sight(area(self.need.screen, first, last))
    }

    /// How many, across and down.
    pub(super) fn count(&self) -> UVec2 {
        (self.size / self.cell).ceil().as_uvec2().max(UVec2::ONE)
    }

    /// The spacing allowed in each cell, row by row; where it is `enough` along both axes, any that is.
    pub(super) fn spacings(&self, enough: f64) -> impl Iterator<Item = DVec2> {
        let (count, blocks) = (self.count(), self.blocks(enough));
        (0..count.y)
            .flat_map(move |y| (0..count.x).map(move |x| UVec2::new(x, y)))
            .map(move |index| match blocks.of(index) {
                Some(spacing) => spacing,
                None => self.need.allowed(self.sight(index)),
            })
    }

    /// What suffices in all of a block of cells suffices in each of them: far from the gaze, most cells need not
    /// be looked at.
    fn blocks(&self, enough: f64) -> Blocks {
        let UVec2 { x: across, y: down } = self.block_count();
        let places = (0..down).flat_map(|y| (0..across).map(move |x| UVec2::new(x, y)));
        let spacing = |place: UVec2| {
            let spacing = self.need.allowed(self.block_sight(place));
            (spacing.min_element() >= enough).then_some(spacing)
        };
        Blocks {
            across,
            spacings: places.map(spacing).collect(),
        }
    }

    /// The spacing allowed in each cell and its pixels (of which there may be fractions); their sum is
    /// the screen. Where there are very many cells, as many as can be afforded of that size, evenly
    /// spread, stand for all: then counts are good to about 1e-3. `enough` is as for [`Cells::spacings`].
    pub(super) fn survey(&self, enough: f64, mut visit: impl FnMut(DVec2, f64)) {
        let count = (self.size / self.cell).ceil().max(DVec2::ONE);
        let share = (MOST_SURVEYED / (count.x * count.y)).min(1.0).sqrt();
        let whole = share >= 1.0;
        let looked_at = (count * share).floor().max(DVec2::ONE);
        if whole {
            return self.survey_blocks(enough, visit);
        }
        let pixels = self.size.x * self.size.y / (looked_at.x * looked_at.y);
        for y in 0..looked_at.y as u64 {
            for x in 0..looked_at.x as u64 {
                let index = DVec2::new(x as f64, y as f64);
                let middle = (index + 0.5) / looked_at * self.size;
                let sight = self.sight_from(middle - self.cell / 2.0);
                visit(self.need.allowed(sight), pixels);
            }
        }
    }

    /// Every cell, block by block; a block that suffices all at once.
    fn survey_blocks(&self, enough: f64, mut visit: impl FnMut(DVec2, f64)) {
        let (count, blocks) = (self.count(), self.blocks(enough));
        for (block, spacing) in (0..).zip(&blocks.spacings) {
            let from = UVec2::new(block % blocks.across, block / blocks.across) * BLOCK;
            let to = (from + BLOCK).min(count);
            if let Some(spacing) = spacing {
                let first = from.as_dvec2() * self.cell;
                let pixels = (to.as_dvec2() * self.cell).min(self.size) - first;
                visit(*spacing, pixels.x * pixels.y);
                continue;
            }
            for y in from.y..to.y {
                for x in from.x..to.x {
                    let index = UVec2::new(x, y);
                    let pixels = self.pixels_from(index.as_dvec2() * self.cell);
                    visit(self.need.allowed(self.sight(index)), pixels);
                }
            }
        }
    }

    /// What the cell that begins at pixel position `first` looks like.
    fn sight_from(&self, first: DVec2) -> Sight {
        let last = (first + self.cell).min(self.size);
        self.need
            .sight(area(self.need.screen, first.max(DVec2::ZERO), last))
    }

    /// Pixels of the cell that begins at pixel position `first`.
    fn pixels_from(&self, first: DVec2) -> f64 {
        let pixels = (first + self.cell).min(self.size) - first.max(DVec2::ZERO);
        pixels.x * pixels.y
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
            cache: None,
        };
        let (mut coarse, mut all) = (0.0, 0.0);
        Cells::new(&need, UVec2::splat(8)).survey(f64::INFINITY, |spacing, pixels| {
            all += pixels;
            coarse += pixels * f64::from(spacing.max_element() >= 0.004 * width_px);
        });
        assert!((all / screen.pixels() - 1.0).abs() < 1e-9);
        (coarse / all, screen.pixels() / 64.0)
    }

    /// Whole blocks that suffice are the cells that do, one by one.
    #[test]
    fn blocks_leave_nothing_out() {
        for (width, at) in [
            (700.0, (11.0, 7.0)),
            (1333.0, (-40.0, 3.0)),
            (90.0, (0.0, 0.0)),
        ] {
            let screen = Screen::planar(width, 1.7, 0.6).unwrap();
            let need = Need {
                screen: &screen,
                acuity: Acuity::default(),
                gaze: GazeDirection::new(at.0, at.1).vector(),
                margin_deg: 1.0,
                cache: None,
            };
            let cells = Cells::new(&need, UVec2::splat(16));
            let capped = |enough: f64| -> Vec<DVec2> {
                cells
                    .spacings(enough)
                    .map(|s| s.min(DVec2::splat(4.0)))
                    .collect()
            };
            assert_eq!(capped(4.0), capped(f64::INFINITY));
            // Pixels by what is allowed there, in quarters of a pixel: the same but for the order of the sum.
            let pixels = |enough: f64| {
                let mut all = [0.0; 17];
                cells.survey(enough, |s, pixels| {
                    all[(s.min_element().min(4.0) * 4.0) as usize] += pixels;
                });
                all
            };
            let (some, all) = (pixels(4.0), pixels(f64::INFINITY));
            let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-12 * screen.pixels();
            assert!(some.iter().zip(&all).all(near), "{some:?} {all:?}");
        }
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
