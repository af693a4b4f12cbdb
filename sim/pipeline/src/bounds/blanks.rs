use foveasim_models::Nanos;

use super::unit::Unit;
use crate::Interval;

/// The vertical blanks as something that happens `after` one of them has them before it.
///
/// The k-th tick of a clock is ⌊k · period⌋ \[ns\]. Two ticks, of two clocks that share a phase, that are x apart
/// without this rounding are ⌊x⌋ or ⌈x⌉ apart with it, and exactly x if that is a whole number: bounds made of
/// both hold in the whole nanoseconds that are simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Blanks {
    unit: Unit,
    /// How long after a blank (that number 0) it happens \[units\]; may be negative.
    after: i128,
}

impl Blanks {
    pub(super) fn new(unit: Unit, after: i128) -> Self {
        Self { unit, after }
    }

    /// As something has them that happens a period of the host's clock before.
    pub(super) fn a_period_later(self) -> Self {
        Self::new(self.unit, self.after - self.unit.period)
    }

    /// Until blank number `n`, one way round and the other.
    pub(super) fn until(&self, n: i64) -> Interval {
        let t = i128::from(n) * self.unit.refresh - self.after;
        Interval::new(self.unit.down(t), self.unit.up(t))
    }

    /// Number of the first blank that is `t` away or more: the smallest that this can be, and the largest.
    pub(super) fn first_after(&self, t: Nanos) -> [i64; 2] {
        let (refresh, ns) = (self.unit.refresh, self.unit.ns);
        let t = self.unit.of_nanos(t) + self.after;
        // ⌈x⌉ ≥ t where x > t − 1, and ⌊x⌋ ≥ t where x ≥ t.
        let smallest = (t - ns).div_euclid(refresh) + 1;
        let largest = -(-t).div_euclid(refresh);
        [smallest as i64, largest as i64]
    }

    /// As [`Blanks::first_after`], of times within `t`: the smallest of the shortest, the largest of the longest, and
    /// whether rounding leaves either open.
    pub(super) fn first_after_within(&self, t: Interval) -> ([i64; 2], bool) {
        let [shortest, longest] = [t.min, t.max].map(|t| self.first_after(t));
        let open = shortest[0] != shortest[1] || longest[0] != longest[1];
        ([shortest[0], longest[1]], open)
    }

    /// From the end of what takes a time within `render` from there on until the compositor takes it, `lead` before
    /// the first blank that it can; and from the beginning until that blank.
    pub(super) fn flip(&self, render: Interval, lead: Nanos) -> Flip {
        let ready = render + Interval::exactly(lead);
        let ([first, last], open) = self.first_after_within(ready);
        let [soon, late] = [first, last].map(|n| self.until(n));
        let longest = (soon.max - ready.min).max(Nanos::ZERO);
        let wait = match first == last {
            true => Interval::new((late.min - ready.max).max(Nanos::ZERO), longest),
            // One that ends just after the deadline waits for the next.
            false => Interval::new(Nanos::ZERO, longest.max(self.unit.up(self.unit.refresh))),
        };
        Flip {
            wait,
            to_flip: Interval::new(soon.min.max(ready.min), late.max),
            blanks: [first, last],
            open,
        }
    }
}

/// When a frame flips.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Flip {
    /// From the end of rendering until the compositor takes it.
    pub(super) wait: Interval,
    /// From the beginning of rendering to the flip.
    pub(super) to_flip: Interval,
    /// At which blanks, of the shortest frame and of the longest.
    pub(super) blanks: [i64; 2],
    /// Whether these depend on how ticks are rounded.
    pub(super) open: bool,
}

#[cfg(test)]
mod tests {
    use foveasim_models::Rate;
    use proptest::prelude::*;

    use super::*;

    fn unit(host: Rate, display: Rate) -> Unit {
        Unit::of_rates(host, display)
    }

    proptest! {
        /// Beside ticks as they are simulated.
        #[test]
        fn what_is_between_ticks_and_blanks_is_within(
            display in 24.0f64..250.0,
            host in 24.0f64..250.0,
            lock in 0i64..5_000_000,
            k in -500i64..500,
            t in 0i64..40_000_000,
        ) {
            let [host, display] = [host, display].map(|hz| Rate::from_hz("f", hz).unwrap());
            let unit = unit(host, display);
            let begun = Nanos(lock) + host.tick(k);
            let after = unit.of_nanos(Nanos(lock)) + i128::from(k) * unit.period;
            let blanks = Blanks::new(unit, after);
            let first = display.first_at_or_after(begun + Nanos(t));
            let [least, most] = blanks.first_after(Nanos(t));
            prop_assert!((least..=most).contains(&first) && most - least <= 1, "{first}: {least} to {most}");
            let apart = blanks.until(first);
            prop_assert!(apart.contains(display.tick(first) - begun) && apart.width() <= Nanos(1));
            let flip = blanks.flip(Interval::exactly(Nanos(t)), Nanos::ZERO);
            prop_assert!(flip.to_flip.contains(display.tick(first) - begun));
            prop_assert!(flip.wait.contains(display.tick(first) - begun - Nanos(t)));
        }
    }

    #[test]
    fn whole_numbers_are_exact() {
        let rate = Rate::from_hz("f", 100.0).unwrap();
        let unit = unit(rate, rate);
        let blanks = Blanks::new(unit, unit.of_nanos(Nanos(3_000_000)));
        assert_eq!(blanks.until(1), Interval::exactly(Nanos(7_000_000)));
        assert_eq!(blanks.first_after(Nanos(7_000_000)), [1, 1]);
        assert_eq!(blanks.first_after(Nanos(7_000_001)), [2, 2]);
        assert_eq!(blanks.first_after(Nanos(-3_000_000)), [0, 0]);
    }
}
