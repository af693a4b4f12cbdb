use foveasim_models::foveation::Method;
use foveasim_models::math::quantile_sorted;
use foveasim_reports::{Cell, ScatterChart, ScatterSeries, Table};

use super::{HeldOutFor, VerifyRow};

/// What a [`Verify`](super::Verify) found.
#[derive(Debug, Clone, PartialEq)]
pub struct VerifyOutcome {
    /// Every cell that was drawn.
    pub rows: Vec<VerifyRow>,
    /// What each part of a frame's work takes: milliseconds for each millisecond of the probe, and for each thing counted.
    pub coefficients: Vec<(&'static str, f64)>,
    /// Processor time of a probe: all small pictures of one view, each once \[ms\].
    pub probe_ms: f64,
    /// How often each cell was drawn.
    pub rounds: u32,
}

/// Errors of some cells.
struct Errors {
    count: usize,
    median: f64,
    p90: f64,
    /// Median of predicted over measured: 1 if there is no bias.
    bias: f64,
    naive_median: f64,
    naive_p90: f64,
    covered: f64,
    noise: f64,
    ratios: Vec<[f64; 2]>,
}

impl VerifyOutcome {
    /// Cells that are held out.
    pub fn held_out(&self) -> impl Iterator<Item = &VerifyRow> {
        self.rows.iter().filter(|r| r.held_out.is_some())
    }

    /// Absolute relative errors of speedups over full resolution, predicted and by the naive rule: of the row's cell, both
    /// of whose frames were drawn. `None` for full resolution itself.
    pub(super) fn ratio_errors(&self, row: &VerifyRow) -> Option<[f64; 2]> {
        if row.method == Method::Full {
            return None;
        }
        let same = |r: &&VerifyRow| {
            r.method == Method::Full && r.scene == row.scene && r.group == row.group
        };
        let full = self.rows.iter().find(same)?;
        let ratio = |f: fn(&VerifyRow) -> f64| f(full) / f(row);
        let measured = ratio(|r| r.measured_ms);
        let off = |predicted: f64| (predicted / measured - 1.0).abs();
        Some([off(ratio(|r| r.predicted_ms)), off(ratio(|r| r.naive_ms))])
    }

    fn errors<'a>(&self, rows: impl Iterator<Item = &'a VerifyRow>) -> Errors {
        let rows: Vec<&VerifyRow> = rows.collect();
        let of = |f: &dyn Fn(&VerifyRow) -> f64, q: f64| {
            quantile(rows.iter().map(|r| f(r)).collect(), q)
        };
        let covered = rows.iter().filter(|r| r.is_covered()).count();
        Errors {
            count: rows.len(),
            median: of(&|r| r.error().abs(), 0.5),
            p90: of(&|r| r.error().abs(), 0.9),
            bias: of(&|r| r.predicted_ms / r.measured_ms, 0.5),
            naive_median: of(&|r| r.naive_error().abs(), 0.5),
            naive_p90: of(&|r| r.naive_error().abs(), 0.9),
            covered: covered as f64 / rows.len() as f64,
            noise: of(&|r| r.noise, 0.5),
            ratios: rows.iter().filter_map(|r| self.ratio_errors(r)).collect(),
        }
    }

    /// Errors of the cells that are held out, all and by why, and of those that are fitted.
    pub fn summary(&self) -> Table {
        let mut table = Table::new([
            "cells",
            "count",
            "median_error",
            "p90_error",
            "bias",
            "speedup_median_error",
            "covered_by_90_percent",
            "naive_median_error",
            "naive_p90_error",
            "naive_speedup_median_error",
            "noise_floor",
        ]);
        let mut push = |name: String, e: Errors| {
            let known = |v: f64| {
                if v.is_finite() {
                    Cell::Float(v)
                } else {
                    Cell::Empty
                }
            };
            let ratio = |k: usize| quantile(e.ratios.iter().map(|r| r[k]).collect(), 0.5);
            table.push(vec![
                name.into(),
                e.count.into(),
                known(e.median),
                known(e.p90),
                known(e.bias),
                known(ratio(0)),
                known(e.covered),
                known(e.naive_median),
                known(e.naive_p90),
                known(ratio(1)),
                known(e.noise),
            ]);
        };
        push("held out".into(), self.errors(self.held_out()));
        for why in [
            HeldOutFor::Scene,
            HeldOutFor::Method,
            HeldOutFor::Size,
            HeldOutFor::Share,
        ] {
            let of_it = || self.rows.iter().filter(|r| r.held_out == Some(why));
            if of_it().count() > 0 {
                push(format!("held out: {}", why.name()), self.errors(of_it()));
            }
        }
        push(
            "fitted".into(),
            self.errors(self.rows.iter().filter(|r| r.held_out.is_none())),
        );
        table
    }

