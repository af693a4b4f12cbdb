mod flips;
mod torn;

use foveasim_models::Nanos;

use super::unit::Unit;
use super::zone::Zone;
use crate::{Interval, Setup};

pub(super) use flips::BacklogFlips;

/// What frames in flight may do if their host's clock is the display's, and some of them take longer than its
/// period and some do not.
///
/// Frame i starts at the first tick after frame i − 1 has; if all n places in flight are taken then, when the
/// frame n before ends. Frames are rendered one at a time, in order, each for a time d of its own from a to b:
///
/// ```text
/// start(i) = max(tick after start(i − 1), end(i − n))
/// begun(i) = max(start(i), end(i − 1))      end(i) = begun(i) + d(i)
/// ```
///
/// Counted from that tick, what was before matters by the ends of the last n frames, 0 if they have ended. Each
/// of these sums and maxima, and the choice of the next tick, takes sets in which the differences of times
/// are bounded ([`Zone`]) to several such sets, exactly. From an empty queue the sets are followed until there
/// is nothing new. Because short frames empty the queue, and keep it empty for as many ticks as one likes, all that
/// is found can happen again, and beside any tick of the clock: host and display may meet in any way that they do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Backlog {
    unit: Unit,
    lead: i128,
    /// How far the beam has come at the host's ticks; `None`: as good as anywhere.
    places: Option<Vec<i128>>,
    /// What a frame and the one before may do together, counted from the first tick after the start of the one
    /// before: coordinates [`BEFORE`] to [`END`].
    frames: Vec<Zone>,
}

/// When the frame before started and ended; when this one starts, is begun and ends.
const BEFORE: usize = 1;
const BEFORE_ENDED: usize = 2;
const START: usize = 3;
const BEGUN: usize = 4;
const END: usize = 5;

/// The most sets that are looked at.
const MOST_LOOKED_AT: usize = 1 << 15;

/// The most sets that are kept.
const MOST_KEPT: usize = 1 << 10;

/// Sets none of which holds another.
#[derive(Default)]
struct Sets(Vec<(Zone, bool)>);

impl Sets {
    /// Adds what is new. `None` if there are too many.
    fn add(&mut self, zone: Zone) -> Option<()> {
        if !self.0.iter().any(|(z, _)| z.holds(&zone)) {
            self.0.retain(|(z, _)| !zone.holds(z));
            self.0.push((zone, false));
        }
        (self.0.len() <= MOST_KEPT).then_some(())
    }

    /// One that has not been looked at.
    fn next(&mut self) -> Option<Zone> {
        let (zone, looked_at) = self.0.iter_mut().find(|(_, looked_at)| !looked_at)?;
        *looked_at = true;
        Some(*zone)
    }
}

impl Backlog {
    /// Follows frames of `setup` that render for a time within `render`, less than a period at the shortest;
    /// their host's clock ticks when the beam has come as far as one of `places`, if these are few. `None` if there
    /// are too many sets to follow.
    pub(super) fn follow(
        setup: &Setup<'_>,
        render: Interval,
        places: Option<Vec<i128>>,
    ) -> Option<Self> {
        let unit = Unit::of(setup);
        let n = setup.runtime.in_flight as usize;
        let render = [render.min, render.max].map(|t| unit.of_nanos(t));
        let lead = unit.of_nanos(setup.runtime.lead);
        Self::follow_units(unit, n, render, lead, places)
    }

    /// As [`Backlog::follow`], of `n` frames in flight and times in units.
    fn follow_units(
        unit: Unit,
        n: usize,
        render: [i128; 2],
        lead: i128,
        places: Option<Vec<i128>>,
    ) -> Option<Self> {
        // Ticks of no whole number of nanoseconds are rounded: what is just before one may be at it.
        let before = match unit.period % unit.ns {
            0 => unit.ns,
            _ => 0,
        };
        // Coordinates 1 to n: until when the places in flight are taken, counted from the next tick.
        let mut states = Sets::default();
        let mut frames = Sets::default();
        states.add(Zone::origin(n))?;
        for _ in 0..MOST_LOOKED_AT {
            let Some(state) = states.next() else {
                return Some(Self {
                    unit,
                    lead,
                    places,
                    frames: frames.0.into_iter().map(|(zone, _)| zone).collect(),
                });
            };
            // A frame starts when the first place is free, is begun when the last is, and takes the first.
            let started = state.with(n, render);
            let [first, last] = started.range(1, 0).map(|t| t.div_euclid(unit.period) + 1);
            for tick in first..=last {
                let next = tick * unit.period;
                let Some(started) = started.where_within(1, [next - unit.period, next - before])
                else {
                    continue;
                };
                let started = started.seen_from(next);
                // The next one, if so many places are free at that tick.
                for free in 0..=n {
                    let is_free = |i: usize| started.where_at_most(i, 0, 0);
                    let free_until = match free {
                        0 => Some(started),
                        _ => is_free(1 + free),
                    };
                    let taken_from = match free == n {
                        true => free_until,
                        false => free_until.and_then(|z| z.where_at_most(0, 2 + free, 0)),
                    };
                    let Some(zone) = taken_from else { continue };
                    let mut coordinates = vec![1, n + 1];
                    coordinates.extend(std::iter::repeat_n(0, free));
                    coordinates.extend(2 + free..=n + 1);
                    let both = zone.picked(&coordinates).with(n + 2, render);
                    frames.add(both.picked(&[1, 2, 3, n + 2, n + 3]))?;
                    let next: Vec<usize> = (3..3 + n).collect();
                    states.add(both.picked(&next))?;
                }
            }
        }
        None
    }

    fn interval(&self, of: impl Fn(&Zone) -> [i128; 2]) -> Interval {
        let ranges = self.frames.iter().map(of);
        let [low, high] = ranges.reduce(join).expect("the first frame was followed");
        self.in_nanos([low, high])
    }

    /// Ticks and blanks are rounded to nanoseconds: times between them by one at most.
    fn in_nanos(&self, [low, high]: [i128; 2]) -> Interval {
        let Unit {
            ns,
            refresh,
            period,
        } = self.unit;
        let rounding = Nanos(i64::from(refresh % ns != 0 || period % ns != 0));
        let low = (self.unit.down(low) - rounding).max(Nanos::ZERO);
        Interval::new(low, self.unit.up(high) + rounding)
    }

    /// Longest time from the start of a frame to that of the next.
    pub(super) fn cycle(&self) -> Nanos {
        self.interval(|z| z.range(START, BEFORE)).max
    }

    /// From a frame's start until its rendering begins.
    pub(super) fn queue(&self) -> Interval {
        self.interval(|z| z.range(BEGUN, START))
    }

    /// Least from a frame's start to its end, and most from the start of the frame before to that.
    pub(super) fn to_end(&self) -> Interval {
        self.interval(|z| [z.range(END, START)[0], z.range(END, BEFORE)[1]])
    }

    /// Whether host and display meet in few places, so that where the beam is at a flip depends on the rest.
    pub(super) fn meets_in_places(&self) -> bool {
        self.places.is_some()
    }
}

fn join(a: [i128; 2], b: [i128; 2]) -> [i128; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

#[cfg(test)]
mod tests;
