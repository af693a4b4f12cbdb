//! Fig. 5: from an eye movement to its light, best and worst case.

use foveasim_models::presets;
use foveasim_pipeline::{Interval, Stage, SyncMode};
use foveasim_reports::{BarChart, BarSeries, Table};

use super::ReproduceError;
use super::paper::LATENCY;
use crate::reproduce::{Paper, Printed, Published};
use crate::{LatencyStudy, QUANTITIES, Quantity, Rows};

/// Fig. 5 beside the pipeline's own bounds for the study's set-up.
#[derive(Debug, Clone, PartialEq)]
pub struct LatencyBars {
    /// One per bar of the paper, then all together.
    pub rows: Vec<LatencyRow>,
}

/// One bar of Fig. 5.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LatencyRow {
    /// What takes time.
    pub name: &'static str,
    /// Shortest and longest by the pipeline's bounds \[ms\].
    pub ours_ms: [f64; 2],
    /// As printed \[ms\].
    pub paper_ms: [f64; 2],
}

impl LatencyBars {
    /// The bounds of the study's set-up: 300 Hz tracker, rendering for one refresh of 120 Hz, tearing,
    /// an inner layer of 200 of 1080 rows about the middle, 6 ms pixel switching.
    ///
    /// Stages belong to bars as the paper's text does: the tracker's bar begins with the exposure that
    /// sees the movement, the render bar holds the wait for the frame that is being drawn. The scan's
    /// bar is what the last row of the inner layer to be renewed takes.
    ///
    /// # Errors
    /// None that the embedded presets can cause.
    pub fn new() -> Result<Self, ReproduceError> {
        let display = presets::display("lg-w2363d")?;
        let tracker = presets::tracker("tx300")?;
        let study = LatencyStudy::new(display, tracker, SyncMode::Tearing, None, None)?;
        let bounds = study.bounds();
        let of = |q: Quantity| bounds[q.index()];
        let stages =
            |list: &[Stage]| -> Interval { list.iter().map(|s| of(Quantity::Stage(*s))).sum() };
        debug_assert_eq!(bounds.len(), QUANTITIES.len());
        let tracker = stages(&[
            Stage::TrackerWait,
            Stage::TrackerExposure,
            Stage::TrackerProcessing,
        ]);
        let render = stages(&[Stage::FrameWait, Stage::Render, Stage::FlipWait]);
        let response = stages(&[Stage::PixelResponse]);
        let total = of(Quantity::Gaze(Rows::Last));
        let before = tracker + render + response;
        let scan = Interval::new(total.min - before.min, total.max - before.max);
        let ms = |i: Interval| [i.min.as_ms(), i.max.as_ms()];
        let ours = [tracker, render, scan, response].map(ms);
        let mut rows: Vec<LatencyRow> = LATENCY
            .iter()
            .zip(ours)
            .map(|(bar, ours_ms)| LatencyRow {
                name: bar.name,
                ours_ms,
                paper_ms: [bar.best_ms, bar.worst_ms],
            })
            .collect();
        rows.push(LatencyRow {
            name: "together",
            ours_ms: ms(total),
            paper_ms: [0, 1].map(|k| rows.iter().map(|r| r.paper_ms[k]).sum()),
        });
        Ok(Self { rows })
    }

    /// Each bar's ends, and those of all together, beside the printed ones.
    pub(super) fn published(&self) -> Vec<Published> {
        let mut all = Vec::new();
        for r in &self.rows {
            for (k, case) in ["best", "worst"].into_iter().enumerate() {
                let printed = Printed::Number(r.paper_ms[k]);
                let quantity = format!("{}, {case} case [ms]", r.name);
                let (paper, ours) = (Paper::Guenter2012, r.ours_ms[k]);
                let number = Published::new(paper, "Fig. 5", quantity, printed, ours, 0.5);
                all.push(match (r.name, k) {
                    ("eye tracker", 0) => number.explained(
                        2.5,
                        "the paper has 6.6 ms, rounded to 7; one exposure and the shortest processing, both as it states them, \
                         are 3.3 + 1.3 = 4.6 ms",
                    ),
                    ("together", 0) => number.explained(
                        3.0,
                        "the tracker's best case, and bars that are rounded before they are added up",
                    ),
                    ("render", 1) => number.explained(
                        0.7,
                        "two refreshes of 8.333 ms; the paper adds up two that are rounded to 8",
                    ),
                    ("together", 1) => {
                        number.explained(1.0, "the paper adds up bars that are rounded")
                    }
                    _ => number,
                });
            }
        }
        all
    }

    /// One row per bar.
    pub fn table(&self) -> Table {
        let columns = [
            "stage",
            "best_ms",
            "paper_best_ms",
            "worst_ms",
            "paper_worst_ms",
        ];
        let mut table = Table::new(columns);
        for r in &self.rows {
            table.push(vec![
                r.name.into(),
                r.ours_ms[0].into(),
                r.paper_ms[0].into(),
                r.ours_ms[1].into(),
                r.paper_ms[1].into(),
            ]);
        }
        table
    }

    /// Bars of both cases, ours beside the paper's.
    pub fn chart(&self) -> BarChart {
        let series = |label: &str, value: fn(&LatencyRow) -> f64| BarSeries {
            label: label.into(),
            values: self.rows.iter().map(|r| Some(value(r))).collect(),
        };
        BarChart {
            title: "Fig. 5: from eye movement to light".into(),
            value_label: "time [ms]".into(),
            groups: self.rows.iter().map(|r| r.name.to_owned()).collect(),
            series: vec![
                series("best, ours", |r| r.ours_ms[0]),
                series("best, paper", |r| r.paper_ms[0]),
                series("worst, ours", |r| r.ours_ms[1]),
                series("worst, paper", |r| r.paper_ms[1]),
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_the_study_set_up_unrounded() {
        let bars = LatencyBars::new().unwrap();
        let total = bars.rows.last().unwrap();
        // methods.md §6: tearing, last inner row renewed.
        assert!((total.ours_ms[0] - 20.51).abs() < 0.01, "{total:?}");
        assert!((total.ours_ms[1] - 40.97).abs() < 0.01, "{total:?}");
        assert_eq!(total.paper_ms, [23.0, 40.0]);
        for k in [0, 1] {
            let parts: f64 = bars.rows[..4].iter().map(|r| r.ours_ms[k]).sum();
            assert!((parts - total.ours_ms[k]).abs() < 1e-6);
        }
        // Every bar but the tracker's best is the paper's to its rounding.
        for r in &bars.rows {
            for k in [0, 1] {
                let exempt = (r.name == "eye tracker" || r.name == "together") && k == 0;
                assert!(
                    exempt || (r.ours_ms[k] - r.paper_ms[k]).abs() < 1.0,
                    "{r:?}"
                );
            }
        }
    }
}
