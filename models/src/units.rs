use std::fmt;
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use serde::{Deserialize, Serialize};

use crate::ModelError;

/// A time or a duration in whole nanoseconds.
///
/// Integer time makes event order exact: two events are simultaneous or they are not. The range is
/// ±292 years.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[serde(transparent)]
pub struct Nanos(pub i64);

impl Nanos {
    /// Zero.
    pub const ZERO: Self = Self(0);
    /// The latest representable time.
    pub const MAX: Self = Self(i64::MAX);

    /// The nearest whole nanosecond to `ms` milliseconds; saturates, and maps NaN to zero, so check
    /// outside values with [`Nanos::try_from_ms`].
    pub fn from_ms(ms: f64) -> Self {
        Self(libm::round(ms * 1e6) as i64)
    }

    /// As [`Nanos::from_ms`] for untrusted input.
    ///
    /// # Errors
    /// If `ms` is NaN, infinite or beyond ±100 years.
    pub fn try_from_ms(field: &str, ms: f64) -> Result<Self, ModelError> {
        const CENTURY_MS: f64 = 3.2e12;
        crate::error::in_range(field, ms, -CENTURY_MS..=CENTURY_MS).map(Self::from_ms)
    }

    /// The nearest whole nanosecond to `s` seconds (as [`Nanos::from_ms`]).
    pub fn from_secs(s: f64) -> Self {
        Self(libm::round(s * 1e9) as i64)
    }

    /// In milliseconds.
    pub fn as_ms(self) -> f64 {
        self.0 as f64 / 1e6
    }

    /// In seconds.
    pub fn as_secs(self) -> f64 {
        self.0 as f64 / 1e9
    }

    /// The later of two times.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Ord::max(self, other)
    }

    /// The earlier of two times.
    #[must_use]
    pub fn min(self, other: Self) -> Self {
        Ord::min(self, other)
    }
}

impl fmt::Display for Nanos {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ms", self.as_ms())
    }
}

impl Add for Nanos {
    type Output = Self;
    fn add(self, rhs: Self) -> Self {
        Self(self.0 + rhs.0)
    }
}

impl Sub for Nanos {
    type Output = Self;
    fn sub(self, rhs: Self) -> Self {
        Self(self.0 - rhs.0)
    }
}

impl Neg for Nanos {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Mul<i64> for Nanos {
    type Output = Self;
    fn mul(self, rhs: i64) -> Self {
        Self(self.0 * rhs)
    }
}

impl AddAssign for Nanos {
    fn add_assign(&mut self, rhs: Self) {
        self.0 += rhs.0;
    }
}

impl SubAssign for Nanos {
    fn sub_assign(&mut self, rhs: Self) {
        self.0 -= rhs.0;
    }
}

/// How often something happens, as an exact rational number of hertz.
///
/// The k-th tick comes from the integer k, never from adding a period up, so a year of 120 Hz has no
/// drift.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Rate {
    micro_hz: u64,
}

impl Rate {
    const NANOS_PER_TICK_AT_ONE_MICRO_HZ: i128 = 1_000_000_000_000_000;

    /// A rate of `hz`, kept to the micro-hertz.
    ///
    /// # Errors
    /// If `hz` is not from 0.001 to 1,000,000.
    pub fn from_hz(field: &str, hz: f64) -> Result<Self, ModelError> {
        crate::error::in_range(field, hz, 1e-3..=1e6)?;
        Ok(Self {
            micro_hz: libm::round(hz * 1e6) as u64,
        })
    }

    /// In hertz.
    pub fn hz(self) -> f64 {
        self.micro_hz as f64 / 1e6
    }

    /// In millionths of a hertz, which it is a whole number of.
    pub fn micro_hz(self) -> u64 {
        self.micro_hz
    }

    /// The rate of a clock that runs faster by `ppm` parts in a million (slower, if negative), kept to
    /// the micro-hertz.
    ///
    /// # Errors
    /// If `ppm` is not within ±100,000.
    pub fn drifted(self, field: &str, ppm: f64) -> Result<Self, ModelError> {
        crate::error::in_range(field, ppm, -1e5..=1e5)?;
        let micro_hz = libm::round(self.micro_hz as f64 * (1.0 + ppm * 1e-6)) as u64;
        Ok(Self { micro_hz })
    }

