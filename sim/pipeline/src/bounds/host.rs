use foveasim_models::Nanos;

use super::BoundKind;
use super::backlog::{Backlog, BacklogFlips};
use super::locked::LockedFlip;
use super::meeting::Meeting;
use super::queue::Queue;
use super::ticks::{longest, periods, refreshes};
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
        let queued = |t: Nanos| match t > period {
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
        let (mut flip_wait, mut to_flip, mut flips) = (None, None, 0);
        let mut from_the_tick_before = Nanos::ZERO;
        let join = |so_far: &mut Option<Interval>, next: Interval| {
            *so_far = Some(so_far.map_or(next, |i| i.hull(next)));
        };
        for begun in flip.beginnings() {
            let blank = |t: Nanos| refreshes(rate, begun + t + lead);
            let ((first, _), (_, last)) = (blank(render.min), blank(render.max));
            let after = |n: i64, t: Nanos| (longest(rate, n) - lead - begun - t).max(Nanos::ZERO);
            join(
                &mut flip_wait,
                match first == last {
                    true => {
                        let least = rate.tick(first) - lead - begun - render.max;
                        Interval::new(least.max(Nanos::ZERO), after(first, render.min))
                    }
                    // One that ends just after the deadline waits for the next.
                    false => {
                        Interval::new(Nanos::ZERO, after(first, render.min).max(longest(rate, 1)))
                    }
                },
            );
            let least = (rate.tick(first) - begun).max(render.min + lead);
            join(
                &mut to_flip,
                Interval::new(least, longest(rate, last) - begun),
            );
            let before = match setup.host_rate == rate && cycle == longest(rate, 1) {
                true => longest(rate, last + 1) - begun,
                false => cycle + longest(rate, last) - begun,
            };
            from_the_tick_before = from_the_tick_before.max(before);
            let (_, next) = blank(cycle + render.max);
            flips = flips.max(next - first);
        }
        let to_flip = queue + to_flip.expect("frames begin somewhere");
        Self {
            cycle,
            wait,
            queue,
            flip_wait: flip_wait.expect("frames begin somewhere"),
            to_flip,
            wait_to_flip: queue.max + from_the_tick_before,
            flips: longest(rate, flips.max(1)),
            whole_is: BoundKind::Exact,
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
        let flip = LockedFlip::at_blanks(setup, render);
        let at_the_display = Setup {
            host_rate: setup.scan.rate,
            ..*setup
        };
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
            turn: Nanos::ZERO,
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
            wait: cycle,
            queue: Interval::ZERO,
            flip_wait,
            to_flip,
            wait_to_flip: cycle + to_flip.max,
            flips: longest(rate, steps + last),
            whole_is: BoundKind::Exact,
            parts_are: BoundKind::Exact,
            settling: Nanos::ZERO,
            turn: Nanos::ZERO,
        }
    }
}
