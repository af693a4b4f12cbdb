//! A recording through the gaze-to-photon chain: what every displayed frame knew, and where the eye
//! really was when its light came out.

mod charts;
mod frame;
mod golden;
mod observer;
mod phase_study;
mod phases;
mod predictor;
mod summary;
mod timeline;

use foveasim_models::{
    Display, FrameCost, GazeDirection, GazeMode, GazeSeries, Geometry, HeadPredictor, ModelError,
    Nanos, PoseSeries, Provenance, Rate, Recording, Role, Stream, Tracker,
};
use foveasim_pipeline::{
    GazeInput, HeadSampling, Phases, Pipeline, RunCounts, Runtime, Setup, SyncMode,
};
use foveasim_reports::Table;
use glam::DVec2;
use thiserror::Error;

pub use frame::{GazeState, REPLAY_COLUMNS, ReplayFrame};
pub use golden::{Difference, Golden};
pub use phase_study::{Margin, PhaseRow, PhaseSpec, PhaseStudy, SUPPRESSION};
pub use phases::{GazePhase, GazePhases, LANDING};
pub use predictor::head_predictor;
pub use summary::{ReplaySummary, Spread};

use observer::Observer;

/// Why a recording cannot be replayed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The parts of the runtime's loop do not fit each other.
    #[error(transparent)]
    Runtime(ModelError),
    /// A setting of the head's predictor or of its sampling is out of range.
    #[error(transparent)]
    Head(ModelError),
    /// Nothing was recorded.
    #[error("{origin}: no samples at all; a replay needs gaze or head poses")]
    Empty {
        /// The recording.
        origin: String,
    },
    /// The gaze should steer the fovea, but there is none.
    #[error(
        "{origin}: {what}; replay it with a fixed fovea (gaze mode `fixed`) or use another one"
    )]
    NoGaze {
        /// The recording.
        origin: String,
        /// What is missing.
        what: &'static str,
    },
    /// Its duration is of no use.
    #[error("{origin}: lasts {seconds} s; must be {valid}")]
    Duration {
        /// The recording.
        origin: String,
        /// How long it lasts \[s\].
        seconds: f64,
        /// What would be valid.
        valid: String,
    },
    /// It says that its tracker reported impossibly late.
    #[error("{origin}: a tracker delay of {delay}; must be from 0 to 10000 ms")]
    Delay {
        /// The recording.
        origin: String,
        /// The delay it states.
        delay: Nanos,
    },
    /// Its time stamps cannot be computed with.
    #[error("{origin}: time stamps from {first} to {last} ns; must be within ±4e18 ns (126 years)")]
    Time {
        /// The recording.
        origin: String,
        /// The first time stamp \[ns\].
        first: i64,
        /// The last time stamp \[ns\].
        last: i64,
    },
}

/// The most scans a replay keeps: 23 hours at 120 Hz, about 4 GB.
const MAX_SCANS: i64 = 10_000_000;

/// Time stamps beyond this leave no room for delays \[ns\].
const MAX_TIME: u64 = 4_000_000_000_000_000_000;

/// The longest delay that a tracker can have had.
const MAX_DELAY: Nanos = Nanos(10_000_000_000);

/// How a recording is replayed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplayOptions {
    /// How host and display are coupled.
    pub sync: SyncMode,
    /// Whether the fovea follows the eye, or stays at the centre.
    pub gaze_mode: GazeMode,
    /// How the head pose is predicted.
    pub predictor: HeadPredictor,
    /// How head poses reach the host.
    pub head: HeadSampling,
    /// Gaze older than this when a frame starts is given up, and the fovea goes to the centre.
    /// `None`: the pipeline's default.
    pub gaze_max_age: Option<Nanos>,
    /// How frames are paced, latched and composed.
    pub runtime: Runtime,
    /// How often a free-running host starts a frame; `None`: at the display's rate.
    pub host_rate: Option<Rate>,
    /// Seed of the clocks' phases, the tracker's processing times and its noise.
    pub seed: u64,
}

impl Default for ReplayOptions {
    fn default() -> Self {
        Self {
            sync: SyncMode::Vsync,
            gaze_mode: GazeMode::Tracked,
            predictor: HeadPredictor::AngularVelocity,
            head: HeadSampling::default(),
            gaze_max_age: None,
            runtime: Runtime::default(),
            host_rate: None,
            seed: 1,
        }
    }
}

/// What a replay found.
#[derive(Debug, Clone, PartialEq)]
pub struct Replay {
    /// One for each scan that showed a frame and whose gaze row was lit within the recording.
    pub frames: Vec<ReplayFrame>,
    /// Scans before the first frame was finished.
    pub dark_scans: u64,
    /// When the recording starts; tables count from here.
    pub start: Nanos,
    /// How much was simulated.
    pub counts: RunCounts,
    /// What had to be assumed; one sentence each.
    pub notes: Vec<String>,
}

/// What a replay is about as a whole.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplayRun {
    /// Displayed frames.
    pub frames: u64,
    /// Scans before the first frame was finished.
    pub dark_scans: u64,
    /// When the recording starts; tables count from here.
    pub start: Nanos,
    /// How much was simulated.
    pub counts: RunCounts,
    /// What had to be assumed; one sentence each.
    pub notes: Vec<String>,
}

