use std::fmt;
use std::str::FromStr;

use foveasim_models::{ModelError, Nanos, Rate, unknown_name};

use crate::SyncMode;

/// How the program's frames are paced, latched and composed: the loop of an XR runtime. The default is
/// a program that talks to the display itself: no compositor, all input read when a frame starts.
///
/// ```text
///   wait   │ frame starts      gaze latch   pose latch      deadline      vblank
///  ────────┼───────┬──────────────┬────────────┬──────┬────────┼────────────┼──────
///          │       │ queue (GPU)  │  render …  │      │        │ compose:   │ scan
///          │       └ input read, unless latched later ┘        │ warp, lead │
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Runtime {
    /// When a host that waits for the display starts a frame.
    pub start: FrameStart,
    /// The compositor takes the newest finished frame this long before each vertical blank.
    pub lead: Nanos,
    /// The compositor turns what it takes to a pose read then (late warp), which takes it this long:
    /// at most the lead, since the vertical blank is its deadline.
    pub warp: Option<Nanos>,
    /// Frames that may be started and not yet shown (not yet finished, if the host runs freely), from
    /// 1 to 3. They are rendered one at a time, in order.
    pub in_flight: u32,
    /// Frames wait for no earlier ones: each is rendered as soon as it is started, however many are in work,
    /// one is started at every vertical blank (or tick of a host that runs freely), and the newest finished is
    /// shown. No machine does this; it is what is left of a chain when its queue takes no time.
    pub overlapped: bool,
    /// The gaze is read this long after a frame starts, at the latest when it ends.
    pub gaze_latch: Nanos,
    /// The head pose is read this long after a frame starts, at the latest when it ends.
    pub pose_latch: Nanos,
    /// The clock of a host that runs freely is the display's: its frames are due this long after each
    /// vertical blank. `None`: the clocks are independent.
    pub host_lock: Option<Nanos>,
    /// What becomes of a refresh that no new frame is ready for.
    pub missed: Missed,
}

impl Default for Runtime {
    fn default() -> Self {
        Self {
            start: FrameStart::AtVblank,
            lead: Nanos::ZERO,
            warp: None,
            in_flight: 1,
            overlapped: false,
            gaze_latch: Nanos::ZERO,
            pose_latch: Nanos::ZERO,
            host_lock: None,
            missed: Missed::Repeat,
        }
    }
}

/// When a host that waits for the display ([`SyncMode::Vsync`]) starts a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FrameStart {
    /// At the vertical blank at which an earlier frame flips: the throttled wait.
    #[default]
    AtVblank,
    /// So late that a frame that takes `reserve` is finished just in time for the compositor.
    JustInTime {
        /// Time set aside for rendering: the expected time and a margin. At least a nanosecond is, or
        /// a frame that takes no time would start when the compositor has just taken another.
        reserve: Nanos,
    },
}

/// The least time that a just-in-time start sets aside.
pub(crate) const LEAST_RESERVE: Nanos = Nanos(1);

/// What becomes of a refresh for which no new frame is ready.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Missed {
    /// The picture before is scanned again.
    #[default]
    Repeat,
    /// So it is, and the program is held to every second refresh until three frames in a row would
    /// have been in time for every one.
    HalfRate,
    /// The frame before is warped to a newer pose.
    Reproject,
}

impl Missed {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Repeat, Self::HalfRate, Self::Reproject];

    /// As given to `--missed`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Repeat => "repeat",
            Self::HalfRate => "half-rate",
            Self::Reproject => "reproject",
        }
    }
}

impl FromStr for Missed {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        Self::ALL
            .into_iter()
            .find(|policy| policy.name() == text)
            .ok_or_else(|| unknown_name("missed-frame policy", text, &Self::ALL.map(Self::name)))
    }
}

impl fmt::Display for Missed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The most frames in flight.
const MOST_IN_FLIGHT: u32 = 3;

impl Runtime {
    /// Checks that the parts fit each other, `sync` and the display's `refresh`.
    ///
    /// # Errors
    /// Names the part that does not, its value and what would.
    pub fn check(&self, sync: SyncMode, refresh: Rate) -> Result<(), ModelError> {
        let error =
            |field: &str, value: String, valid: &str| Err(ModelError::range(field, value, valid));
        let period = refresh.period();
        if !(Nanos::ZERO..period).contains(&self.lead) {
            let valid = format!("from 0 to below {} (a refresh)", period.as_ms());
            return error(
                "compositor lead [ms]",
                self.lead.as_ms().to_string(),
                &valid,
            );
        }
        if sync == SyncMode::Tearing && self.lead > Nanos::ZERO {
            let valid = "0 with tearing: frames go to the display without a compositor";
            return error("compositor lead [ms]", self.lead.as_ms().to_string(), valid);
        }
        match self.warp {
            Some(_) if sync == SyncMode::Tearing => {
                let valid = "off with tearing: there is no compositor to warp";
                return error("late warp", "on".into(), valid);
            }
            Some(cost) if !(Nanos::ZERO..=self.lead).contains(&cost) => {
                let valid = format!(
                    "from 0 to the compositor lead, {}: the vertical blank is its deadline",
                    self.lead.as_ms()
                );
                return error("late warp [ms]", cost.as_ms().to_string(), &valid);
            }
            None if self.missed == Missed::Reproject => {
                let valid = "repeat or half-rate, or give the late warp's cost";
                return error("missed-frame policy", "reproject".into(), valid);
            }
            _ => {}
        }
        if !(1..=MOST_IN_FLIGHT).contains(&self.in_flight) {
            return error("frames in flight", self.in_flight.to_string(), "1 to 3");
        }
        let longest = period * 100;
        for (field, latch) in [
            ("gaze latch [ms]", self.gaze_latch),
            ("pose latch [ms]", self.pose_latch),
        ] {
            if !(Nanos::ZERO..=longest).contains(&latch) {
                let valid = format!("from 0 to {}", longest.as_ms());
                return error(field, latch.as_ms().to_string(), &valid);
            }
        }
        let waits = sync == SyncMode::Vsync;
        if let Some(after) = self.host_lock {
            if waits {
                let valid = "none with vsync, which is locked to the display";
                return error("host lock [ms]", after.as_ms().to_string(), valid);
            }
            if !(Nanos::ZERO..=period).contains(&after) {
                let valid = format!("from 0 to {} (a refresh)", period.as_ms());
                return error("host lock [ms]", after.as_ms().to_string(), &valid);
            }
        }
        match self.start {
            FrameStart::AtVblank => {}
            FrameStart::JustInTime { .. } if !waits || self.in_flight > 1 || self.overlapped => {
                let valid = "at-vblank, unless sync is vsync with one frame in flight";
                return error("frame start", "just-in-time".into(), valid);
            }
            FrameStart::JustInTime { reserve } if !(Nanos::ZERO..=longest).contains(&reserve) => {
                let valid = format!("from 0 to {}", longest.as_ms());
                let value = reserve.as_ms().to_string();
                return error("just-in-time reserve [ms]", value, &valid);
            }
            FrameStart::JustInTime { .. } => {}
        }
        let plain = self.start == FrameStart::AtVblank && self.in_flight == 1 && !self.overlapped;
        if self.missed == Missed::HalfRate && !(waits && plain) {
            let valid = "repeat or reproject, unless sync is vsync, with frames started at the \
                         vertical blank and one in flight";
            return error("missed-frame policy", "half-rate".into(), valid);
        }
        Ok(())
    }
}
