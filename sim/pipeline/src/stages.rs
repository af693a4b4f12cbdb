use foveasim_models::Nanos;

use crate::{Displayed, GazeStamp, Rendered, Shown};

/// A leg of the way from a movement to light, in order.
///
/// A movement of the head takes the same way as one of the eye, but for the first four: there they
/// are the wait for the next head sample, nothing twice, and the head tracker's delay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(usize)]
pub enum Stage {
    /// From the movement to the start of the exposure that sees it.
    TrackerWait,
    /// The exposure.
    TrackerExposure,
    /// From the end of the exposure until the sample is ready.
    TrackerProcessing,
    /// From there to delivery.
    TrackerTransport,
    /// From delivery until a frame reads it: at its start, or where it latches.
    FrameWait,
    /// From there until rendering begins: earlier frames are rendered first.
    FrameQueue,
    /// Rendering, from there or from the latch.
    Render,
    /// From the end of rendering until the compositor (without one: the display) takes the frame, or
    /// a newer one.
    FlipWait,
    /// From there until the display reads it: the compositor's lead, late warp included.
    Compose,
    /// Frames held in the display.
    DisplayBuffer,
    /// From there until the row is scanned.
    ScanWait,
    /// From scanned to lit.
    PixelResponse,
    /// From first lit to the light that counts.
    Persistence,
}

/// All stages in order.
pub const STAGES: [Stage; 13] = [
    Stage::TrackerWait,
    Stage::TrackerExposure,
    Stage::TrackerProcessing,
    Stage::TrackerTransport,
    Stage::FrameWait,
    Stage::FrameQueue,
    Stage::Render,
    Stage::FlipWait,
    Stage::Compose,
    Stage::DisplayBuffer,
    Stage::ScanWait,
    Stage::PixelResponse,
    Stage::Persistence,
];

impl Stage {
    /// As in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::TrackerWait => "tracker_wait",
            Self::TrackerExposure => "tracker_exposure",
            Self::TrackerProcessing => "tracker_processing",
            Self::TrackerTransport => "tracker_transport",
            Self::FrameWait => "frame_wait",
            Self::FrameQueue => "frame_queue",
            Self::Render => "render",
            Self::FlipWait => "flip_wait",
            Self::Compose => "compose",
            Self::DisplayBuffer => "display_buffer",
            Self::ScanWait => "scan_wait",
            Self::PixelResponse => "pixel_response",
            Self::Persistence => "persistence",
        }
    }

    /// Whether every chain has it. The others belong to parts that can be off, and are then left out
    /// of tables.
    pub fn is_basic(self) -> bool {
        !matches!(
            self,
            Self::TrackerTransport
                | Self::FrameQueue
                | Self::Compose
                | Self::DisplayBuffer
                | Self::Persistence
        )
    }
}

/// When a sample of the eye or the head was made, and when the host had it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sensed {
    /// The measurement begins (exposure), ends, is ready, and is delivered.
    pub times: [Nanos; 4],
}

impl From<&GazeStamp> for Sensed {
    fn from(gaze: &GazeStamp) -> Self {
        let GazeStamp {
            exposure_start,
            exposure_end,
            processed,
            delivered,
            ..
        } = *gaze;
        Self {
            times: [exposure_start, exposure_end, processed, delivered],
        }
    }
}

/// How long each stage took; they add up to the whole way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stages([Nanos; STAGES.len()]);

impl Stages {
    /// The way of an eye movement at `moved` through a gaze sample and `frame`, to row boundary `row`
    /// of `scan`, which shows `shown`. `gaze` is the first sample that saw the movement; the first
    /// frame to read the gaze after its delivery may already use a newer one, and what is shown may be
    /// a newer frame.
    pub fn of_gaze(
        moved: Nanos,
        gaze: &GazeStamp,
        frame: &Rendered,
        shown: &Shown,
        scan: &Displayed,
        row: u32,
    ) -> Self {
        let rendered = [frame.gaze_latched, frame.begun, frame.end];
        Self::new(moved, gaze.into(), rendered, shown, scan, row)
    }

    /// The way of a head movement at `moved` through a head sample, and `frame` or else the warp of
    /// what is shown.
    pub fn of_motion(
        moved: Nanos,
        head: Sensed,
        frame: &Rendered,
        shown: &Shown,
        scan: &Displayed,
        row: u32,
    ) -> Self {
        let rendered = match &shown.warp {
            Some(warp) => [warp.latched; 3],
            None => [frame.pose_latched, frame.begun, frame.end],
        };
        // A warp of an old frame is composed when it latches; the frame was long before.
        let shown = Shown {
            composed: shown.composed.max(rendered[2]),
            flipped: shown.flipped.max(scan_flip(shown, scan)),
            ..*shown
        };
        Self::new(moved, head, rendered, &shown, scan, row)
    }

    fn new(
        moved: Nanos,
        sensed: Sensed,
        [latched, begun, end]: [Nanos; 3],
        shown: &Shown,
        scan: &Displayed,
        row: u32,
    ) -> Self {
        let [exposure_start, exposure_end, processed, delivered] = sensed.times;
        let lit = scan.lit(row);
        let times = [
            moved,
            exposure_start,
            exposure_end,
            processed,
            delivered,
            latched,
            begun.max(latched),
            end,
            shown.composed,
            shown.flipped,
            shown.flipped + scan.buffered,
            scan.scanned(row),
            lit - scan.response.to_counted_light,
            lit,
        ];
        Self(std::array::from_fn(|i| times[i + 1] - times[i]))
    }

    /// The share of one stage.
    pub fn get(&self, stage: Stage) -> Nanos {
        self.0[stage as usize]
    }

    /// All of them together.
    pub fn total(&self) -> Nanos {
        self.0.iter().fold(Nanos::ZERO, |sum, t| sum + *t)
    }
}

/// A picture warped anew for this scan counts as flipped with it.
fn scan_flip(shown: &Shown, scan: &Displayed) -> Nanos {
    match &shown.warp {
        Some(warp) if warp.latched > shown.composed => scan.vblank,
        _ => shown.flipped,
    }
}
