use foveasim_models::Nanos;
use foveasim_pipeline::{RunCounts, STAGES};

use super::{GazeState, ReplayFrame, Sketch};

/// How a quantity is spread over displayed frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Over how many frames.
    pub n: u64,
    /// Mean.
    pub mean: f64,
    /// Median, as a [`Sketch`] knows it: to 1 µs or 0.001°.
    pub p50: f64,
    /// 95 % are at or below this, likewise.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

impl Spread {
    /// The spread of what was counted; `None` of nothing.
    fn of(sketch: &Sketch) -> Option<Self> {
        (!sketch.is_empty()).then(|| Self {
            n: sketch.len(),
            mean: sketch.mean(),
            p50: sketch.quantile(0.5),
            p95: sketch.quantile(0.95),
            max: sketch.max(),
        })
    }
}

/// A replay in a few numbers, each over displayed frames (scans), not over time.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplaySummary {
    /// Displayed frames.
    pub scans: u64,
    /// Scans before the first frame was finished.
    pub dark_scans: u64,
    /// Frames rendered.
    pub frames: u64,
    /// Scans that showed the same frame at the gaze row as the scan before.
    pub repeated: u64,
    /// Scans that showed more than one frame.
    pub torn: u64,
    /// Displayed frames in each state: tracked, held, lost, fixed.
    pub states: [u64; 4],
    /// Displayed frames at whose light the true gaze is not known (blink, loss, end of recording).
    pub truth_unknown: u64,
    /// Angle between true gaze and drawn fovea \[deg\].
    pub gaze_error_deg: Option<Spread>,
    /// From the start of the exposure used to the light of the gaze row \[ms\].
    pub exposure_to_photon_ms: Option<Spread>,
    /// Where that time went on average, by stage in order \[ms\]; `None` if no frame knew any gaze.
    pub mean_stages_ms: Option<[f64; STAGES.len()]>,
    /// Angle between predicted and true head orientation \[deg\].
    pub head_error_deg: Option<Spread>,
}

/// Counts displayed frames, in order, for a [`ReplaySummary`]; its memory is bounded.
#[derive(Debug, Clone)]
pub struct ReplayTally {
    scans: u64,
    repeated: u64,
    torn: u64,
    states: [u64; GazeState::ALL.len()],
    truth_unknown: u64,
    gaze_error: Sketch,
    latency: Sketch,
    head_error: Sketch,
    /// Frames that knew a gaze, and the sum of each of their stages \[ns\].
    stages: (u64, [i128; STAGES.len()]),
    /// The frame shown last.
    last: Option<u64>,
}

/// Quantiles are known to this \[ms, deg\].
const LATENCY_BIN_MS: f64 = 0.001;
const ANGLE_BIN_DEG: f64 = 0.001;

impl Default for ReplayTally {
    fn default() -> Self {
        Self {
            scans: 0,
            repeated: 0,
            torn: 0,
            states: [0; GazeState::ALL.len()],
            truth_unknown: 0,
            gaze_error: Sketch::new(ANGLE_BIN_DEG),
            latency: Sketch::new(LATENCY_BIN_MS),
            head_error: Sketch::new(ANGLE_BIN_DEG),
            stages: (0, [0; STAGES.len()]),
            last: None,
        }
    }
}

impl ReplayTally {
    /// Counts the next displayed frame.
    pub fn add(&mut self, frame: &ReplayFrame) {
        self.scans += 1;
        self.repeated += u64::from(self.last == Some(frame.frame.id));
        self.last = Some(frame.frame.id);
        self.torn += u64::from(frame.frame_ids[0] != frame.frame_ids[1]);
        self.states[frame.state as usize] += 1;
        self.truth_unknown += u64::from(frame.true_gaze.is_none());
        let add = |sketch: &mut Sketch, value: Option<f64>| {
            if let Some(value) = value {
                sketch.add(value);
            }
        };
        add(&mut self.gaze_error, frame.gaze_error_deg());
        let latency = frame.exposure_to_photon().map(Nanos::as_ms);
        add(&mut self.latency, latency);
        add(&mut self.head_error, frame.head_error_deg);
        if let Some(stages) = &frame.stages {
            self.stages.0 += 1;
            for (sum, stage) in self.stages.1.iter_mut().zip(STAGES) {
                *sum += i128::from(stages.get(stage).0);
            }
        }
    }

    /// The summary of a replay with these frames.
    pub fn finish(&self, dark_scans: u64, counts: &RunCounts) -> ReplaySummary {
        let (n, sums) = self.stages;
        ReplaySummary {
            scans: self.scans,
            dark_scans,
            frames: counts.frames,
            repeated: self.repeated,
            torn: self.torn,
            states: self.states,
            truth_unknown: self.truth_unknown,
            gaze_error_deg: Spread::of(&self.gaze_error),
            exposure_to_photon_ms: Spread::of(&self.latency),
            mean_stages_ms: (n > 0).then(|| sums.map(|sum| sum as f64 / n as f64 / 1e6)),
            head_error_deg: Spread::of(&self.head_error),
        }
    }
}

impl ReplaySummary {
    /// For people: a few sentences.
    pub fn lines(&self) -> Vec<String> {
        let [tracked, held, lost, fixed] = self.states;
        let mut lines = vec![
            format!(
                "{} displayed frames ({} rendered, {} shown again, {} torn)",
                self.scans, self.frames, self.repeated, self.torn
            ),
            format!(
                "fovea: {tracked} tracked, {held} held over a loss, {lost} at the centre for want of gaze, {fixed} fixed; true gaze unknown in {}",
                self.truth_unknown
            ),
        ];
        let mut spread = |what: &str, unit: &str, s: &Option<Spread>| {
            if let Some(s) = s {
                lines.push(format!(
                    "{what}: mean {:.2}, median {:.2}, p95 {:.2}, worst {:.2} {unit}",
                    s.mean, s.p50, s.p95, s.max
                ));
            }
        };
        spread("exposure to photon", "ms", &self.exposure_to_photon_ms);
        spread("gaze error", "deg", &self.gaze_error_deg);
        spread("head error", "deg", &self.head_error_deg);
        lines
    }
}
