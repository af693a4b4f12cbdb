use foveasim_models::foveation::Method;
use foveasim_models::math::{self, quantile_sorted};
use foveasim_models::{Acuity, ModelError, Role, Stream};
use foveasim_reports::Table;
use rayon::prelude::*;

use super::{Sweep, SweepRow};

/// How savings spread over viewers, over the tracker's error and over what is not known of the cost.
///
/// Viewers differ in the quality index j at which they no longer see the layers: 14.9 ± 3.07 in the pair test of
/// Guenter 2012, §5, with the slope m = 0.33/j. That is a normal approximation from 15 subjects. The tracker errs
/// by a normal deviate in each of two directions, which the margin must cover besides the sweep's own; the error
/// of a cost profile is a factor, common to foveated frames, whose logarithm is normal.
#[derive(Debug, Clone, PartialEq)]
pub struct SavingsSpread {
    /// Standard deviation of the tracker's error along one axis \[deg\]; 0: it makes none.
    pub tracker_sd_deg: f64,
    /// How many times a row is made with other viewers, errors and costs.
    pub draws: u32,
    /// Seed of the draws.
    pub seed: u64,
}

/// Savings of one row, by what varies.
#[derive(Debug, Clone, PartialEq)]
pub struct SavingsSpreadRow {
    /// The row with the sweep's own acuity and margin.
    pub row: SweepRow,
    /// What varies: `viewers`, `tracker`, `cost` or `all`.
    pub varies: &'static str,
    /// Samples saved by 90, 50 and 10 % of the cases at least: the 10th, 50th and 90th percentile.
    pub sample_ratio: [f64; 3],
    /// The same of the predicted speedup.
    pub speedup: [f64; 3],
}

/// Mean and standard deviation of the quality index at which viewers no longer see layers (Guenter 2012, §5, pair
/// test; methods.md).
const VIEWERS_J: [f64; 2] = [14.9, 3.07];

/// No viewer's index is lower: the normal law's tail reaches below 0.
const LEAST_J: f64 = 3.0;

/// Rows of which each spread is made.
const VARIES: [&str; 4] = ["viewers", "tracker", "cost", "all"];

/// The standard normal deviate that so large a part of the law is below, to 1e-9 (by halving).
fn deviate(part: f64) -> f64 {
    let below = |x: f64| 0.5 * math::erfc(-x / std::f64::consts::SQRT_2);
    let (mut low, mut high) = (-10.0, 10.0);
    while high - low > 1e-10 {
        let middle = (low + high) / 2.0;
        match below(middle) < part {
            true => low = middle,
            false => high = middle,
        }
    }
    (low + high) / 2.0
}

impl SavingsSpread {
    /// The acuity line at which so large a part of viewers no longer sees layers.
    ///
    /// # Errors
    /// If the part is not above 0 and below 1, or hardly anybody is that insensitive.
    pub fn acuity_for(part: f64) -> Result<Acuity, ModelError> {
        if !(part > 0.0 && part < 1.0) {
            return Err(ModelError::range(
                "part of viewers",
                part,
                "above 0 and below 1",
            ));
        }
        let [mean, sd] = VIEWERS_J;
        Acuity::from_quality_index((mean + sd * deviate(part)).max(LEAST_J))
    }

    /// Each row of `sweep` in four variants: viewers, tracker and cost one at a time, then all.
    ///
    /// # Errors
    /// As [`Sweep::rows`]; if there are no draws or more than 100,000, or the tracker's error is not from 0 to 20
    /// degrees.
    pub fn run(&self, sweep: &Sweep) -> Result<Vec<SavingsSpreadRow>, ModelError> {
        if !(0.0..=20.0).contains(&self.tracker_sd_deg) {
            return Err(ModelError::range(
                "tracker error [deg]",
                self.tracker_sd_deg,
                "from 0 to 20",
            ));
        }
        if !(1..=100_000).contains(&self.draws) {
            return Err(ModelError::range("draws", self.draws, "from 1 to 100000"));
        }
        let cases: Vec<(usize, Method)> = (0..sweep.groups())
            .flat_map(|group| sweep.methods.iter().map(move |m| (group, *m)))
            .collect();
        let rows: Vec<_> = cases
            .par_iter()
            .map(|(group, method)| self.of(&sweep.one(*group), *method))
            .collect::<Result<_, ModelError>>()?;
        Ok(rows.into_iter().flatten().collect())
    }

