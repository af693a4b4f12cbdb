use foveasim_models::{Nanos, Rate};

use crate::runtime::LEAST_RESERVE;
use crate::{FrameStart, Interval, Missed, STAGES, Setup, Stage, SyncMode};

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

/// The shortest and the longest time of each stage and of the whole way to a row's light, whatever the
/// phases of the clocks and the draws of tracker and renderer.
///
/// All clocks tick at whole nanoseconds, so a period may be one nanosecond longer than its rate says;
/// the bounds include it.
///
/// The clocks' phases and all draws are independent, so that extremes of independent parts add up;
/// from the start of a frame to its flip, where the parts depend on each other, the sum is bounded as
/// a whole. Every bound of the whole way is attained (to the nanoseconds of rounding), with one
/// exception: more than one frame in flight with frames that render for longer than a refresh, or too
/// long for the compositor's lead. Such queues settle into cycles that depend on their history, and the
/// bounds hold but need not be reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StageBounds {
    stages: [Interval; STAGES.len()],
    /// From the movement to the flip.
    to_flip: Interval,
    /// How far the beam has come at every flip, if that is always the same.
    flip_at: Option<Nanos>,
    /// Longest time between vertical blanks.
    pub refresh: Nanos,
    /// Longest time from the start of a frame to the start of the next.
    pub host_cycle: Nanos,
}

/// From the moment a frame could be started to its flip.
#[derive(Debug, Clone, Copy)]
struct Host {
    /// Longest time from one frame's start to the next.
    cycle: Nanos,
    /// From its start until rendering begins.
    queue: Interval,
    /// From the end of rendering until the compositor takes it.
    flip_wait: Interval,
    /// From its start to its flip, as a whole.
    to_flip: Interval,
    /// Longest time from being ready to start to the flip: the wait for the start, and what follows.
    wait_to_flip: Nanos,
    /// Longest time between flips of new frames.
    flips: Nanos,
}

impl StageBounds {
    /// Bounds for the answer to `movement` in the row that is scanned `row` after the vertical blank,
    /// if frames of `setup` render for a time within `render`. Latches must not come later than the
    /// end of the shortest frame.
    pub fn new(setup: &Setup<'_>, render: Interval, row: Nanos, movement: Movement) -> Self {
        let refresh = longest(setup.scan.rate, 1);
        let host = Host::new(setup, render);
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
            let wait = Interval::new(Nanos::ZERO, host.cycle);
            let whole = Interval::new(host.to_flip.min - latch, host.wait_to_flip - latch);
            ([wait, queue, render, host.flip_wait], whole)
        };
        let buffered = match setup.scan.buffered_frames {
            0 => Interval::ZERO,
            n => periods(setup.scan.rate, i64::from(n)),
        };
        let flip_at = flip_at(setup, render);
        let scan_wait = match setup.sync {
            SyncMode::Tearing => match flip_at {
                Some(at) => about(until(row, at, refresh)),
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
            flip_at,
            refresh,
            host_cycle: host.cycle,
        }
    }

    /// How far after the vertical blank every flip of a torn picture is, if it is always the same.
    pub fn flip_at(&self) -> Option<Nanos> {
        self.flip_at
    }

    /// Bounds of one stage.
    pub fn get(&self, stage: Stage) -> Interval {
        self.stages[stage as usize]
    }

    /// From the movement to the flip.
    pub fn to_flip(&self) -> Interval {
        self.to_flip
    }

    /// From the movement until the panel is told: the flip, and the frames it holds.
    pub fn to_panel(&self) -> Interval {
        self.to_flip + self.get(Stage::DisplayBuffer)
    }

