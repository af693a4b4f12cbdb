use foveasim_models::{GazeDirection, Nanos, Pose};

/// A gaze sample as the host has it: what, and how old.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GazeStamp {
    /// When its exposure started. For a recorded tracker output: when the reported gaze was so.
    pub exposure_start: Nanos,
    /// When its exposure ended (as the start for a recorded tracker output).
    pub exposure_end: Nanos,
    /// When it was ready to be sent. For a recorded tracker output: on delivery.
    pub processed: Nanos,
    /// When the host could first read it.
    pub delivered: Nanos,
    /// The gaze reported, relative to the head.
    pub value: GazeDirection,
}

impl GazeStamp {
    /// The time the sample speaks of: the middle of its exposure.
    pub fn middle(&self) -> Nanos {
        Nanos(self.exposure_start.0 + (self.exposure_end - self.exposure_start).0 / 2)
    }
}

/// A head pose as a frame used it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseStamp {
    /// When the newest pose that went into it was so.
    pub sampled: Nanos,
    /// The time it was predicted for.
    pub predicted_for: Nanos,
    /// The `world_from_head` the frame was drawn with.
    pub pose: Pose,
}

/// A finished frame: when it was rendered, and what it knew.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rendered {
    /// Frame number, from 0 in each run.
    pub id: u64,
    /// When the frame was started.
    pub start: Nanos,
    /// When the gaze was read: at the start, unless latched later.
    pub gaze_latched: Nanos,
    /// When the pose was read: at the start, unless latched later.
    pub pose_latched: Nanos,
    /// When rendering began: at the start, unless earlier frames were still being rendered.
    pub begun: Nanos,
    /// When it was finished.
    pub end: Nanos,
    /// The newest gaze delivered when it was read; `None` if there was none, or it was too old to use.
    pub gaze: Option<GazeStamp>,
    /// The pose it was drawn for; `None` without head tracking.
    pub pose: Option<PoseStamp>,
}

/// A late warp: the picture of a frame turned to a newer pose on its way to the display.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Warp {
    /// When the pose was read.
    pub latched: Nanos,
    /// When the warp was finished.
    pub end: Nanos,
    /// The pose it was turned to; `None` without head tracking.
    pub pose: Option<PoseStamp>,
}
