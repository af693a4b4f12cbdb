//! Figs 12 and 13: what layers would save, and cost, on displays as sharp as the fovea.

use foveasim_models::foveation::{LayersSettings, Screen};
use foveasim_models::{Acuity, ModelError, SLOPE_A, SLOPE_B};
use foveasim_reports::{LineChart, LineSeries, Table};
use rayon::prelude::*;

use super::paper::PREDICTED_ASPECT;
use crate::line::Line;

/// The curves of Fig. 12: how many layers, and whether the middle one has the scale 2 of the user
/// study instead of the best one (n = 3*).
const CURVES: [(&str, usize, Option<f64>); 4] = [
    ("n = 2", 2, None),
    ("n = 3", 3, None),
    ("n = 3*", 3, Some(2.0)),
    ("n = 4", 4, None),
];

/// Both slopes of the user study (§5).
const SLOPES: [(&str, f64); 2] = [("A", SLOPE_A), ("B", SLOPE_B)];

/// Up to this field of view the paper finds the foveated cost roughly linear \[deg\].
const LINEAR_TO_DEG: f64 = 90.0;

/// Layers on one predicted display.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedRow {
    /// Horizontal field of view \[deg\].
    pub fov_deg: f64,
    /// `A` or `B`.
    pub slope: &'static str,
    /// The curve of Fig. 12.
    pub curve: &'static str,
    /// P*, pixels of the display (Eq. 8).
    pub display_pixels: f64,
    /// P, pixels of all layers (Eq. 5), each counted fully.
    pub samples: f64,
}

/// Figs 12 and 13.
#[derive(Debug, Clone, PartialEq)]
pub struct Predicted {
    /// By slope, then curve, then field of view.
    pub rows: Vec<PredictedRow>,
}

impl PredictedRow {
    /// P*/P.
    pub fn speedup(&self) -> f64 {
        self.display_pixels / self.samples
    }
}

impl Predicted {
    /// Designs layers for planar displays with ω* = ω₀ and α = 0.75 at 10° to 130°, every 5°.
    ///
    /// # Errors
    /// None that these displays can cause.
    pub fn new() -> Result<Self, ModelError> {
        let mut cases = Vec::new();
        for slope in SLOPES {
            for curve in CURVES {
                cases.extend((2..=26).map(|k| (slope, curve, f64::from(k) * 5.0)));
            }
        }
        let row = |&((slope, m), (curve, count, second_scale), fov_deg): &(_, _, f64)| {
            let acuity = Acuity::new(m)?;
            let screen = Screen::from_sharpness(fov_deg, acuity, 1.0, PREDICTED_ASPECT)?;
            let settings = LayersSettings {
                second_scale,
                ..LayersSettings::new(count)?
            };
            Ok(PredictedRow {
                fov_deg,
                slope,
                curve,
                display_pixels: screen.pixels(),
                samples: settings.design(&screen, acuity, 0.0)?.samples(),
            })
        };
        let rows = cases.par_iter().map(row).collect::<Result<_, ModelError>>();
        Ok(Self { rows: rows? })
    }

    fn curve(&self, slope: &str, curve: &str) -> impl Iterator<Item = &PredictedRow> {
        let wanted = move |r: &&PredictedRow| (r.slope, r.curve) == (slope, curve);
        self.rows.iter().filter(wanted)
    }

    /// The row of one curve at one field of view, if it is there.
    pub fn at(&self, slope: &str, curve: &str, fov_deg: f64) -> Option<&PredictedRow> {
        self.curve(slope, curve).find(|r| r.fov_deg == fov_deg)
    }

    /// How well a straight line through the foveated cost (n = 4) fits up to 90°: the coefficient of
    /// determination R², 1 for a perfect line.
    pub fn linearity(&self, slope: &str) -> f64 {
        let rows = self.curve(slope, "n = 4");
        let points: Vec<[f64; 2]> = rows
            .filter(|r| r.fov_deg <= LINEAR_TO_DEG)
            .map(|r| [r.fov_deg, r.samples])
            .collect();
        Line::through(&points).r2
    }

