use foveasim_models::{Emission, EyePanel, Nanos, PixelResponse, Pose, ScanClock, View};

use crate::{PoseStamp, Rendered, Warp};

/// A frame on the display.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// Which frame, and what it knew.
    pub frame: Rendered,
    /// When the compositor took it; at the flip, without one.
    pub composed: Nanos,
    /// When it became the buffer that is scanned.
    pub flipped: Nanos,
    /// How it was warped for this scan, if it was.
    pub warp: Option<Warp>,
}

impl Shown {
    /// When the pose was read that the picture agrees with.
    pub fn pose_latched(&self) -> Nanos {
        self.warp.map_or(self.frame.pose_latched, |w| w.latched)
    }

    /// The pose that the picture agrees with: the warp's, or else the frame's.
    pub fn pose(&self) -> Option<PoseStamp> {
        match &self.warp {
            Some(warp) => warp.pose.or(self.frame.pose),
            None => self.frame.pose,
        }
    }
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
    /// How much later the panel does what the host's scan-out does: the frames it holds.
    pub buffered: Nanos,
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

    /// When row boundary `row` is scanned on the panel.
    pub fn scanned(&self, row: u32) -> Nanos {
        self.vblank + self.buffered + self.clock.row_offset(row)
    }

    /// When row boundary `row` gives the light that counts.
    pub fn lit(&self, row: u32) -> Nanos {
        let offset = self.clock.row_offset(row);
        self.vblank + self.buffered + self.clock.lit_after_blank(&self.response, offset)
    }

    /// What a renderer needs to draw, for `panel`, each row as the world is seen when that row gives light: a view
    /// from the head's first to its last pose of the scan, where `head` says where it is, or is predicted to be, at a time. `None` where it
    /// does not know. A display that lights globally shows one moment: its view is still.
    pub fn rolling_view(
        &self,
        panel: &EyePanel,
        head: impl Fn(Nanos) -> Option<Pose>,
    ) -> Option<View> {
        let [first, last] = self.lit_span();
        let eye = |t: Nanos| Some(head(t)?.then(panel.head_from_eye));
        let view = match self.response.emission {
            Emission::Rolling => View::rolling(
                panel.eye,
                panel.viewport,
                [eye(first)?, eye(last)?],
                self.clock.picture_skew(),
            ),
            Emission::Global => View::still(panel.eye, panel.viewport, eye(first)?),
        };
        Some(view.seen_through(panel.lens()))
    }

    /// When the row boundary scanned first, and the one scanned last, give the light that counts.
    pub fn lit_span(&self) -> [Nanos; 2] {
        let edges = [self.lit(0), self.lit(self.clock.rows)];
        [edges[0].min(edges[1]), edges[0].max(edges[1])]
    }

    /// What a renderer needs to draw the image that `panel` shows at boundary `row`: a still view
    /// from the pose that the picture agrees with (from the origin without head tracking).
    pub fn view(&self, panel: &EyePanel, row: u32) -> Option<View> {
        let shown = self.at_row(row)?;
        let world_from_head = shown.pose().map_or(Pose::IDENTITY, |p| p.pose);
        Some(View::still(
            panel.eye,
            panel.viewport,
            world_from_head.then(panel.head_from_eye),
        ))
    }
}
