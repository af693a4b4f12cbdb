use foveasim_models::{Interpolate, Nanos, Sample};

use crate::Samples;

/// Reads samples at times that mostly grow, in constant time per step; [`Cursor::at`] gives the values of
/// [`Series::at`](foveasim_models::Series::at).
#[derive(Debug, Clone)]
pub struct Cursor<'a, T> {
    samples: Samples<'a, T>,
    /// Which reader of a window this is.
    reader: usize,
    /// How many samples are at or before the time sought last.
    seen: usize,
}

/// After this many steps in one go, a binary search is cheaper.
const MAX_WALK: usize = 32;

impl<'a, T: Interpolate> Cursor<'a, T> {
    /// A cursor before the first sample.
    pub fn new(samples: impl Into<Samples<'a, T>>) -> Self {
        let samples = samples.into();
        let reader = match samples {
            Samples::Series(_) => 0,
            Samples::Window(window) => window.enter(),
        };
        Self {
            samples,
            reader,
            seen: 0,
        }
    }

    /// Moves to `t`: afterwards [`Cursor::seen`] is how many samples are at or before it.
    pub fn seek(&mut self, t: Nanos) {
        let mut steps = 0;
        loop {
            if self.samples.time(self.seen).is_some_and(|at| at <= t) {
                self.seen += 1;
            } else if self.seen > 0 && self.samples.time(self.seen - 1).is_some_and(|at| at > t) {
                self.seen -= 1;
            } else {
                return;
            }
            steps += 1;
            if let Samples::Series(series) = self.samples
                && steps == MAX_WALK
            {
                self.seen = series.samples().partition_point(|s| s.t <= t);
                return;
            }
        }
    }

    /// How many samples are at or before the time sought last.
    pub fn seen(&self) -> usize {
        self.seen
    }

    /// Sample `index`, counted from the first; `None` after the last.
    pub fn get(&self, index: usize) -> Option<Sample<T>> {
        self.samples.get(index)
    }

    /// Says that no time before the one sought last will be asked for again: only a window forgets.
    pub fn release(&self) {
        if let Samples::Window(window) = self.samples {
            window.release(self.reader, self.seen.saturating_sub(1));
        }
    }

    /// The value at `t`, linear between the samples around it; `None` outside the series, next to a
    /// missing sample, or inside a hole longer than `max_gap`.
    pub fn at(&mut self, t: Nanos, max_gap: Nanos) -> Option<T> {
        self.seek(t);
        let before = self.samples.get(self.seen.checked_sub(1)?)?;
        before.towards(self.samples.get(self.seen).as_ref(), t, max_gap)
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::{GazeDirection, Provenance, Series};
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn equals_a_search_from_scratch(
            steps in prop::collection::vec((0i64..5, prop::option::weighted(0.8, -9.0f64..9.0)), 1..90),
            asked in prop::collection::vec(-5i64..220, 1..60),
            max_gap in 0i64..6,
        ) {
            let mut t = 0;
            let samples = steps.iter().map(|(dt, az)| {
                t += dt;
                Sample { t: Nanos(t), value: az.map(|a| GazeDirection::new(a, 0.0)) }
            });
            let series = Series::new(samples.collect(), Provenance::Truth).unwrap();
            let mut cursor = Cursor::new(&series);
            for t in asked {
                let got = cursor.at(Nanos(t), Nanos(max_gap));
                prop_assert_eq!(got, series.at(Nanos(t), Nanos(max_gap)));
            }
        }
    }
}
