use std::sync::Arc;

use foveasim_models::foveation::Method;
use foveasim_models::{GazeMode, ModelError};
use foveasim_reports::{LineChart, LineSeries, Table};

use crate::line::Line;
use crate::{DensityAt, GazeAt, Resolution, Scenario, Sweep, SweepDisplay, SweepRow, Terms};

/// How the cost of each method grows with the field of view: Figs 12 and 13 of Guenter 2012 for this set-up, on flat
/// displays of its sharpness at the centre, its shape, acuity, margin and gaze.
#[derive(Debug, Clone)]
pub struct Growth {
    /// Pixels per degree at the centre of all displays.
    pub ppd_centre: f64,
    /// Each method at each field of view, method by method.
    pub rows: Vec<SweepRow>,
    methods: Vec<Method>,
    gaze_mode: GazeMode,
}

/// Fields of view, as in the paper's figures \[deg\].
const FOV_DEG: std::ops::RangeInclusive<u32> = 2..=26;
/// … in steps of so much \[deg\].
const STEP_DEG: f64 = 5.0;
/// Up to this field of view the paper finds the foveated cost roughly linear \[deg\].
const LINEAR_TO_DEG: f64 = 90.0;

impl Growth {
    pub(super) fn new(scenario: &Scenario, terms: &Arc<Terms>) -> Result<Self, ModelError> {
        let viewport = &scenario.display.primary().viewport;
        let ppd_centre = viewport.pixel_density().centre;
        let aspect = f64::from(viewport.size.y) / f64::from(viewport.size.x);
        let display = |k: u32| {
            let resolution = Resolution::PerDegree(DensityAt::Centre, ppd_centre);
            // Beyond the most pixels that an image can have there is nothing to say.
            resolution.display(f64::from(k) * STEP_DEG, aspect).ok()
        };
        let displays: Vec<SweepDisplay> = FOV_DEG.filter_map(display).collect();
        let mut rows = Vec::new();
        for method in &scenario.methods {
            let sweep = Sweep {
                displays: displays.clone(),
                acuities: vec![scenario.acuity],
                gazes: vec![GazeAt::Centre],
                gaze_mode: scenario.gaze_mode,
                margins_deg: vec![scenario.spec.margin_deg],
                methods: vec![*method],
                terms: terms.clone(),
            };
            rows.extend(sweep.run(|_| ())?);
        }
        Ok(Self {
            ppd_centre,
            rows,
            methods: scenario.methods.clone(),
            gaze_mode: scenario.gaze_mode,
        })
    }

    /// The rows as a table.
    pub fn table(&self) -> Table {
        SweepRow::table(&self.rows)
    }

    fn of(&self, method: Method) -> impl Iterator<Item = &SweepRow> {
        self.rows.iter().filter(move |r| r.method == method)
    }

    fn foveated(&self) -> impl Iterator<Item = Method> {
        self.methods.iter().copied().filter(|m| *m != Method::Full)
    }

    fn series(&self, method: Method, value: fn(&SweepRow) -> f64) -> LineSeries {
        LineSeries {
            label: method.to_string(),
            points: self
                .of(method)
                .map(|r| [r.display.fov_h_deg, value(r)])
                .collect(),
        }
    }

    fn chart(title: &str, y_label: &str, series: Vec<LineSeries>) -> LineChart {
        LineChart {
            title: title.into(),
            x_label: "horizontal field of view [deg]".into(),
            y_label: y_label.into(),
            series,
            ..LineChart::default()
        }
    }

    /// As Fig. 12: display pixels per shaded sample over field of view.
    pub fn speedup_chart(&self) -> LineChart {
        let of = |method| self.series(method, SweepRow::shading_ratio);
        let series = self.foveated().map(of).collect();
        let y_label = "display pixels per shaded sample";
        Self::chart("What foveation saves over field of view", y_label, series)
    }

    /// As Fig. 13: pixels of the display (a), and samples that methods shade (b), over field of view.
    pub fn cost_charts(&self) -> [LineChart; 2] {
        let y_label = "million shaded samples";
        let full = self.methods.first().map(|method| LineSeries {
            label: "every pixel".into(),
            ..self.series(*method, |r| r.display_samples / 1e6)
        });
        let of = |method| self.series(method, |r| r.method_shadings / 1e6);
        let series = self.foveated().map(of).collect();
        [
            Self::chart(
                "Cost without foveation",
                y_label,
                full.into_iter().collect(),
            ),
            Self::chart("Cost with foveation", y_label, series),
        ]
    }

    /// The line through a quantity of a method up to 90°.
    fn line(&self, method: Method, value: fn(&SweepRow) -> f64) -> Line {
        let rows = self.of(method);
        let points = rows
            .filter(|r| r.display.fov_h_deg <= LINEAR_TO_DEG)
            .map(|r| [r.display.fov_h_deg, value(r)]);
        Line::through(&points.collect::<Vec<_>>())
    }

    /// What the charts say, in a sentence about one method.
    pub fn sentence(&self, method: Method) -> String {
        let line = self.line(method, |r| r.method_shadings);
        let every = self.line(method, |r| r.display_samples);
        let fixed = match self.gaze_mode {
            GazeMode::Tracked => "",
            GazeMode::Fixed => ", its sharp region fixed at the centre",
        };
        format!(
            "At {:.1} pixels per degree at the centre, what {method} shades{fixed} grows by {:.2} million samples for each 10° of \
             field of view up to 90°, along a line to R² = {:.3}; all pixels grow by {:.1} million and faster the wider \
             (R² = {:.3} of a line).",
            self.ppd_centre,
            10.0 * line.slope / 1e6,
            line.r2,
            10.0 * every.slope / 1e6,
            every.r2,
        )
    }
}
