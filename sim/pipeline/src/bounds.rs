mod backlog;
mod blanks;
mod host;
mod locked;
mod meeting;
mod queue;
mod ticks;
mod unit;
mod zone;

use foveasim_models::Nanos;

use crate::{Interval, Missed, STAGES, Setup, Stage, SyncMode};
use host::Host;
use meeting::{Meeting, Torn};
use ticks::{longest, periods};

pub use locked::Beat;
pub use ticks::until;

/// Which movement is answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Movement {
    /// The eye steps, and the tracker sees it.
    Gaze,
    /// The head moves; a sample every `wait` at most reaches the host `delay` later.
    Head {
        /// Longest time between head samples; 0 if they are continuous.
        wait: Nanos,
        /// From a sample to the host having it.
        delay: Nanos,
    },
}

/// How good a bound is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BoundKind {
    /// It is reached, to the nanoseconds that clocks are rounded to.
    Exact,
    /// It holds, but need not be reached.
    Outer,
}

impl BoundKind {
    /// As in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Outer => "outer",
        }
    }

    /// Of two together: exact if both are.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Exact, Self::Exact) => Self::Exact,
            _ => Self::Outer,
        }
    }
}

/// The shortest and the longest time of each stage and of the whole way to a row's light, whatever the
/// phases of the clocks and the draws of tracker and renderer.
///
/// All clocks tick at whole nanoseconds, so a period may be one nanosecond longer than its rate says;
/// the bounds include it.
///
/// The clocks' phases and all draws are independent, so that extremes of independent parts add up;
/// from the start of a frame to its flip, where the parts depend on each other, the sum is bounded as
/// a whole. Frames in flight that are late are followed from one to the next until what they do repeats.
/// [`StageBounds::kind`] says which bounds are exact.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StageBounds {
    stages: [Interval; STAGES.len()],
    /// From the movement to the flip.
    to_flip: Interval,
    whole_is: BoundKind,
    parts_are: BoundKind,
    /// When frames flip, where the place of the beam then is not independent.
    torn: Option<Torn>,
    /// When after the vertical blank the row is scanned.
    row: Nanos,
    /// Longest time between vertical blanks.
    pub refresh: Nanos,
    /// Longest time from the start of a frame to the start of the next.
    pub host_cycle: Nanos,
    /// From the start of the host until it does what it always will: what happens before is not bounded.
    pub settling: Nanos,
    /// How long frames in flight take to come back to where they were, if they do so in turns; else 0. The longest
    /// time there is where that takes too long to find out.
    pub turn: Nanos,
    /// After how long host and display meet as they did.
    pub beat: Beat,
}

impl StageBounds {
    /// Bounds for the answer to `movement` in the row that is scanned `row` after the vertical blank,
    /// if frames of `setup` render for a time within `render`. Latches must not come later than the
    /// end of the shortest frame.
    pub fn new(setup: &Setup<'_>, render: Interval, row: Nanos, movement: Movement) -> Self {
        let refresh = longest(setup.scan.rate, 1);
        let beat = Beat::of(setup, render);
        let meeting = Meeting::of(setup, render);
        let host = Host::new(setup, render, &meeting);
        let (runtime, lead) = (&setup.runtime, setup.runtime.lead);
        let sensing = sensing(setup, movement);
        let latch = match movement {
            Movement::Gaze => runtime.gaze_latch,
            Movement::Head { .. } => runtime.pose_latch,
        };
        let warped = matches!(movement, Movement::Head { .. }) && runtime.warp.is_some();
        let (frame, delivered_to_flip) = if warped {
            let wait = match runtime.missed {
                Missed::Reproject => refresh,
                Missed::Repeat | Missed::HalfRate => host.flips,
            };
            let wait = Interval::new(Nanos::ZERO, wait);
            let none = Interval::ZERO;
            ([wait, none, none, none], wait + Interval::exactly(lead))
        } else {
            let beyond = |t: Nanos| (t - latch).max(Nanos::ZERO);
            let within = |t: Nanos| (latch - t).max(Nanos::ZERO);
            let queue = Interval::new(beyond(host.queue.min), beyond(host.queue.max));
            let render = Interval::new(
                render.min - within(host.queue.min),
                render.max - within(host.queue.max),
            );
            let wait = Interval::new(Nanos::ZERO, host.wait);
            let whole = Interval::new(host.to_flip.min - latch, host.wait_to_flip - latch);
            ([wait, queue, render, host.flip_wait], whole)
        };
        let buffered = match setup.scan.buffered_frames {
            0 => Interval::ZERO,
            n => periods(setup.scan.rate, i64::from(n)),
        };
        let torn = match setup.sync {
            SyncMode::Tearing => Torn::of(&meeting),
            _ => None,
        };
        let scan_wait = match setup.sync {
            SyncMode::Tearing => match &torn {
                Some(torn) => torn.wait(refresh, row),
                None => Interval::new(Nanos::ZERO, refresh),
            },
            SyncMode::VsyncFree | SyncMode::Vsync => Interval::exactly(row),
        };
        let response = &setup.response;
        let lit = setup.scan.lit_after_blank(response, row) - row - response.to_counted_light;
        let [wait, queue, render, flip_wait] = frame;
        let [s0, s1, s2, s3] = sensing;
        Self {
            stages: [
                s0,
                s1,
                s2,
                s3,
                wait,
                queue,
                render,
                flip_wait,
                Interval::exactly(lead),
                buffered,
                scan_wait,
                Interval::exactly(lit),
                Interval::exactly(response.to_counted_light),
            ],
            to_flip: sensing.into_iter().sum::<Interval>() + delivered_to_flip,
            whole_is: match warped && runtime.missed == Missed::Reproject {
                true => BoundKind::Exact,
                false => host.whole_is,
            },
            parts_are: match warped {
                true => BoundKind::Exact,
                false => host.parts_are,
            },
            torn,
            row,
            refresh,
            host_cycle: host.cycle,
            settling: host.settling,
            turn: host.turn,
            beat,
        }
    }

