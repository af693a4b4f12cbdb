use foveasim_reports::{LineChart, LineSeries};

use super::paper::MARKS;
use super::{QualityRow, QualitySweep};

impl QualitySweep {
    /// Fig. 10: speedup by pixels and by time, with the paper's marked points; `informal` is the index
    /// at which its column I stands here.
    pub fn speedup_chart(&self, informal: f64) -> LineChart {
        let curve = |label: &str, value: fn(&QualityRow) -> f64| LineSeries {
            label: label.into(),
            points: self.rows.iter().map(|r| [r.j, value(r)]).collect(),
        };
        let mut marks: Vec<_> = MARKS
            .iter()
            .map(|m| (m.j.unwrap_or(informal), m.pixels, m.time))
            .collect();
        marks.sort_by(|a, b| a.0.total_cmp(&b.0));
        let paper = |label: &str, value: fn(&(f64, f64, f64)) -> f64| LineSeries {
            label: label.into(),
            points: marks.iter().map(|m| [m.0, value(m)]).collect(),
        };
        LineChart {
            title: "Fig. 10: speedup over foveation quality".into(),
            x_label: "quality index j".into(),
            y_label: "times".into(),
            series: vec![
                curve("pixels, gaze at the centre", |r| r.pixels_speedup),
                curve("pixels drawn in the fly-through", |r| r.drawn_speedup),
                curve("time", |r| r.time_speedup),
                paper("pixels, paper (I, A, B)", |m| m.1),
                paper("time, paper (I, A, B)", |m| m.2),
            ],
            ..LineChart::default()
        }
    }

    /// Fig. 11: pixels per frame, and time per frame, of all layers together (S) and of each.
    pub fn layer_charts(&self) -> [LineChart; 2] {
        let line = |label: &str, value: &dyn Fn(&QualityRow) -> f64| LineSeries {
            label: label.into(),
            points: self.rows.iter().map(|r| [r.j, value(r)]).collect(),
        };
        let chart = |title: &str, y_label: &str, series| LineChart {
            title: title.into(),
            x_label: "quality index j".into(),
            y_label: y_label.into(),
            series,
            ..LineChart::default()
        };
        let pixels = vec![
            line("S", &|r| r.layer_samples.iter().sum::<f64>() / 1e3),
            line("inner", &|r| r.layer_samples[0] / 1e3),
            line("middle", &|r| r.layer_samples[1] / 1e3),
            line("outer", &|r| r.layer_samples[2] / 1e3),
        ];
        let times = vec![
            line("S", &|r| r.total.mean_ms()),
            line("inner", &|r| r.layer_ms[0]),
            line("middle", &|r| r.layer_ms[1]),
            line("outer", &|r| r.layer_ms[2]),
            line("putting together", &|r| r.together_ms),
        ];
        [
            chart(
                "Fig. 11: pixels shaded, by layer",
                "thousand pixels per frame",
                pixels,
            ),
            chart("Fig. 11: render time, by layer", "ms per frame", times),
        ]
    }
}
