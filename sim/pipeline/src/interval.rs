use std::ops::Add;

use foveasim_models::Nanos;

/// A range of durations, both ends included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Interval {
    /// The shortest.
    pub min: Nanos,
    /// The longest.
    pub max: Nanos,
}

impl Interval {
    /// Nothing takes no time.
    pub const ZERO: Self = Self::exactly(Nanos::ZERO);

    /// From `min` to `max`.
    ///
    /// # Panics
    /// If `max` is below `min`.
    pub fn new(min: Nanos, max: Nanos) -> Self {
        assert!(min <= max, "an interval from {min} to {max}");
        Self { min, max }
    }

    /// A duration that does not vary.
    pub const fn exactly(t: Nanos) -> Self {
        Self { min: t, max: t }
    }

    /// Whether `t` is in it.
    pub fn contains(self, t: Nanos) -> bool {
        self.min <= t && t <= self.max
    }

    /// The smallest that holds both.
    #[must_use]
    pub fn hull(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// How far apart its ends are.
    pub fn width(self) -> Nanos {
        self.max - self.min
    }
}

/// One after the other: the ends add up. Exact if the two are independent, an outer bound if not.
impl Add for Interval {
    type Output = Self;
    fn add(self, rhs: Self) -> Self {
        Self {
            min: self.min + rhs.min,
            max: self.max + rhs.max,
        }
    }
}

impl std::iter::Sum for Interval {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::ZERO, Add::add)
    }
}
