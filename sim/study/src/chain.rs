//! The gaze-to-photon and motion-to-photon chain as a whole: devices, the loop between them, and which
//! of its parts are off.

mod part;
mod spec;

use foveasim_models::{
    Display, Durations, FrameCost, GazeDirection, ModelError, Nanos, Rate, ScanClock, Tracker,
};
use foveasim_pipeline::{
    FrameStart, GazeInput, Interval, Movement, Phases, Runtime, Setup, SyncMode,
};

pub use foveasim_pipeline::HeadSampling;
pub use part::{Anomaly, PARTS, Part};
pub use spec::{ChainSpec, DriftSpec, render_law};

/// A valid chain: everything that latency depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// The display.
    pub display: Display,
    /// The eye tracker.
    pub tracker: Tracker,
    /// How host and display are coupled.
    pub sync: SyncMode,
    /// How frames are paced, latched and composed.
    pub runtime: Runtime,
    /// How often a free-running host starts a frame.
    pub host_rate: Rate,
    /// How long frames render.
    pub render: Durations,
    /// How head poses reach the host.
    pub head: HeadSampling,
    /// Which eye's rows are looked at: 0 for the first (left), 1 for the second.
    pub eye: usize,
    /// Which parts are off, in the order in which they were switched off, and what may be worse for it.
    pub off: Vec<(Part, Vec<Anomaly>)>,
}

impl Chain {
    /// A chain without a compositor whose host runs at the display's rate, whose frames render for one
    /// refresh period, rounded down to the nanosecond so that a blocked host meets every vertical
    /// blank, and whose head poses are always new.
    pub fn new(display: Display, tracker: Tracker, sync: SyncMode) -> Self {
        Self {
            host_rate: display.scan.rate,
            render: Durations::fixed(display.scan.rate.period()),
            display,
            tracker,
            sync,
            runtime: Runtime::default(),
            head: HeadSampling::default(),
            eye: 0,
            off: Vec::new(),
        }
    }

    /// Whether `part` is off.
    pub fn is_off(&self, part: Part) -> bool {
        self.off.iter().any(|(off, _)| *off == part)
    }

    /// What may be worse because parts are off ([`Anomaly`]), one sentence each.
    pub fn cautions(&self) -> Vec<String> {
        let sentences = self.off.iter().flat_map(|(part, anomalies)| {
            let sentence = move |anomaly| format!("{part} is off: {anomaly}");
            anomalies.iter().map(sentence)
        });
        sentences.collect()
    }

    /// Checks that the parts fit each other.
    ///
    /// # Errors
    /// Names the part that does not, its value and what would.
    pub fn check(&self) -> Result<(), ModelError> {
        self.runtime.check(self.sync, self.display.scan.rate)?;
        let shortest = self.render.min();
        for (field, latch) in [
            ("gaze latch [ms]", self.runtime.gaze_latch),
            ("pose latch [ms]", self.runtime.pose_latch),
        ] {
            if latch > shortest {
                let valid = format!("at most the shortest render time, {}", shortest.as_ms());
                return Err(ModelError::range(field, latch.as_ms(), valid));
            }
        }
        if self.eye >= self.display.eyes.len() {
            let valid = "left: this display shows both eyes one image";
            return Err(ModelError::range("eye", "right", valid));
        }
        Ok(())
    }

    /// When the rows of the eye looked at are scanned.
    pub fn scan(&self) -> ScanClock {
        self.display.scan_of_eye(self.eye)
    }

    /// Shortest and longest rendering time.
    pub fn render_range(&self) -> Interval {
        Interval::new(self.render.min(), self.render.max())
    }

    /// Whether every frame takes longer than a host that runs freely has for one.
    pub fn never_keeps_up(&self) -> bool {
        self.sync != SyncMode::Vsync && self.render.min() > self.host_rate.period()
    }

    /// What answers a movement of the head.
    pub fn head_movement(&self) -> Movement {
        Movement::Head {
            wait: self.head.rate.map_or(Nanos::ZERO, |r| -r.tick(-1)),
            delay: self.head.delay,
        }
    }

    /// The chain as the pipeline plays it, for an eye that rests.
    pub fn setup<'a>(&'a self, cost: &'a dyn FrameCost, phases: Phases) -> Setup<'a> {
        let response = self.display.response;
        Setup {
            runtime: self.runtime,
            host_rate: self.host_rate,
            phases,
            gaze: GazeInput::Constant(GazeDirection::AHEAD),
            gaze_max_age: Nanos::MAX,
            ..Setup::new(self.scan(), response, &self.tracker, self.sync, cost)
        }
    }

    /// Time set aside for a frame that starts just in time; `None` if frames start otherwise.
    pub fn reserve(&self) -> Option<Nanos> {
        match self.runtime.start {
            FrameStart::AtVblank => None,
            FrameStart::JustInTime { reserve } => Some(reserve),
        }
    }
}
