use foveasim_reports::{LineChart, LineSeries};

use super::{Replay, ReplayFrame};

impl Replay {
    /// The angle between eye and drawn fovea along the recording.
    pub fn gaze_error_chart(&self) -> LineChart {
        let seconds = |f: &ReplayFrame| (f.lit - self.start).as_secs();
        let point = |f: &ReplayFrame| [seconds(f), f.gaze_error_deg().unwrap_or(f64::NAN)];
        let mut shaded: Vec<[f64; 2]> = Vec::new();
        for pair in self.frames.windows(2).filter(|w| w[0].true_gaze.is_none()) {
            let [from, to] = [seconds(&pair[0]), seconds(&pair[1])];
            match shaded.last_mut() {
                Some(last) if last[1] >= from => last[1] = to,
                _ => shaded.push([from, to]),
            }
        }
        let p95 = self
            .summary()
            .gaze_error_deg
            .map(|e| (e.p95, "95th percentile".to_owned()));
        LineChart {
            title: "Gaze error along the recording".into(),
            x_label: "time [s]".into(),
            y_label: "angle between eye and drawn fovea [deg]".into(),
            series: vec![LineSeries {
                label: "gaze error".into(),
                points: self.frames.iter().map(point).collect(),
            }],
            shaded,
            shaded_label: "true gaze not known".into(),
            levels: p95.into_iter().collect(),
        }
    }
}