    /// Whether the bounds of a stage are reached.
    pub fn kind(&self, stage: Stage) -> BoundKind {
        match stage {
            // What does not vary is what it is.
            _ if self.get(stage).width() == Nanos::ZERO => BoundKind::Exact,
            Stage::FrameWait => self.whole_is,
            Stage::ScanWait => self.whole_kind(&[self.row]),
            Stage::FrameQueue | Stage::Render | Stage::FlipWait => self.parts_are,
            _ => BoundKind::Exact,
        }
    }

    /// Whether the bounds of the whole way are reached, if its end jumps where a picture tears at one of `edges`.
    pub fn whole_kind(&self, edges: &[Nanos]) -> BoundKind {
        match self.torn.as_ref().is_some_and(|torn| torn.is_open(edges)) {
            true => BoundKind::Outer,
            false => self.whole_is,
        }
    }

    /// Bounds of one stage.
    pub fn get(&self, stage: Stage) -> Interval {
        self.stages[stage as usize]
    }

    /// From the movement to the flip.
    pub fn to_flip(&self) -> Interval {
        self.to_flip
    }

    /// From the movement until the panel is told, and `after` that, where the place of the beam at the flip depends
    /// on when it is; else `None`. `after` is told how far the beam has come; it may jump where the beam passes one
    /// of `edges`, and is steady or falls by as much as the beam goes on in between.
    pub fn torn(&self, edges: &[Nanos], after: impl Fn(Nanos) -> Nanos) -> Option<Interval> {
        let torn = self.torn.as_ref()?;
        let (whole, depends) = (self.to_flip, torn.to_flip());
        let before = Interval::new(whole.min - depends.min, whole.max - depends.max);
        let way = torn.way(self.refresh, edges, after);
        Some(before + self.get(Stage::DisplayBuffer) + way)
    }

    /// From the movement until the panel is told: the flip, and the frames it holds.
    pub fn to_panel(&self) -> Interval {
        self.to_flip + self.get(Stage::DisplayBuffer)
    }

    /// The whole way, to the row's light.
    pub fn total(&self) -> Interval {
        let after = |beam| until(self.row, beam, self.refresh);
        let to_row = match self.torn(&[self.row], after) {
            Some(way) => way,
            None => self.to_panel() + self.get(Stage::ScanWait),
        };
        to_row + self.get(Stage::PixelResponse) + self.get(Stage::Persistence)
    }
}

/// From the movement until the host knows: wait, exposure, processing, transport.
fn sensing(setup: &Setup<'_>, movement: Movement) -> [Interval; 4] {
    let tracker = setup.tracker;
    match movement {
        Movement::Gaze => {
            // Just after an exposure has begun the eye is lost for as long as can be: all exposures
            // that begin until then are lost, and the next one is seen.
            let lost = match tracker.longest_loss() {
                Nanos::ZERO => 0,
                loss => tracker.rate.first_at_or_after(loss),
            };
            [
                Interval::new(Nanos::ZERO, longest(tracker.rate, 1 + lost)),
                Interval::exactly(tracker.exposure),
                Interval::new(tracker.processing.min(), tracker.processing.max()),
                Interval::new(tracker.transport.min(), tracker.transport.max()),
            ]
        }
        Movement::Head { wait, delay } => [
            Interval::new(Nanos::ZERO, wait),
            Interval::ZERO,
            Interval::ZERO,
            Interval::exactly(delay),
        ],
    }
}