/// Replays `recording` on `display` and keeps every displayed frame; [`replay_each`] keeps none.
///
/// # Errors
/// If there is nothing to replay, or its times cannot be used.
pub fn replay(
    recording: &Recording,
    display: &Display,
    tracker: &Tracker,
    cost: &dyn FrameCost,
    options: &ReplayOptions,
) -> Result<Replay, ReplayError> {
    let mut frames = Vec::new();
    let run = replay_each(recording, display, tracker, cost, options, |frame| {
        frames.push(frame);
    })?;
    Ok(Replay {
        frames,
        dark_scans: run.dark_scans,
        start: run.start,
        counts: run.counts,
        notes: run.notes,
    })
}

/// Replays `recording` on `display` and gives each displayed frame to `each`, in order. Beside the
/// recording itself, memory does not grow with its length.
///
/// Recorded truth is seen through `tracker`; a tracker's own output is delivered at its own time
/// stamps, and the truth at time t is what it reports at t + delay. A lost gaze leaves the fovea where
/// it was until it is too old, then the fovea goes to the centre; [`GazeState`] says which. A planar
/// display is watched with a still head.
///
/// # Errors
/// If there is nothing to replay, or its times cannot be used; no frame was given then, unless the
/// recording is too short for any.
pub fn replay_each(
    recording: &Recording,
    display: &Display,
    tracker: &Tracker,
    cost: &dyn FrameCost,
    options: &ReplayOptions,
    mut each: impl FnMut(ReplayFrame),
) -> Result<ReplayRun, ReplayError> {
    let (start, end) = span(recording, display)?;
    let mut notes = Vec::new();
    let pose = pose_of(recording, display, &mut notes);
    let gaze = gaze_of(recording, options.gaze_mode, pose.is_some(), &mut notes)?;

    let mut setup = Setup::new(display.scan, display.response, tracker, options.sync, cost);
    options
        .runtime
        .check(options.sync, display.scan.rate)
        .map_err(ReplayError::Runtime)?;
    setup.runtime = options.runtime;
    if let Some(rate) = options.host_rate {
        setup.host_rate = rate;
    }
    check_head(options)?;
    setup.head = options.head;
    setup.phases = phases(&setup, options.seed, start);
    setup.seed = options.seed;
    setup.predictor = options.predictor;
    setup.pose = pose;
    if let Some(age) = options.gaze_max_age {
        setup.gaze_max_age = age;
    }
    if let (GazeMode::Tracked, Some(series)) = (options.gaze_mode, gaze) {
        setup.gaze = GazeInput::Series(series);
        if let Provenance::TrackerOutput { delay } = series.provenance() {
            notes.push(format!(
                "the recorded gaze is a tracker's output, {delay} old: the simulated tracker is not used"
            ));
        }
    }

    if let (GazeMode::Tracked, Some(Provenance::TrackerOutput { delay })) =
        (options.gaze_mode, gaze.map(GazeSeries::provenance))
        && delay >= setup.gaze_max_age
    {
        notes.push(format!(
            "the recorded gaze is {delay} old on arrival, older than the {} it may be: it is never used",
            setup.gaze_max_age
        ));
    }
    let fresh = fresh_age(&setup, options.gaze_mode, gaze);
    let (mut frames, mut beyond) = (0u64, 0u64);
    let see = |frame: ReplayFrame| {
        frames += 1;
        beyond += u64::from(frame.true_gaze.is_some_and(|g| !on_display(display, g)));
        each(frame);
    };
    let mode = options.gaze_mode;
    let mut observer = Observer::new(display, &setup, mode, gaze, fresh, end, see);
    let counts = Pipeline::new().run(&setup, start, end, &mut observer);
    let dark_scans = observer.dark_scans();
    if frames == 0 {
        return Err(ReplayError::Duration {
            origin: recording.source.clone(),
            seconds: (end - start).as_secs(),
            valid: "long enough for a frame to reach the display".into(),
        });
    }
    if beyond > 0 {
        notes.push(format!(
            "the eye looks beyond the display in {beyond} of {frames} displayed frames"
        ));
    }
    Ok(ReplayRun {
        frames,
        dark_scans,
        start,
        counts,
        notes,
    })
}

impl Replay {
    /// One row per displayed frame.
    pub fn table(&self) -> Table {
        let mut table = Table::new(REPLAY_COLUMNS);
        for frame in &self.frames {
            table.push(frame.row(self.start));
        }
        table
    }

    /// Counts, and the spread of errors and latencies.
    pub fn summary(&self) -> ReplaySummary {
        ReplaySummary::new(self)
    }
}

/// Whether a gaze meets the first eye's image.
fn on_display(display: &Display, gaze: GazeDirection) -> bool {
    let panel = display.primary();
    let size = panel.viewport.size.as_dvec2();
    panel
        .viewport
        .project(panel.in_eye(gaze).vector())
        .is_some_and(|px| px.cmpge(DVec2::ZERO).all() && px.cmple(size).all())
}

