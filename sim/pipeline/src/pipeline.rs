use std::collections::VecDeque;
use std::ops::ControlFlow;

use foveasim_models::{Nanos, Ticks};

use crate::gaze_feed::{GazeFeed, InFlight};
use crate::pose_feed::PoseFeed;
use crate::{
    Calendar, Displayed, FrameStart, GazeStamp, Rendered, Segment, Setup, Shown, Sink, SyncMode,
};

/// What happens, in the order in which simultaneous events happen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Event {
    /// The tracker starts an exposure, or a recorded sample is read.
    Measure,
    /// The oldest sample in flight reaches the host.
    Deliver,
    /// The oldest frame that waits for its gaze reads it: after deliveries, before the frame ends.
    LatchGaze,
    /// The oldest frame that waits for its pose reads it.
    LatchPose,
    /// The frame in work is finished: before the compositor and the vertical blank, so that it is on
    /// time for them.
    RenderEnd,
    /// The compositor takes a frame.
    Compose,
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
    in_work: VecDeque<Rendered>,
    ready: VecDeque<Rendered>,
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
            in_work: VecDeque::new(),
            ready: VecDeque::new(),
        }
    }

    /// Plays `setup` from `begin` up to and including `end`, or until the sink breaks.
    ///
    /// Every clock starts with its first tick at or after `begin`. At that time no sample is in flight,
    /// no frame is in work and the display is dark. What the set-up's runtime asks for must fit
    /// together ([`Runtime::check`](crate::Runtime::check)).
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
        self.in_work.clear();
        self.ready.clear();
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

/// The state of one run: here its clocks and the tracker, in `host` the frames, in `compositor` how
/// they reach the display.
pub(crate) struct Run<'p, 'a> {
    pub(crate) setup: &'p Setup<'a>,
    pub(crate) calendar: &'p mut Calendar<Event>,
    in_flight: &'p mut InFlight,
    pub(crate) counts: RunCounts,
    gaze_feed: GazeFeed<'a>,
    pub(crate) pose_feed: Option<PoseFeed<'a>>,
    host_ticks: Ticks,
    host_phase: Nanos,
    vblanks: Ticks,
    /// Number of the vertical blank that `vblanks` gives next.
    next_tick: i64,
    /// Time from the vertical blank to the end of the last row.
    pub(crate) active: Nanos,
    /// The newest gaze delivered.
    pub(crate) gaze: Option<GazeStamp>,
    /// The frames in work, with their ends: the first is rendered, the others wait for it.
    pub(crate) in_work: &'p mut VecDeque<Rendered>,
    /// Frames started and not yet flipped, where the host waits for flips.
    pub(crate) unflipped: u32,
    /// A tick of the host's clock passed while no frame could be started.
    pub(crate) overdue: bool,
    pub(crate) frames_started: u64,
    /// How many frames have read their gaze, and their pose.
    pub(crate) latched: [u64; 2],
    /// When the last frame started.
    pub(crate) last_start: Option<Nanos>,
    /// How long the last frame took: what the host expects of the next.
    pub(crate) last_duration: Nanos,
    /// Number of the vertical blank that the last frame started just in time is meant for.
    pub(crate) target: i64,
    /// The newest frame that is finished.
    pub(crate) newest_finished: Option<u64>,
    /// Finished, not yet composed.
    pub(crate) ready: &'p mut VecDeque<Rendered>,
    /// Composed, not yet flipped; and whether its frame is new.
    pub(crate) composed: Option<(Shown, bool)>,
    /// What the display reads.
    pub(crate) front: Option<Shown>,
    /// The host is held to every second refresh, and has been in time for that many in a row.
    pub(crate) halved: Option<u32>,
    /// During which scan the last frame started.
    pub(crate) start_scan: i64,
    /// The scan going on, or the last one; `scan.scan` is −1 before the first.
    pub(crate) scan: Displayed,
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
        let host_phase = match setup.runtime.host_lock {
            Some(after) => phases.vblank + after,
            None => phases.host,
        };
        let host_ticks = host_rate.ticks(host_rate.first_at_or_after(begin - host_phase));
        let next_tick = clock.rate.first_at_or_after(begin - phases.vblank);
        let scan = Displayed {
            scan: -1,
            vblank: begin,
            next_vblank: begin,
            buffered: Nanos::ZERO,
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
            host_phase,
            vblanks: clock.rate.ticks(next_tick),
            next_tick,
            active: clock.active(),
            gaze: None,
            in_work: &mut memory.in_work,
            unflipped: 0,
            overdue: false,
            frames_started: 0,
            latched: [0; 2],
            last_start: None,
            last_duration: clock.rate.period(),
            target: i64::MIN,
            newest_finished: None,
            ready: &mut memory.ready,
            composed: None,
            front: None,
            halved: None,
            start_scan: -1,
            scan,
        }
    }

    pub(crate) fn plan(&mut self, at: Nanos, event: Event) {
        self.calendar.schedule(at, event as u8, event);
    }

    fn plan_first_events(&mut self) {
        self.plan_measurement();
        self.plan_vblank();
        if self.setup.sync != SyncMode::Vsync {
            self.plan_host_tick();
        } else if let FrameStart::JustInTime { reserve } = self.setup.runtime.start {
            self.plan_just_in_time(reserve);
        }
    }

    fn plan_measurement(&mut self) {
        if let Some(t) = self.gaze_feed.next_time() {
            self.plan(t, Event::Measure);
        }
    }

    pub(crate) fn plan_vblank(&mut self) {
        if let Some(t) = self.vblanks.next() {
            self.next_tick += 1;
            self.scan.next_vblank = self.setup.phases.vblank + t;
            self.plan(self.scan.next_vblank, Event::Vblank);
            let lead = self.setup.runtime.lead;
            if lead > Nanos::ZERO {
                let deadline = (self.scan.next_vblank - lead).max(self.calendar.now());
                self.plan(deadline, Event::Compose);
            }
        }
    }

    /// How much later than the vertical blank going on the panel does what it is told in it.
    pub(crate) fn buffered(&self) -> Nanos {
        match self.setup.scan.buffered_frames {
            0 => Nanos::ZERO,
            n => {
                // Of the blank before the one that is planned.
                let (rate, tick) = (self.setup.scan.rate, self.next_tick - 2);
                rate.tick(tick + i64::from(n)) - rate.tick(tick)
            }
        }
    }

    fn plan_host_tick(&mut self) {
        if let Some(t) = self.host_ticks.next() {
            self.plan(self.host_phase + t, Event::HostTick);
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
            Event::LatchGaze => self.latch_gaze(),
            Event::LatchPose => self.latch_pose(),
            Event::RenderEnd => return self.render_end(sink),
            Event::Compose => self.compose(self.scan.next_vblank),
            Event::ScanEnd => {
                self.counts.scans += 1;
                return sink.displayed(&self.scan);
            }
            Event::Vblank => self.vblank(),
            Event::HostTick => {
                self.plan_host_tick();
                self.host_tick();
            }
            Event::FrameStart => self.frame_start(),
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
}
