use foveasim_models::{Nanos, Rate};

use crate::Interval;

/// From `at` after a vertical blank until `row` after one: this one, or the next.
pub fn until(row: Nanos, at: Nanos, refresh: Nanos) -> Nanos {
    let wait = row - at;
    match wait < Nanos::ZERO {
        true => wait + refresh,
        false => wait,
    }
}

/// The longest time that `n` periods can take between ticks of whole nanoseconds.
pub(super) fn longest(rate: Rate, n: i64) -> Nanos {
    -rate.tick(-n)
}

/// The shortest and the longest time that `n` periods can take.
pub(super) fn periods(rate: Rate, n: i64) -> Interval {
    Interval::new(rate.tick(n), longest(rate, n))
}

/// Fewest and most periods, at least one, that something which takes `t` from a tick lasts to the tick
/// at or after its end: with the longest and with the shortest rounding.
pub(super) fn refreshes(rate: Rate, t: Nanos) -> (i64, i64) {
    let most = rate.first_at_or_after(t).max(1);
    let fewest = match most > 1 && longest(rate, most - 1) >= t {
        true => most - 1,
        false => most,
    };
    (fewest, most)
}
