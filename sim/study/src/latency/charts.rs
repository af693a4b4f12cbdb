use foveasim_pipeline::STAGES;
use foveasim_reports::{self as reports, HistogramSeries, Waterfall, WaterfallStage};

use super::{LatencyResult, Quantity, Rows};

/// Bins of a chart's histogram.
const CHART_BINS: usize = 60;

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
}
