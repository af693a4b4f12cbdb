use std::collections::{BTreeMap, HashMap};

use foveasim_models::Nanos;

use super::unit::Unit;
use crate::{Interval, Setup};

/// What frames in flight do once they run as they always will, if they render for longer than a refresh or too
/// long for the compositor.
///
/// A host blocked on the swap starts frame i at the blank at which frame i − n flips; frames are rendered one
/// at a time, in order, and flip in order, one a blank at most, at the first that they are finished a lead
/// before. In refreshes, with d the time it renders and L the lead:
///
/// ```text
/// begun(i) = max(flip(i − n), end(i − 1))      end(i) = begun(i) + d(i)
/// flip(i)  = max(flip(i − 1) + 1, ⌈end(i) + L⌉)
/// ```
///
/// Times are counted from the last flip. What a frame leaves to the next is how many refreshes ago the last
/// n + 1 frames flipped (whole numbers), and when its rendering ended: one of a range of times, each of which
/// is possible, because d may have any value of its law. From n frames started at once the sets of these
/// states are followed, frame by frame, until a set comes again: what lies between is what happens for
/// ever. All arithmetic is in whole numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Queue {
    /// Longest time from the start of a frame to the start of the next \[refreshes\].
    pub(super) cycle: i64,
    /// Longest time between flips \[refreshes\].
    pub(super) flips: i64,
    /// From a frame's start to its flip \[refreshes\].
    pub(super) start_to_flip: [i64; 2],
    /// Longest time from the start of a frame to the flip of the next \[refreshes\].
    pub(super) wait_to_flip: i64,
    /// From a frame's start until its rendering begins.
    pub(super) waits: Interval,
    /// From the end of rendering until the compositor takes it.
    pub(super) flip_wait: Interval,
    /// Until this is what happens, and until it begins again \[refreshes\].
    pub(super) settling: i64,
    pub(super) turn: i64,
}

/// The longest that a queue may take to settle \[refreshes\]: simulations wait for it.
const LONGEST_SETTLING: i64 = 128;

/// The most frames that are followed.
const MOST_FRAMES: usize = 4096;

/// The most ranges in one set of states.
const MOST_RANGES: usize = 4096;

/// The most frames in flight, and the one before them.
const FLIPS: usize = 4;

/// When the last frames flipped, counted from the last of them: 0 and then ever earlier.
type Flips = [i64; FLIPS];

/// When the rendering of the last frame may have ended, by when the last frames flipped: ranges that do not
/// touch, both ends included.
type States = BTreeMap<Flips, Vec<[i128; 2]>>;

impl Queue {
    /// Follows frames of `setup` that render for a time within `render`. `None` if no set of states comes again
    /// soon enough, or if it depends on how blanks are rounded to nanoseconds.
    pub(super) fn follow(setup: &Setup<'_>, render: Interval) -> Option<Self> {
        let unit = Unit::of(setup);
        let n = setup.runtime.in_flight as usize;
        let [least, most] = [render.min, render.max].map(|t| unit.of_nanos(t));
        let lead = unit.of_nanos(setup.runtime.lead);
        let mut states = States::from([([0; FLIPS], vec![[0, 0]])]);
        let mut seen: HashMap<States, usize> = HashMap::new();
        let mut each: Vec<Extremes> = Vec::new();
        while each.len() < MOST_FRAMES {
            if let Some(&since) = seen.get(&states) {
                let mut all = Extremes::default();
                each[since..].iter().for_each(|e| all.join(e));
                let refreshes = |frames: &[Extremes]| frames.iter().map(|e| e.flips).sum::<i64>();
                let settling = refreshes(&each[..since]);
                let turn = refreshes(&each[since..]);
                let queue = all.in_nanos(&unit, [settling, turn]);
                return Some(queue).filter(|q| q.settling <= LONGEST_SETTLING);
            }
            let mut next = States::new();
            let mut found = Extremes::default();
            for (flips, ranges) in &states {
                // The frame n before flipped when this one starts.
                let start = i128::from(flips[n - 1]) * unit.refresh;
                let before = i128::from(flips[n]) * unit.refresh;
                found.see_start(flips[n - 1] - flips[n]);
                debug_assert!(before <= start);
                for &[low, high] in ranges {
                    let begun = [low.max(start), high.max(start)];
                    found.waits.join(begun[0] - start, begun[1] - start);
                    let end = [begun[0] + least, begun[1] + most];
                    let first = refreshes(&unit, end[0] + lead)?.max(1);
                    let last = refreshes(&unit, end[1] + lead)?.max(1);
                    for m in first..=last {
                        let deadline = i128::from(m) * unit.refresh - lead;
                        let high = end[1].min(deadline);
                        // A nanosecond more than the deadline before.
                        let low = match m {
                            1 => end[0],
                            _ => end[0].max(deadline - unit.refresh + unit.ns),
                        };
                        if low > high {
                            continue;
                        }
                        found.see_flip(m, flips[n - 1], flips[n]);
                        found.flip_wait.join(deadline - high, deadline - low);
                        let mut after = [0; FLIPS];
                        for (after, flip) in after[1..].iter_mut().zip(flips) {
                            *after = flip - m;
                        }
                        // What is longer ago than any frame looks is forgotten.
                        after[n + 1..].fill(0);
                        let shift = i128::from(m) * unit.refresh;
                        let range = [low - shift, high - shift];
                        next.entry(after).or_default().push(range);
                    }
                }
            }
            next.values_mut().for_each(|ranges| merge(ranges, unit.ns));
            if next.values().map(Vec::len).sum::<usize>() > MOST_RANGES {
                return None;
            }
            seen.insert(std::mem::replace(&mut states, next), each.len());
            each.push(found);
        }
        None
    }
}

