use foveasim_models::{Interpolate, Nanos, Sample, Series};

/// Reads a series at times that mostly grow, in constant time per step; [`Cursor::at`] gives the
/// values of [`Series::at`].
#[derive(Debug, Clone)]
pub struct Cursor<'a, T> {
    samples: &'a [Sample<T>],
    /// How many samples are at or before the time sought last.
    seen: usize,
}

/// After this many steps in one go, a binary search is cheaper.
const MAX_WALK: usize = 32;

impl<'a, T: Interpolate> Cursor<'a, T> {
    /// A cursor before the first sample.
    pub fn new(series: &'a Series<T>) -> Self {
        Self {
            samples: series.samples(),
            seen: 0,
        }
    }

    /// Moves to `t`: afterwards [`Cursor::past`] ends with the last sample at or before it.
    pub fn seek(&mut self, t: Nanos) {
        for _ in 0..MAX_WALK {
            if self.seen < self.samples.len() && self.samples[self.seen].t <= t {
                self.seen += 1;
            } else if self.seen > 0 && self.samples[self.seen - 1].t > t {
                self.seen -= 1;
            } else {
                return;
            }
        }
        self.seen = self.samples.partition_point(|s| s.t <= t);
    }

    /// The samples at or before the time sought last.
    pub fn past(&self) -> &'a [Sample<T>] {
        &self.samples[..self.seen]
    }

    /// The value at `t`, linear between the samples around it; `None` outside the series, next to a
    /// missing sample, or inside a hole longer than `max_gap`.
    pub fn at(&mut self, t: Nanos, max_gap: Nanos) -> Option<T> {
        self.seek(t);
        let before = self.past().last()?;
        before.towards(self.samples.get(self.seen), t, max_gap)
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::{GazeDirection, Provenance};
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
