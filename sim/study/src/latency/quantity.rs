use foveasim_models::{Emission, Nanos};
use foveasim_pipeline::{Interval, STAGES, Stage, StageBounds, SyncMode};

use super::band::Edges;

/// What a latency study reports.
///
/// A row is *renewed* when it is first lit from a frame that knew of the eye movement. Where the
/// picture tears, rows above the beam wait for the next scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// One stage's share, on the way to the gaze row.
    Stage(Stage),
    /// Until the first of the inner layer's rows to be renewed is.
    FirstRow,
    /// Until the gaze row is renewed.
    GazeRow,
    /// Until every row of the inner layer has been renewed, each judged for itself.
    LastRow,
    /// Until the inner layer has first been scanned from top to bottom out of frames that knew.
    CompletePass,
}

/// All of them, in the order of the table.
pub const QUANTITIES: [Quantity; 12] = [
    Quantity::Stage(STAGES[0]),
    Quantity::Stage(STAGES[1]),
    Quantity::Stage(STAGES[2]),
    Quantity::Stage(STAGES[3]),
    Quantity::Stage(STAGES[4]),
    Quantity::Stage(STAGES[5]),
    Quantity::Stage(STAGES[6]),
    Quantity::Stage(STAGES[7]),
    Quantity::FirstRow,
    Quantity::GazeRow,
    Quantity::LastRow,
    Quantity::CompletePass,
];

impl Quantity {
    /// Its place in [`QUANTITIES`].
    pub fn index(self) -> usize {
        match self {
            Self::Stage(stage) => stage as usize,
            Self::FirstRow => STAGES.len(),
            Self::GazeRow => STAGES.len() + 1,
            Self::LastRow => STAGES.len() + 2,
            Self::CompletePass => STAGES.len() + 3,
        }
    }

    /// As in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stage(stage) => stage.name(),
            Self::FirstRow => "gaze_to_photon_first_row",
            Self::GazeRow => "gaze_to_photon_gaze_row",
            Self::LastRow => "gaze_to_photon_last_row",
            Self::CompletePass => "gaze_to_photon_complete_pass",
        }
    }

    /// The exact range of the quantity.
    pub(super) fn bounds(self, stages: &StageBounds, edges: &Edges, sync: SyncMode) -> Interval {
        let to_flip = stages.until(Stage::FlipWait);
        match self {
            Self::Stage(stage) => stages.get(stage),
            Self::GazeRow => stages.total(),
            _ if sync != SyncMode::Tearing => {
                let row = if self == Self::FirstRow {
                    edges.top
                } else {
                    edges.bottom
                };
                to_flip + Interval::exactly(edges.lit(row))
            }
            _ => to_flip + self.after_flip(stages.refresh, edges),
        }
    }

    /// From a flip anywhere in the scan until the rows are lit, when the picture tears.
    fn after_flip(self, refresh: Nanos, edges: &Edges) -> Interval {
        let Edges {
            top,
            bottom,
            active,
            ..
        } = *edges;
        let pass = bottom - top;
        let settle = Interval::exactly(edges.response.settle);
        // The shortest wait has the beam arrive just after the flip; the longest has it just gone.
        let wait = match (edges.response.emission, self) {
            // The beam inside the layer renews something at once; just below it, the top is next.
            (Emission::Rolling, Self::FirstRow) => Interval::new(Nanos::ZERO, refresh - pass),
            // From just inside the layer, the last row renewed is the one just above the beam.
            (Emission::Rolling, Self::LastRow) => Interval::new(pass, refresh),
            (Emission::Rolling, _) => Interval::new(pass, refresh + pass),
            // Nothing is lit before the scan ends: what counts is which scan holds the rows.
            (Emission::Global, Self::FirstRow) => {
                Interval::new(active - bottom, refresh + active - bottom)
            }
            (Emission::Global, _) => Interval::new(active - top, refresh + active - top),
        };
        wait + settle
    }
}
