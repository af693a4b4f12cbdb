/// The most coordinates of a zone, the origin among them.
const MOST: usize = 7;

/// A set of points on which only the differences between two coordinates are bounded, those to the origin
/// (coordinate 0) included: the zones of timed automata, as matrices of differences (Dill 1989, "Timing
/// assumptions and verification of finite-state concurrent systems"). Each bound is the tightest that follows
/// from all of them, so that every bound is reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Zone {
    len: usize,
    /// The most that coordinate `i` is beyond coordinate `j`.
    most: [[i128; MOST]; MOST],
}

impl Zone {
    /// The one point whose `coordinates` (and the origin) are all 0.
    pub(super) fn origin(coordinates: usize) -> Self {
        Self {
            len: coordinates + 1,
            most: [[0; MOST]; MOST],
        }
    }

    /// Least and most of coordinate `i` less coordinate `j`.
    pub(super) fn range(&self, i: usize, j: usize) -> [i128; 2] {
        [-self.most[j][i], self.most[i][j]]
    }

    /// With one more coordinate, the last: from `least` to `most` beyond coordinate `i`.
    #[must_use]
    pub(super) fn with(mut self, i: usize, [least, most]: [i128; 2]) -> Self {
        let new = self.len;
        for k in 0..new {
            self.most[new][k] = self.most[i][k] + most;
            self.most[k][new] = self.most[k][i] - least;
        }
        self.most[new][new] = 0;
        self.len += 1;
        self
    }

    /// The part in which coordinate `i` is at most `most` beyond coordinate `j`; `None` if that is empty.
    pub(super) fn where_at_most(mut self, i: usize, j: usize, most: i128) -> Option<Self> {
        if self.most[j][i] + most < 0 {
            return None;
        }
        if most >= self.most[i][j] {
            return Some(self);
        }
        let before = self.most;
        for k in 0..self.len {
            for l in 0..self.len {
                let through = before[k][i] + most + before[j][l];
                self.most[k][l] = self.most[k][l].min(through);
            }
        }
        Some(self)
    }

    /// The part in which coordinate `i` is from `least` to `most`.
    pub(super) fn where_within(self, i: usize, [least, most]: [i128; 2]) -> Option<Self> {
        self.where_at_most(i, 0, most)?.where_at_most(0, i, -least)
    }

    /// The same points with the origin moved by `by`.
    #[must_use]
    pub(super) fn seen_from(mut self, by: i128) -> Self {
        for i in 1..self.len {
            self.most[i][0] -= by;
            self.most[0][i] += by;
        }
        self
    }

    /// These coordinates only, in this order, after the origin. One may come again; coordinate 0 makes one
    /// that is always 0.
    #[must_use]
    pub(super) fn picked(&self, coordinates: &[usize]) -> Self {
        let from = |i: usize| match i {
            0 => 0,
            _ => coordinates[i - 1],
        };
        let mut picked = Self::origin(coordinates.len());
        for i in 0..picked.len {
            for j in 0..picked.len {
                picked.most[i][j] = self.most[from(i)][from(j)];
            }
        }
        picked
    }

    /// Whether all points of `other` are among these.
    pub(super) fn holds(&self, other: &Self) -> bool {
        let rows = |zone: &Self| zone.most;
        let (ours, theirs) = (rows(self), rows(other));
        (0..self.len).all(|i| (0..self.len).all(|j| theirs[i][j] <= ours[i][j]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_follow_from_each_other() {
        // x from 2 to 5, y from 1 to 3 beyond x.
        let zone = Zone::origin(0).with(0, [2, 5]).with(1, [1, 3]);
        assert_eq!(zone.range(2, 0), [3, 8]);
        // Of y at most 4: x is at most 3.
        let low = zone.where_at_most(2, 0, 4).unwrap();
        assert_eq!((low.range(1, 0), low.range(2, 1)), ([2, 3], [1, 2]));
        assert_eq!(zone.where_within(2, [9, 10]), None);
        assert!(zone.holds(&low) && !low.holds(&zone));
        // A point of the whole is in one of two halves.
        let high = zone.where_at_most(0, 2, -5).unwrap();
        assert_eq!(high.range(2, 0), [5, 8]);
    }

    #[test]
    fn coordinates_can_be_moved_dropped_and_doubled() {
        let zone = Zone::origin(0).with(0, [2, 5]).with(1, [1, 3]);
        let moved = zone.seen_from(4);
        assert_eq!((moved.range(1, 0), moved.range(2, 1)), ([-2, 1], [1, 3]));
        let picked = zone.picked(&[2, 0, 2]);
        assert_eq!((picked.range(1, 0), picked.range(2, 0)), ([3, 8], [0, 0]));
        assert_eq!(picked.range(3, 1), [0, 0]);
        // What is dropped still bounds what is kept.
        let kept = zone.where_at_most(1, 0, 3).unwrap().picked(&[2]);
        assert_eq!(kept.range(1, 0), [3, 6]);
    }
}
