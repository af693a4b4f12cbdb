use foveasim_models::{Emission, Nanos};
use foveasim_pipeline::{BoundKind, Interval, STAGES, Stage, StageBounds, SyncMode, until};

use super::band::Edges;

/// Which rows a latency ends with.
///
/// A row is *renewed* when it is first lit from a picture that knew of the movement. Where the picture
/// tears, rows above the beam wait for the next scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Rows {
    /// The first of the inner layer's rows to be renewed.
    First,
    /// The row gazed at.
    Gaze,
    /// The last of the inner layer's rows to be renewed, each judged for itself.
    Last,
    /// The first scan of the inner layer from end to end out of pictures that knew.
    CompletePass,
}

/// All of them, in the order of tables.
pub const ROWS: [Rows; 4] = [Rows::First, Rows::Gaze, Rows::Last, Rows::CompletePass];

/// What a latency study reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// One stage's share, on the way from an eye movement to the gaze row.
    Stage(Stage),
    /// From the eye movement to light.
    Gaze(Rows),
    /// One stage's share, on the way from a head movement to the gaze row.
    MotionStage(Stage),
    /// From the head movement to light.
    Motion(Rows),
}

/// Quantities of one movement.
const EACH: usize = STAGES.len() + ROWS.len();

/// All of them: those of gaze, then those of motion; stages first.
pub const QUANTITIES: [Quantity; 2 * EACH] = {
    let mut all = [Quantity::Gaze(Rows::Gaze); 2 * EACH];
    let mut i = 0;
    while i < STAGES.len() {
        all[i] = Quantity::Stage(STAGES[i]);
        all[EACH + i] = Quantity::MotionStage(STAGES[i]);
        i += 1;
    }
    let mut i = 0;
    while i < ROWS.len() {
        all[STAGES.len() + i] = Quantity::Gaze(ROWS[i]);
        all[EACH + STAGES.len() + i] = Quantity::Motion(ROWS[i]);
        i += 1;
    }
    all
};

impl Quantity {
    /// Its place in [`QUANTITIES`].
    pub fn index(self) -> usize {
        match self {
            Self::Stage(stage) => stage as usize,
            Self::Gaze(rows) => STAGES.len() + rows as usize,
            Self::MotionStage(stage) => EACH + stage as usize,
            Self::Motion(rows) => EACH + STAGES.len() + rows as usize,
        }
    }

    /// Whether it belongs to the head's movement, not the eye's.
    pub fn is_motion(self) -> bool {
        matches!(self, Self::MotionStage(_) | Self::Motion(_))
    }

    /// As in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stage(stage) => stage.name(),
            Self::Gaze(Rows::First) => "gaze_to_photon_first_row",
            Self::Gaze(Rows::Gaze) => "gaze_to_photon_gaze_row",
            Self::Gaze(Rows::Last) => "gaze_to_photon_last_row",
            Self::Gaze(Rows::CompletePass) => "gaze_to_photon_complete_pass",
            Self::MotionStage(Stage::TrackerWait) => "motion_head_wait",
            Self::MotionStage(Stage::TrackerExposure) => "motion_exposure",
            Self::MotionStage(Stage::TrackerProcessing) => "motion_processing",
            Self::MotionStage(Stage::TrackerTransport) => "motion_head_delay",
            Self::MotionStage(Stage::FrameWait) => "motion_latch_wait",
            Self::MotionStage(Stage::FrameQueue) => "motion_frame_queue",
            Self::MotionStage(Stage::Render) => "motion_render",
            Self::MotionStage(Stage::FlipWait) => "motion_flip_wait",
            Self::MotionStage(Stage::Compose) => "motion_compose",
            Self::MotionStage(Stage::DisplayBuffer) => "motion_display_buffer",
            Self::MotionStage(Stage::ScanWait) => "motion_scan_wait",
            Self::MotionStage(Stage::PixelResponse) => "motion_pixel_response",
            Self::MotionStage(Stage::Persistence) => "motion_persistence",
            Self::Motion(Rows::First) => "motion_to_photon_first_row",
            Self::Motion(Rows::Gaze) => "motion_to_photon_gaze_row",
            Self::Motion(Rows::Last) => "motion_to_photon_last_row",
            Self::Motion(Rows::CompletePass) => "motion_to_photon_complete_pass",
        }
    }

    /// Whether those bounds are reached.
    pub(super) fn bound_kind(self, stages: &StageBounds, edges: &Edges) -> BoundKind {
        match self {
            Self::Stage(stage) | Self::MotionStage(stage) => stages.kind(stage),
            Self::Gaze(Rows::Gaze) | Self::Motion(Rows::Gaze) => stages.whole_kind(&[edges.gaze]),
            Self::Gaze(_) | Self::Motion(_) => stages.whole_kind(&[edges.first, edges.last]),
        }
    }

    /// The range of the quantity, from the stages' of the same movement.
    pub(super) fn bounds(self, stages: &StageBounds, edges: &Edges, sync: SyncMode) -> Interval {
        match self {
            Self::Stage(stage) | Self::MotionStage(stage) => stages.get(stage),
            Self::Gaze(rows) | Self::Motion(rows) => rows.bounds(stages, edges, sync),
        }
    }
}

