use foveasim_models::math::{exp, log, quantile_sorted};

use super::terms::{TERMS, Terms};
use crate::calibrate::non_negative_least_squares;

/// Frame time as a sum of what each term takes, none below 0: fitted so that the squares of relative errors are least.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TimeModel {
    /// Milliseconds for each of [`TERMS`].
    pub(super) coefficients: Terms,
    /// How far the logarithm of a new frame's time may be from that predicted: 90 % of frames are within.
    pub(super) spread: f64,
}

/// A frame whose time is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Known {
    pub(super) terms: Terms,
    pub(super) ms: f64,
    /// What it belongs to: all rows of a group are left out together.
    pub(super) group: usize,
}

/// The share of new frames that an interval is to hold.
pub(super) const COVERED: f64 = 0.9;

impl TimeModel {
    /// The fit to `rows`. Its spread comes from rows that were left out: those of each group predicted by the other
    /// groups (each row by the others, if there is one group), and the quantile that conformal prediction takes of
    /// their errors (Vovk, Gammerman & Shafer 2005; Barber et al. 2021, §2).
    pub(super) fn fitted(rows: &[Known]) -> Self {
        let all: Vec<&Known> = rows.iter().collect();
        let one_group = rows.windows(2).all(|w| w[0].group == w[1].group);
        let group = |i: usize| if one_group { i } else { rows[i].group };
        let mut groups: Vec<usize> = (0..rows.len()).map(group).collect();
        groups.sort_unstable();
        groups.dedup();
        let mut errors = Vec::with_capacity(rows.len());
        for left_out in groups {
            let (out, others): (Vec<_>, Vec<_>) =
                (0..rows.len()).partition(|i| group(*i) == left_out);
            let others: Vec<&Known> = others.into_iter().map(|i| &rows[i]).collect();
            let coefficients = least(&others);
            for row in out.into_iter().map(|i| &rows[i]) {
                errors.push(log(row.ms / time_ms(&coefficients, &row.terms)).abs());
            }
        }
        errors.sort_by(f64::total_cmp);
        let n = errors.len() as f64;
        // Of n errors and the next one, that is as likely to be any of the n + 1 in order.
        let share = (COVERED * (n + 1.0) / n).min(1.0);
        Self {
            coefficients: least(&all),
            spread: quantile_sorted(&errors, share),
        }
    }

    /// Time of a frame \[ms\].
    pub(super) fn ms(&self, terms: &Terms) -> f64 {
        time_ms(&self.coefficients, terms)
    }

    /// Where nine in ten frames that are predicted so lie \[ms\].
    pub(super) fn interval(&self, ms: f64) -> [f64; 2] {
        [ms * exp(-self.spread), ms * exp(self.spread)]
    }
}

fn time_ms(coefficients: &Terms, terms: &Terms) -> f64 {
    let parts = coefficients.iter().zip(terms).map(|(c, t)| c * t);
    parts.fold(0.0, |sum, part| sum + part)
}

fn least(rows: &[&Known]) -> Terms {
    let relative = |row: &&Known| row.terms.iter().map(|t| t / row.ms).collect();
    let matrix: Vec<Vec<f64>> = rows.iter().map(relative).collect();
    let found = non_negative_least_squares(&matrix, &vec![1.0; rows.len()]);
    let mut coefficients = [0.0; TERMS.len()];
    coefficients[..found.len()].copy_from_slice(&found);
    coefficients
}

#[cfg(test)]
mod tests {
    use foveasim_models::{Role, Stream};

    use super::*;

    fn rows(count: u64, noise: f64, seed: u64) -> Vec<Known> {
        let row = |i: u64| {
            let mut stream = Stream::new(seed, Role::Population, i);
            let terms: Terms = std::array::from_fn(|_| stream.uniform() + 0.1);
            let ms = 2.0 * terms[0] + 3.0 * terms[7] + 0.5 * terms[9];
            Known {
                terms,
                ms: ms * exp(noise * stream.normal()),
                group: i as usize % 5,
            }
        };
        (0..count).map(row).collect()
    }

    #[test]
    fn what_times_are_made_of_is_found() {
        let model = TimeModel::fitted(&rows(60, 0.0, 1));
        for (k, expected) in [(0, 2.0), (7, 3.0), (9, 0.5), (4, 0.0)] {
            assert!(
                (model.coefficients[k] - expected).abs() < 1e-6,
                "{:?}",
                model.coefficients
            );
        }
        assert!(model.spread < 1e-6);
    }

    #[test]
    fn intervals_hold_as_many_as_they_promise() {
        let model = TimeModel::fitted(&rows(200, 0.1, 1));
        let new = rows(1000, 0.1, 2);
        let held = new.iter().filter(|row| {
            let [low, high] = model.interval(model.ms(&row.terms));
            (low..=high).contains(&row.ms)
        });
        let share = held.count() as f64 / 1000.0;
        assert!((0.86..0.95).contains(&share), "{share}");
    }
}
