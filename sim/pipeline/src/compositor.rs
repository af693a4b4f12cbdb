//! The compositor and the display: which frame is scanned, how it is warped, and when.

use foveasim_models::Nanos;

use crate::pipeline::{Event, Run};
use crate::{FrameStart, Missed, Segment, Shown, SyncMode, Warp};

/// A host that was held to every second refresh is let go after that many frames in a row that would
/// have been in time for each.
const RECOVERED: u32 = 3;

impl Run<'_, '_> {
    /// The compositor takes a frame for the scan that begins at `vblank`, or warps the old one.
    pub(crate) fn compose(&mut self, vblank: Nanos) {
        let now = self.calendar.now();
        self.keep_half_rate();
        // A host at half rate is shown at the times it was promised.
        let due = self.halved.is_none() || (self.scan.scan + 1 - self.start_scan) % 2 == 0;
        let frame = match due {
            true => self.ready.pop_front(),
            false => None,
        };
        if let Some(frame) = frame {
            let in_time =
                frame.end - frame.begun + self.setup.runtime.lead <= self.setup.scan.rate.period();
            self.halved = match self.halved {
                Some(_) if !in_time => Some(0),
                Some(good) if good + 1 < RECOVERED => Some(good + 1),
                _ => None,
            };
            let warp = self.warp(vblank);
            let shown = Shown {
                frame,
                composed: now,
                flipped: vblank,
                warp,
            };
            self.composed = Some((shown, true));
        } else if self.setup.runtime.missed == Missed::Reproject
            && let Some(shown) = self.front
        {
            let warp = self.warp(vblank);
            self.composed = Some((Shown { warp, ..shown }, false));
        }
    }

    /// A frame that is not ready for the first refresh after its start puts the host to half rate.
    fn keep_half_rate(&mut self) {
        let first = self.scan.scan == self.start_scan;
        let missed = self.ready.is_empty() && !self.in_work.is_empty();
        if self.setup.runtime.missed == Missed::HalfRate && first && missed {
            self.halved = Some(0);
        }
    }

    fn warp(&mut self, vblank: Nanos) -> Option<Warp> {
        let cost = self.setup.runtime.warp?;
        let latched = self.calendar.now();
        let pose = self.pose_for(vblank + self.middle_row_lit());
        Some(Warp {
            latched,
            end: latched + cost,
            pose,
        })
    }

    /// The rest of the scan going on reads the new front buffer.
    pub(crate) fn tear(&mut self, now: Nanos) {
        let from = now - self.scan.vblank;
        if self.scan.scan < 0 || from >= self.active {
            return; // before the first scan, or in blanking
        }
        let segment = Segment {
            from,
            shown: self.front,
        };
        match self.scan.segments.last_mut() {
            Some(last) if last.from == from => *last = segment,
            _ => self.scan.segments.push(segment),
        }
    }

    /// What was composed flips (when tearing, it did at once); a scan begins.
    pub(crate) fn vblank(&mut self) {
        let now = self.calendar.now();
        let waits = self.setup.sync == SyncMode::Vsync;
        if self.setup.sync != SyncMode::Tearing && self.setup.runtime.lead == Nanos::ZERO {
            self.compose(now);
        }
        if let Some((shown, new)) = self.composed.take() {
            self.front = Some(shown);
            if new && waits {
                self.unflipped -= 1;
            }
        }
        self.scan.scan += 1;
        self.scan.vblank = now;
        self.scan.segments.clear();
        self.scan.segments.push(Segment {
            from: Nanos::ZERO,
            shown: self.front,
        });
        self.plan_vblank();
        self.scan.buffered = self.buffered();
        self.plan(now + self.active, Event::ScanEnd);
        let runtime = &self.setup.runtime;
        let slots = runtime.overlapped || self.unflipped < runtime.in_flight;
        if waits && slots && self.setup.runtime.start == FrameStart::AtVblank {
            self.plan(now, Event::FrameStart);
        }
    }
}
