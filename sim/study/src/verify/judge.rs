use std::collections::BTreeSet;

use super::choice::{HeldOut, kind};
use super::model::{Known, TimeModel};
use super::terms::TERMS;
use super::{Cell, HeldOutFor, Verify, VerifyOutcome, VerifyRow, pixels};
use crate::calibrate::non_negative_least_squares;
use crate::measure::Measured;

impl Verify<'_> {
    fn held_out(&self, cells: &[Cell<'_>]) -> HeldOut {
        let sizes: BTreeSet<u64> = cells.iter().map(|c| pixels(&c.viewport)).collect();
        // Of a method that no cell has, any kind will do: there is nothing of it to hold out.
        let methods = self.sweep.methods.iter().enumerate().map(|(k, method)| {
            let of_it = cells.iter().find(|c| c.pick.method == k);
            let kind = of_it.map_or_else(String::new, |c| kind(&c.job.frames[0].plan));
            (*method, kind)
        });
        HeldOut::draw(
            self.scenes.len(),
            &methods.collect::<Vec<_>>(),
            &sizes,
            self.seed,
        )
    }

    /// Splits cells into those that are fitted and those held out, and predicts all.
    pub(super) fn judge(
        &self,
        cells: &[Cell<'_>],
        measured: &[Measured],
        probe_ms: f64,
    ) -> VerifyOutcome {
        let held = self.held_out(cells);
        let mut why: Vec<Option<HeldOutFor>> = cells
            .iter()
            .map(|c| {
                if held.scenes.contains(&c.pick.scene) {
                    Some(HeldOutFor::Scene)
                } else if held.methods.contains(&c.pick.method) {
                    Some(HeldOutFor::Method)
                } else {
                    let largest = held.pixels == Some(pixels(&c.viewport));
                    largest.then_some(HeldOutFor::Size)
                }
            })
            .collect();
        // At most half are fitted; those beyond are every so manieth one of what is left.
        let left: Vec<usize> = (0..cells.len()).filter(|&i| why[i].is_none()).collect();
        let beyond = left.len().saturating_sub(cells.len() / 2);
        for k in 0..beyond {
            why[left[(2 * k + 1) * left.len() / (2 * beyond)]] = Some(HeldOutFor::Share);
        }
        let known: Vec<Known> = cells
            .iter()
            .zip(measured)
            .zip(&why)
            .filter(|(_, why)| why.is_none())
            .map(|((cell, measured), _)| Known {
                terms: cell.terms,
                ms: measured.frame_ms(),
                group: cell.pick.scene,
            })
            .collect();
        let model = TimeModel::fitted(&known);
        let counts = |c: &Cell<'_>| c.job.frames[0].plan.count();
        let fitted = cells
            .iter()
            .zip(measured)
            .zip(&why)
            .filter(|(_, why)| why.is_none());
        let inverse: Vec<[f64; 2]> = fitted
            .map(|((c, m), _)| [counts(c).shadings() as f64 / m.frame_ms(), 1.0])
            .collect();
        let (matrix, wanted): (Vec<_>, Vec<_>) =
            inverse.into_iter().map(|[r, one]| (vec![r], one)).unzip();
        let each = non_negative_least_squares(&matrix, &wanted);
        let per_shading = each.first().copied().unwrap_or(f64::NAN);
        let rows = cells
            .iter()
            .zip(measured)
            .zip(why)
            .map(|((cell, measured), held_out)| {
                let count = counts(cell);
                let predicted_ms = model.ms(&cell.terms);
                let (name, fov_deg) = self.sweep.named(cell.pick.group);
                VerifyRow {
                    scene: self.scenes[cell.pick.scene].name.clone(),
                    display: name.to_owned(),
                    fov_deg,
                    size: cell.viewport.size.to_array(),
                    group: cell.pick.group,
                    method: self.sweep.methods[cell.pick.method],
                    samples: count.samples(),
                    shadings: count.shadings(),
                    held_out,
                    measured_ms: measured.frame_ms(),
                    noise: measured.noise(),
                    predicted_ms,
                    interval_ms: model.interval(predicted_ms),
                    naive_ms: per_shading * count.shadings() as f64,
                    terms: cell.terms.to_vec(),
                }
            });
        VerifyOutcome {
            rows: rows.collect(),
            coefficients: TERMS.into_iter().zip(model.coefficients).collect(),
            probe_ms,
            rounds: self.rounds,
        }
    }
}
