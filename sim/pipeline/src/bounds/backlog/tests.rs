//! Sets of times beside every time there is: with whole numbers of a few units all frames can be tried, and bounds
//! on differences of whole numbers are reached by whole numbers.

use std::collections::HashSet;

use super::*;
use crate::bounds::until;

/// Frames in flight, the host's period, the refresh, and least and most time to render \[units\].
#[derive(Debug, Clone, Copy)]
struct Case {
    n: usize,
    period: i64,
    refresh: i64,
    render: [i64; 2],
    lead: i64,
    lock: i64,
}

const CASES: [Case; 9] = [
    case(2, 10, 10, [8, 14], 0, 3),
    case(2, 10, 10, [8, 14], 4, 3),
    case(3, 10, 10, [7, 13], 0, 0),
    case(2, 10, 10, [0, 11], 2, 5),
    case(2, 10, 10, [9, 11], 0, 9),
    case(2, 12, 8, [5, 17], 3, 1),
    case(3, 8, 12, [6, 11], 0, 1),
    case(2, 10, 10, [10, 12], 0, 3),
    case(3, 6, 10, [2, 13], 1, 7),
];

const fn case(n: usize, period: i64, refresh: i64, render: [i64; 2], lead: i64, lock: i64) -> Case {
    Case {
        n,
        period,
        refresh,
        render,
        lead,
        lock,
    }
}

/// What one frame does, and the one before: [`BEFORE`] to [`END`].
type Times = [i64; 5];

impl Case {
    fn places(&self) -> Vec<i64> {
        let mut places: Vec<i64> = (0..self.refresh)
            .map(|k| (self.lock + k * self.period) % self.refresh)
            .collect();
        places.sort_unstable();
        places.dedup();
        places
    }

    fn backlog(&self) -> Backlog {
        let unit = Unit {
            ns: 1,
            refresh: self.refresh.into(),
            period: self.period.into(),
        };
        let render = self.render.map(i128::from);
        let places = self.places().into_iter().map(i128::from).collect();
        Backlog::follow_units(unit, self.n, render, self.lead.into(), Some(places)).unwrap()
    }

    /// Every frame there can be, one after the other from an empty queue.
    fn frames(&self) -> HashSet<Times> {
        let [least, most] = self.render;
        // The start and the end of the last frame, and those of the places in flight.
        let first = (-self.period, -self.period, vec![0; self.n]);
        let mut seen = HashSet::from([first.clone()]);
        let (mut todo, mut frames) = (vec![first], HashSet::new());
        while let Some((before, ended, taken)) = todo.pop() {
            let (start, begun) = (taken[0], taken[self.n - 1]);
            for end in begun + least..=begun + most {
                // What the first frame follows is made up.
                if before > -self.period || ended > -self.period {
                    frames.insert([before, ended, start, begun, end]);
                }
                let tick = (start / self.period + 1) * self.period;
                let next = taken[1..].iter().chain([&end]);
                let next = next.map(|t| (t - tick).max(0)).collect();
                let state = (start - tick, end - tick, next);
                if seen.insert(state.clone()) {
                    todo.push(state);
                }
            }
        }
        frames
    }
}

fn extremes(values: impl Iterator<Item = i64>) -> Interval {
    let (low, high) = values.fold((i64::MAX, i64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    Interval::new(Nanos(low), Nanos(high))
}

#[test]
fn sets_reach_what_single_frames_do_and_no_more() {
    for case in CASES {
        let (backlog, frames) = (case.backlog(), case.frames());
        let all = |of: fn(&Times) -> i64| extremes(frames.iter().map(of));
        assert_eq!(backlog.cycle(), all(|[p, _, s, ..]| s - p).max, "{case:?}");
        assert_eq!(backlog.queue(), all(|[_, _, s, b, _]| b - s), "{case:?}");
        let to_end = Interval::new(
            all(|[_, _, s, _, e]| e - s).min,
            all(|[p, _, _, _, e]| e - p).max,
        );
        assert_eq!(backlog.to_end(), to_end, "{case:?}");
    }
}

#[test]
fn flips_are_those_of_single_frames() {
    for case in CASES {
        let (frames, places) = (case.frames(), case.places());
        // The blank before which the compositor takes what ends then, from the first tick on.
        let blank = |end: i64, place: i64| {
            let refreshes = (end + place + case.lead + case.refresh - 1).div_euclid(case.refresh);
            refreshes * case.refresh - place
        };
        let all = |of: &dyn Fn(&Times, i64) -> i64| {
            let each = frames
                .iter()
                .flat_map(|f| places.iter().map(move |p| of(f, *p)));
            extremes(each)
        };
        let flips = case.backlog().flips();
        let wait = all(&|[.., e], at| blank(*e, at) - case.lead - e);
        assert_eq!(flips.flip_wait, wait, "{case:?}");
        let whole = all(&|[_, _, s, _, e], at| blank(*e, at) - s);
        assert_eq!(flips.start_to_flip, whole, "{case:?}");
        let longest = all(&|[p, .., e], at| blank(*e, at) - p).max;
        assert_eq!(flips.wait_to_flip, longest, "{case:?}");
        let apart = all(&|[_, q, .., e], at| blank(*e, at) - blank(*q, at)).max;
        assert_eq!(flips.flips, apart, "{case:?}");
    }
}

#[test]
fn what_tears_meets_the_beam_as_single_frames_do() {
    for case in CASES {
        let (backlog, frames, places) = (case.backlog(), case.frames(), case.places());
        let refresh = Nanos(case.refresh);
        for (first, last) in [(0, 5), (2, 6), (4, 4), (1, 7)].map(|(a, b)| (Nanos(a), Nanos(b))) {
            // Until the beam reaches a row; nothing while it is between two of them; until it has passed both.
            let to_row = |at: Nanos| until(first, at, refresh);
            let inside = |at: Nanos| match first < at && at < last {
                true => Nanos::ZERO,
                false => until(first, at, refresh),
            };
            let passed = |at: Nanos| match first < at && at < last {
                true => refresh,
                false => until(first, at, refresh) + (last - first),
            };
            for after in [&to_row as &dyn Fn(Nanos) -> Nanos, &inside, &passed] {
                let lasts =
                    |end: i64, place: i64| after(Nanos((end + place).rem_euclid(case.refresh))).0;
                let all = |of: &dyn Fn(&Times, i64) -> i64| {
                    extremes(
                        frames
                            .iter()
                            .flat_map(|f| places.iter().map(move |p| of(f, *p))),
                    )
                };
                let edges = [first, last];
                let waits = all(&|[.., e], at| lasts(*e, at));
                assert_eq!(backlog.after_end(&edges, after), waits, "{case:?}");
                let way = Interval::new(
                    all(&|[_, _, s, _, e], at| e - s + lasts(*e, at)).min,
                    all(&|[p, .., e], at| e - p + lasts(*e, at)).max,
                );
                assert_eq!(backlog.way(&edges, after), way, "{case:?} {first} {last}");
            }
        }
    }
}

#[test]
fn what_fills_too_slowly_is_not_followed() {
    let unit = Unit {
        ns: 1,
        refresh: 10_000_000,
        period: 10_000_000,
    };
    let render = [9_999_999, 10_000_001];
    assert_eq!(
        Backlog::follow_units(unit, 2, render, 0, Some(vec![0])),
        None
    );
}
