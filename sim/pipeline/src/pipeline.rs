use std::ops::ControlFlow;

use foveasim_models::{Emission, FrameInput, Nanos, Ticks};

use crate::gaze_feed::{GazeFeed, InFlight};
use crate::pose_feed::PoseFeed;
use crate::{Calendar, Displayed, GazeStamp, Rendered, Segment, Setup, Shown, Sink, SyncMode};

/// What happens, in the order in which simultaneous events happen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Event {
    /// The tracker starts an exposure, or a recorded sample is read.
    Measure,
    /// The oldest sample in flight reaches the host.
    Deliver,
    /// The frame in work is finished: before the vertical blank, so that it is on time for it.
    RenderEnd,
    /// The last row has been read.
    ScanEnd,
    /// The next scan begins.
    Vblank,
    /// The host's own clock ticks.
    HostTick,
    /// The host starts a frame now: last, so that it knows everything that happens now.
    FrameStart,
}

/// How much a run did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RunCounts {
    /// Events that happened.
    pub events: u64,
    /// Gaze samples delivered.
    pub delivered: u64,
    /// Frames finished.
    pub frames: u64,
    /// Scans completed.
    pub scans: u64,
}

/// The simulator; holds only memory that runs reuse.
#[derive(Debug)]
pub struct Pipeline {
    calendar: Calendar<Event>,
    in_flight: InFlight,
    segments: Vec<Segment>,
}

impl Default for Pipeline {
    fn default() -> Self {
        Self::new()
    }
}

impl Pipeline {
    /// A simulator.
    pub fn new() -> Self {
        let calendar = Calendar::new(Nanos::ZERO);
        Self {
            calendar,
            in_flight: InFlight::new(),
            segments: Vec::new(),
        }
    }

    /// Plays `setup` from `begin` up to and including `end`, or until the sink breaks.
    ///
    /// Every clock starts with its first tick at or after `begin`. At that time no sample is in flight,
    /// no frame is in work and the display is dark.
    pub fn run<S: Sink>(
        &mut self,
        setup: &Setup<'_>,
        begin: Nanos,
        end: Nanos,
        sink: &mut S,
    ) -> RunCounts {
        self.calendar.reset(begin);
        self.in_flight.clear();
        self.segments.clear();
        let mut run = Run::new(self, setup, begin);
        run.plan_first_events();
        while run.calendar.peek().is_some_and(|t| t <= end) {
            if run.step(sink).is_break() {
                break;
            }
        }
        let counts = RunCounts {
            events: run.calendar.happened(),
            ..run.counts
        };
        self.segments = std::mem::take(&mut run.scan.segments);
        counts
    }
}

/// The state of one run.
struct Run<'p, 'a> {
    setup: &'p Setup<'a>,
    calendar: &'p mut Calendar<Event>,
    in_flight: &'p mut InFlight,
    counts: RunCounts,
    gaze_feed: GazeFeed<'a>,
    pose_feed: Option<PoseFeed<'a>>,
    host_ticks: Ticks,
    vblanks: Ticks,
    /// Time from the vertical blank to the end of the last row.
    active: Nanos,
    /// The newest gaze delivered.
    gaze: Option<GazeStamp>,
    /// The frame in work, with its end.
    in_work: Option<Rendered>,
    /// A tick of the host's clock passed while a frame was in work.
    overdue: bool,
    frames_started: u64,
    /// When the last frame started.
    last_start: Option<Nanos>,
    /// How long the last frame took: what the host expects of the next.
    last_duration: Nanos,
    /// Finished, not yet flipped.
    pending: Option<Rendered>,
    /// What the display reads.
    front: Option<Shown>,
    /// The scan going on, or the last one; `scan.scan` is −1 before the first.
    scan: Displayed,
}

impl<'p, 'a> Run<'p, 'a> {
    fn new(memory: &'p mut Pipeline, setup: &'p Setup<'a>, begin: Nanos) -> Self {
        let Setup {
            scan: clock,
            response,
            phases,
            host_rate,
            ..
        } = *setup;
        let host_ticks = host_rate.ticks(host_rate.first_at_or_after(begin - phases.host));
        let vblanks = clock
            .rate
            .ticks(clock.rate.first_at_or_after(begin - phases.vblank));
        let scan = Displayed {
            scan: -1,
            vblank: begin,
            next_vblank: begin,
            clock,
            response,
            segments: std::mem::take(&mut memory.segments),
        };
        Self {
            setup,
            calendar: &mut memory.calendar,
            in_flight: &mut memory.in_flight,
            counts: RunCounts::default(),
            gaze_feed: GazeFeed::new(setup, begin),
            pose_feed: PoseFeed::new(setup),
            host_ticks,
            vblanks,
            active: clock.active(),
            gaze: None,
            in_work: None,
            overdue: false,
            frames_started: 0,
            last_start: None,
            last_duration: clock.rate.period(),
            pending: None,
            front: None,
            scan,
        }
    }

    fn plan(&mut self, at: Nanos, event: Event) {
        self.calendar.schedule(at, event as u8, event);
    }

    fn plan_first_events(&mut self) {
        self.plan_measurement();
        self.plan_vblank();
        if self.setup.sync != SyncMode::Vsync {
            self.plan_host_tick();
        }
    }

