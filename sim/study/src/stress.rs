//! Numerical stability: closed forms and kernels over extreme inputs.

mod big;
mod kernels;
mod maps;
mod sampling;
mod times;
mod vision;

use foveasim_models::math::{log10, pow};
use foveasim_models::{Role, Stream};
use foveasim_reports::Table;
use rayon::prelude::*;

/// Every closed form and kernel over extreme inputs, against more digits or an identity that holds exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StressStudy {
    /// Inputs for each quantity; those that cost a thousand times more get fewer, at least four.
    pub inputs: u32,
    /// Of the inputs.
    pub seed: u64,
}

/// What one quantity came to.
#[derive(Debug, Clone, PartialEq)]
pub struct StressRow {
    /// What was computed.
    pub quantity: &'static str,
    /// `f64` or `f32`.
    pub precision: &'static str,
    /// What it was held against.
    pub against: &'static str,
    /// Over which inputs.
    pub over: &'static str,
    /// What the error is in.
    pub unit: &'static str,
    /// How many inputs.
    pub inputs: u64,
    /// The worst error; infinite if any result was not a number.
    pub worst: f64,
    /// What it may be.
    pub tolerance: f64,
    /// The input of the worst error.
    pub at: String,
}

impl StressRow {
    /// Whether the worst error is within the tolerance.
    pub fn holds(&self) -> bool {
        self.worst <= self.tolerance
    }
}

impl Default for StressStudy {
    fn default() -> Self {
        Self {
            inputs: 20_000,
            seed: 1,
        }
    }
}

impl StressStudy {
    /// Worst errors, in a fixed order; the same for any number of threads.
    pub fn run(&self) -> Vec<StressRow> {
        let checks: Vec<Check> = [
            vision::CHECKS,
            maps::CHECKS,
            times::CHECKS,
            sampling::CHECKS,
            kernels::CHECKS,
        ]
        .concat();
        let indexed = (0..).zip(&checks).collect::<Vec<(u64, &Check)>>();
        let row = |(index, check): (u64, &Check)| {
            let count = (self.inputs / check.costs).max(4);
            let mut draw = Draw(Stream::new(self.seed, Role::Stress, index));
            let (mut worst, mut at, mut inputs) = (f64::NEG_INFINITY, String::new(), 0);
            for step in 0..count {
                for trial in (check.trial)(&mut draw, step) {
                    inputs += 1;
                    let error = if trial.error.is_nan() {
                        f64::INFINITY
                    } else {
                        trial.error
                    };
                    if error > worst {
                        (worst, at) = (error, trial.input);
                    }
                }
            }
            StressRow {
                quantity: check.quantity,
                precision: check.precision,
                against: check.against,
                over: check.over,
                unit: check.unit,
                inputs,
                worst,
                tolerance: check.tolerance,
                at,
            }
        };
        indexed.into_par_iter().map(row).collect()
    }

    /// One row per quantity.
    pub fn table(rows: &[StressRow]) -> Table {
        let mut table = Table::new([
            "quantity",
            "precision",
            "against",
            "over",
            "inputs",
            "worst_error",
            "tolerance",
            "unit",
            "holds",
            "worst_at",
        ]);
        for row in rows {
            table.push(vec![
                row.quantity.into(),
                row.precision.into(),
                row.against.into(),
                row.over.into(),
                row.inputs.into(),
                row.worst.into(),
                row.tolerance.into(),
                row.unit.into(),
                if row.holds() { "yes" } else { "no" }.into(),
                row.at.as_str().into(),
            ]);
        }
        table
    }
}

/// How a quantity is checked.
#[derive(Clone, Copy)]
struct Check {
    quantity: &'static str,
    precision: &'static str,
    against: &'static str,
    over: &'static str,
    unit: &'static str,
    tolerance: f64,
    /// How many times fewer inputs are tried.
    costs: u32,
    /// Draws inputs, and says how far off each came.
    trial: fn(&mut Draw, u32) -> Vec<Trial>,
}

/// One input.
struct Trial {
    error: f64,
    input: String,
}

impl Trial {
    /// Of one input, named as people read it.
    fn of(error: f64, input: String) -> Vec<Self> {
        vec![Self { error, input }]
    }
}

/// Extreme inputs.
struct Draw(Stream);

impl Draw {
    /// Uniform.
    fn range(&mut self, low: f64, high: f64) -> f64 {
        self.0.range(low, high)
    }

    /// Of any magnitude between two positive ones.
    fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        let exponent = self.0.range(log10(low), log10(high));
        pow(10.0, exponent).clamp(low, high)
    }

    /// The same of either sign.
    fn signed(&mut self, low: f64, high: f64) -> f64 {
        let size = self.magnitude(low, high);
        if self.0.below(2) == 0 { size } else { -size }
    }

    /// Pixels along one side of a display: mostly ordinary ones, and 1 and 65,536.
    fn pixels(&mut self) -> u32 {
        match self.0.below(8) {
            0 => 1,
            1 => 65_536,
            _ => self.magnitude(1.0, 65_536.0) as u32,
        }
    }

    fn below(&mut self, n: u64) -> u64 {
        self.0.below(n)
    }
}

/// How far `value` is from `exact`, over `exact`.
fn relative(value: f64, exact: f64) -> f64 {
    if value == exact {
        0.0
    } else {
        (value - exact).abs() / exact.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quantity_is_within_its_tolerance() {
        let study = StressStudy {
            inputs: 2000,
            ..StressStudy::default()
        };
        let rows = study.run();
        assert!(rows.len() >= 20, "{}", rows.len());
        let wrong: Vec<_> = rows.iter().filter(|row| !row.holds()).collect();
        assert!(wrong.is_empty(), "{wrong:#?}");
        // Tolerances say something: none is ten million times what is found, unless nothing is.
        for row in &rows {
            assert!(row.inputs >= 4 && row.tolerance.is_finite());
            assert!(
                row.worst == 0.0 || row.worst > 1e-7 * row.tolerance,
                "{row:?}"
            );
        }
        assert_eq!(rows, study.run());
        assert_eq!(StressStudy::table(&rows).rows().len(), rows.len());
    }

    #[test]
    fn what_is_no_number_does_not_hold() {
        let row = StressRow {
            quantity: "",
            precision: "f64",
            against: "",
            over: "",
            unit: "",
            inputs: 1,
            worst: f64::INFINITY,
            tolerance: 1.0,
            at: String::new(),
        };
        assert!(!row.holds());
    }
}