/// First and last time, if they can be computed with.
fn span(recording: &Recording, display: &Display) -> Result<(Nanos, Nanos), ReplayError> {
    let origin = || recording.source.clone();
    let (start, end) = recording
        .span()
        .ok_or_else(|| ReplayError::Empty { origin: origin() })?;
    if start.0.unsigned_abs() > MAX_TIME || end.0.unsigned_abs() > MAX_TIME {
        return Err(ReplayError::Time {
            origin: origin(),
            first: start.0,
            last: end.0,
        });
    }
    let provenances = [
        recording.gaze.as_ref().map(GazeSeries::provenance),
        recording.pose.as_ref().map(PoseSeries::provenance),
    ];
    for provenance in provenances.into_iter().flatten() {
        if let Provenance::TrackerOutput { delay } = provenance
            && !(Nanos::ZERO..=MAX_DELAY).contains(&delay)
        {
            return Err(ReplayError::Delay {
                origin: origin(),
                delay,
            });
        }
    }
    let longest = display.scan.rate.tick(MAX_SCANS);
    if end - start > longest {
        return Err(ReplayError::Duration {
            origin: origin(),
            seconds: (end - start).as_secs(),
            valid: format!("at most {} s on this display", longest.as_secs()),
        });
    }
    Ok((start, end))
}

/// The gaze. A fixed fovea can do without; so can a moving head, whose frames are then all drawn as
/// after a loss.
fn gaze_of<'a>(
    recording: &'a Recording,
    mode: GazeMode,
    head_moves: bool,
    notes: &mut Vec<String>,
) -> Result<Option<&'a GazeSeries>, ReplayError> {
    let what = match &recording.gaze {
        Some(series) if series.samples().iter().any(|s| s.value.is_some()) => {
            return Ok(Some(series));
        }
        Some(_) => "the gaze is lost in every sample",
        None => "no gaze was recorded",
    };
    match mode {
        GazeMode::Fixed => Ok(None),
        GazeMode::Tracked if head_moves => {
            notes.push(format!(
                "{what}: the fovea stays at the centre in every frame, and no gaze error is known"
            ));
            Ok(None)
        }
        GazeMode::Tracked => Err(ReplayError::NoGaze {
            origin: recording.source.clone(),
            what,
        }),
    }
}

/// Head poses, where the display moves with the head.
fn pose_of<'a>(
    recording: &'a Recording,
    display: &Display,
    notes: &mut Vec<String>,
) -> Option<&'a PoseSeries> {
    let head_mounted = display.geometry == Geometry::HeadMounted;
    match &recording.pose {
        Some(_) if !head_mounted => {
            notes.push(
                "the display does not move with the head: recorded head motion is not used".into(),
            );
            None
        }
        None if head_mounted => {
            notes.push("no head motion was recorded: the head is still".into());
            None
        }
        pose => pose.as_ref(),
    }
}

/// Draws where the clocks stand when the recording starts.
fn phases(setup: &Setup<'_>, seed: u64, start: Nanos) -> Phases {
    let mut stream = Stream::new(seed, Role::Phase, 0);
    let mut within = |period: Nanos| start + Nanos(stream.below(period.0 as u64) as i64);
    Phases {
        exposure: within(setup.tracker.rate.period()),
        host: within(setup.host_rate.period()),
        vblank: within(setup.scan.rate.period()),
        // Drawn last, and only if used: the other clocks stand where they did without it.
        head: match setup.head.rate {
            Some(rate) => within(rate.period()),
            None => start,
        },
    }
}

/// Checks how the head is sampled and predicted.
fn check_head(options: &ReplayOptions) -> Result<(), ReplayError> {
    options.predictor.validate().map_err(ReplayError::Head)?;
    let delay = options.head.delay;
    if (Nanos::ZERO..=MAX_DELAY).contains(&delay) {
        return Ok(());
    }
    let valid = format!("0 to {}", MAX_DELAY.as_ms());
    let error = ModelError::range("head delay [ms]", delay.as_ms(), valid);
    Err(ReplayError::Head(error))
}

/// How old the newest gaze may be when a frame starts, if no sample is missing; with two periods, so
/// that jitter does not count as a loss.
fn fresh_age(setup: &Setup<'_>, mode: GazeMode, gaze: Option<&GazeSeries>) -> Nanos {
    let tracker = setup.tracker;
    match (mode, gaze.map(|g| (g, g.provenance()))) {
        (GazeMode::Tracked, Some((series, Provenance::TrackerOutput { delay }))) => {
            let mut steps: Vec<Nanos> = series
                .samples()
                .windows(2)
                .map(|w| w[1].t - w[0].t)
                .collect();
            steps.sort_unstable();
            delay
                + steps
                    .get(steps.len() / 2)
                    .map_or(Nanos::ZERO, |step| *step * 2)
        }
        _ => {
            let longest = tracker.exposure + tracker.processing.max() + tracker.transport.max();
            longest + tracker.rate.period() * 2
        }
    }
}

#[cfg(test)]
mod tests;
