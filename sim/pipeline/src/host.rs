//! The host: when frames start, what they know, and when they are finished.

use std::ops::ControlFlow;

use foveasim_models::{Emission, FrameInput, Nanos};

use crate::pipeline::{Event, Run};
use crate::runtime::LEAST_RESERVE;
use crate::{FrameStart, GazeStamp, PoseStamp, Rendered, Shown, Sink, SyncMode};

impl Run<'_, '_> {
    fn in_flight_is_full(&self) -> bool {
        let runtime = &self.setup.runtime;
        !runtime.overlapped && self.in_work.len() >= runtime.in_flight as usize
    }

    /// A host that runs freely is due to start a frame.
    pub(crate) fn host_tick(&mut self) {
        if self.in_flight_is_full() {
            self.overdue = true;
            return;
        }
        self.start_frame();
        while self.setup.filled && !self.setup.runtime.overlapped && !self.in_flight_is_full() {
            self.start_frame();
        }
    }

    /// A host that waited may start a frame.
    pub(crate) fn frame_start(&mut self) {
        match (self.setup.sync, self.setup.runtime.start) {
            (SyncMode::Vsync, FrameStart::AtVblank) if self.setup.runtime.overlapped => {
                self.start_frame();
            }
            (SyncMode::Vsync, FrameStart::AtVblank) => {
                while self.unflipped < self.setup.runtime.in_flight {
                    self.start_frame();
                }
            }
            (SyncMode::Vsync, FrameStart::JustInTime { .. }) => self.start_frame(),
            _ => {
                // A tick at the same time may have started it already, and it may have ended already.
                let started = self.last_start == Some(self.calendar.now());
                if !self.in_flight_is_full() && !started {
                    self.start_frame();
                }
            }
        }
    }

    /// Plans the next frame to be finished, if it takes `reserve`, when the compositor takes it: for
    /// the first vertical blank that is not served yet and can still be met.
    pub(crate) fn plan_just_in_time(&mut self, reserve: Nanos) {
        let (rate, phase) = (self.setup.scan.rate, self.setup.phases.vblank);
        let ahead = self.setup.runtime.lead + reserve.max(LEAST_RESERVE);
        let soonest = rate.first_at_or_after(self.calendar.now() + ahead - phase);
        self.target = soonest.max(self.target.saturating_add(1));
        self.plan(phase + rate.tick(self.target) - ahead, Event::FrameStart);
    }

    /// The newest gaze delivered, if it is not too old to use.
    fn usable_gaze(&self) -> Option<GazeStamp> {
        let now = self.calendar.now();
        self.gaze
            .filter(|g| now - g.middle() <= self.setup.gaze_max_age)
    }

    /// The newest pose, predicted for `shown`.
    pub(crate) fn pose_for(&mut self, shown: Nanos) -> Option<PoseStamp> {
        let now = self.calendar.now();
        self.pose_feed.as_mut()?.predict(now, shown)
    }

    /// The host reads gaze and pose, unless it latches them later, and starts rendering.
    fn start_frame(&mut self) {
        let now = self.calendar.now();
        self.overdue = false;
        self.last_start = Some(now);
        self.start_scan = self.scan.scan;
        if self.setup.sync == SyncMode::Vsync {
            self.unflipped += 1;
        }
        let gaze = self.usable_gaze();
        let pose = match self.pose_feed {
            None => None,
            Some(_) => self.pose_for(self.expected_photon_time(now)),
        };
        let id = self.frames_started;
        self.frames_started += 1;
        let input = FrameInput {
            id,
            start: now,
            gaze: gaze.map(|g| g.value),
            pose: pose.map(|p| p.pose),
        };
        let duration = self.setup.cost.duration(&input).max(Nanos::ZERO);
        self.last_duration = duration;
        let runtime = &self.setup.runtime;
        let before = self.in_work.back().filter(|_| !runtime.overlapped);
        let begun = before.map_or(now, |f| f.end.max(now));
        let end = begun + duration;
        let frame = Rendered {
            id,
            start: now,
            gaze_latched: (now + runtime.gaze_latch).min(end),
            pose_latched: (now + runtime.pose_latch).min(end),
            begun,
            end,
            gaze,
            pose,
        };
        let later = [runtime.gaze_latch, runtime.pose_latch].map(|t| t > Nanos::ZERO);
        self.in_work.push_back(frame);
        self.plan(end, Event::RenderEnd);
        if later[0] {
            self.plan(frame.gaze_latched, Event::LatchGaze);
        }
        if later[1] {
            self.plan(frame.pose_latched, Event::LatchPose);
        }
    }

