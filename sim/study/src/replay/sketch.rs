/// The spread of numbers from 0 on in bounded memory.
///
/// Count, mean, smallest and largest are exact. Quantiles are within a bin of those of the sorted numbers;
/// bins are as fine as asked for until a number needs more than 2²⁰ of them, and become twice as
/// wide as often as it then takes.
#[derive(Debug, Clone, PartialEq)]
pub struct Sketch {
    bin: f64,
    counts: Vec<u64>,
    n: u64,
    sum: f64,
    min: f64,
    max: f64,
}

/// The most bins: 8 MB.
const MOST_BINS: usize = 1 << 20;

impl Sketch {
    /// An empty sketch with bins of this width, above 0.
    pub fn new(bin: f64) -> Self {
        Self {
            bin,
            counts: Vec::new(),
            n: 0,
            sum: 0.0,
            min: f64::INFINITY,
            max: f64::NEG_INFINITY,
        }
    }

    /// Counts a number; one below 0 in the first bin, and one that is none not at all.
    pub fn add(&mut self, value: f64) {
        if !value.is_finite() {
            return;
        }
        while value / self.bin >= MOST_BINS as f64 {
            self.widen();
        }
        let bin = (value / self.bin) as usize;
        if bin >= self.counts.len() {
            self.counts.resize(bin + 1, 0);
        }
        self.counts[bin] += 1;
        self.n += 1;
        self.sum += value;
        self.min = self.min.min(value);
        self.max = self.max.max(value);
    }

    fn widen(&mut self) {
        self.bin *= 2.0;
        let pairs = self.counts.chunks(2);
        self.counts = pairs.map(|pair| pair.iter().sum()).collect();
    }

    /// How many numbers were counted.
    pub fn len(&self) -> u64 {
        self.n
    }

    /// Whether none was.
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// Their mean; NaN of none.
    pub fn mean(&self) -> f64 {
        self.sum / self.n as f64
    }

    /// The largest; −∞ of none.
    pub fn max(&self) -> f64 {
        self.max
    }

    /// The quantile `q` in 0..=1; NaN of none. Linear between order statistics (Hyndman & Fan type 7).
    pub fn quantile(&self, q: f64) -> f64 {
        if self.is_empty() {
            return f64::NAN;
        }
        let h = q.clamp(0.0, 1.0) * (self.n - 1) as f64;
        let low = h as u64;
        let [at, next] = [low, low + 1].map(|rank| self.order_statistic(rank.min(self.n - 1)));
        at + (h - low as f64) * (next - at)
    }

    /// The number that `rank` others are below, those of one bin taken as evenly spread over it.
    fn order_statistic(&self, rank: u64) -> f64 {
        let mut below = 0;
        for (i, &count) in self.counts.iter().enumerate() {
            if rank < below + count {
                let inside = ((rank - below) as f64 + 0.5) / count as f64;
                return ((i as f64 + inside) * self.bin).clamp(self.min, self.max);
            }
            below += count;
        }
        self.max
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::math::quantile_sorted;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn quantiles_are_within_a_bin(
            values in prop::collection::vec(prop_oneof![0.0f64..3.0, 0.0f64..4000.0], 1..300),
            q in 0.0f64..=1.0,
        ) {
            let mut sketch = Sketch::new(0.001);
            values.iter().for_each(|v| sketch.add(*v));
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            // 2²⁰ bins of a thousandth reach to 1048; twice doubled, beyond 4000.
            let widest = if sorted.last() < Some(&1048.0) { 0.001 } else { 0.004 };
            prop_assert!((sketch.quantile(q) - quantile_sorted(&sorted, q)).abs() <= widest);
            prop_assert_eq!(sketch.max(), *sorted.last().unwrap());
            prop_assert_eq!(sketch.len(), sorted.len() as u64);
            prop_assert!((sketch.mean() - foveasim_models::math::mean(&values)).abs() < 1e-9);
        }
    }

    #[test]
    fn what_is_no_number_is_not_counted() {
        let mut sketch = Sketch::new(1.0);
        sketch.add(f64::NAN);
        sketch.add(f64::INFINITY);
        assert!(sketch.is_empty() && sketch.quantile(0.5).is_nan() && sketch.mean().is_nan());
        sketch.add(-0.5);
        assert_eq!((sketch.len(), sketch.quantile(0.5)), (1, -0.5));
        sketch.add(1e300);
        assert_eq!(sketch.max(), 1e300);
    }
}