    /// The four variants of one row.
    fn of(&self, one: &Sweep, method: Method) -> Result<Vec<SavingsSpreadRow>, ModelError> {
        let made = |acuity: Acuity, margin_deg: f64| -> Result<SweepRow, ModelError> {
            let sweep = Sweep {
                acuities: vec![acuity],
                margins_deg: vec![margin_deg],
                methods: vec![method],
                ..one.clone()
            };
            Ok(sweep.rows(0)?.remove(0))
        };
        let (acuity, margin_deg) = (one.acuities[0], one.margins_deg[0]);
        let own = made(acuity, margin_deg)?;
        let error = one.terms.cost.error.unwrap_or(0.0);
        let mut spreads = Vec::with_capacity(VARIES.len());
        for varies in VARIES {
            let on = |what: &str| varies == what || varies == "all";
            let (mut samples, mut speedups) = (Vec::new(), Vec::new());
            for draw in 0..self.draws {
                let mut stream = Stream::new(self.seed, Role::Population, draw.into());
                // One draw at each of as many even steps of the viewers' law, the others at random: each source's
                // draws are the same whichever vary.
                let part = (f64::from(draw) + 0.5) / f64::from(self.draws);
                let [right, up, cost] = [(); 3].map(|()| stream.normal());
                let acuity = match on("viewers") {
                    true => Self::acuity_for(part)?,
                    false => acuity,
                };
                let off = self.tracker_sd_deg * math::hypot(right, up);
                let margin = match on("tracker") {
                    true => (margin_deg + off).min(90.0),
                    false => margin_deg,
                };
                let row = match on("viewers") || on("tracker") && off > 0.0 {
                    true => made(acuity, margin)?,
                    false => own.clone(),
                };
                let factor = match on("cost") {
                    true => math::exp(-error * cost),
                    false => 1.0,
                };
                samples.push(row.sample_ratio());
                speedups.push(row.needs().speedup() * factor);
            }
            let percentiles = |mut values: Vec<f64>| {
                values.sort_by(f64::total_cmp);
                [0.1, 0.5, 0.9].map(|q| quantile_sorted(&values, q))
            };
            spreads.push(SavingsSpreadRow {
                row: own.clone(),
                varies,
                sample_ratio: percentiles(samples),
                speedup: percentiles(speedups),
            });
        }
        Ok(spreads)
    }
}

impl SavingsSpreadRow {
    /// One row each.
    pub fn table(rows: &[Self]) -> Table {
        let mut table = Table::new([
            "method",
            "display",
            "fov_h_deg",
            "margin_deg",
            "varies",
            "sample_ratio_p10",
            "sample_ratio_p50",
            "sample_ratio_p90",
            "predicted_speedup_p10",
            "predicted_speedup_p50",
            "predicted_speedup_p90",
        ]);
        for row in rows {
            let mut cells = vec![
                row.row.method.to_string().into(),
                row.row.display.name.as_str().into(),
                row.row.display.fov_h_deg.into(),
                row.row.margin_deg.into(),
                row.varies.into(),
            ];
            cells.extend(row.sample_ratio.map(Into::into));
            cells.extend(row.speedup.map(Into::into));
            table.push(cells);
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use foveasim_models::{GazeMode, presets};

    use super::super::{GazeAt, SweepDisplay, Terms};
    use super::*;

    fn study(acuity: Acuity) -> Sweep {
        let lg = presets::display("lg-w2363d").unwrap();
        let mut terms = Terms::default();
        terms.cost.error = Some(0.1);
        Sweep {
            displays: vec![SweepDisplay::from(&lg)],
            acuities: vec![acuity],
            gazes: vec![GazeAt::Centre],
            gaze_mode: GazeMode::Tracked,
            margins_deg: vec![0.0],
            methods: Method::parse_list("layers:3").unwrap(),
            terms: Arc::new(terms),
        }
    }

    #[test]
    fn deviates_are_those_of_the_tables() {
        for (part, z) in [
            (0.5, 0.0),
            (0.9, 1.281_551_566),
            (0.95, 1.644_853_627),
            (0.1, -1.281_551_566),
        ] {
            assert!((deviate(part) - z).abs() < 1e-8, "{part}");
        }
    }

    /// methods.md §7: layers that satisfy 90 and 95 % of viewers save 4.86 and 4.52 times, where slope B saves 6.43.
    #[test]
    fn what_satisfies_most_viewers_saves_less() {
        let ratio = |acuity| study(acuity).rows(0).unwrap()[0].sample_ratio();
        for (part, want) in [(0.9, 4.86), (0.95, 4.52)] {
            let got = ratio(SavingsSpread::acuity_for(part).unwrap());
            assert!((got - want).abs() < 0.005, "{part}: {got}");
        }
        assert!((ratio(Acuity::new(foveasim_models::SLOPE_B).unwrap()) - 6.43).abs() < 0.005);
        for bad in [0.0, 1.0, -1.0, f64::NAN] {
            assert!(SavingsSpread::acuity_for(bad).is_err());
        }
    }

    #[test]
    fn each_source_spreads_and_all_of_them_do() {
        let spread = SavingsSpread {
            tracker_sd_deg: 0.5,
            draws: 199,
            seed: 1,
        };
        let rows = spread.run(&study(Acuity::default())).unwrap();
        assert_eq!(rows.iter().map(|r| r.varies).collect::<Vec<_>>(), VARIES);
        for row in &rows {
            assert!(row.speedup.is_sorted() && row.sample_ratio.is_sorted());
            assert!(row.speedup[2] > row.speedup[0], "{}", row.varies);
        }
        // The tenth percentile of savings is what suits nine viewers in ten.
        assert!(
            (rows[0].sample_ratio[0] - 4.86).abs() < 0.02,
            "{:?}",
            rows[0].sample_ratio
        );
        // Cost does not change samples; the margin only ever takes more.
        assert_eq!(rows[2].sample_ratio, [rows[2].row.sample_ratio(); 3]);
        assert!(rows[1].sample_ratio[2] < rows[1].row.sample_ratio());
        assert_eq!(spread.run(&study(Acuity::default())).unwrap(), rows);
        let none = SavingsSpread { draws: 0, ..spread };
        assert!(none.run(&study(Acuity::default())).is_err());
    }
}