impl Rows {
    fn bounds(self, stages: &StageBounds, edges: &Edges, sync: SyncMode) -> Interval {
        let to_panel = stages.to_panel();
        match self {
            Self::Gaze => stages.total(),
            _ if sync != SyncMode::Tearing => {
                let row = match self {
                    Self::First => edges.first,
                    _ => edges.last,
                };
                to_panel + Interval::exactly(edges.lit(row))
            }
            // The place of the beam depends on how long the frame renders: both are bounded at once.
            _ => {
                let refresh = stages.refresh;
                let after = |at| self.after_flip_at(at, refresh, edges);
                match stages.torn(&[edges.first, edges.last], after) {
                    Some(way) => way + Interval::exactly(self.lit(edges)),
                    None => to_panel + self.after_flip(refresh, edges),
                }
            }
        }
    }

    /// From a flip anywhere in the scan until the rows are lit, when the picture tears.
    fn after_flip(self, refresh: Nanos, edges: &Edges) -> Interval {
        let pass = edges.last - edges.first;
        // The shortest wait has the beam arrive just after the flip; the longest has it just gone.
        let wait = match (edges.response.emission, self) {
            // The beam inside the layer renews something at once; just below it, the top is next.
            (Emission::Rolling, Self::First) => Interval::new(Nanos::ZERO, refresh - pass),
            // From just inside the layer, the last row renewed is the one just above the beam.
            (Emission::Rolling, Self::Last) => Interval::new(pass, refresh),
            (Emission::Rolling, _) => Interval::new(pass, refresh + pass),
            // Nothing is lit before the scan ends: what counts is which scan holds the rows.
            (Emission::Global, Self::First) => Interval::new(Nanos::ZERO, refresh),
            (Emission::Global, _) => Interval::new(pass, refresh + pass),
        };
        wait + Interval::exactly(self.lit(edges))
    }

    /// From scanned to lit; of a global flash, from the start of the scan.
    fn lit(self, edges: &Edges) -> Nanos {
        match edges.response.emission {
            Emission::Rolling => edges.lit(Nanos::ZERO),
            Emission::Global => edges.lit(Nanos::ZERO) - edges.last,
        }
    }

    /// From a flip with the beam at `at` until the rows are scanned; of a global flash, until the end of the
    /// layer in the scan that holds them.
    fn after_flip_at(self, at: Nanos, refresh: Nanos, edges: &Edges) -> Nanos {
        let Edges { first, last, .. } = *edges;
        if edges.response.emission == Emission::Global {
            let still = match self {
                Self::First => at < last || at <= first,
                _ => at <= first,
            };
            return match still {
                true => last - at,
                false => last - at + refresh,
            };
        }
        let inside = first < at && at < last;
        match self {
            Self::First if inside => Nanos::ZERO,
            Self::First => until(first, at, refresh),
            Self::Last if inside => refresh,
            _ => until(first, at, refresh) + (last - first),
        }
    }
}