/// Refreshes until the first blank at or after `t`. `None` within the nanosecond after a blank: blanks are
/// rounded down to whole ones, which decides it.
fn refreshes(unit: &Unit, t: i128) -> Option<i64> {
    let (whole, rest) = (t.div_euclid(unit.refresh), t.rem_euclid(unit.refresh));
    let clear = rest == 0 || rest >= unit.ns;
    clear.then_some((whole + i128::from(rest > 0)) as i64)
}

/// Joins ranges that overlap, or are a nanosecond apart.
fn merge(ranges: &mut Vec<[i128; 2]>, ns: i128) {
    ranges.sort_unstable();
    let mut merged: Vec<[i128; 2]> = Vec::with_capacity(ranges.len());
    for &[low, high] in ranges.iter() {
        match merged.last_mut() {
            Some(last) if low <= last[1] + ns => last[1] = last[1].max(high),
            _ => merged.push([low, high]),
        }
    }
    *ranges = merged;
}

/// A range that grows.
#[derive(Debug, Clone, Copy)]
struct Span([i128; 2]);

impl Span {
    const NONE: Self = Self([i128::MAX, i128::MIN]);

    fn join(&mut self, low: i128, high: i128) {
        self.0 = [self.0[0].min(low), self.0[1].max(high)];
    }
}

/// What one frame, or several, may come to.
#[derive(Debug, Clone, Copy)]
struct Extremes {
    cycle: i64,
    flips: i64,
    start_to_flip: [i64; 2],
    wait_to_flip: i64,
    waits: Span,
    flip_wait: Span,
}

impl Default for Extremes {
    fn default() -> Self {
        Self {
            cycle: 0,
            flips: 0,
            start_to_flip: [i64::MAX, i64::MIN],
            wait_to_flip: 0,
            waits: Span::NONE,
            flip_wait: Span::NONE,
        }
    }
}

impl Extremes {
    fn see_start(&mut self, since_last: i64) {
        self.cycle = self.cycle.max(since_last);
    }

    /// A flip `m` refreshes after the last, of a frame started at `start`, the one before it at `before`.
    fn see_flip(&mut self, m: i64, start: i64, before: i64) {
        self.flips = self.flips.max(m);
        let [least, most] = self.start_to_flip;
        self.start_to_flip = [least.min(m - start), most.max(m - start)];
        self.wait_to_flip = self.wait_to_flip.max(m - before);
    }

    fn join(&mut self, other: &Self) {
        self.cycle = self.cycle.max(other.cycle);
        self.flips = self.flips.max(other.flips);
        let [least, most] = other.start_to_flip;
        self.start_to_flip = [
            self.start_to_flip[0].min(least),
            self.start_to_flip[1].max(most),
        ];
        self.wait_to_flip = self.wait_to_flip.max(other.wait_to_flip);
        self.waits.join(other.waits.0[0], other.waits.0[1]);
        self.flip_wait
            .join(other.flip_wait.0[0], other.flip_wait.0[1]);
    }

    fn in_nanos(&self, unit: &Unit, [settling, turn]: [i64; 2]) -> Queue {
        // Blanks are rounded to nanoseconds: waits for them and from them by one at most.
        let nanos = |span: Span| {
            let [low, high] = span.0;
            let low = (unit.down(low) - Nanos(1)).max(Nanos::ZERO);
            Interval::new(low, unit.up(high) + Nanos(1))
        };
        Queue {
            cycle: self.cycle,
            flips: self.flips,
            start_to_flip: self.start_to_flip,
            wait_to_flip: self.wait_to_flip,
            waits: nanos(self.waits),
            flip_wait: nanos(self.flip_wait),
            settling,
            turn,
        }
    }
}
