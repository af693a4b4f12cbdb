use super::Volume;

/// How many voxels have which values.
#[derive(Debug, Clone, PartialEq)]
pub struct ValueHistogram {
    /// The volume's least and greatest value.
    pub range: [f64; 2],
    /// Voxels in equal parts of the range, lowest first.
    pub counts: Vec<u64>,
}

impl ValueHistogram {
    /// Counts the voxels of `volume` in so many equal parts of its range (at least one).
    pub fn new(volume: &Volume, bins: usize) -> Self {
        let bins = bins.max(1);
        let range = volume.range();
        let [slope, intercept] = volume.scale();
        let mut counts = vec![0; bins];
        let per_value = bins as f64 / (range[1] - range[0]).max(f64::MIN_POSITIVE);
        let voxels = volume.voxels();
        voxels.for_each(0, voxels.len(), |_, stored| {
            let bin = (slope * stored + intercept - range[0]) * per_value;
            counts[(bin as usize).min(bins - 1)] += 1;
        });
        Self { range, counts }
    }

    /// The value in the middle of a bin.
    pub fn middle(&self, bin: usize) -> f64 {
        self.edge(bin as f64 + 0.5)
    }

    /// The value after so many bins from the lowest.
    pub(super) fn edge(&self, bins: f64) -> f64 {
        let [low, high] = self.range;
        low + (high - low) * bins / self.counts.len() as f64
    }

    /// The bin with most voxels, and its share of all.
    pub(super) fn mode(&self) -> (usize, f64) {
        let all: u64 = self.counts.iter().sum();
        let (bin, count) = self
            .counts
            .iter()
            .enumerate()
            .max_by_key(|(bin, count)| (**count, std::cmp::Reverse(*bin)))
            .unwrap_or((0, &0));
        (bin, *count as f64 / all.max(1) as f64)
    }

    /// The first bin of the upper of two classes whose means are farthest apart for their sizes
    /// (Otsu 1979).
    pub(super) fn otsu(&self) -> usize {
        let all: u64 = self.counts.iter().sum();
        let moment = |counts: &[u64]| -> f64 {
            let terms = counts.iter().enumerate();
            terms.map(|(bin, n)| bin as f64 * *n as f64).sum()
        };
        let whole = moment(&self.counts);
        let (mut below, mut below_moment) = (0u64, 0.0);
        let (mut best, mut split) = (-1.0, self.counts.len() / 2);
        for (bin, count) in self.counts.iter().enumerate() {
            below += count;
            below_moment += bin as f64 * *count as f64;
            let above = all - below;
            if below == 0 || above == 0 {
                continue;
            }
            let apart = below_moment / below as f64 - (whole - below_moment) / above as f64;
            let between = below as f64 * above as f64 * apart * apart;
            if between > best {
                (best, split) = (between, bin + 1);
            }
        }
        split
    }

    /// The value below which a share `q` of the voxels in bins `from..to` lies.
    pub(super) fn quantile(&self, from: usize, to: usize, q: f64) -> f64 {
        let counts = &self.counts[from..to];
        let wanted = counts.iter().sum::<u64>() as f64 * q;
        let mut below = 0.0;
        for (k, count) in counts.iter().enumerate() {
            let count = *count as f64;
            if count > 0.0 && below + count >= wanted {
                return self.edge((from + k) as f64 + (wanted - below) / count);
            }
            below += count;
        }
        self.edge(to as f64)
    }
}
