use std::str::FromStr;

use foveasim_models::{Durations, ModelError, Nanos, Role, Stream, unknown_name};
use foveasim_pipeline::{BoundKind, Interval};
use foveasim_reports::{Cell, Table};

use super::{Histogram, LatencyError};

/// How the rounded numbers of Guenter 2012, Fig. 5, can be read. The figure gives a best and a worst
/// case of 23 and 40 ms; the text beside it leaves open how the parts of the worst case add up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fig5Reading {
    /// As the figure adds up: worst 10 + 16 + 8 + 6 = 40 ms; the scan-out of 8 ms holds the 2 ms in which
    /// the inner layer is scanned.
    Figure,
    /// The 2 ms come after a wait of 8 ms: 10 + 16 + (8 + 2) + 6 = 42 ms.
    ScanAfterWait,
    /// "Adding two render periods" (caption) to the one that a frame takes anyway: 10 + 8 + 16 + 8 + 6 =
    /// 48 ms.
    TwoPeriodsMore,
}

/// All of them.
pub const FIG5_READINGS: [Fig5Reading; 3] = [
    Fig5Reading::Figure,
    Fig5Reading::ScanAfterWait,
    Fig5Reading::TwoPeriodsMore,
];

/// The bars of Fig. 5, and all of them together.
const BARS: [&str; 5] = [
    "tracker",
    "render",
    "scan_out",
    "pixel_switching",
    "gaze_to_photon",
];

/// What a reading gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Fig5Result {
    /// Bars in order, then the whole.
    pub histograms: Vec<Histogram>,
    /// Least and most, by adding up.
    pub bounds: Vec<Interval>,
}

impl Fig5Reading {
    /// As given to `--reading`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Figure => "figure",
            Self::ScanAfterWait => "scan-after-wait",
            Self::TwoPeriodsMore => "two-periods-more",
        }
    }

    /// Least and most of each bar \[ms\].
    fn bars_ms(self) -> [[f64; 2]; 4] {
        let render = match self {
            Self::TwoPeriodsMore => [8.0, 24.0],
            Self::Figure | Self::ScanAfterWait => [8.0, 16.0],
        };
        let scan = match self {
            Self::ScanAfterWait => [2.0, 10.0],
            Self::Figure | Self::TwoPeriodsMore => [2.0, 8.0],
        };
        [[7.0, 10.0], render, scan, [6.0, 6.0]]
    }

    /// Every bar uniform between its least and its most, independent of the others.
    ///
    /// # Errors
    /// If `runs` is 0 or above [`MAX_RUNS`](super::MAX_RUNS).
    pub fn run(self, runs: u64, seed: u64) -> Result<Fig5Result, LatencyError> {
        super::check_runs(runs)?;
        let bars: Vec<Durations> = self
            .bars_ms()
            .iter()
            .map(|range| Durations::uniform("bar", *range))
            .collect::<Result<_, _>>()?;
        let mut bounds: Vec<Interval> = bars
            .iter()
            .map(|bar| Interval::new(bar.min(), bar.max()))
            .collect();
        bounds.push(bounds.iter().copied().sum());
        let mut histograms: Vec<_> = bounds.iter().map(|b| Histogram::new(*b)).collect();
        let mut stream = Stream::new(seed, Role::Phase, 0);
        for _ in 0..runs {
            let mut total = Nanos::ZERO;
            for (bar, histogram) in bars.iter().zip(&mut histograms) {
                let t = bar.draw(&mut stream);
                histogram.add(t);
                total += t;
            }
            histograms[bars.len()].add(total);
        }
        Ok(Fig5Result { histograms, bounds })
    }
}

impl FromStr for Fig5Reading {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        FIG5_READINGS
            .into_iter()
            .find(|r| r.name() == text)
            .ok_or_else(|| unknown_name("reading of Fig. 5", text, &FIG5_READINGS.map(Self::name)))
    }
}

impl Fig5Result {
    /// From the eye's movement to its light.
    pub fn total(&self) -> &Histogram {
        &self.histograms[BARS.len() - 1]
    }

    /// One row per bar, then the whole; columns as those of
    /// [`LatencyResult::table`](super::LatencyResult::table).
    pub fn table(&self) -> Table {
        let mut table = Table::new(super::result::COLUMNS);
        for ((name, h), bound) in BARS.iter().zip(&self.histograms).zip(&self.bounds) {
            let mut row = vec![Cell::from(*name)];
            row.extend(super::result::columns(h, *bound).map(Cell::from));
            row.push(BoundKind::Exact.name().into());
            table.push(row);
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_rounded_numbers_and_their_other_readings() {
        let ends = |reading: Fig5Reading| {
            let result = reading.run(1, 1).unwrap();
            let total = result.bounds[4];
            (total.min.as_ms(), total.max.as_ms())
        };
        assert_eq!(ends(Fig5Reading::Figure), (23.0, 40.0));
        assert_eq!(ends(Fig5Reading::ScanAfterWait), (23.0, 42.0));
        assert_eq!(ends(Fig5Reading::TwoPeriodsMore), (23.0, 48.0));
        assert!(
            "figures"
                .parse::<Fig5Reading>()
                .unwrap_err()
                .to_string()
                .contains("`figure`")
        );
        assert!(Fig5Reading::Figure.run(0, 1).is_err());
    }

    #[test]
    fn distributions_of_the_readings() {
        // Sums of three uniform parts, exactly, by an independent computation [ms].
        for (reading, want) in [
            (
                Fig5Reading::Figure,
                [26.512_461, 31.5, 31.5, 36.487_539, 37.948_028],
            ),
            (
                Fig5Reading::ScanAfterWait,
                [26.876_973, 32.5, 32.5, 38.123_027, 39.741_514],
            ),
        ] {
            let result = reading.run(1_000_000, 1).unwrap();
            let h = result.total();
            let got = [
                h.quantile_ms(0.05),
                h.quantile_ms(0.5),
                h.mean_ms(),
                h.quantile_ms(0.95),
                h.quantile_ms(0.99),
            ];
            for (got, want) in got.iter().zip(want) {
                assert!((got - want).abs() < 0.05, "{reading:?} {got} {want}");
            }
        }
    }
}
