use foveasim_models::{GazeDirection, Nanos, Pose};
use foveasim_pipeline::{PoseStamp, Rendered, Stages};
use foveasim_reports::Cell;

/// Where a frame's fovea came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum GazeState {
    /// From the tracker, in time.
    Tracked,
    /// From the tracker's last sample, because newer ones are missing (a blink, a lost track).
    Held,
    /// There was no sample, or only one too old to use: the fovea is at the centre.
    Lost,
    /// The fovea stays at the centre on purpose.
    Fixed,
}

impl GazeState {
    /// Every state, in the order in which they are counted.
    pub const ALL: [Self; 4] = [Self::Tracked, Self::Held, Self::Lost, Self::Fixed];

    /// As in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tracked => "tracked",
            Self::Held => "held",
            Self::Lost => "lost",
            Self::Fixed => "fixed",
        }
    }
}

/// One displayed frame: a scan, at the row the eye looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplayFrame {
    /// Refresh number, from 0.
    pub scan: i64,
    /// When the scan began.
    pub vblank: Nanos,
    /// The frame that lit the gaze row, and what it knew.
    pub frame: Rendered,
    /// When the compositor took it; at the flip, without one.
    pub composed: Nanos,
    /// Whether it was warped late.
    pub warped: bool,
    /// When that frame became the buffer that is scanned.
    pub flipped: Nanos,
    /// The pose that the picture in that row agrees with: the frame's, or a late warp's.
    pub pose: Option<PoseStamp>,
    /// Where the time went from the start of the exposure that the frame used to its light; `None`
    /// without one.
    pub stages: Option<Stages>,
    /// The frames of the first and the last row; `None` where no frame was shown yet. They differ
    /// where the picture tears.
    pub frame_ids: [Option<u64>; 2],
    /// The row looked at (of the true gaze in the middle of the scan; of the fovea, if that is not
    /// known).
    pub gaze_row: u32,
    /// When the gaze row was scanned.
    pub scanned: Nanos,
    /// When the gaze row gave light.
    pub lit: Nanos,
    /// Where the fovea was drawn, relative to the head.
    pub fovea: GazeDirection,
    /// Where that came from.
    pub state: GazeState,
    /// Where the eye was when the gaze row gave light, relative to the head; `None` if not recorded.
    pub true_gaze: Option<GazeDirection>,
    /// The angle between where the head was and where the frame in the middle row took it to be, when
    /// that row gave light \[deg\]; `None` without head motion.
    pub head_error_deg: Option<f64>,
    /// Where the head was when the first and when the last row scanned gave light, `world_from_head`; `None` without head motion, and on
    /// displays that light all rows at once.
    pub heads: Option<[Pose; 2]>,
}

/// Columns of the replay table.
///
/// Times count from the start of the recording. `gaze_age_ms` is from the middle of the exposure that
/// the frame used, `exposure_to_photon_ms` from its start, both to the light of the gaze row.
/// `gaze_error_deg` is the angle between the true gaze and the drawn fovea at that moment.
pub const REPLAY_COLUMNS: [&str; 16] = [
    "scan",
    "vblank_ms",
    "frame",
    "frame_first_row",
    "frame_last_row",
    "gaze_row",
    "lit_ms",
    "gaze_state",
    "gaze_age_ms",
    "exposure_to_photon_ms",
    "true_azimuth_deg",
    "true_elevation_deg",
    "fovea_azimuth_deg",
    "fovea_elevation_deg",
    "gaze_error_deg",
    "head_error_deg",
];

impl ReplayFrame {
    /// From the middle of the exposure that the frame used to its light.
    pub fn gaze_age(&self) -> Option<Nanos> {
        self.frame.gaze.map(|g| self.lit - g.middle())
    }

    /// From the start of the exposure that the frame used to its light.
    pub fn exposure_to_photon(&self) -> Option<Nanos> {
        self.frame.gaze.map(|g| self.lit - g.exposure_start)
    }

    /// The angle between the true gaze and the drawn fovea when the gaze row gave light \[deg\].
    pub fn gaze_error_deg(&self) -> Option<f64> {
        self.true_gaze.map(|truth| truth.angle_to_deg(self.fovea))
    }

    /// `world_from_head` as a rolling picture has it at the end of its scan: [`head`](Self::head), moved on as the head
    /// moved while the frame was scanned.
    pub fn head_at_end(&self) -> Pose {
        let moved = self.heads.map(|[first, last]| first.inverse().then(last));
        moved.map_or(self.head(), |moved| self.head().then(moved))
    }

    /// `world_from_head` as the picture has it (the origin without head motion).
    pub fn head(&self) -> Pose {
        self.pose.map_or(Pose::IDENTITY, |p| p.pose)
    }

    /// The row of a table of [`REPLAY_COLUMNS`], times from `start`.
    pub fn row(&self, start: Nanos) -> Vec<Cell> {
        let ms = |t: Nanos| Cell::from((t - start).as_ms());
        let lasting = |t: Option<Nanos>| Cell::from(t.map(Nanos::as_ms));
        vec![
            self.scan.into(),
            ms(self.vblank),
            self.frame.id.into(),
            self.frame_ids[0].into(),
            self.frame_ids[1].into(),
            self.gaze_row.into(),
            ms(self.lit),
            self.state.name().into(),
            lasting(self.gaze_age()),
            lasting(self.exposure_to_photon()),
            self.true_gaze.map(|g| g.azimuth_deg).into(),
            self.true_gaze.map(|g| g.elevation_deg).into(),
            self.fovea.azimuth_deg.into(),
            self.fovea.elevation_deg.into(),
            self.gaze_error_deg().into(),
            self.head_error_deg.into(),
        ]
    }
}
