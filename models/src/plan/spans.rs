use std::ops::Range;
use std::sync::Arc;

use glam::UVec2;

/// A run of samples in each row of a lattice.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Spans {
    lattice: UVec2,
    rows: Arc<[Range<u32>]>,
}

impl Spans {
    /// Asks for each row of `lattice` from which column to before which its samples are live; what lies
    /// outside the lattice is cut off.
    pub fn new(lattice: UVec2, mut row: impl FnMut(u32) -> Range<u32>) -> Self {
        let rows = (0..lattice.y).map(|y| {
            let given = row(y);
            let end = given.end.min(lattice.x);
            given.start.min(end)..end
        });
        Self {
            lattice,
            rows: rows.collect(),
        }
    }

    /// The lattice that they are for.
    pub fn lattice(&self) -> UVec2 {
        self.lattice
    }

    /// The columns of a row's live samples; may be empty.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn row(&self, y: u32) -> Range<u32> {
        self.rows[y as usize].clone()
    }

    /// Whether a sample of the lattice is live.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn is_live(&self, sample: UVec2) -> bool {
        self.rows[sample.y as usize].contains(&sample.x)
    }

    /// How many samples are live.
    pub fn samples(&self) -> u64 {
        self.rows.iter().map(|row| row.len() as u64).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::reversed_empty_ranges, reason = "what a caller may give")]
    fn live_samples_are_counted_row_by_row() {
        let rows = [2..5, 7..3, 0..99, 12..20];
        let spans = Spans::new(UVec2::new(10, 4), |y| rows[y as usize].clone());
        assert_eq!(spans.samples(), 3 + 10);
        assert!(spans.is_live(UVec2::new(4, 0)) && !spans.is_live(UVec2::new(5, 0)));
        assert!(spans.row(1).is_empty() && spans.row(3).is_empty());
        assert_eq!(spans.row(2), 0..10);
    }
}