    /// Time of tick `k` after tick 0, rounded down to a nanosecond; `k` may be negative.
    pub fn tick(self, k: i64) -> Nanos {
        let ns =
            (i128::from(k) * Self::NANOS_PER_TICK_AT_ONE_MICRO_HZ).div_euclid(self.micro_hz.into());
        Nanos(ns as i64)
    }

    /// The first tick index whose time is at or after `t`.
    pub fn first_at_or_after(self, t: Nanos) -> i64 {
        // tick(k) = floor(k·N/r) ≥ t  ⟺  k·N/r ≥ t (t is whole)  ⟺  k ≥ t·r/N.
        let num = i128::from(t.0) * i128::from(self.micro_hz);
        let n = Self::NANOS_PER_TICK_AT_ONE_MICRO_HZ;
        (num.div_euclid(n) + i128::from(num.rem_euclid(n) != 0)) as i64
    }

    /// One period, rounded down to a nanosecond.
    pub fn period(self) -> Nanos {
        self.tick(1)
    }

    /// `numerator / denominator` of a period, rounded down to a nanosecond once, at the end. Exact for
    /// products of two 32-bit numbers; the fraction must not exceed a million periods.
    pub(crate) fn part_of_period(self, numerator: u64, denominator: u64) -> Nanos {
        let whole = Self::NANOS_PER_TICK_AT_ONE_MICRO_HZ * i128::from(numerator);
        let ns = whole / (i128::from(self.micro_hz) * i128::from(denominator));
        Nanos(ns as i64)
    }

    /// The times of ticks `first`, `first + 1`, …: the values of [`Rate::tick`], without its
    /// division.
    pub fn ticks(self, first: i64) -> Ticks {
        let n = Self::NANOS_PER_TICK_AT_ONE_MICRO_HZ;
        let hz = i128::from(self.micro_hz);
        Ticks {
            at: self.tick(first),
            remainder: (i128::from(first) * n).rem_euclid(hz) as u64,
            step: Nanos((n / hz) as i64),
            step_remainder: (n % hz) as u64,
            micro_hz: self.micro_hz,
        }
    }
}

/// Consecutive ticks of a [`Rate`], without end. The fraction below a nanosecond is carried exactly,
/// so it never drifts.
#[derive(Debug, Clone)]
pub struct Ticks {
    at: Nanos,
    remainder: u64,
    step: Nanos,
    step_remainder: u64,
    micro_hz: u64,
}

impl Iterator for Ticks {
    type Item = Nanos;

    fn next(&mut self) -> Option<Nanos> {
        let now = self.at;
        self.at += self.step;
        self.remainder += self.step_remainder;
        if self.remainder >= self.micro_hz {
            self.remainder -= self.micro_hz;
            self.at += Nanos(1);
        }
        Some(now)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn ticks_do_not_drift() {
        let rate = Rate::from_hz("f", 120.0).unwrap();
        assert_eq!(rate.tick(1), Nanos(8_333_333));
        // A day of frames ends on the day, to the nanosecond.
        assert_eq!(rate.tick(120 * 86_400), Nanos(86_400 * 1_000_000_000));
    }

    proptest! {
        #[test]
        fn ticks_in_a_row_are_the_ticks(hz in 0.5f64..5000.0, k in -1_000_000_000i64..1_000_000_000) {
            let rate = Rate::from_hz("f", hz).unwrap();
            for (i, t) in (0..200).zip(rate.ticks(k)) {
                prop_assert_eq!(t, rate.tick(k + i));
            }
        }

        #[test]
        fn first_tick_is_the_first(hz in 0.5f64..5000.0, t in -10_000_000_000i64..10_000_000_000) {
            let rate = Rate::from_hz("f", hz).unwrap();
            let k = rate.first_at_or_after(Nanos(t));
            prop_assert!(rate.tick(k) >= Nanos(t));
            prop_assert!(rate.tick(k - 1) < Nanos(t));
        }
    }
}
