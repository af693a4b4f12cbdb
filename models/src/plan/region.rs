use std::sync::Arc;

use glam::UVec2;

use super::Spans;

/// Which samples of a lattice are drawn.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Region {
    /// All.
    All,
    /// Those in live cells.
    Cells(CellMask),
    /// A run of each row: those whose cells lie on the display, at least in part. So every pixel's own
    /// cell is live. A sample whose middle lies beyond the display's edge is taken at the nearest point of
    /// the edge (see [`SamplePlan::position`](super::SamplePlan::position)).
    Spans(Spans),
}

impl Region {
    /// Whether a sample of the lattice is drawn.
    ///
    /// # Panics
    /// If there is no such sample.
    pub fn is_live(&self, sample: UVec2) -> bool {
        match self {
            Self::All => true,
            Self::Cells(mask) => mask.is_live(sample),
            Self::Spans(spans) => spans.is_live(sample),
        }
    }
}

/// A lattice cut into equal cells (the last of a row or column may be cut short), each live or not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CellMask {
    lattice: UVec2,
    cell: UVec2,
    live: Arc<[bool]>,
}

impl CellMask {
    /// Cuts `lattice` into cells of `cell` samples (each side at least 1; clamped) and asks for each,
    /// by column and row, whether it is live.
    pub fn new(lattice: UVec2, cell: UVec2, mut is_live: impl FnMut(UVec2) -> bool) -> Self {
        let cell = cell.max(UVec2::ONE);
        let cells = cells(lattice, cell);
        let live = (0..cells.y)
            .flat_map(|y| (0..cells.x).map(move |x| UVec2::new(x, y)))
            .map(&mut is_live)
            .collect();
        Self {
            lattice,
            cell,
            live,
        }
    }

    /// The lattice that it is for.
    pub fn lattice(&self) -> UVec2 {
        self.lattice
    }

    /// Samples across and down of a cell.
    pub fn cell(&self) -> UVec2 {
        self.cell
    }

    /// Whether a sample of the lattice is live.
    ///
    /// # Panics
    /// If there is no such sample.
    pub fn is_live(&self, sample: UVec2) -> bool {
        assert!(sample.cmplt(self.lattice).all(), "no sample {sample}");
        let place = sample / self.cell;
        self.live[(place.y * cells(self.lattice, self.cell).x + place.x) as usize]
    }

    /// Which cells are live of those that hold samples of row `y`, from left to right.
    ///
    /// # Panics
    /// If the lattice has no such row.
    pub fn row(&self, y: u32) -> &[bool] {
        assert!(y < self.lattice.y, "no row {y}");
        let across = cells(self.lattice, self.cell).x as usize;
        let first = (y / self.cell.y) as usize * across;
        &self.live[first..first + across]
    }

    /// First sample of the least box that holds all live ones, and one past its last; `None` if none is live.
    pub fn bounds(&self) -> Option<[UVec2; 2]> {
        let across = cells(self.lattice, self.cell).x as usize;
        let live = self.live.iter().enumerate().filter(|(_, live)| **live);
        let places = live.map(|(k, _)| UVec2::new((k % across) as u32, (k / across) as u32));
        let (low, high) = places.fold((UVec2::MAX, UVec2::ZERO), |(low, high), place| {
            (low.min(place), high.max(place + 1))
        });
        (high != UVec2::ZERO).then(|| [low, high].map(|b| (b * self.cell).min(self.lattice)))
    }

    /// How many samples are live.
    pub fn samples(&self) -> u64 {
        let across = cells(self.lattice, self.cell).x as usize;
        let size = |index: usize| {
            let first = UVec2::new((index % across) as u32, (index / across) as u32) * self.cell;
            let size = (self.lattice - first).min(self.cell);
            u64::from(size.x) * u64::from(size.y)
        };
        let live = self.live.iter().enumerate().filter(|(_, live)| **live);
        live.map(|(index, _)| size(index)).sum()
    }
}

/// Cells across and down.
pub(super) fn cells(lattice: UVec2, cell: UVec2) -> UVec2 {
    UVec2::new(lattice.x.div_ceil(cell.x), lattice.y.div_ceil(cell.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn live_samples_are_counted_cell_by_cell() {
        let lattice = UVec2::new(10, 7);
        let mask = CellMask::new(lattice, UVec2::new(4, 3), |c| (c.x + c.y) % 2 == 0);
        let live = (0..7)
            .flat_map(|y| (0..10).map(move |x| UVec2::new(x, y)))
            .filter(|s| mask.is_live(*s))
            .count();
        assert_eq!(mask.samples(), live as u64);
        assert!(mask.is_live(UVec2::new(9, 6)) && !mask.is_live(UVec2::new(4, 0)));
        assert_eq!(mask.row(2), [true, false, true]);
        assert_eq!(mask.row(3), [false, true, false]);
        assert_eq!(mask.bounds(), Some([UVec2::ZERO, lattice]));
        let one = CellMask::new(lattice, UVec2::new(4, 3), |c| c == UVec2::new(2, 1));
        assert_eq!(one.bounds(), Some([UVec2::new(8, 3), UVec2::new(10, 6)]));
        assert_eq!(CellMask::new(lattice, UVec2::ONE, |_| false).bounds(), None);
        assert_eq!(CellMask::new(UVec2::ZERO, lattice, |_| true).samples(), 0);
    }
}
