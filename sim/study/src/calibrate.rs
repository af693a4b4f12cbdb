//! What work costs, fitted to measured frames.

mod fit;
mod nnls;
mod rows;

pub use fit::{Coefficient, CostFit};
pub use nnls::non_negative_least_squares;
pub use rows::{CostRow, CostRows};

use foveasim_models::math::{log, mean, quantile_sorted, sqrt};
use foveasim_models::{CostForm, FrameWork, ModelError, Role, Stream};
use foveasim_reports::{Cell, LineChart, LineSeries, Table};

use fit::fitted;

/// Fits of both forms of cost (methods.md §7) to the same rows, with what each is worth.
///
/// The squares of relative errors are least, with no coefficient negative; so a frame of a millisecond counts as
/// much as one of thirty.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The rows.
    pub rows: CostRows,
    /// One fit for each of [`CostForm::ALL`].
    pub fits: Vec<CostFit>,
    /// The rule that time goes with samples: time over shaded samples (or those of visibility), each row predicted
    /// by the others. `None` where no samples are given.
    pub naive: Option<Vec<f64>>,
}

/// Refits of resampled rows from which the intervals of coefficients come.
const RESAMPLED: u64 = 400;

/// The fewest rows beyond those that a fit has coefficients.
const SPARE_ROWS: usize = 1;

impl Calibration {
    /// Fits both forms to `rows`. Coefficients have intervals from 400 refits to as many rows drawn from them with
    /// replacement (the bootstrap; 5th to 95th percentile), by `seed`.
    ///
    /// # Errors
    /// If there are not more rows than coefficients.
    pub fn new(rows: CostRows, seed: u64) -> Result<Self, ModelError> {
        let n = rows.rows.len();
        let least = rows.terms.len() + 1 + SPARE_ROWS;
        if n < least {
            let valid = format!("at least {least}: as many as coefficients, and one more");
            return Err(ModelError::range("measured rows", n, valid));
        }
        let all: Vec<&CostRow> = rows.rows.iter().collect();
        let fits = CostForm::ALL
            .into_iter()
            .map(|form| {
                let profile = fitted(&all, &rows.terms, form);
                let without = |terms: &[usize]| left_out(&all, terms, form);
                let predicted = without(&rows.terms);
                let resampled: Vec<[f64; 5]> = (0..RESAMPLED)
                    .map(|draw| {
                        let mut stream = Stream::new(seed, Role::Population, draw);
                        let some: Vec<&CostRow> = (0..n)
                            .map(|_| all[stream.below(n as u64) as usize])
                            .collect();
                        fitted(&some, &rows.terms, form)
                    })
                    .collect();
                let places = std::iter::once(0).chain(rows.terms.iter().map(|k| k + 1));
                let coefficients = places.map(|place| {
                    let mut values: Vec<f64> = resampled.iter().map(|c| c[place]).collect();
                    values.sort_by(f64::total_cmp);
                    let others: Vec<usize> = rows
                        .terms
                        .iter()
                        .copied()
                        .filter(|k| k + 1 != place)
                        .collect();
                    let leaving = match place {
                        0 => None,
                        _ => Some(median_error(&all, &without(&others))),
                    };
                    Coefficient {
                        place,
                        value: profile[place],
                        interval: [0.05, 0.95].map(|q| quantile_sorted(&values, q)),
                        error_without: leaving,
                    }
                });
                CostFit {
                    form,
                    coefficients: coefficients.collect(),
                    fitted_ms: all
                        .iter()
                        .map(|r| fit::time_ms(&profile, &r.work, form))
                        .collect(),
                    left_out_ms: predicted,
                }
            })
            .collect();
        let naive = naive(&all, &rows.terms);
        Ok(Self { rows, fits, naive })
    }

    /// The fit whose rows, each left out, are predicted best: by the median of relative errors.
    pub fn best(&self) -> &CostFit {
        let errors = |fit: &&CostFit| median_error(&self.measured(), &fit.left_out_ms);
        let best = self
            .fits
            .iter()
            .min_by(|a, b| errors(a).total_cmp(&errors(b)));
        best.expect("both forms are fitted")
    }

    fn measured(&self) -> Vec<&CostRow> {
        self.rows.rows.iter().collect()
    }

    /// The smallest and largest value of each part of work that is given.
    pub fn ranges(&self) -> Vec<(&'static str, [f64; 2])> {
        let range = |&k: &usize| {
            let values = self.rows.rows.iter().map(|r| r.work.terms()[k]);
            let ends = values.fold([f64::INFINITY, 0.0], |[a, b], v| [a.min(v), f64::max(b, v)]);
            (FrameWork::TERMS[k], ends)
        };
        self.rows.terms.iter().map(range).collect()
    }

    /// One row for each coefficient of each form.
    pub fn coefficients(&self) -> Table {
        let mut table = Table::new([
            "form",
            "term",
            "coefficient",
            "p5",
            "p95",
            "unit",
            "median_error_without_term",
            "median_error",
        ]);
        for fit in &self.fits {
            let error = median_error(&self.measured(), &fit.left_out_ms);
            for c in &fit.coefficients {
                table.push(vec![
                    fit.form.name().into(),
                    c.name().into(),
                    c.value.into(),
                    c.interval[0].into(),
                    c.interval[1].into(),
                    c.unit().into(),
                    c.error_without.into(),
                    error.into(),
                ]);
            }
        }
        table
    }

