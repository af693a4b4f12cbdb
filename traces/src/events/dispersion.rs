use std::collections::VecDeque;

use foveasim_models::math::{cos, to_rad};

use super::chunks::Chunks;
use super::{EventOptions, GazeEvent};
use crate::EventKind;

/// Shortest fixation by dispersion \[ms\] (Salvucci & Goldberg 2000: 100 to 200).
const MIN_FIXATION_MS: f64 = 100.0;
/// Two fixations with more than this between them are not joined by one saccade \[ms\].
const MAX_SACCADE_MS: f64 = 150.0;

/// The least and the largest value of a window that moves forward, in constant time per step.
#[derive(Debug, Default)]
struct Extent {
    low: VecDeque<(usize, f64)>,
    high: VecDeque<(usize, f64)>,
}

impl Extent {
    fn push(&mut self, i: usize, v: f64) {
        while self.low.back().is_some_and(|b| b.1 >= v) {
            self.low.pop_back();
        }
        while self.high.back().is_some_and(|b| b.1 <= v) {
            self.high.pop_back();
        }
        self.low.push_back((i, v));
        self.high.push_back((i, v));
    }

    /// Forgets what is before `first`.
    fn drop_before(&mut self, first: usize) {
        for values in [&mut self.low, &mut self.high] {
            while values.front().is_some_and(|f| f.0 < first) {
                values.pop_front();
            }
        }
    }

    fn width(&self) -> f64 {
        match (self.low.front(), self.high.front()) {
            (Some(low), Some(high)) => high.1 - low.1,
            _ => 0.0,
        }
    }
}

/// Fixations by dispersion (I-DT), and saccades as what joins two of them.
pub(super) fn events(chunks: &Chunks, speeds: &[f64], options: &EventOptions) -> Vec<GazeEvent> {
    let shortest = options.min_fixation_ms.max(MIN_FIXATION_MS);
    let mut events: Vec<GazeEvent> = Vec::new();
    for range in &chunks.ranges {
        let mut landed: Option<usize> = None;
        for fixation in fixations(chunks, range, shortest, options.dispersion_deg) {
            let (first, last) = (*fixation.start(), *fixation.end());
            if let Some(from) = landed
                && (chunks.t[first] - chunks.t[from]).as_ms() <= MAX_SACCADE_MS
            {
                events.push(chunks.event(EventKind::Saccade, from..=first, speeds));
            }
            events.push(chunks.event(EventKind::Fixation, fixation, speeds));
            landed = Some(last);
        }
    }
    events
}

fn fixations(
    chunks: &Chunks,
    range: &std::ops::Range<usize>,
    shortest_ms: f64,
    limit_deg: f64,
) -> Vec<std::ops::RangeInclusive<usize>> {
    let mut found = Vec::new();
    let mut extents = [Extent::default(), Extent::default()];
    let (mut first, mut next) = (range.start, range.start);
    while first < range.end {
        // As many samples as the shortest fixation has, and then as many as fit.
        let here = chunks.gaze[first];
        let squeeze = cos(to_rad(here.elevation_deg));
        let dispersion = |e: &[Extent; 2]| e[0].width() * squeeze + e[1].width();
        while next < range.end {
            let long =
                next > first && (chunks.t[next - 1] - chunks.t[first]).as_ms() >= shortest_ms;
            if long {
                break;
            }
            push(&mut extents, chunks, next);
            next += 1;
        }
        let enough = (chunks.t[next - 1] - chunks.t[first]).as_ms() >= shortest_ms;
        if !enough {
            break;
        }
        if dispersion(&extents) > limit_deg {
            first += 1;
            for e in &mut extents {
                e.drop_before(first);
            }
            continue;
        }
        let mut last = next - 1;
        while next < range.end {
            push(&mut extents, chunks, next);
            next += 1;
            if dispersion(&extents) > limit_deg {
                break;
            }
            last = next - 1;
        }
        found.push(first..=last);
        first = last + 1;
        next = first;
        extents = [Extent::default(), Extent::default()];
    }
    found
}

fn push(extents: &mut [Extent; 2], chunks: &Chunks, i: usize) {
    extents[0].push(i, chunks.gaze[i].azimuth_deg);
    extents[1].push(i, chunks.gaze[i].elevation_deg);
}
