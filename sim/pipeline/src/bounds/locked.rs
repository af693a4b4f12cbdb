use foveasim_models::Nanos;

use super::blanks::Blanks;
use super::unit::{Unit, greatest_common_divisor};
use crate::{Interval, Setup};

/// Where the frames of a host whose clock is the display's begin to be rendered, and when they flip if they
/// tear.
///
/// At the display's rate, frames that are finished before the next is due begin `lock` after every vertical
/// blank. At another rate the host's ticks come back to where they were after as many refreshes as both periods
/// have a common multiple of; and frames that always take the same time, longer than a period, begin one after
/// the other without end. In all of these the places in the refresh are a lattice: `lock` and every multiple of
/// the greatest common measure of the refresh, the host's period and, if they overrun, the frames' time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct LockedFlip {
    unit: Unit,
    /// From the vertical blank to a tick of the host \[units\].
    lock: i128,
    /// In how many places of a refresh frames begin, evenly apart.
    places: i64,
    /// How long frames render.
    pub(super) render: Interval,
}

/// Whether frames may take longer than the host has for one.
pub(super) fn overruns(setup: &Setup<'_>, render: Interval) -> bool {
    render.max > setup.host_rate.period() && !setup.runtime.overlapped
}

/// After how long a host whose clock is the display's meets it as it did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Beat {
    /// In so many refreshes the host's clock comes back to where it was; 1 if the clocks are independent.
    pub refreshes: i64,
    /// Where frames begin moves by this from one to the next, whatever the host's clock says: the time they all
    /// take, if it is longer than the host's period; else 0.
    pub overrun: Nanos,
    /// In how many places of a refresh, evenly apart, frames begin.
    pub(super) places: i64,
}

impl Beat {
    pub(super) fn of(setup: &Setup<'_>, render: Interval) -> Self {
        if setup.runtime.host_lock.is_none() {
            return Self {
                refreshes: 1,
                overrun: Nanos::ZERO,
                places: 1,
            };
        }
        let Unit {
            ns,
            refresh,
            period,
        } = Unit::of(setup);
        let both = greatest_common_divisor(refresh, period);
        let overrun = match overruns(setup, render) && render.width() == Nanos::ZERO {
            true => render.max,
            false => Nanos::ZERO,
        };
        let measure = greatest_common_divisor(both, i128::from(overrun.0) * ns);
        // Clocks that meet nowhere twice have more places than can be counted.
        let few = |n: i128| i64::try_from(n).unwrap_or(i64::MAX);
        Self {
            refreshes: few(period / both),
            overrun,
            places: few(refresh / measure),
        }
    }

    /// How many of them differ from each other, at most a million.
    pub fn overruns(&self) -> u64 {
        match self.overrun {
            Nanos::ZERO => 1,
            _ => self.places.min(1 << 20) as u64,
        }
    }
}

impl LockedFlip {
    /// Of frames that begin in `places` of a refresh, one of them `lock` after the vertical blank.
    pub(super) fn new(setup: &Setup<'_>, render: Interval, lock: Nanos, places: i64) -> Self {
        let unit = Unit::of(setup);
        Self {
            unit,
            lock: unit.of_nanos(lock),
            places,
            render,
        }
    }

    /// Of frames that begin at vertical blanks.
    pub(super) fn at_blanks(setup: &Setup<'_>, render: Interval) -> Self {
        Self::new(setup, render, Nanos::ZERO, 1)
    }

    /// When after a vertical blank frames begin in place number `place` \[units\].
    fn begun(&self, place: i64) -> i128 {
        let step = self.unit.refresh / i128::from(self.places);
        (self.lock + i128::from(place) * step).rem_euclid(self.unit.refresh)
    }

    /// How the vertical blanks follow the beginning of a frame.
    pub(super) fn beginnings(&self) -> impl Iterator<Item = Blanks> + '_ {
        (0..self.places).map(|place| Blanks::new(self.unit, self.begun(place)))
    }

    /// How far the beam has come `t` after a frame begins in place number `place`: one way round, and the other.
    fn beam(&self, place: i64, t: Nanos) -> [Nanos; 2] {
        let Unit { ns, refresh, .. } = self.unit;
        let at = (self.begun(place) + self.unit.of_nanos(t)).rem_euclid(refresh);
        let up = match self.unit.up(at) {
            // By then the next scan has begun.
            up if i128::from(up.0) * ns >= refresh => Nanos::ZERO,
            up => up,
        };
        [self.unit.down(at), up]
    }

    /// Least and most of what depends on how long a frame renders and how far the beam has come then; it may
    /// jump where the beam passes one of `edges`, and is steady, rises or falls by as much as the beam goes on
    /// in between.
    fn extremes(
        &self,
        refresh: Nanos,
        edges: &[Nanos],
        of: impl Fn(Nanos, Nanos) -> Nanos,
    ) -> Interval {
        let Interval { min, max } = self.render;
        let (mut low, mut high) = (Nanos::MAX, Nanos(i64::MIN));
        for place in 0..self.places {
            let mut see = |t: Nanos| {
                if self.render.contains(t) {
                    for beam in self.beam(place, t) {
                        let value = of(t, beam);
                        (low, high) = (low.min(value), high.max(value));
                    }
                }
            };
            see(min);
            see(max);
            let [first, last] = [min, max].map(|t| self.beam(place, t)[0]);
            for edge in edges {
                // Where the beam passes it first, and last: what lies between is no shorter and no longer.
                let after = min + Nanos((*edge - first).0.rem_euclid(refresh.0));
                let before = max - Nanos((last - *edge).0.rem_euclid(refresh.0));
                for at in [after, before] {
                    (-2..=2).for_each(|ns| see(at + Nanos(ns)));
                }
            }
        }
        Interval::new(low, high)
    }

    /// Whether rounding decides if the beam passes one of `edges` before the shortest, or the longest, frame ends.
    pub(super) fn is_open(&self, edges: &[Nanos]) -> bool {
        let Interval { min, max } = self.render;
        let mut ends = (0..self.places).flat_map(|place| [min, max].map(|t| self.beam(place, t)));
        ends.any(|[down, up]| down < up && edges.contains(&down))
    }

    /// From the flip until the beam reaches `row`.
    pub(super) fn wait(&self, refresh: Nanos, row: Nanos) -> Interval {
        let Interval { min, max } =
            self.extremes(refresh, &[row], |_, beam| super::until(row, beam, refresh));
        // The next scan may begin a nanosecond before `refresh` says.
        Interval::new((min - Nanos(1)).max(Nanos::ZERO), max)
    }

    /// Least and most of a way that begins when a frame begins to be rendered, and goes on from its flip as
    /// `after` says, which is told how far the beam has come then. `after` may jump where the beam passes one
    /// of `edges`, and is steady or falls by as much as the beam goes on in between.
    pub(super) fn way(
        &self,
        refresh: Nanos,
        edges: &[Nanos],
        after: impl Fn(Nanos) -> Nanos,
    ) -> Interval {
        let Interval { min, max } = self.extremes(refresh, edges, |t, beam| t + after(beam));
        // Ticks are rounded to the nanosecond.
        Interval::new((min - Nanos(2)).max(Nanos::ZERO), max + Nanos(2))
    }
}
