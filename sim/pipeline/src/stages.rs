use foveasim_models::{Emission, Nanos, Rate};

use crate::{GazeStamp, Interval, Rendered, Setup, SyncMode};

/// A leg of the way from an eye movement to light, in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(usize)]
pub enum Stage {
    /// From the movement to the start of the exposure that sees it.
    TrackerWait,
    /// The exposure.
    TrackerExposure,
    /// From the end of the exposure to delivery.
    TrackerProcessing,
    /// From delivery to the start of the frame that uses it.
    FrameWait,
    /// Rendering.
    Render,
    /// From the end of rendering until the display reads the frame, or a newer one.
    FlipWait,
    /// From the flip until the row is scanned.
    ScanWait,
    /// From scanned to lit.
    PixelResponse,
}

/// All stages in order.
pub const STAGES: [Stage; 8] = [
    Stage::TrackerWait,
    Stage::TrackerExposure,
    Stage::TrackerProcessing,
    Stage::FrameWait,
    Stage::Render,
    Stage::FlipWait,
    Stage::ScanWait,
    Stage::PixelResponse,
];

impl Stage {
    /// As in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::TrackerWait => "tracker_wait",
            Self::TrackerExposure => "tracker_exposure",
            Self::TrackerProcessing => "tracker_processing",
            Self::FrameWait => "frame_wait",
            Self::Render => "render",
            Self::FlipWait => "flip_wait",
            Self::ScanWait => "scan_wait",
            Self::PixelResponse => "pixel_response",
        }
    }
}

/// How long each stage took; they add up to the whole way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stages([Nanos; STAGES.len()]);

impl Stages {
    /// The way of an eye movement at `moved` through a gaze sample and `frame`, flipped, scanned and
    /// lit as given. `gaze` is the first sample that saw the movement; the first frame to start after
    /// its delivery may already use a newer one.
    pub fn new(
        moved: Nanos,
        gaze: &GazeStamp,
        frame: &Rendered,
        flipped: Nanos,
        scanned: Nanos,
        lit: Nanos,
    ) -> Self {
        let times = [
            moved,
            gaze.exposure_start,
            gaze.exposure_end,
            gaze.delivered,
            frame.start,
            frame.end,
            flipped,
            scanned,
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

/// The shortest and the longest time of each stage, for frames that all take the same time, whatever
/// the phases of the clocks.
///
/// All clocks tick at whole nanoseconds, so a period may be one nanosecond longer than its rate says;
/// the bounds include it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StageBounds {
    stages: [Interval; STAGES.len()],
    /// Longest time between vertical blanks.
    pub refresh: Nanos,
    /// Longest time from the start of a frame to the start of the next.
    pub host_cycle: Nanos,
}

impl StageBounds {
    /// Bounds for the row that is scanned `row` after the vertical blank, if every frame of `setup`
    /// renders for `render`.
    pub fn new(setup: &Setup<'_>, render: Nanos, row: Nanos) -> Self {
        let tracker = setup.tracker;
        let refresh = longest(setup.scan.rate, 1);
        let (host_cycle, flip_wait) = match setup.sync {
            SyncMode::Tearing => (render.max(longest(setup.host_rate, 1)), Interval::ZERO),
            SyncMode::VsyncFree => (
                render.max(longest(setup.host_rate, 1)),
                Interval::new(Nanos::ZERO, refresh),
            ),
            SyncMode::Vsync => blocked(setup.scan.rate, render),
        };
        let scan_wait = match setup.sync {
            SyncMode::Tearing => Interval::new(Nanos::ZERO, refresh),
            SyncMode::VsyncFree | SyncMode::Vsync => Interval::exactly(row),
        };
        let hold = match setup.response.emission {
            Emission::Rolling => Nanos::ZERO,
            Emission::Global => setup.scan.active() - row,
        };
        Self {
            stages: [
                Interval::new(Nanos::ZERO, longest(tracker.rate, 1)),
                Interval::exactly(tracker.exposure),
                Interval::new(tracker.processing_min, tracker.processing_max),
                Interval::new(Nanos::ZERO, host_cycle),
                Interval::exactly(render),
                flip_wait,
                scan_wait,
                Interval::exactly(hold + setup.response.settle),
            ],
            refresh,
            host_cycle,
        }
    }

    /// Bounds of one stage.
    pub fn get(&self, stage: Stage) -> Interval {
        self.stages[stage as usize]
    }

    /// From the eye movement to the end of `stage`.
    pub fn until(&self, stage: Stage) -> Interval {
        self.stages[..=stage as usize].iter().copied().sum()
    }

    /// The whole way, to the row's light.
    pub fn total(&self) -> Interval {
        self.until(Stage::PixelResponse)
    }
}

/// The longest time that `n` periods can take between ticks of whole nanoseconds.
fn longest(rate: Rate, n: i64) -> Nanos {
    -rate.tick(-n)
}

/// A host blocked on swap: its cycle, and the wait from the end of a frame to the vertical blank.
fn blocked(rate: Rate, render: Nanos) -> (Nanos, Interval) {
    // Most and fewest periods, at least one: with the shortest and with the longest rounding.
    let most = rate.first_at_or_after(render).max(1);
    let fewest = if most > 1 && longest(rate, most - 1) >= render {
        most - 1
    } else {
        most
    };
    let first = rate.tick(fewest).max(render);
    let cycle = longest(rate, most);
    (cycle, Interval::new(first - render, cycle - render))
}
