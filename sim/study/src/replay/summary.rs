use foveasim_models::Nanos;
use foveasim_models::math::{mean, quantile_sorted};
use foveasim_pipeline::{STAGES, Stage};

use super::{GazeState, Replay};

/// How a quantity is spread over displayed frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Over how many frames.
    pub n: u64,
    /// Mean.
    pub mean: f64,
    /// Median.
    pub p50: f64,
    /// 95 % are at or below this.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

impl Spread {
    /// The spread of `values`; `None` of none.
    fn of(values: impl Iterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        let max = *values.last()?;
        Some(Self {
            n: values.len() as u64,
            mean: mean(&values),
            p50: quantile_sorted(&values, 0.5),
            p95: quantile_sorted(&values, 0.95),
            max,
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

impl ReplaySummary {
    pub(super) fn new(replay: &Replay) -> Self {
        let frames = &replay.frames;
        let count = |state: GazeState| frames.iter().filter(|f| f.state == state).count() as u64;
        let stages: Vec<_> = frames.iter().filter_map(|f| f.stages).collect();
        let mean_of = |stage: Stage| {
            mean(
                &stages
                    .iter()
                    .map(|s| s.get(stage).as_ms())
                    .collect::<Vec<_>>(),
            )
        };
        let repeated = frames
            .windows(2)
            .filter(|w| w[0].frame.id == w[1].frame.id)
            .count();
        let torn = frames
            .iter()
            .filter(|f| f.frame_ids[0] != f.frame_ids[1])
            .count();
        let unknown = frames.iter().filter(|f| f.true_gaze.is_none()).count();
        Self {
            scans: frames.len() as u64,
            dark_scans: replay.dark_scans,
            frames: replay.counts.frames,
            repeated: repeated as u64,
            torn: torn as u64,
            states: [
                GazeState::Tracked,
                GazeState::Held,
                GazeState::Lost,
                GazeState::Fixed,
            ]
            .map(count),
            truth_unknown: unknown as u64,
            gaze_error_deg: Spread::of(frames.iter().filter_map(|f| f.gaze_error_deg())),
            exposure_to_photon_ms: Spread::of(
                frames
                    .iter()
                    .filter_map(|f| f.exposure_to_photon().map(Nanos::as_ms)),
            ),
            mean_stages_ms: (!stages.is_empty()).then(|| STAGES.map(mean_of)),
            head_error_deg: Spread::of(frames.iter().filter_map(|f| f.head_error_deg)),
        }
    }

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
