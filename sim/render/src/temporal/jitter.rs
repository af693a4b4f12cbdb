use glam::DVec2;

/// Offsets before they repeat.
const PERIOD: u64 = 16;

/// Where in its cell each sample of a pass is taken when the pass is drawn for the `index`-th time: a
/// shift from the middle in lattice steps, each part within ±½ (Guenter 2012, §4.2 and Fig. 6).
///
/// The first 16 points of Halton's sequence in bases 2 and 3, moved so that their mean is the middle:
/// the mean over a period is then that of the cell itself, not of one beside it.
pub fn jitter(index: u64) -> DVec2 {
    let at = |i| DVec2::new(radical_inverse(i, 2), radical_inverse(i, 3));
    let mean = (0..PERIOD).map(at).sum::<DVec2>() / PERIOD as f64;
    at(index % PERIOD) - mean
}

/// The digits of `index` mirrored at the point.
fn radical_inverse(mut index: u64, base: u64) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0);
    while index > 0 {
        digit /= base as f64;
        value += digit * (index % base) as f64;
        index /= base;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_stay_in_the_cell_and_fill_it() {
        let offsets: Vec<_> = (0..PERIOD).map(jitter).collect();
        assert!(offsets.iter().all(|o| o.abs().max_element() <= 0.5));
        assert!(offsets.iter().sum::<DVec2>().length() < 1e-12);
        assert_eq!(jitter(5), jitter(5 + PERIOD));
        // Every sixteenth of the cell along x once; every quarter square at least once.
        let mut columns: Vec<_> = offsets.iter().map(|o| (o.x * 16.0 + 8.0) as u32).collect();
        columns.sort_unstable();
        assert_eq!(columns, (0..16).collect::<Vec<_>>());
        for quarter in 0..16 {
            let low = DVec2::new(f64::from(quarter % 4), f64::from(quarter / 4)) / 4.0 - 0.5;
            let near = |o: &&DVec2| (**o - low - 0.125).abs().max_element() <= 0.25;
            assert!(offsets.iter().any(|o| near(&o)), "{low}");
        }
    }
}