    /// One sentence: what the cells that are held out say.
    pub fn sentence(&self) -> String {
        let e = self.errors(self.held_out());
        let ratio = quantile(e.ratios.iter().map(|r| r[0]).collect(), 0.5);
        let percent = |v: f64| format!("{:.1} %", 100.0 * v);
        let against = if e.median < e.naive_median {
            "better"
        } else {
            "no better"
        };
        format!(
            "Of {} cells that no fit has seen, the time of half is predicted within {} and of nine in ten within {} (speedups: half within {}); \
             {} lie in their 90 % intervals; equal draws differ by {}. That is {against} than taking time to go with shaded samples ({}).",
            e.count,
            percent(e.median),
            percent(e.p90),
            percent(ratio),
            percent(e.covered),
            percent(e.noise),
            percent(e.naive_median),
        )
    }

    /// Every cell.
    pub fn table(&self) -> Table {
        let columns = [
            "scene",
            "display",
            "fov_h_deg",
            "width_px",
            "height_px",
            "method",
            "plan_samples",
            "plan_shadings",
            "held_out",
            "measured_ms",
            "noise",
            "predicted_ms",
            "low_ms",
            "high_ms",
            "naive_ms",
        ];
        let terms = self
            .coefficients
            .iter()
            .map(|(name, _)| format!("term_{name}"));
        let mut table = Table::new(columns.map(str::to_owned).into_iter().chain(terms));
        for r in &self.rows {
            let mut cells = vec![
                r.scene.as_str().into(),
                r.display.as_str().into(),
                r.fov_deg.into(),
                r.size[0].into(),
                r.size[1].into(),
                r.method.to_string().into(),
                r.samples.into(),
                r.shadings.into(),
                r.held_out.map(HeldOutFor::name).into(),
                r.measured_ms.into(),
                r.noise.into(),
                r.predicted_ms.into(),
                r.interval_ms[0].into(),
                r.interval_ms[1].into(),
                r.naive_ms.into(),
            ];
            cells.extend(r.terms.iter().map(|t| Cell::Float(*t)));
            table.push(cells);
        }
        table
    }

    /// What the fit found.
    pub fn coefficients(&self) -> Table {
        let mut table = Table::new(["term", "coefficient", "unit"]);
        for (name, value) in &self.coefficients {
            let unit = if name.ends_with("_ms") {
                "ms for each of the probe"
            } else {
                "ms each"
            };
            table.push(vec![(*name).into(), (*value).into(), unit.into()]);
        }
        table
    }

    /// Predicted over measured time, those that are held out apart.
    pub fn scatter(&self) -> ScatterChart {
        let series = |label: &str, held_out: bool| ScatterSeries {
            label: label.into(),
            points: self
                .rows
                .iter()
                .filter(|r| r.held_out.is_some() == held_out)
                .map(|r| [r.measured_ms, r.predicted_ms])
                .collect(),
            names: Vec::new(),
            hollow: !held_out,
        };
        ScatterChart {
            title: "Predicted and measured time of a frame".into(),
            x_label: "processor time, measured [ms]".into(),
            y_label: "predicted [ms]".into(),
            logarithmic: [true, true],
            series: vec![series("held out", true), series("fitted", false)],
            line: None,
            identity: Some("as measured".into()),
        }
    }
}

/// NaN of none.
fn quantile(mut values: Vec<f64>, q: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    quantile_sorted(&values, q)
}
