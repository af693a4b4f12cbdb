//! A recording through the gaze-to-photon chain: what every displayed frame knew, and where the eye
//! really was when its light came out.

mod charts;
mod error;
mod frame;
mod golden;
mod observer;
mod options;
mod phase_study;
mod phases;
mod played;
mod predictor;
mod prepare;
mod sketch;
mod streamed;
mod summary;
mod timeline;

use foveasim_models::{
    Display, FrameCost, GazeMode, Geometry, Nanos, Provenance, Recording, Tracker,
};
use foveasim_pipeline::{GazeInput, Pipeline, RunCounts, Setup};
use foveasim_reports::Table;
use foveasim_traces::{StreamedRecording, TraceError};

pub use error::ReplayError;
pub use frame::{GazeState, REPLAY_COLUMNS, ReplayFrame};
pub use golden::{Difference, Golden, GoldenCheck};
pub use options::ReplayOptions;
pub use phase_study::{Margin, PhaseRow, PhaseSpec, PhaseStudy};
pub use phases::{GazePhase, GazePhases, LANDING, Suppression};
pub use predictor::head_predictor;
pub use sketch::Sketch;
pub use summary::{ReplaySummary, ReplayTally, Spread};

use observer::Observer;
use played::Played;
use streamed::Passing;

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
    each: impl FnMut(ReplayFrame),
) -> Result<ReplayRun, ReplayError> {
    play(&recording.into(), display, tracker, cost, options, each)
}

/// As [`replay_each`], of a recording that stays in its file and is read as simulated time goes on. Frames
/// and notes are the same.
///
/// # Errors
/// As [`replay_each`], and if the file cannot be read any more; frames were given then.
pub fn replay_streamed(
    recording: &StreamedRecording,
    display: &Display,
    tracker: &Tracker,
    cost: &dyn FrameCost,
    options: &ReplayOptions,
    each: impl FnMut(ReplayFrame),
) -> Result<ReplayRun, ReplayError> {
    let reading = |e: TraceError| ReplayError::Reading(e.to_string());
    let used = [
        recording.gaze.is_some_and(|outline| outline.present > 0),
        display.geometry == Geometry::HeadMounted,
    ];
    let passing = Passing::new(recording.reader().map_err(reading)?, used);
    let windows = passing.windows(recording);
    let out = play(
        &windows.played(recording),
        display,
        tracker,
        cost,
        options,
        each,
    );
    match passing.failure() {
        Some(e) => Err(reading(e)),
        None => out,
    }
}

fn play(
    played: &Played<'_>,
    display: &Display,
    tracker: &Tracker,
    cost: &dyn FrameCost,
    options: &ReplayOptions,
    mut each: impl FnMut(ReplayFrame),
) -> Result<ReplayRun, ReplayError> {
    let (start, end) = prepare::span(played, display)?;
    let mut notes = Vec::new();
    let pose = prepare::pose_of(played, display, &mut notes);
    let gaze = prepare::gaze_of(played, options.gaze_mode, pose.is_some(), &mut notes)?;

    let mut setup = Setup::new(display.scan, display.response, tracker, options.sync, cost);
    options
        .runtime
        .check(options.sync, display.scan.rate)
        .map_err(ReplayError::Runtime)?;
    setup.runtime = options.runtime;
    if let Some(rate) = options.host_rate {
        setup.host_rate = rate;
    }
    prepare::check_head(options)?;
    setup.head = options.head;
    setup.phases = prepare::phases(&setup, options.seed, start);
    setup.seed = options.seed;
    setup.predictor = options.predictor;
    setup.pose = pose.map(|track| track.samples);
    if let Some(age) = options.gaze_max_age {
        setup.gaze_max_age = age;
    }
    if let (GazeMode::Tracked, Some(track)) = (options.gaze_mode, gaze) {
        setup.gaze = GazeInput::Recorded(track.samples);
        if let Provenance::TrackerOutput { delay } = track.outline.provenance {
            notes.push(format!(
                "the recorded gaze is a tracker's output, {delay} old: the simulated tracker is not used"
            ));
            if delay >= setup.gaze_max_age {
                notes.push(format!(
                    "the recorded gaze is {delay} old on arrival, older than the {} it may be: it is never used",
                    setup.gaze_max_age
                ));
            }
        }
    }
    let mode = options.gaze_mode;
    let fresh = prepare::fresh_age(&setup, mode, gaze.as_ref().map(|track| &track.outline));
    let (mut frames, mut beyond) = (0u64, 0u64);
    let see = |frame: ReplayFrame| {
        frames += 1;
        beyond += u64::from(
            frame
                .true_gaze
                .is_some_and(|g| !prepare::on_display(display, g)),
        );
        each(frame);
    };
    let mut observer = Observer::new(display, &setup, mode, gaze, pose, fresh, end, see);
    let counts = Pipeline::new().run(&setup, start, end, &mut observer);
    let dark_scans = observer.dark_scans();
    if frames == 0 {
        return Err(ReplayError::Duration {
            origin: played.origin.to_owned(),
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

    /// What it is about as a whole.
    pub fn about(&self) -> ReplayRun {
        ReplayRun {
            frames: self.frames.len() as u64,
            dark_scans: self.dark_scans,
            start: self.start,
            counts: self.counts,
            notes: self.notes.clone(),
        }
    }

    /// Counts, and the spread of errors and latencies.
    pub fn summary(&self) -> ReplaySummary {
        let mut tally = ReplayTally::default();
        self.frames.iter().for_each(|frame| tally.add(frame));
        tally.finish(self.dark_scans, &self.counts)
    }
}

#[cfg(test)]
mod tests;