    fn plan_measurement(&mut self) {
        if let Some(t) = self.gaze_feed.next_time() {
            self.plan(t, Event::Measure);
        }
    }

    fn plan_vblank(&mut self) {
        if let Some(t) = self.vblanks.next() {
            self.scan.next_vblank = self.setup.phases.vblank + t;
            self.plan(self.scan.next_vblank, Event::Vblank);
        }
    }

    fn plan_host_tick(&mut self) {
        if let Some(t) = self.host_ticks.next() {
            self.plan(self.setup.phases.host + t, Event::HostTick);
        }
    }

    /// Takes the next event and does what it says.
    fn step<S: Sink>(&mut self, sink: &mut S) -> ControlFlow<()> {
        let Some(event) = self.calendar.next() else {
            return ControlFlow::Break(());
        };
        match event {
            Event::Measure => self.measure(),
            Event::Deliver => return self.deliver(sink),
            Event::RenderEnd => return self.render_end(sink),
            Event::ScanEnd => {
                self.counts.scans += 1;
                return sink.displayed(&self.scan);
            }
            Event::Vblank => self.vblank(),
            Event::HostTick => {
                self.plan_host_tick();
                if self.in_work.is_some() {
                    self.overdue = true;
                } else {
                    self.start_frame();
                }
            }
            Event::FrameStart => {
                // A tick at the same time may have started it already, and it may have ended already.
                let started = self.last_start == Some(self.calendar.now());
                if self.in_work.is_none() && !started {
                    self.start_frame();
                }
            }
        }
        ControlFlow::Continue(())
    }

    fn measure(&mut self) {
        if let Some(sample) = self.gaze_feed.measure(self.calendar.now()) {
            self.in_flight.push_back(sample);
            self.plan(sample.delivered, Event::Deliver);
        }
        self.plan_measurement();
    }

    fn deliver<S: Sink>(&mut self, sink: &mut S) -> ControlFlow<()> {
        let sample = self
            .in_flight
            .pop_front()
            .expect("each delivery was put in flight");
        self.counts.delivered += 1;
        self.gaze = Some(sample);
        sink.delivered(&sample)
    }

    /// The host reads gaze and pose, and starts rendering.
    fn start_frame(&mut self) {
        let now = self.calendar.now();
        self.overdue = false;
        self.last_start = Some(now);
        let gaze = self
            .gaze
            .filter(|g| now - g.middle() <= self.setup.gaze_max_age);
        let pose = match &mut self.pose_feed {
            None => None,
            Some(_) => {
                let shown = self.expected_photon_time(now);
                self.pose_feed
                    .as_mut()
                    .and_then(|feed| feed.predict(now, shown))
            }
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
        let end = now + duration;
        self.in_work = Some(Rendered {
            id,
            start: now,
            end,
            gaze,
            pose,
        });
        self.plan(end, Event::RenderEnd);
    }

    /// When the host expects the middle row of a frame started at `now` to be lit, if it takes as long
    /// as the frame before (the first: one refresh).
    fn expected_photon_time(&self, now: Nanos) -> Nanos {
        let finished = now + self.last_duration;
        let flipped = match self.setup.sync {
            SyncMode::Tearing => finished,
            SyncMode::VsyncFree | SyncMode::Vsync => {
                let (rate, phase) = (self.setup.scan.rate, self.setup.phases.vblank);
                // A frame that starts at a blank cannot flip at the same one.
                let earliest = finished.max(now + Nanos(1));
                phase + rate.tick(rate.first_at_or_after(earliest - phase))
            }
        };
        let scanned = match self.setup.response.emission {
            Emission::Rolling => Nanos(self.active.0 / 2),
            Emission::Global => self.active,
        };
        flipped + scanned + self.setup.response.settle
    }

    fn render_end<S: Sink>(&mut self, sink: &mut S) -> ControlFlow<()> {
        let now = self.calendar.now();
        let frame = self.in_work.take().expect("a frame that ends was in work");
        self.counts.frames += 1;
        if self.setup.sync == SyncMode::Tearing {
            self.front = Some(Shown {
                frame,
                flipped: now,
            });
            self.tear(now);
        } else {
            self.pending = Some(frame);
        }
        if self.overdue {
            self.plan(now, Event::FrameStart);
        }
        sink.rendered(&frame)
    }

    /// The rest of the scan going on reads the new front buffer.
    fn tear(&mut self, now: Nanos) {
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

    /// The newest finished frame flips (it did at once when tearing); a scan begins.
    fn vblank(&mut self) {
        let now = self.calendar.now();
        if let Some(frame) = self.pending.take() {
            self.front = Some(Shown {
                frame,
                flipped: now,
            });
        }
        self.scan.scan += 1;
        self.scan.vblank = now;
        self.scan.segments.clear();
        self.scan.segments.push(Segment {
            from: Nanos::ZERO,
            shown: self.front,
        });
        self.plan_vblank();
        self.plan(now + self.active, Event::ScanEnd);
        if self.setup.sync == SyncMode::Vsync && self.in_work.is_none() {
            self.plan(now, Event::FrameStart);
        }
    }
}