    /// One row per display, slope and curve.
    pub fn table(&self) -> Table {
        let columns = [
            "fov_deg",
            "slope",
            "curve",
            "display_pixels",
            "samples",
            "speedup",
        ];
        let mut table = Table::new(columns);
        for r in &self.rows {
            table.push(vec![
                r.fov_deg.into(),
                r.slope.into(),
                r.curve.into(),
                r.display_pixels.into(),
                r.samples.into(),
                r.speedup().into(),
            ]);
        }
        table
    }

    /// Fig. 12: speedup over field of view, for slope `A` (a) or `B` (b).
    pub fn speedup_chart(&self, slope: &'static str) -> LineChart {
        let series = CURVES.iter().map(|(curve, ..)| LineSeries {
            label: (*curve).into(),
            points: self
                .curve(slope, curve)
                .map(|r| [r.fov_deg, r.speedup()])
                .collect(),
        });
        LineChart {
            title: format!("Fig. 12: predicted speedup by pixels, slope {slope}"),
            x_label: "horizontal field of view [deg]".into(),
            y_label: "P*/P".into(),
            series: series.collect(),
            ..LineChart::default()
        }
    }

    /// Fig. 13 (a): pixels of the display; (b): of four layers, at both slopes.
    pub fn cost_charts(&self) -> [LineChart; 2] {
        let chart = |title: &str, series| LineChart {
            title: title.into(),
            x_label: "horizontal field of view [deg]".into(),
            y_label: "million pixels".into(),
            series,
            ..LineChart::default()
        };
        let full = LineSeries {
            label: "every pixel".into(),
            points: self
                .curve("A", "n = 4")
                .map(|r| [r.fov_deg, r.display_pixels / 1e6])
                .collect(),
        };
        let foveated = SLOPES.iter().map(|(slope, _)| LineSeries {
            label: format!("n = 4, slope {slope}"),
            points: self
                .curve(slope, "n = 4")
                .map(|r| [r.fov_deg, r.samples / 1e6])
                .collect(),
        });
        [
            chart("Fig. 13 (a): cost without foveation", vec![full]),
            chart("Fig. 13 (b): cost with foveation", foveated.collect()),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seventy_degrees_as_the_oracle_has_them() {
        let predicted = Predicted::new().unwrap();
        // methods.md §2: oracle s1, ω* = ω₀ at 70°.
        for (curve, expect) in [
            ("n = 2", 26.6),
            ("n = 3", 69.2),
            ("n = 3*", 49.6),
            ("n = 4", 103.0),
        ] {
            let row = predicted.at("A", curve, 70.0).unwrap();
            assert!(
                (row.speedup() - expect).abs() < 0.06,
                "{curve}: {}",
                row.speedup()
            );
        }
        assert_eq!(predicted.rows.len(), 2 * 4 * 25);
    }

    #[test]
    fn foveated_cost_grows_along_a_line() {
        let predicted = Predicted::new().unwrap();
        for slope in ["A", "B"] {
            let r2 = predicted.linearity(slope);
            assert!(r2 > 0.99 && r2 <= 1.0, "{slope}: {r2}");
        }
        let full = predicted.curve("A", "n = 4");
        let full = full.filter(|r| r.fov_deg <= LINEAR_TO_DEG);
        let full: Vec<_> = full.map(|r| [r.fov_deg, r.display_pixels]).collect();
        assert!(Line::through(&full).r2 < 0.92);
        // And full cost does not: from 45° to 90° it grows by (tan 45°/tan 22.5°)² = 5.8.
        let pixels = |fov| predicted.at("A", "n = 4", fov).unwrap().display_pixels;
        assert!((pixels(90.0) / pixels(45.0) - 5.828_427).abs() < 1e-5);
    }
}
