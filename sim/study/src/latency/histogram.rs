use foveasim_models::Nanos;
use foveasim_pipeline::Interval;

/// A distribution of durations in bounded memory: the same for any order of additions and merges.
///
/// Minimum, maximum and mean are exact. Quantiles are within one bin of the order statistics; a bin is
/// at most 1/16384 of the range (1.4 µs for a range of 22 ms), or one nanosecond.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Histogram {
    origin: Nanos,
    /// A bin is 2^shift nanoseconds wide.
    shift: u32,
    counts: Vec<u64>,
    n: u64,
    /// Sum of all durations after `origin` \[ns\].
    sum: i128,
    min: Nanos,
    max: Nanos,
}

/// Between half as many and as many bins are used for a range that is wide enough.
const BINS: i64 = 1 << 15;

impl Histogram {
    /// An empty histogram for durations in `range`; others are counted in the first or last bin.
    pub fn new(range: Interval) -> Self {
        let width = range.width().0;
        let mut shift = 0;
        while (width >> shift) >= BINS {
            shift += 1;
        }
        Self {
            origin: range.min,
            shift,
            counts: vec![0; (width >> shift) as usize + 1],
            n: 0,
            sum: 0,
            min: Nanos::MAX,
            max: Nanos(i64::MIN),
        }
    }

    /// Counts one duration.
    pub fn add(&mut self, t: Nanos) {
        let after = t - self.origin;
        let bin = (after.0 >> self.shift).clamp(0, self.counts.len() as i64 - 1);
        self.counts[bin as usize] += 1;
        self.n += 1;
        self.sum += i128::from(after.0);
        self.min = self.min.min(t);
        self.max = self.max.max(t);
    }

    /// Counts all of `other` as well.
    ///
    /// # Panics
    /// If it is of another range.
    pub fn merge(&mut self, other: &Self) {
        let shape = |h: &Self| (h.origin, h.shift, h.counts.len());
        assert_eq!(shape(self), shape(other), "histograms of one range");
        for (mine, theirs) in self.counts.iter_mut().zip(&other.counts) {
            *mine += theirs;
        }
        self.n += other.n;
        self.sum += other.sum;
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
    }

    /// How many durations were counted.
    pub fn len(&self) -> u64 {
        self.n
    }

    /// Whether none was.
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// The shortest; [`Nanos::MAX`] of none.
    pub fn min(&self) -> Nanos {
        self.min
    }

    /// The longest; `i64::MIN` of none.
    pub fn max(&self) -> Nanos {
        self.max
    }

    /// The mean \[ms\]; NaN of none.
    pub fn mean_ms(&self) -> f64 {
        self.origin.as_ms() + self.sum as f64 / self.n as f64 / 1e6
    }

    /// The quantile `q` in 0..=1 \[ms\]; NaN of none. Linear between order statistics (Hyndman & Fan
    /// type 7), those of one bin taken as evenly spread over it.
    pub fn quantile_ms(&self, q: f64) -> f64 {
        if self.is_empty() {
            return f64::NAN;
        }
        let rank = q.clamp(0.0, 1.0) * (self.n - 1) as f64;
        let mut below = 0;
        for (i, &count) in self.counts.iter().enumerate() {
            // Order statistics below + 0 … below + count − 1 are here; the gap to the next one too.
            if count > 0 && rank < (below + count) as f64 {
                let inside = match self.shift {
                    0 => 0.0, // a bin of one nanosecond holds one value
                    _ => ((rank - below as f64 + 0.5) / count as f64).min(1.0),
                };
                let ns = self.origin.0 as f64 + (i as f64 + inside) * self.bin_ns();
                return ns.clamp(self.min.0 as f64, self.max.0 as f64) / 1e6;
            }
            below += count;
        }
        self.max.as_ms()
    }

    /// `bins` equal bins (at least 1) from the start to the end of the range: from \[ms\], to \[ms\]
    /// and fraction of all durations. A duration is counted where its fine bin begins.
    pub fn coarse(&self, bins: usize) -> Vec<(f64, f64, f64)> {
        let bins = bins.clamp(1, self.counts.len());
        let mut counts = vec![0; bins];
        for (i, &count) in self.counts.iter().enumerate() {
            counts[i * bins / self.counts.len()] += count;
        }
        let edge = |i: usize| {
            let fine = (i * self.counts.len()).div_ceil(bins);
            (self.origin.0 as f64 + fine as f64 * self.bin_ns()) / 1e6
        };
        let bin = |(i, &count): (usize, &u64)| (edge(i), edge(i + 1), count as f64 / self.n as f64);
        counts.iter().enumerate().map(bin).collect()
    }

    fn bin_ns(&self) -> f64 {
        (1u64 << self.shift) as f64
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::math::quantile_sorted;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn agrees_with_the_sorted_values(
            values in prop::collection::vec(0i64..1_000_000, 1..300),
            q in 0.0f64..=1.0,
        ) {
            let range = Interval::new(Nanos(0), Nanos(1_000_000));
            let (mut whole, mut left, mut right) =
                (Histogram::new(range), Histogram::new(range), Histogram::new(range));
            for (i, &v) in values.iter().enumerate() {
                whole.add(Nanos(v));
                if i % 3 == 0 { left.add(Nanos(v)) } else { right.add(Nanos(v)) }
            }
            right.merge(&left);
            prop_assert_eq!(&whole, &right);
            let mut sorted: Vec<f64> = values.iter().map(|v| *v as f64 / 1e6).collect();
            sorted.sort_by(f64::total_cmp);
            let h = q * (sorted.len() - 1) as f64;
            // A quantile lies within a bin of the order statistics around its rank.
            let bin = whole.bin_ns() / 1e6;
            let got = whole.quantile_ms(q);
            prop_assert!(got >= sorted[h.floor() as usize] - bin && got <= sorted[h.ceil() as usize] + bin);
            prop_assert!((whole.quantile_ms(0.0) - sorted[0]).abs() <= bin);
            prop_assert!((quantile_sorted(&sorted, 1.0) - whole.quantile_ms(1.0)).abs() <= bin);
            let mean = foveasim_models::math::mean(&sorted);
            prop_assert!((whole.mean_ms() - mean).abs() < 1e-12);
            let fractions: f64 = whole.coarse(7).iter().map(|b| b.2).sum();
            prop_assert!((fractions - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_duration_that_does_not_vary() {
        let mut h = Histogram::new(Interval::exactly(Nanos(5)));
        h.add(Nanos(5));
        assert_eq!(
            (h.quantile_ms(0.5), h.mean_ms(), h.coarse(9).len()),
            (5e-6, 5e-6, 1)
        );
    }
}
