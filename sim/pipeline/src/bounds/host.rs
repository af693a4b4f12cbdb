use foveasim_models::Nanos;

use super::BoundKind;
use super::backlog::{Backlog, BacklogFlips};
use super::blanks::{Blanks, Flip};
use super::locked::{LockedFlip, overruns};
use super::meeting::Meeting;
use super::queue::Queue;
use super::ticks::{longest, periods, refreshes};
use super::unit::Unit;
use crate::runtime::LEAST_RESERVE;
use crate::{FrameStart, Interval, Missed, Setup, SyncMode};

/// From the moment a frame could be started to its flip.
#[derive(Debug, Clone, Copy)]
pub(super) struct Host {
    /// Longest time from one frame's start to the next.
    pub(super) cycle: Nanos,
    /// Longest time until the start of the frame that answers first: a newer one, where frames overlap.
    pub(super) wait: Nanos,
    /// From its start until rendering begins.
    pub(super) queue: Interval,
    /// From the end of rendering until the compositor takes it.
    pub(super) flip_wait: Interval,
    /// From its start to its flip, as a whole.
    pub(super) to_flip: Interval,
    /// Longest time from being ready to start to the flip: the wait for the start, and what follows.
    pub(super) wait_to_flip: Nanos,
    /// Longest time between flips of new frames.
    pub(super) flips: Nanos,
    /// Whether the whole is exact, and whether `queue` and `flip_wait` are.
    pub(super) whole_is: BoundKind,
    pub(super) parts_are: BoundKind,
    /// From the start of the host until it does what it always will, and how long it takes to come back to
    /// where it was, if it does so in turns.
    pub(super) settling: Nanos,
    pub(super) turn: Nanos,
}

/// What becomes of the queue of frames that take a refresh, less the part of a nanosecond, while a run lasts.
const SHRINKS: Nanos = Nanos(256);

/// Of frames in flight that take turns for longer than they are followed.
const UNKNOWN_TURN: Nanos = Nanos(i64::MAX);

/// How the frames of a host that runs freely follow each other.
struct Turns {
    cycle: Nanos,
    wait: Nanos,
    queue: Interval,
    /// Longest time from the end of one frame to the end of the next that is shown.
    ends: Nanos,
}

impl Turns {
    fn of(setup: &Setup<'_>, render: Interval) -> Self {
        let period = longest(setup.host_rate, 1);
        // A short frame before a long one.
        let uneven = period + render.width();
        if setup.runtime.overlapped {
            // Newer frames may be finished before an older one is: of the longest, the last that is.
            let overtaken = (render.width().0 - 1).max(0) / period.0;
            return Self {
                cycle: period,
                wait: period * (1 + overtaken),
                queue: Interval::ZERO,
                ends: uneven,
            };
        }
        let ahead = i64::from(setup.runtime.in_flight) - 1;
        // Frames that never wait for the clock wait for all those before them.
        let queued = |t: Nanos| match t > setup.host_rate.period() {
            true => t * ahead,
            false => Nanos::ZERO,
        };
        Self {
            cycle: render.max.max(period),
            wait: render.max.max(period),
            queue: Interval::new(queued(render.min), queued(render.max)),
            ends: render.max.max(uneven),
        }
    }
}

impl Host {
    pub(super) fn new(setup: &Setup<'_>, render: Interval, meeting: &Meeting) -> Self {
        match (setup.sync, setup.runtime.start) {
            (SyncMode::Tearing | SyncMode::VsyncFree, _) => Self::free(setup, render, meeting),
            (SyncMode::Vsync, FrameStart::JustInTime { reserve }) => {
                Self::just_in_time(setup, render, reserve)
            }
            (SyncMode::Vsync, FrameStart::AtVblank) if setup.runtime.overlapped => {
                Self::overlapped(setup, render)
            }
            (SyncMode::Vsync, FrameStart::AtVblank) if setup.runtime.in_flight == 1 => {
                Self::blocked(setup, render)
            }
            (SyncMode::Vsync, FrameStart::AtVblank) => Self::queued(setup, render),
        }
    }

    /// Frames start with the host's own clock, or as soon as one of those in flight is finished.
    fn free(setup: &Setup<'_>, render: Interval, meeting: &Meeting) -> Self {
        match meeting {
            Meeting::Places(flip) if setup.sync == SyncMode::VsyncFree => {
                return Self::locked(setup, flip);
            }
            Meeting::Mixed(backlog) => return Self::mixed(setup, backlog),
            _ => {}
        }
        let refresh = longest(setup.scan.rate, 1);
        let Turns {
            cycle,
            wait,
            queue,
            ends,
        } = Turns::of(setup, render);
        let lead = Interval::exactly(setup.runtime.lead);
        let flip_wait = match setup.sync {
            SyncMode::Tearing => Interval::ZERO,
            _ => Interval::new(Nanos::ZERO, refresh),
        };
        let whole_is = match meeting {
            Meeting::Unfollowed => BoundKind::Outer,
            _ => BoundKind::Exact,
        };
        let to_flip = queue + render + flip_wait + lead;
        Self {
            cycle,
            wait,
            queue,
            flip_wait,
            to_flip,
            wait_to_flip: cycle + to_flip.max,
            flips: longest(
                setup.scan.rate,
                setup.scan.rate.first_at_or_after(ends).max(1),
            ),
            whole_is,
            parts_are: BoundKind::Exact,
            settling: Nanos::ZERO,
            turn: Nanos::ZERO,
        }
    }

