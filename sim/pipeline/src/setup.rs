use std::fmt;
use std::str::FromStr;

use foveasim_models::{
    FrameCost, GazeDirection, HeadPredictor, ModelError, Nanos, PixelResponse, Pose, Rate,
    ScanClock, Tracker, unknown_name,
};

use crate::{Runtime, Samples};

/// When a finished frame reaches the display, and when the host starts the next one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SyncMode {
    /// The host runs on its own clock; a finished frame is scanned from the row where the beam is.
    Tearing,
    /// The host runs on its own clock; the newest finished frame flips at the vertical blank.
    VsyncFree,
    /// The host waits for its frame to flip: frames start at a vertical blank, and flip at the first
    /// one at or after their end.
    #[default]
    Vsync,
}

impl SyncMode {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Tearing, Self::VsyncFree, Self::Vsync];

    /// As given to `--sync`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tearing => "tearing",
            Self::VsyncFree => "vsync-free",
            Self::Vsync => "vsync",
        }
    }
}

impl FromStr for SyncMode {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        Self::ALL
            .into_iter()
            .find(|mode| mode.name() == text)
            .ok_or_else(|| unknown_name("sync mode", text, &Self::ALL.map(Self::name)))
    }
}

impl fmt::Display for SyncMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Where each clock stands: the time of one of its ticks, all others follow from its rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Phases {
    /// A tracker exposure starts here.
    pub exposure: Nanos,
    /// A free-running host is due to start a frame here (not used by [`SyncMode::Vsync`]).
    pub host: Nanos,
    /// A scan starts here.
    pub vblank: Nanos,
    /// A head sample is taken here (not used without [`HeadSampling::rate`]).
    pub head: Nanos,
}

/// How head poses reach the host.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HeadSampling {
    /// Samples a second; `None` if the pose is always new: a replay takes each recorded sample.
    pub rate: Option<Rate>,
    /// From a sample to the host having it.
    pub delay: Nanos,
}

/// What the tracker looks at.
#[derive(Debug, Clone, Copy, Default)]
pub enum GazeInput<'a> {
    /// Nothing is tracked: no frame knows any gaze.
    #[default]
    None,
    /// An eye that rests.
    Constant(GazeDirection),
    /// A recording. The truth goes through the simulated tracker; a tracker's own output is delivered
    /// at its own time stamps and is not delayed again.
    Recorded(Samples<'a, GazeDirection>),
}

/// Everything one run depends on; the same set-up gives the same records.
#[derive(Clone, Copy)]
pub struct Setup<'a> {
    /// When rows are scanned.
    pub scan: ScanClock,
    /// When scanned rows give light.
    pub response: PixelResponse,
    /// The eye tracker (not used for recorded tracker output).
    pub tracker: &'a Tracker,
    /// How host and display are coupled.
    pub sync: SyncMode,
    /// How frames are paced, latched and composed; see [`Runtime::check`].
    pub runtime: Runtime,
    /// How often a free-running host is due to start a frame. A frame that overruns delays the next,
    /// which then starts as soon as it ends; later ones are back on the grid.
    pub host_rate: Rate,
    /// All places in flight of a host that runs freely are taken from its first tick on, as they are after a
    /// while if frames always take longer than its period.
    pub filled: bool,
    /// How long frames take to render.
    pub cost: &'a dyn FrameCost,
    /// Where the clocks stand.
    pub phases: Phases,
    /// What the tracker looks at.
    pub gaze: GazeInput<'a>,
    /// Gaze that is older than this when a frame starts is not used by it.
    pub gaze_max_age: Nanos,
    /// A hole in recorded truth longer than this is not bridged: the tracker sees nothing in it. Head
    /// poses further apart than this give no velocity, and a newest pose older than this when a frame
    /// starts is held, not extrapolated.
    pub max_gap: Nanos,
    /// Head poses, if the head is tracked.
    pub pose: Option<Samples<'a, Pose>>,
    /// How the pose is predicted for the time of display, from samples that follow each other without
    /// a loss or a hole ([`Setup::max_gap`]). Its settings must be in range
    /// ([`HeadPredictor::validate`]).
    pub predictor: HeadPredictor,
    /// How poses of recorded truth reach the host; a tracker's own output does at its own time stamps.
    pub head: HeadSampling,
    /// Seed of tracker processing time and noise.
    pub seed: u64,
    /// Number of this run: runs of the same seed draw independently.
    pub run: u64,
}

/// What a frame that lost the gaze still uses \[ms\]: longer than most blinks (100 to 400 ms, of which
/// the pupil is covered for less), short enough that a lost tracker does not leave the fovea behind.
const DEFAULT_GAZE_MAX_AGE_MS: f64 = 250.0;

/// Longest hole in recorded truth that is bridged \[ms\].
const DEFAULT_MAX_GAP_MS: f64 = 75.0;

impl<'a> Setup<'a> {
    /// A set-up whose host runs at the display's rate, with all clocks in phase, nothing tracked and
    /// no prediction.
    pub fn new(
        scan: ScanClock,
        response: PixelResponse,
        tracker: &'a Tracker,
        sync: SyncMode,
        cost: &'a dyn FrameCost,
    ) -> Self {
        Self {
            scan,
            response,
            tracker,
            sync,
            runtime: Runtime::default(),
            host_rate: scan.rate,
            filled: false,
            cost,
            phases: Phases::default(),
            gaze: GazeInput::None,
            gaze_max_age: Nanos::from_ms(DEFAULT_GAZE_MAX_AGE_MS),
            max_gap: Nanos::from_ms(DEFAULT_MAX_GAP_MS),
            pose: None,
            predictor: HeadPredictor::Constant,
            head: HeadSampling::default(),
            seed: 0,
            run: 0,
        }
    }
}

impl fmt::Debug for Setup<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Setup")
            .field("scan", &self.scan)
            .field("sync", &self.sync)
            .field("phases", &self.phases)
            .field("seed", &self.seed)
            .field("run", &self.run)
            .finish_non_exhaustive()
    }
}
