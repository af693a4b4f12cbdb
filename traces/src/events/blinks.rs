use foveasim_models::{GazeSeries, Nanos};

use super::chunks::Chunks;
use super::{EventOptions, GazeEvent};
use crate::EventKind;

/// Losses of a blink's length, each between two chunks.
#[derive(Debug)]
pub(super) struct Blinks {
    /// For each chunk, the blink before it, if any: its first and last time.
    spans: Vec<Option<(Nanos, Nanos)>>,
}

impl Blinks {
    /// Losses after each chunk but the last. A hole in time is no blink: nothing was recorded.
    pub(super) fn new(series: &GazeSeries, chunks: &Chunks, options: &EventOptions) -> Self {
        let [short, long] = options.blink_ms;
        let mut spans = vec![None; chunks.ranges.len() + 1];
        for (i, pair) in chunks.ranges.windows(2).enumerate() {
            let (last, next) = (chunks.t[pair[0].end - 1], chunks.t[pair[1].start]);
            let lost = series.index_at(last).is_some_and(|at| {
                series.samples()[at + 1..]
                    .first()
                    .is_some_and(|s| s.value.is_none())
            });
            let ms = (next - last).as_ms();
            spans[i + 1] = (lost && (short..=long).contains(&ms)).then_some((last, next));
        }
        Self { spans }
    }

    /// Whether there is a blink before chunk `i`.
    pub(super) fn before(&self, i: usize) -> bool {
        self.spans[i].is_some()
    }

    /// Whether there is one after it.
    pub(super) fn after(&self, i: usize) -> bool {
        self.spans[i + 1].is_some()
    }

    /// The blink before chunk `i` ends at this time.
    pub(super) fn ends_at(&mut self, i: usize, t: Nanos) {
        if let Some((_, end)) = &mut self.spans[i] {
            *end = t;
        }
    }

    /// The blink after chunk `i` begins at this time.
    pub(super) fn begins_at(&mut self, i: usize, t: Nanos) {
        if let Some((start, _)) = &mut self.spans[i + 1] {
            *start = t;
        }
    }

    pub(super) fn finish(self) -> impl Iterator<Item = GazeEvent> {
        self.spans
            .into_iter()
            .flatten()
            .map(|(start, end)| GazeEvent {
                kind: EventKind::Blink,
                start,
                end,
                from: None,
                to: None,
                amplitude_deg: 0.0,
                peak_deg_per_s: 0.0,
            })
    }
}
