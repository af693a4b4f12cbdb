use std::collections::BTreeMap;

use crate::{Interpolate, Nanos, Provenance, Sample, Series};

/// What is known of a series without keeping it: where it begins and ends, how much of it has a value, and
/// how far apart its samples are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SeriesOutline {
    /// Time of the first sample.
    pub start: Nanos,
    /// Time of the last sample.
    pub end: Nanos,
    /// How many samples there are.
    pub samples: u64,
    /// How many of them have a value.
    pub present: u64,
    /// Median time from one sample to the next, to a microsecond; 0 for fewer than two samples.
    pub median_step: Nanos,
    /// What the numbers are.
    pub provenance: Provenance,
}

impl<T: Interpolate> From<&Series<T>> for SeriesOutline {
    fn from(series: &Series<T>) -> Self {
        let mut sketch = OutlineSketch::default();
        series.samples().iter().for_each(|s| sketch.add(s));
        let outline = sketch.finish(series.provenance());
        outline.expect("a series has at least one sample")
    }
}

/// Makes a [`SeriesOutline`] of samples one by one, in bounded memory.
#[derive(Debug, Clone, Default)]
pub struct OutlineSketch {
    ends: Option<[Nanos; 2]>,
    samples: u64,
    present: u64,
    /// How many steps there are of each length in whole microseconds, and their sum \[ns\].
    steps: BTreeMap<i64, (u64, i64)>,
    /// The entry that is counted in before it goes to the map: most steps are as long as the one before.
    open: Option<(i64, (u64, i64))>,
}

/// Steps of a second and more count as one length: a median is not among them, or does not matter.
const LONGEST_STEP: Nanos = Nanos(1_000_000_000);

impl OutlineSketch {
    /// Takes the next sample; time must not go back.
    pub fn add<T>(&mut self, sample: &Sample<T>) {
        self.samples += 1;
        self.present += u64::from(sample.value.is_some());
        match &mut self.ends {
            None => self.ends = Some([sample.t; 2]),
            Some([_, end]) => {
                let step = Nanos(sample.t.0.saturating_sub(end.0)).min(LONGEST_STEP);
                *end = sample.t;
                self.count(step);
            }
        }
    }

    fn count(&mut self, step: Nanos) {
        let bin = step.0 / 1000;
        match &mut self.open {
            Some((open, (n, sum))) if *open == bin => {
                *n += 1;
                *sum += step.0;
            }
            _ => {
                self.close();
                self.open = Some((bin, (1, step.0)));
            }
        }
    }

    fn close(&mut self) {
        if let Some((bin, (n, sum))) = self.open.take() {
            let entry = self.steps.entry(bin).or_default();
            *entry = (entry.0 + n, entry.1 + sum);
        }
    }

    /// The outline of all samples taken; `None` of none.
    pub fn finish(mut self, provenance: Provenance) -> Option<SeriesOutline> {
        let [start, end] = self.ends?;
        self.close();
        let mut before_median = (self.samples - 1) / 2;
        let mut median_step = Nanos::ZERO;
        for (n, sum) in self.steps.values() {
            if before_median < *n {
                median_step = Nanos(sum / *n as i64);
                break;
            }
            before_median -= n;
        }
        Some(SeriesOutline {
            start,
            end,
            samples: self.samples,
            present: self.present,
            median_step,
            provenance,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GazeDirection;

    fn outline(times: &[i64]) -> SeriesOutline {
        let sample = |&t: &i64| Sample {
            t: Nanos(t),
            value: (t != 5000).then_some(GazeDirection::AHEAD),
        };
        let series = Series::new(times.iter().map(sample).collect(), Provenance::Truth);
        SeriesOutline::from(&series.unwrap())
    }

    #[test]
    fn the_median_is_known_to_a_microsecond() {
        let one = outline(&[7]);
        assert_eq!((one.start, one.end), (Nanos(7), Nanos(7)));
        assert_eq!((one.samples, one.median_step), (1, Nanos::ZERO));
        // Steps 5000, 10, 3333333, 3333333, 3333334, 9e9 ns.
        let times = [
            0,
            5000,
            5010,
            3_338_343,
            6_671_676,
            10_005_010,
            9_010_005_010,
        ];
        let found = outline(&times);
        assert_eq!((found.samples, found.present), (7, 6));
        assert_eq!(found.median_step, Nanos(3_333_333));
        assert_eq!(found.end, Nanos(9_010_005_010));
    }
}
