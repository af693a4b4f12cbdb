use foveasim_models::{GazeDirection, Nanos};
use foveasim_reports::{LineChart, LineSeries};

use super::{GazePhases, Replay, ReplayFrame};

/// How much of a recording the path of gaze is drawn of \[s\]: more would hide the latency.
const PATH_S: f64 = 5.0;

impl Replay {
    /// The angle between eye and drawn fovea along the recording, saccades marked where they are known.
    pub fn gaze_error_chart(&self, phases: Option<&GazePhases>) -> LineChart {
        self.along(
            phases,
            "Gaze error along the recording",
            "angle between eye and drawn fovea [deg]",
            "gaze error",
            self.summary().gaze_error_deg.map(|e| e.p95),
            &|f| f.gaze_error_deg().unwrap_or(f64::NAN),
        )
    }

    /// From the exposure that a frame used to its light, along the recording; saccades marked where they are
    /// known. Frames without a gaze have none.
    pub fn latency_chart(&self, phases: Option<&GazePhases>) -> LineChart {
        self.along(
            phases,
            "Latency along the recording",
            "exposure to photon [ms]",
            "exposure to photon",
            self.summary().exposure_to_photon_ms.map(|e| e.p95),
            &|f| f.exposure_to_photon().map_or(f64::NAN, Nanos::as_ms),
        )
    }

    /// A number of each frame along the recording; NaN where it has none.
    fn along(
        &self,
        phases: Option<&GazePhases>,
        title: &str,
        y_label: &str,
        label: &str,
        p95: Option<f64>,
        value: &dyn Fn(&ReplayFrame) -> f64,
    ) -> LineChart {
        let point = |f: &ReplayFrame| [self.seconds(f.lit), value(f)];
        LineChart {
            title: title.into(),
            x_label: "time [s]".into(),
            y_label: y_label.into(),
            series: vec![LineSeries {
                label: label.into(),
                points: self.frames.iter().map(point).collect(),
            }],
            shaded: self.unknown(&self.frames),
            shaded_label: "true gaze not known".into(),
            levels: p95
                .map(|p| (p, "95th percentile".to_owned()))
                .into_iter()
                .collect(),
            marked: self.saccades(phases, &self.frames),
            marked_label: "saccade".into(),
        }
    }

    /// Where the eye was when light came out, and where the fovea of the picture was drawn, in the first
    /// five seconds shown.
    pub fn gaze_path_chart(&self, phases: Option<&GazePhases>) -> LineChart {
        let first = self.frames.first().map_or(0.0, |f| self.seconds(f.lit));
        let early = |f: &ReplayFrame| self.seconds(f.lit) <= first + PATH_S;
        let frames = &self.frames[..self.frames.partition_point(early)];
        let line = |label: &str, value: &dyn Fn(&ReplayFrame) -> Option<f64>| LineSeries {
            label: label.into(),
            points: frames
                .iter()
                .map(|f| [self.seconds(f.lit), value(f).unwrap_or(f64::NAN)])
                .collect(),
        };
        let eye = |pick: fn(GazeDirection) -> f64| move |f: &ReplayFrame| f.true_gaze.map(pick);
        LineChart {
            title: "Gaze and drawn fovea".into(),
            x_label: "time [s]".into(),
            y_label: "direction relative to the head [deg]".into(),
            series: vec![
                line("eye, azimuth", &eye(|g| g.azimuth_deg)),
                line("fovea, azimuth", &|f| Some(f.fovea.azimuth_deg)),
                line("eye, elevation", &eye(|g| g.elevation_deg)),
                line("fovea, elevation", &|f| Some(f.fovea.elevation_deg)),
            ],
            shaded: self.unknown(frames),
            shaded_label: "true gaze not known".into(),
            marked: self.saccades(phases, frames),
            marked_label: "saccade".into(),
            ..LineChart::default()
        }
    }

    fn seconds(&self, t: Nanos) -> f64 {
        (t - self.start).as_secs()
    }

    /// Stretches of frames whose true gaze is not known \[s\].
    fn unknown(&self, frames: &[ReplayFrame]) -> Vec<[f64; 2]> {
        let gaps = frames.windows(2).filter(|w| w[0].true_gaze.is_none());
        gaps.map(|w| [w[0].lit, w[1].lit].map(|t| self.seconds(t)))
            .collect()
    }

    /// Saccades while these frames are shown \[s\].
    fn saccades(&self, phases: Option<&GazePhases>, frames: &[ReplayFrame]) -> Vec<[f64; 2]> {
        let (Some(first), Some(last)) = (frames.first(), frames.last()) else {
            return Vec::new();
        };
        let saccades = phases.into_iter().flat_map(GazePhases::saccades);
        saccades
            .filter(|[start, end]| *end >= first.lit && *start <= last.lit)
            .map(|[start, end]| [start.max(first.lit), end.min(last.lit)])
            .map(|ends| ends.map(|t| self.seconds(t)))
            .collect()
    }
}
