use std::collections::BTreeMap;

use foveasim_models::presets::Source;
use foveasim_models::{CostForm, CostProfile, FrameWork, ModelError};

use super::{Calibration, CostRow, log_error, non_negative_least_squares};

/// What is fixed \[ms\], then what each of [`FrameWork::TERMS`] takes \[ms\].
pub(super) type Coefficients = [f64; 5];

/// One coefficient of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficient {
    /// 0: what is fixed; else one more than the place in [`FrameWork::TERMS`].
    pub(super) place: usize,
    /// In [`Coefficient::unit`].
    pub(super) value: f64,
    /// 5th and 95th percentile of refits to resampled rows.
    pub interval: [f64; 2],
    /// Median relative error of rows that are left out, if this part of the work is not looked at; `None` for what
    /// is fixed. If it is no larger than with it, the part does not matter here.
    pub error_without: Option<f64>,
}

impl Coefficient {
    /// `fixed`, or the name of the part of work.
    pub fn name(&self) -> &'static str {
        match self.place {
            0 => "fixed",
            k => FrameWork::TERMS[k - 1],
        }
    }

    /// Milliseconds a frame, or for each unit of work.
    pub fn unit(&self) -> &'static str {
        match self.place {
            0 => "ms",
            _ => "ms each",
        }
    }

    /// Its value, in [`Coefficient::unit`].
    pub fn value(&self) -> f64 {
        self.value
    }
}

/// One form of cost, fitted to rows.
#[derive(Debug, Clone, PartialEq)]
pub struct CostFit {
    /// The form.
    pub form: CostForm,
    /// Its coefficients: what is fixed first.
    pub coefficients: Vec<Coefficient>,
    /// What it says of each row \[ms\].
    pub fitted_ms: Vec<f64>,
    /// What it says of each row when fitted to the others \[ms\].
    pub left_out_ms: Vec<f64>,
}

/// What a fit says of a frame \[ms\].
pub(super) fn time_ms(c: &Coefficients, work: &FrameWork, form: CostForm) -> f64 {
    let parts = work
        .terms()
        .into_iter()
        .zip(&c[1..])
        .map(|(n, each)| n * each);
    match form {
        CostForm::Sum => parts.fold(c[0], |sum, part| sum + part),
        CostForm::Largest => c[0] + parts.fold(0.0, f64::max),
    }
}

/// The coefficients with the least squares of relative errors, of parts of work in `terms`.
pub(super) fn fitted(rows: &[&CostRow], terms: &[usize], form: CostForm) -> Coefficients {
    match form {
        CostForm::Sum => least(rows, terms, None),
        CostForm::Largest => largest(rows, terms),
    }
}

/// `stage`: the only part of work that each row is charged for.
fn least(rows: &[&CostRow], terms: &[usize], stage: Option<&[usize]>) -> Coefficients {
    let relative = |(i, row): (usize, &&CostRow)| -> Vec<f64> {
        let charged = |k: usize| stage.is_none_or(|s| s[i] == k);
        let part = |&k: &usize| match charged(k) {
            true => row.work.terms()[k] / row.time_ms,
            false => 0.0,
        };
        std::iter::once(1.0 / row.time_ms)
            .chain(terms.iter().map(part))
            .collect()
    };
    let matrix: Vec<Vec<f64>> = rows.iter().enumerate().map(relative).collect();
    let x = non_negative_least_squares(&matrix, &vec![1.0; rows.len()]);
    let mut c = [0.0; 5];
    c[0] = x[0];
    for (k, v) in terms.iter().zip(&x[1..]) {
        c[k + 1] = *v;
    }
    c
}

/// Rounds of assigning rows to stages and fitting the stages, until rows stay where they are.
const ROUNDS: usize = 50;

/// Which stage decides a row is not known, and which fit is best depends on it: rows are charged for the stage that
/// decides by the fit so far, and fitted again. It begins from the sum's coefficients and from each stage alone;
/// the best end is taken, which need not be the best there is.
fn largest(rows: &[&CostRow], terms: &[usize]) -> Coefficients {
    let squares = |c: &Coefficients| -> f64 {
        let error = |r: &&CostRow| time_ms(c, &r.work, CostForm::Largest) / r.time_ms - 1.0;
        rows.iter().map(error).map(|e| e * e).sum()
    };
    let sum = least(rows, terms, None);
    let alone = terms.iter().map(|k| least(rows, &[*k], None));
    let mut best = (f64::INFINITY, sum);
    for begin in std::iter::once(sum).chain(alone) {
        let mut c = begin;
        let mut before: Option<Vec<usize>> = None;
        for _ in 0..ROUNDS {
            let found = squares(&c);
            if found < best.0 {
                best = (found, c);
            }
            let decides = |row: &&CostRow| {
                let part = |k: usize| row.work.terms()[k] * c[k + 1];
                let first = terms.first().copied().unwrap_or(0);
                terms
                    .iter()
                    .fold(first, |a, &b| if part(b) > part(a) { b } else { a })
            };
            let stages: Vec<usize> = rows.iter().map(decides).collect();
            if before.as_ref() == Some(&stages) {
                break;
            }
            c = least(rows, terms, Some(&stages));
            before = Some(stages);
        }
    }
    best.1
}

impl Calibration {
    /// A named profile of one of the fits, that says what it rests on.
    ///
    /// # Errors
    /// If a coefficient is out of the range of profiles.
    pub fn profile(
        &self,
        fit: &CostFit,
        name: &str,
        origin: &str,
    ) -> Result<CostProfile, ModelError> {
        let of = |name: &str| {
            let found = fit.coefficients.iter().find(|c| c.name() == name);
            found.map_or(0.0, |c| c.value)
        };
        let all: Vec<&CostRow> = self.rows.rows.iter().collect();
        let error = log_error(&all, &fit.left_out_ms);
        let title = format!(
            "fitted to {} rows of {origin}, {} form; rows left out differ by {}",
            all.len(),
            fit.form.name(),
            error.map_or("more than can be said".into(), |e| format!(
                "{:.1} %",
                100.0 * e
            )),
        );
        let source = |c: &Coefficient| {
            let [low, high] = c.interval;
            let text = format!(
                "`foveasim calibrate {origin}`: {low:.4e} to {high:.4e} ms in 90 % of refits"
            );
            Source {
                source: text,
                unverified: false,
            }
        };
        let fields = [
            ("fixed", "fixed_ms"),
            ("samples_shaded", "per_sample_ns"),
            ("samples", "per_visible_sample_ns"),
            ("pixels_resolved", "per_pixel_ns"),
            ("passes", "per_pass_ms"),
        ];
        let sources = fit.coefficients.iter().filter_map(|c| {
            let field = fields.iter().find(|(term, _)| *term == c.name())?.1;
            Some((field.to_owned(), source(c)))
        });
        let fitted: BTreeMap<String, [f64; 2]> = self
            .ranges()
            .into_iter()
            .map(|(n, r)| (n.to_owned(), r))
            .collect();
        CostProfile {
            name: name.to_owned(),
            title,
            form: fit.form,
            fixed_ms: of("fixed"),
            per_sample_ns: of("samples_shaded") * 1e6,
            per_pixel_ns: of("pixels_resolved") * 1e6,
            per_visible_sample_ns: of("samples") * 1e6,
            per_pass_ms: of("passes"),
            fitted,
            error,
            energy: None,
            sources: sources.collect(),
        }
        .validate()
    }
}