    /// How well each form, and the rule that time goes with samples, predict rows they were not fitted to.
    pub fn errors(&self) -> Table {
        let mut table = Table::new([
            "model",
            "rows",
            "median_error",
            "p90_error",
            "max_error",
            "sd_of_log",
        ]);
        let all = self.measured();
        let mut push = |name: &str, predicted: &[f64]| {
            let errors = sorted_errors(&all, predicted);
            let most = errors.last().copied().unwrap_or(f64::NAN);
            table.push(vec![
                name.into(),
                all.len().into(),
                quantile_sorted(&errors, 0.5).into(),
                quantile_sorted(&errors, 0.9).into(),
                most.into(),
                log_error(&all, predicted).map_or(Cell::Empty, Into::into),
            ]);
        };
        for fit in &self.fits {
            push(
                &format!("{}, each row left out", fit.form.name()),
                &fit.left_out_ms,
            );
            push(
                &format!("{}, the rows it is fitted to", fit.form.name()),
                &fit.fitted_ms,
            );
        }
        if let Some(naive) = &self.naive {
            push("time goes with samples, each row left out", naive);
        }
        table
    }

    /// Every row with what each form says of it when it is left out \[ms\].
    pub fn predictions(&self) -> Table {
        let mut columns = vec!["name".to_owned(), "group".to_owned(), "time_ms".to_owned()];
        columns.extend(
            self.fits
                .iter()
                .map(|f| format!("{}_left_out_ms", f.form.name())),
        );
        columns.extend(
            self.fits
                .iter()
                .map(|f| format!("{}_fitted_ms", f.form.name())),
        );
        let mut table = Table::new(columns);
        for (i, row) in self.rows.rows.iter().enumerate() {
            let mut cells = vec![
                row.name.as_str().into(),
                row.group.as_str().into(),
                row.time_ms.into(),
            ];
            cells.extend(self.fits.iter().map(|f| Cell::Float(f.left_out_ms[i])));
            cells.extend(self.fits.iter().map(|f| Cell::Float(f.fitted_ms[i])));
            table.push(cells);
        }
        table
    }

    /// Relative errors of rows that were left out, over the measured time: a dot each.
    pub fn residuals(&self) -> LineChart {
        let series = self.fits.iter().map(|fit| {
            let mut dots: Vec<[f64; 2]> = self
                .rows
                .rows
                .iter()
                .zip(&fit.left_out_ms)
                .map(|(row, ms)| [row.time_ms, 100.0 * (ms / row.time_ms - 1.0)])
                .collect();
            dots.sort_by(|a, b| a[0].total_cmp(&b[0]));
            // A point that is not finite parts its neighbours.
            let points = dots.into_iter().flat_map(|p| [p, [p[0], f64::NAN]]);
            LineSeries {
                label: format!("{} form", fit.form.name()),
                points: points.collect(),
            }
        });
        LineChart {
            title: "Errors of rows that were left out".into(),
            x_label: "measured time [ms]".into(),
            y_label: "error [%]".into(),
            series: series.collect(),
            levels: vec![(0.0, "as measured".into())],
            ..LineChart::default()
        }
    }
}

/// What each row would take \[ms\], by a fit to the others.
fn left_out(all: &[&CostRow], terms: &[usize], form: CostForm) -> Vec<f64> {
    let one = |i: usize| {
        let mut others = all.to_vec();
        let row = others.remove(i);
        fit::time_ms(&fitted(&others, terms, form), &row.work, form)
    };
    (0..all.len()).map(one).collect()
}

/// Time over samples, and nothing else, by the other rows.
fn naive(all: &[&CostRow], terms: &[usize]) -> Option<Vec<f64>> {
    let term = *terms.iter().find(|k| **k < 2)?;
    let one = |i: usize| {
        let others = all.iter().enumerate().filter(|(j, _)| *j != i);
        let rows: Vec<_> = others
            .map(|(_, r)| vec![r.work.terms()[term] / r.time_ms])
            .collect();
        let each = non_negative_least_squares(&rows, &vec![1.0; rows.len()])[0];
        each * all[i].work.terms()[term]
    };
    Some((0..all.len()).map(one).collect())
}

/// |predicted/measured − 1|, ascending.
fn sorted_errors(all: &[&CostRow], predicted: &[f64]) -> Vec<f64> {
    let errors = all
        .iter()
        .zip(predicted)
        .map(|(r, p)| (p / r.time_ms - 1.0).abs());
    let mut errors: Vec<f64> = errors.collect();
    errors.sort_by(f64::total_cmp);
    errors
}

fn median_error(all: &[&CostRow], predicted: &[f64]) -> f64 {
    quantile_sorted(&sorted_errors(all, predicted), 0.5)
}

/// Standard deviation of the logarithm of measured over predicted; `None` if a prediction is 0.
fn log_error(all: &[&CostRow], predicted: &[f64]) -> Option<f64> {
    let logs = all.iter().zip(predicted).map(|(r, p)| log(r.time_ms / p));
    let squares: Vec<f64> = logs.map(|l| l * l).collect();
    Some(sqrt(mean(&squares))).filter(|e| e.is_finite())
}

#[cfg(test)]
mod tests;
