use foveasim_models::{EyePanel, Nanos, PixelResponse, Pose, ScanClock, View};

use crate::Rendered;
use foveasim_models::Emission;

/// A frame on the display.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// Which frame, and what it knew.
    pub frame: Rendered,
    /// When it became the buffer that is scanned.
    pub flipped: Nanos,
}

/// Part of a scan, from one flip to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Time after the vertical blank at which the beam begins to read this frame. A row belongs to
    /// the segment in which its scan begins; in between, the position is continuous.
    pub from: Nanos,
    /// The frame; `None` before the first one is finished.
    pub shown: Option<Shown>,
}

/// One complete scan-out: which frame lit which rows, and when.
#[derive(Debug, Clone, PartialEq)]
pub struct Displayed {
    /// Refresh number, from 0 in each run.
    pub scan: i64,
    /// When the scan began.
    pub vblank: Nanos,
    /// When the next one begins.
    pub next_vblank: Nanos,
    /// Row times.
    pub clock: ScanClock,
    /// From scanned to lit.
    pub response: PixelResponse,
    /// From top to bottom, at least one, the first from 0. More than one where the picture tears.
    pub segments: Vec<Segment>,
}

impl Displayed {
    /// The segment that the beam reads `offset` after the vertical blank.
    pub fn segment_at(&self, offset: Nanos) -> &Segment {
        let after = self.segments.partition_point(|s| s.from <= offset);
        &self.segments[after.max(1) - 1]
    }

    /// The frame that lights row boundary `row` (0 = top edge).
    pub fn at_row(&self, row: u32) -> Option<&Shown> {
        self.segment_at(self.clock.row_offset(row)).shown.as_ref()
    }

    /// When row boundary `row` is scanned.
    pub fn scanned(&self, row: u32) -> Nanos {
        self.vblank + self.clock.row_offset(row)
    }

    /// When what is scanned at `scanned` gives light.
    pub fn lit_after(&self, scanned: Nanos) -> Nanos {
        self.response.settle
            + match self.response.emission {
                Emission::Rolling => scanned,
                Emission::Global => self.vblank + self.clock.active(),
            }
    }

    /// When row boundary `row` gives light.
    pub fn lit(&self, row: u32) -> Nanos {
        self.lit_after(self.scanned(row))
    }

    /// What a renderer needs to draw the image that `panel` shows at boundary `row`: a still view
    /// from the pose that frame was predicted to have (from the origin without head tracking).
    pub fn view(&self, panel: &EyePanel, row: u32) -> Option<View> {
        let frame = &self.at_row(row)?.frame;
        let world_from_head = frame.pose.map_or(Pose::IDENTITY, |p| p.pose);
        Some(View::still(
            panel.eye,
            panel.viewport,
            world_from_head.then(panel.head_from_eye),
        ))
    }
}