    /// The place in `in_work` of the next frame to latch `what`: latches keep the order of frames.
    fn next_to_latch(&mut self, what: usize) -> usize {
        let id = self.latched[what];
        self.latched[what] += 1;
        let place = self.in_work.iter().position(|f| f.id == id);
        place.expect("a frame latches while in work")
    }

    pub(crate) fn latch_gaze(&mut self) {
        let (gaze, i) = (self.usable_gaze(), self.next_to_latch(0));
        self.in_work[i].gaze = gaze;
    }

    pub(crate) fn latch_pose(&mut self) {
        let i = self.next_to_latch(1);
        let (start, before) = (self.in_work[i].start, self.in_work[i].pose);
        let shown = before.map_or_else(|| self.expected_photon_time(start), |p| p.predicted_for);
        self.in_work[i].pose = self.pose_for(shown);
    }

    /// When the host expects the middle row of a frame started at `now` to be lit, if it takes as long
    /// as the frame before (the first: one refresh).
    fn expected_photon_time(&self, now: Nanos) -> Nanos {
        let runtime = &self.setup.runtime;
        let (ahead, in_flight) = match runtime.overlapped {
            true => (1, 1),
            false => (self.in_work.len() as i64 + 1, runtime.in_flight),
        };
        let finished = now + self.last_duration * ahead;
        let flipped = match self.setup.sync {
            SyncMode::Tearing => finished,
            SyncMode::VsyncFree | SyncMode::Vsync => {
                let (rate, phase) = (self.setup.scan.rate, self.setup.phases.vblank);
                let refreshes = match (self.setup.sync, self.halved) {
                    (SyncMode::Vsync, Some(_)) => 2,
                    (SyncMode::Vsync, None) => i64::from(in_flight),
                    _ => 1,
                };
                // A frame that starts at a blank cannot flip at the same one.
                let soonest = now + rate.period() * (refreshes - 1) + Nanos(1);
                let earliest = (finished + runtime.lead).max(soonest);
                phase + rate.tick(rate.first_at_or_after(earliest - phase))
            }
        };
        flipped + self.middle_row_lit()
    }

    /// From the flip until the middle row is lit, as the host knows it.
    pub(crate) fn middle_row_lit(&self) -> Nanos {
        let (clock, response) = (&self.setup.scan, &self.setup.response);
        let buffered = clock.rate.period() * i64::from(clock.buffered_frames);
        let first = clock.row_offset(0).min(clock.row_offset(clock.rows));
        let scanned = match response.emission {
            Emission::Rolling => Nanos((first + self.active).0 / 2),
            Emission::Global => clock.picture_end() + response.strobe_delay,
        };
        buffered + scanned + response.settle + response.to_counted_light
    }

    pub(crate) fn render_end<S: Sink>(&mut self, sink: &mut S) -> ControlFlow<()> {
        let now = self.calendar.now();
        // The oldest of those that end now: ends are in the order of starts, unless frames overlap.
        let place = self.in_work.iter().position(|f| f.end == now);
        let frame = place
            .and_then(|i| self.in_work.remove(i))
            .expect("a frame that ends was in work");
        self.counts.frames += 1;
        let waits = self.setup.sync == SyncMode::Vsync;
        let newest = self.newest_finished.is_none_or(|id| id < frame.id);
        self.newest_finished = self.newest_finished.max(Some(frame.id));
        if !newest {
            // Overtaken by a newer one, it is never shown.
            self.unflipped = self.unflipped.saturating_sub(1);
        } else if self.setup.sync == SyncMode::Tearing {
            self.front = Some(Shown {
                frame,
                composed: now,
                flipped: now,
                warp: None,
            });
            self.tear(now);
        } else {
            // Frames in flight queue up for their flips; else a newer frame replaces one that waits.
            let runtime = &self.setup.runtime;
            if !waits || runtime.in_flight == 1 || runtime.overlapped {
                let replaced = self.ready.len() as u32;
                self.unflipped = self.unflipped.saturating_sub(replaced);
                self.ready.clear();
            }
            self.ready.push_back(frame);
        }
        match self.setup.runtime.start {
            FrameStart::JustInTime { reserve } if waits => self.plan_just_in_time(reserve),
            _ if self.overdue => self.plan(now, Event::FrameStart),
            _ => {}
        }
        sink.rendered(&frame)
    }
}