    /// The whole way, to the row's light.
    pub fn total(&self) -> Interval {
        self.to_panel()
            + self.get(Stage::ScanWait)
            + self.get(Stage::PixelResponse)
            + self.get(Stage::Persistence)
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

impl Host {
    fn new(setup: &Setup<'_>, render: Interval) -> Self {
        match (setup.sync, setup.runtime.start) {
            (SyncMode::Tearing | SyncMode::VsyncFree, _) => Self::free(setup, render),
            (SyncMode::Vsync, FrameStart::JustInTime { reserve }) => {
                Self::just_in_time(setup, render, reserve)
            }
            (SyncMode::Vsync, FrameStart::AtVblank) if setup.runtime.in_flight == 1 => {
                Self::blocked(setup, render)
            }
            (SyncMode::Vsync, FrameStart::AtVblank) => Self::queued(setup, render),
        }
    }

    /// Frames start with the host's own clock, or as soon as one of those in flight is finished.
    fn free(setup: &Setup<'_>, render: Interval) -> Self {
        let (period, refresh) = (longest(setup.host_rate, 1), longest(setup.scan.rate, 1));
        let ahead = i64::from(setup.runtime.in_flight) - 1;
        let cycle = render.max.max(period);
        // Frames that never wait for the clock wait for all those before them.
        let queued = |t: Nanos| match t > period {
            true => t * ahead,
            false => Nanos::ZERO,
        };
        let queue = Interval::new(queued(render.min), queued(render.max));
        let lead = Interval::exactly(setup.runtime.lead);
        let flip_wait = match (setup.sync, flip_at(setup, render)) {
            (SyncMode::Tearing, _) => Interval::ZERO,
            (_, Some(at)) => about(until(refresh, at + setup.runtime.lead, refresh)),
            _ => Interval::new(Nanos::ZERO, refresh),
        };
        let to_flip = queue + render + flip_wait + lead;
        // From the end of one frame to the end of the next: a short one before a long one.
        let ends = render.max.max(period + render.max - render.min);
        Self {
            cycle,
            queue,
            flip_wait,
            to_flip,
            wait_to_flip: cycle + to_flip.max,
            flips: longest(
                setup.scan.rate,
                setup.scan.rate.first_at_or_after(ends).max(1),
            ),
        }
    }

    /// Frames start at a vertical blank and flip at the first one that they are composed in time for;
    /// the next one starts there. At half rate, at every second.
    fn blocked(setup: &Setup<'_>, render: Interval) -> Self {
        let (rate, lead) = (setup.scan.rate, setup.runtime.lead);
        let (least, _) = refreshes(rate, render.min + lead);
        let (_, most) = refreshes(rate, render.max + lead);
        // A frame that misses its first refresh halves the rate: what follows takes even numbers.
        let held = |n: i64| match setup.runtime.missed == Missed::HalfRate && most > 1 {
            true if n > 1 => n + n % 2,
            _ => n,
        };
        let (least, most) = (held(least), held(most));
        let first = rate.tick(least).max(render.min + lead);
        let cycle = longest(rate, most);
        let jumps = least != most;
        let after = |t: Nanos, n: i64| (longest(rate, n) - lead - t).max(Nanos::ZERO);
        // A frame that ends just after a deadline waits for the next one.
        let step = match setup.runtime.missed {
            Missed::HalfRate => 2,
            _ => 1,
        };
        let flip_wait = Interval::new(
            match jumps {
                true => Nanos::ZERO,
                false => (rate.tick(least) - lead - render.max).max(Nanos::ZERO),
            },
            match jumps {
                true => after(render.min, least).max(longest(rate, step)),
                false => after(render.min, most),
            },
        );
        Self {
            cycle,
            queue: Interval::ZERO,
            flip_wait,
            to_flip: Interval::new(first, cycle),
            wait_to_flip: cycle + cycle,
            flips: cycle,
        }
    }

    /// As [`Host::blocked`], with more frames in flight.
    fn queued(setup: &Setup<'_>, render: Interval) -> Self {
        let (rate, lead) = (setup.scan.rate, setup.runtime.lead);
        let n = i64::from(setup.runtime.in_flight);
        let up = |t: Nanos| rate.first_at_or_after(t).max(1);
        let keeps_up = render.max <= rate.period() && render.max + lead <= rate.tick(n);
        if keeps_up {
            // Every blank flips one frame and starts one. When the first ones are rendered, and when
            // they then wait for their flips, is left open: n start at once, and the queue of those
            // that take nearly a refresh never empties.
            let whole = periods(rate, n);
            return Self {
                cycle: longest(rate, 1),
                queue: Interval::new(Nanos::ZERO, render.max * (n - 1)),
                flip_wait: Interval::new(Nanos::ZERO, whole.max - lead - render.min),
                to_flip: whole,
                wait_to_flip: longest(rate, n + 1),
                flips: longest(rate, 1),
            };
        }
        // A frame starts when the one n before it flips, which was finished a lead before. At worst the
        // n − 1 in between are all still to be rendered then, and so is the next to start.
        let (b, one) = (render.max, up(render.max));
        let most = (n + 1)
            .max(up(b * (n + 1)))
            .max(up(lead + b * 2))
            .max(one + up(lead + b));
        // At best only this frame is; flips are one a blank, and rendering goes on without a break if
        // no frame is shorter than a refresh.
        let busy = match render.min > rate.period() {
            true => rate.first_at_or_after(render.min * n - rate.period() + Nanos(1)),
            false => 1,
        };
        let least = n.max(up(render.min + lead)).max(busy);
        let whole = Interval::new(rate.tick(least), longest(rate, most));
        Self {
            cycle: longest(rate, one + 1),
            queue: Interval::new(Nanos::ZERO, b * (n - 1)),
            flip_wait: Interval::new(Nanos::ZERO, whole.max),
            to_flip: whole,
            wait_to_flip: whole.max,
            flips: longest(rate, up(b + lead) + 1),
        }
    }

    /// Frames start so that one that takes `reserve` is composed in time.
    fn just_in_time(setup: &Setup<'_>, render: Interval, reserve: Nanos) -> Self {
        let (rate, lead) = (setup.scan.rate, setup.runtime.lead);
        let reserve = reserve.max(LEAST_RESERVE);
        let late = |t: Nanos| match t > reserve {
            true => rate.first_at_or_after(t - reserve).max(1),
            false => 0,
        };
        let (first, last) = (late(render.min), late(render.max));
        let steps = rate.first_at_or_after(render.max).max(1);
        let cycle = longest(rate, steps);
        let to_flip = Interval::new(rate.tick(first), longest(rate, last))
            + Interval::exactly(reserve + lead);
        let early = |t: Nanos, n: i64| (longest(rate, n) + reserve - t).max(Nanos::ZERO);
        let flip_wait = match first == last {
            true => Interval::new(early(render.max, last), early(render.min, first)),
            // One that ends just after the deadline waits for the next.
            false => Interval::new(Nanos::ZERO, early(render.min, first).max(longest(rate, 1))),
        };
        Self {
            cycle,
            queue: Interval::ZERO,
            flip_wait,
            to_flip,
            wait_to_flip: cycle + to_flip.max,
            flips: longest(rate, steps + last),
        }
    }
}

/// When after a vertical blank frames end, if that is always the same: they all take the same time, at
/// most a period of a host whose clock is the display's.
fn flip_at(setup: &Setup<'_>, render: Interval) -> Option<Nanos> {
    let rate = setup.scan.rate;
    let steady = render.width() == Nanos::ZERO && render.max <= rate.period();
    let end = setup.runtime.host_lock? + render.max;
    (steady && setup.host_rate == rate).then(|| end - rate.tick(end_periods(rate, end)))
}

/// Whole periods within `t`.
fn end_periods(rate: Rate, t: Nanos) -> i64 {
    rate.first_at_or_after(t + Nanos(1)) - 1
}

/// From `at` after a vertical blank until `row` after one: this one, or the next.
pub fn until(row: Nanos, at: Nanos, refresh: Nanos) -> Nanos {
    let wait = row - at;
    match wait < Nanos::ZERO {
        true => wait + refresh,
        false => wait,
    }
}

/// A duration between ticks of one rate, which are rounded to the nanosecond.
fn about(t: Nanos) -> Interval {
    Interval::new((t - Nanos(1)).max(Nanos::ZERO), t + Nanos(1))
}

/// The longest time that `n` periods can take between ticks of whole nanoseconds.
fn longest(rate: Rate, n: i64) -> Nanos {
    -rate.tick(-n)
}

/// The shortest and the longest time that `n` periods can take.
fn periods(rate: Rate, n: i64) -> Interval {
    Interval::new(rate.tick(n), longest(rate, n))
}

/// Fewest and most periods, at least one, that something which takes `t` from a tick lasts to the tick
/// at or after its end: with the longest and with the shortest rounding.
fn refreshes(rate: Rate, t: Nanos) -> (i64, i64) {
    let most = rate.first_at_or_after(t).max(1);
    let fewest = match most > 1 && longest(rate, most - 1) >= t {
        true => most - 1,
        false => most,
    };
    (fewest, most)
}
