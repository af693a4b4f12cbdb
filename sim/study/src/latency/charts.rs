use foveasim_pipeline::STAGES;
use foveasim_reports::{
    self as reports, BarChart, BarSeries, HistogramSeries, LineChart, LineSeries, Strip, Strips,
    Waterfall, WaterfallStage,
};

use super::{LatencyResult, LatencySample, QUANTITIES, Quantity, Rows, Sensitivity};

/// Bins of a chart's histogram.
const CHART_BINS: usize = 60;
/// Points of a cumulative distribution.
const CDF_POINTS: usize = 200;

impl LatencyResult {
    /// Where the time goes: stage after stage in the best, the mean and the worst case.
    pub fn waterfall(&self) -> Waterfall {
        let stage = |name: &str, quantity: Quantity| {
            let (h, bound) = (self.histogram(quantity), self.bounds[quantity.index()]);
            WaterfallStage {
                name: name.into(),
                best_ms: h.min().as_ms(),
                mean_ms: h.mean_ms(),
                worst_ms: h.max().as_ms(),
                bounds_ms: Some([bound.min.as_ms(), bound.max.as_ms()]),
            }
        };
        let stages = STAGES
            .iter()
            .filter(|s| self.is_told(Quantity::Stage(**s)))
            .map(|s| stage(&s.name().replace('_', " "), Quantity::Stage(*s)));
        Waterfall {
            title: "Where the time goes".into(),
            stages: stages.collect(),
            total: Some(stage(
                "gaze to photon, gaze row",
                Quantity::Gaze(Rows::Gaze),
            )),
        }
    }

    /// Fig. 5 of Guenter 2012 for this set-up: the stages of the fastest and of the slowest run, for
    /// the eye's movement and for the head's.
    pub fn strips(&self) -> Strips {
        let strip = |name: &str, sample: &LatencySample, of: fn(_) -> Quantity| Strip {
            name: name.into(),
            lengths_ms: STAGES
                .iter()
                .map(|s| sample[of(*s).index()].as_ms())
                .collect(),
        };
        let [gaze, motion] = &self.extremes;
        Strips {
            title: format!("Fastest and slowest of {} runs", self.histograms[0].len()),
            stages: STAGES.map(|s| s.name().replace('_', " ")).into(),
            strips: vec![
                strip("gaze, fastest", &gaze[0], Quantity::Stage),
                strip("gaze, slowest", &gaze[1], Quantity::Stage),
                strip("motion, fastest", &motion[0], Quantity::MotionStage),
                strip("motion, slowest", &motion[1], Quantity::MotionStage),
            ],
        }
    }

    /// How often a quantity takes how long, with its median and 95 % quantile, within its bounds.
    pub fn chart(&self, quantity: Quantity) -> reports::Histogram {
        let (histogram, bound) = (self.histogram(quantity), self.bounds[quantity.index()]);
        let mark = |q: f64| (format!("p{:.0}", 100.0 * q), histogram.quantile_ms(q));
        reports::Histogram {
            title: quantity.name().replace('_', " "),
            x_label: "time since the eye moved [ms]".into(),
            series: vec![HistogramSeries {
                label: format!("{} runs", histogram.len()),
                bins: histogram.coarse(CHART_BINS),
                marks: vec![mark(0.5), mark(0.95)],
            }],
            bounds: Some([bound.min.as_ms(), bound.max.as_ms()]),
        }
    }

    /// Histograms of all stages and of the whole ways that vary, by their names in tables.
    pub fn charts(&self) -> Vec<(&'static str, reports::Histogram)> {
        let varying = QUANTITIES.into_iter().filter(|q| self.varies(*q));
        varying
            .map(|quantity| {
                let mut chart = self.chart(quantity);
                chart.x_label = match quantity {
                    Quantity::Stage(_) | Quantity::MotionStage(_) => "duration [ms]".into(),
                    Quantity::Gaze(_) => chart.x_label,
                    Quantity::Motion(_) => "time since the head moved [ms]".into(),
                };
                (quantity.name(), chart)
            })
            .collect()
    }

    /// Cumulative distributions of the stages that vary on the eye's way, and of both whole ways to the
    /// row gazed at.
    pub fn cdf(&self) -> LineChart {
        let line = |quantity: Quantity| {
            let h = self.histogram(quantity);
            let point = |k: usize| {
                let fraction = k as f64 / CDF_POINTS as f64;
                [h.quantile_ms(fraction), fraction]
            };
            LineSeries {
                label: quantity.name().replace('_', " "),
                points: (0..=CDF_POINTS).map(point).collect(),
            }
        };
        let stages = STAGES.iter().map(|s| Quantity::Stage(*s));
        let totals = [Quantity::Gaze(Rows::Gaze), Quantity::Motion(Rows::Gaze)];
        LineChart {
            title: "How many runs take at most so long".into(),
            x_label: "time [ms]".into(),
            y_label: "fraction of runs".into(),
            series: stages
                .filter(|q| self.varies(*q))
                .chain(totals)
                .map(line)
                .collect(),
            ..LineChart::default()
        }
    }

    fn varies(&self, quantity: Quantity) -> bool {
        self.bounds[quantity.index()].width().0 > 2
    }
}

/// What a millisecond less of each part buys, the most first: a tornado plot.
pub fn tornado(sensitivities: &[Sensitivity]) -> BarChart {
    let mut sorted = sensitivities.to_vec();
    let reach = |s: &Sensitivity| s.gaze_p95.abs().max(s.motion_p95.abs());
    sorted.sort_by(|a, b| reach(b).total_cmp(&reach(a)));
    let series = |label: &str, value: fn(&Sensitivity) -> f64| BarSeries {
        label: label.into(),
        // Below what the histograms resolve, nothing is what there is.
        values: sorted
            .iter()
            .map(|s| Some(value(s)).map(|v| if v.abs() < 0.005 { 0.0 } else { v }))
            .collect(),
    };
    BarChart {
        title: "What one millisecond less buys at the 95th percentile".into(),
        value_label: "saved per millisecond [ms/ms]".into(),
        groups: sorted
            .iter()
            .map(|s| s.knob.name().replace('_', " "))
            .collect(),
        series: vec![
            series("gaze to photon", |s| s.gaze_p95),
            series("motion to photon", |s| s.motion_p95),
        ],
    }
}