    /// As [`Host::free`], of frames that begin by how many wait for them.
    fn mixed(setup: &Setup<'_>, backlog: &Backlog) -> Self {
        let BacklogFlips {
            flip_wait,
            start_to_flip,
            wait_to_flip,
            flips,
        } = match setup.sync {
            // They flip when they end.
            SyncMode::Tearing => {
                let Interval { min, max } = backlog.to_end();
                BacklogFlips {
                    flip_wait: Interval::ZERO,
                    start_to_flip: Interval::new(min, max),
                    wait_to_flip: max,
                    flips: max,
                }
            }
            _ => backlog.flips(),
        };
        Self {
            cycle: backlog.cycle(),
            wait: backlog.cycle(),
            queue: backlog.queue(),
            flip_wait,
            to_flip: start_to_flip,
            wait_to_flip,
            flips,
            whole_is: BoundKind::Exact,
            parts_are: BoundKind::Exact,
            settling: Nanos::ZERO,
            turn: Nanos::ZERO,
        }
    }

    /// As [`Host::free`], of frames that begin in certain places of the refresh only.
    fn locked(setup: &Setup<'_>, flip: &LockedFlip) -> Self {
        let (rate, lead) = (setup.scan.rate, setup.runtime.lead);
        let render = flip.render;
        let Turns {
            cycle, wait, queue, ..
        } = Turns::of(setup, render);
        let each = || {
            flip.beginnings()
                .map(|blanks| (blanks, blanks.flip(render, lead)))
        };
        let hull =
            |of: fn(&Flip) -> Interval| each().map(|(_, flip)| of(&flip)).reduce(Interval::hull);
        let longest_of = |of: &dyn Fn(Blanks, Flip) -> i64| each().map(|(b, f)| of(b, f)).max();
        // The frame before began a period before, with the host's clock, or as long before as it takes.
        let overrun = overruns(setup, render);
        let from_the_one_before = longest_of(&|blanks,
                                               Flip {
                                                   blanks: [_, last], ..
                                               }| {
            match overrun {
                true => cycle + blanks.until(last).max,
                false => blanks.a_period_later().until(last).max,
            }
            .0
        });
        let flips = longest_of(&|blanks,
                                 Flip {
                                     blanks: [first, _], ..
                                 }| {
            blanks.first_after(cycle + render.max + lead)[1] - first
        });
        let somewhere = "frames begin somewhere";
        Self {
            cycle,
            wait,
            queue,
            flip_wait: hull(|flip| flip.wait).expect(somewhere),
            to_flip: queue + hull(|flip| flip.to_flip).expect(somewhere),
            wait_to_flip: queue.max + Nanos(from_the_one_before.expect(somewhere)),
            flips: longest(rate, flips.expect(somewhere).max(1)),
            // Whether a frame that is finished within a nanosecond of a deadline meets it is up to rounding.
            whole_is: match each().any(|(_, flip)| flip.open) {
                true => BoundKind::Outer,
                false => BoundKind::Exact,
            },
            parts_are: BoundKind::Exact,
            settling: Nanos::ZERO,
            turn: Nanos::ZERO,
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
        // A frame that ends just after a deadline waits for the next one; of a host held to every second
        // refresh, one that ends just after the second of them does, and the shortest waits for the second.
        let longest_wait = match setup.runtime.missed {
            _ if !jumps => after(render.min, most),
            Missed::HalfRate if most == 2 => after(render.min, 2),
            Missed::HalfRate => after(render.min, least.max(2)).max(longest(rate, 2)),
            _ => after(render.min, least).max(longest(rate, 1)),
        };
        let shortest_wait = match jumps {
            true => Nanos::ZERO,
            false => (rate.tick(least) - lead - render.max).max(Nanos::ZERO),
        };
        let flip_wait = Interval::new(shortest_wait, longest_wait);
        Self {
            cycle,
            wait: cycle,
            queue: Interval::ZERO,
            flip_wait,
            to_flip: Interval::new(first, cycle),
            wait_to_flip: cycle + cycle,
            flips: cycle,
            whole_is: BoundKind::Exact,
            parts_are: BoundKind::Exact,
            settling: Nanos::ZERO,
            turn: Nanos::ZERO,
        }
    }

    /// Frames start at every vertical blank and are rendered at once; the newest finished one flips.
    fn overlapped(setup: &Setup<'_>, render: Interval) -> Self {
        let at_the_display = Setup {
            host_rate: setup.scan.rate,
            ..*setup
        };
        let flip = LockedFlip::at_blanks(&at_the_display, render);
        Self::locked(&at_the_display, &flip)
    }

    /// As [`Host::blocked`], with more frames in flight.
    fn queued(setup: &Setup<'_>, render: Interval) -> Self {
        let (rate, lead) = (setup.scan.rate, setup.runtime.lead);
        let n = i64::from(setup.runtime.in_flight);
        let up = |t: Nanos| rate.first_at_or_after(t).max(1);
        let keeps_up = render.max <= rate.period() && render.max + lead <= rate.tick(n);
        if keeps_up {
            // Every blank flips one frame and starts one. n start at once, and the queue of those that
            // take nearly a refresh never empties; that of others does.
            let whole = periods(rate, n);
            let all = render.max * (n - up(render.max + lead));
            let fills = |queue: Interval| {
                let least = whole.min - lead - queue.max - render.max;
                let most = whole.max - lead - queue.min - render.min;
                Interval::new(least.max(Nanos::ZERO), most)
            };
            let never_empties = render.min == rate.period();
            let followed = match never_empties {
                true => None,
                false => Queue::follow(setup, render),
            };
            let (queue, flip_wait, parts_are, settling) = match followed {
                None if never_empties => {
                    // By less than a nanosecond a refresh: what runs see of it is far below a microsecond.
                    let queue = Interval::new((all - SHRINKS).max(Nanos::ZERO), all);
                    (queue, fills(queue), BoundKind::Exact, Nanos::ZERO)
                }
                Some(queue) => {
                    let settling = longest(rate, queue.settling);
                    (queue.waits, queue.flip_wait, BoundKind::Exact, settling)
                }
                None => {
                    let queue = Interval::new(Nanos::ZERO, render.max * (n - 1));
                    (queue, fills(queue), BoundKind::Outer, Nanos::ZERO)
                }
            };
            return Self {
                cycle: longest(rate, 1),
                wait: longest(rate, 1),
                queue,
                flip_wait,
                to_flip: whole,
                wait_to_flip: longest(rate, n + 1),
                flips: longest(rate, 1),
                whole_is: BoundKind::Exact,
                parts_are,
                settling,
                turn: Nanos::ZERO,
            };
        }
        if let Some(queue) = Queue::follow(setup, render) {
            let [least, most] = queue.start_to_flip;
            return Self {
                cycle: longest(rate, queue.cycle),
                wait: longest(rate, queue.cycle),
                queue: queue.waits,
                flip_wait: queue.flip_wait,
                to_flip: Interval::new(rate.tick(least), longest(rate, most)),
                wait_to_flip: longest(rate, queue.wait_to_flip),
                flips: longest(rate, queue.flips),
                whole_is: BoundKind::Exact,
                parts_are: BoundKind::Exact,
                settling: longest(rate, queue.settling),
                turn: longest(rate, queue.turn),
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
            wait: longest(rate, one + 1),
            queue: Interval::new(Nanos::ZERO, b * (n - 1)),
            flip_wait: Interval::new(Nanos::ZERO, whole.max),
            to_flip: whole,
            wait_to_flip: whole.max,
            flips: longest(rate, up(b + lead) + 1),
            whole_is: BoundKind::Outer,
            parts_are: BoundKind::Outer,
            settling: Nanos::ZERO,
            turn: UNKNOWN_TURN,
        }
    }

    /// Frames start so that one that takes `reserve` is composed in time. One that takes a refresh less than that,
    /// or several, flips as many blanks sooner.
    fn just_in_time(setup: &Setup<'_>, render: Interval, reserve: Nanos) -> Self {
        let (rate, lead) = (setup.scan.rate, setup.runtime.lead);
        let ahead = reserve.max(LEAST_RESERVE) + lead;
        let unit = Unit::of(setup);
        let blanks = Blanks::new(unit, -unit.of_nanos(ahead));
        let flip = blanks.flip(render, lead);
        let [_, last] = flip.blanks;
        // The next is meant for the first blank that it can still meet, as far on as this one takes.
        let steps = |t: Nanos| rate.first_at_or_after(t).max(1);
        let cycle = longest(rate, steps(render.max));
        let flips = |t: Nanos| steps(t) - blanks.first_after(t + lead)[0] + last;
        // This is longest for the shortest frame, the longest, or one that just misses a blank.
        let misses = |n: i64| Some(longest(rate, n) + Nanos(1)).filter(|t| render.contains(*t));
        let apart = (0..=steps(render.max))
            .filter_map(misses)
            .chain([render.min, render.max]);
        let flips = apart.map(flips).max().expect("there are frames").max(1);
        Self {
            cycle,
            wait: cycle,
            queue: Interval::ZERO,
            flip_wait: flip.wait,
            to_flip: flip.to_flip,
            wait_to_flip: longest(rate, steps(render.max) + last) + ahead,
            flips: longest(rate, flips),
            whole_is: match flip.open {
                true => BoundKind::Outer,
                false => BoundKind::Exact,
            },
            parts_are: BoundKind::Exact,
            settling: Nanos::ZERO,
            turn: Nanos::ZERO,
        }
    }
}
