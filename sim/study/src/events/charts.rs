use foveasim_models::Recording;
use foveasim_reports::{LineChart, LineSeries};
use foveasim_traces::{Estimate, EventKind, GazeEvent};

use super::EventStudy;

/// Points of a fitted curve.
const CURVE: usize = 200;

/// Lines are not drawn over holes longer than this \[s\], and than so many steps from sample to sample.
const LONGEST_STEP_S: f64 = 0.075;
const USUAL_STEPS: f64 = 3.0;

impl EventStudy {
    /// Peak speed of saccades over their amplitude, with the fitted main sequence.
    pub fn peak_chart(&self) -> LineChart {
        let fit = self.main_sequence.as_ref().map(|fit| {
            let Estimate { value: v, error } = fit.peak_deg_per_s;
            let c = fit.scale_deg;
            let label = format!(
                "{v:.0}±{error:.0} · (1 − exp(−A / {:.1}±{:.1}))",
                c.value, c.error
            );
            (label, |a: f64| fit.peak(a))
        });
        self.chart(
            "Main sequence: peak speed",
            "peak speed [deg/s]",
            |e| e.peak_deg_per_s,
            fit,
        )
    }

    /// Duration of saccades over their amplitude, with the fitted line.
    pub fn duration_chart(&self) -> LineChart {
        let fit = self.main_sequence.as_ref().map(|fit| {
            let (d0, d) = (fit.duration_ms, fit.duration_ms_per_deg);
            let label = format!(
                "{:.1}±{:.1} + {:.2}±{:.2} · A",
                d0.value, d0.error, d.value, d.error
            );
            (label, |a: f64| fit.duration(a))
        });
        self.chart(
            "Main sequence: duration",
            "duration [ms]",
            |e| e.duration().as_ms(),
            fit,
        )
    }

    fn chart(
        &self,
        title: &str,
        y_label: &str,
        value: fn(&GazeEvent) -> f64,
        fit: Option<(String, impl Fn(f64) -> f64)>,
    ) -> LineChart {
        let mut points: Vec<[f64; 2]> = self
            .events
            .of(EventKind::Saccade)
            .map(|e| [e.amplitude_deg, value(e)])
            .collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let widest = points.last().map_or(0.0, |p| p[0]);
        let n = points.len();
        // Points that stand alone are dots.
        let gap = [f64::NAN; 2];
        let dots = points.into_iter().flat_map(|p| [p, gap]).collect();
        let mut series = vec![LineSeries {
            label: format!("{n} saccades"),
            points: dots,
        }];
        if let Some((label, curve)) = fit {
            let at = |i: usize| widest * i as f64 / CURVE as f64;
            series.push(LineSeries {
                label,
                points: (0..=CURVE).map(|i| [at(i), curve(at(i))]).collect(),
            });
        }
        LineChart {
            title: title.into(),
            x_label: "amplitude A [deg]".into(),
            y_label: y_label.into(),
            series,
            ..LineChart::default()
        }
    }

    /// Gaze along the recording, from its first sample, with saccades and blinks shaded.
    pub fn gaze_chart(&self, recording: &Recording) -> LineChart {
        let samples = recording.gaze.as_ref().map_or(&[][..], |g| g.samples());
        let hole = LONGEST_STEP_S.max(USUAL_STEPS / self.events.rate_hz);
        let line = |pick: fn(foveasim_models::GazeDirection) -> f64| -> Vec<[f64; 2]> {
            let mut points: Vec<[f64; 2]> = Vec::with_capacity(samples.len());
            for s in samples {
                let t = s.t.as_secs() - self.start_s;
                if points.last().is_some_and(|[last, _]| t - last > hole) {
                    points.push([t, f64::NAN]);
                }
                points.push([t, s.value.map_or(f64::NAN, pick)]);
            }
            points
        };
        let of_line = |label: &str, points| LineSeries {
            label: label.into(),
            points,
        };
        let moving = |e: &&GazeEvent| e.kind != EventKind::Fixation;
        let seconds = |e: &GazeEvent| [e.start, e.end].map(|t| t.as_secs() - self.start_s);
        LineChart {
            title: "Gaze and its events".into(),
            x_label: "time [s]".into(),
            y_label: "gaze [deg]".into(),
            series: vec![
                of_line("azimuth", line(|g| g.azimuth_deg)),
                of_line("elevation", line(|g| g.elevation_deg)),
            ],
            shaded: self
                .events
                .events
                .iter()
                .filter(moving)
                .map(seconds)
                .collect(),
            shaded_label: "saccade or blink".into(),
            ..LineChart::default()
        }
    }
}
