use foveasim_models::Nanos;

use super::ticks::until;
use crate::{Interval, Setup};

/// When a host whose clock is the display's has its frames flip, if each is finished before the next is
/// due: `lock` after a vertical blank and the time they render.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LockedFlip {
    /// From the vertical blank to the start of a frame.
    pub lock: Nanos,
    /// How long it renders.
    pub render: Interval,
}

impl LockedFlip {
    /// Of such a host; `None` of any other.
    pub(super) fn of(setup: &Setup<'_>, render: Interval) -> Option<Self> {
        let rate = setup.scan.rate;
        let lock = setup.runtime.host_lock?;
        let keeps_up = render.max <= rate.period() && setup.host_rate == rate;
        keeps_up.then_some(Self { lock, render })
    }

    /// From the flip until the beam reaches `row`.
    pub(super) fn wait(&self, refresh: Nanos, row: Nanos) -> Interval {
        // The wait alone: what is rendered longer is not counted.
        let Interval { min, max } = self.render;
        let mut ends = vec![min, max];
        for n in -1..=2 {
            let at = row + refresh * n - self.lock;
            ends.extend([at, at + Nanos(1)]);
        }
        let beam = |t: Nanos| Nanos((self.lock + t).0.rem_euclid(refresh.0));
        let waits = ends
            .into_iter()
            .filter(|t| self.render.contains(*t))
            .map(|t| until(row, beam(t), refresh));
        let (low, high) = waits.fold((Nanos::MAX, Nanos::ZERO), |(low, high), wait| {
            (low.min(wait), high.max(wait))
        });
        Interval::new((low - Nanos(1)).max(Nanos::ZERO), high + Nanos(1))
    }

    /// Least and most of a way that begins with the start of a frame, and goes on from its flip as `after`
    /// says, which is told how far the beam has come then. `after` may jump where the beam passes one of
    /// `edges`, and is steady or falls by as much as the beam goes on in between.
    pub fn way(&self, refresh: Nanos, edges: &[Nanos], after: impl Fn(Nanos) -> Nanos) -> Interval {
        let Self { lock, render } = *self;
        let mut ends = vec![render.min, render.max];
        for edge in edges {
            // The edge in this refresh and in those that the frame may still be at work in.
            for n in -1..=2 {
                let at = *edge + refresh * n - lock;
                ends.extend([at - Nanos(1), at, at + Nanos(1)]);
            }
        }
        let beam = |t: Nanos| Nanos((lock + t).0.rem_euclid(refresh.0));
        let ways = ends
            .into_iter()
            .filter(|t| render.contains(*t))
            .map(|t| t + after(beam(t)));
        let (low, high) = ways.fold((Nanos::MAX, Nanos::ZERO), |(low, high), way| {
            (low.min(way), high.max(way))
        });
        // Ticks are rounded to the nanosecond.
        Interval::new((low - Nanos(2)).max(Nanos::ZERO), high + Nanos(2))
    }
}
