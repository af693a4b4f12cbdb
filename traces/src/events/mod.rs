//! Fixations, saccades and blinks in a recording of gaze.

mod adaptive;
mod agreement;
mod blinks;
mod chunks;
mod dispersion;
mod main_sequence;
mod targets;
mod velocity;

use foveasim_models::{GazeDirection, GazeSeries, Nanos, Rate};

use crate::error::option_in;
use crate::{EventKind, TraceError};

pub use agreement::{Agreement, OnsetError, agreement, vendor_agreement};
pub use main_sequence::{Estimate, MainSequence, main_sequence};
pub use targets::target_agreement;

use chunks::Chunks;

/// A fixation, saccade or blink.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GazeEvent {
    /// What it is.
    pub kind: EventKind,
    /// Its first sample.
    pub start: Nanos,
    /// Its last sample.
    pub end: Nanos,
    /// Gaze at the start; none for a blink.
    pub from: Option<GazeDirection>,
    /// Gaze at the end; none for a blink.
    pub to: Option<GazeDirection>,
    /// From start to end \[deg\]; of a fixation the drift; 0 for a blink.
    pub amplitude_deg: f64,
    /// Highest speed \[deg/s\]; 0 for a blink.
    pub peak_deg_per_s: f64,
}

impl GazeEvent {
    /// How long it lasts, from its first sample to its last.
    pub fn duration(&self) -> Nanos {
        self.end - self.start
    }
}

/// How events are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EventMethod {
    /// Speed above limits that adapt to the recording's noise (Nyström & Holmqvist 2010).
    #[default]
    Velocity,
    /// Gaze that stays within a small field for a while (I-DT, Salvucci & Goldberg 2000).
    Dispersion,
}

impl EventMethod {
    /// Every method.
    pub const ALL: [Self; 2] = [Self::Velocity, Self::Dispersion];

    /// Short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Velocity => "velocity",
            Self::Dispersion => "dispersion",
        }
    }
}

impl std::str::FromStr for EventMethod {
    type Err = foveasim_models::ModelError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let names = Self::ALL.map(Self::name);
        let found = Self::ALL.into_iter().find(|m| m.name() == text);
        found.ok_or_else(|| foveasim_models::unknown_name("method", text, &names))
    }
}

/// Limits of the detection; the defaults are those of the methods' papers where they give any.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EventOptions {
    /// How saccades and fixations are told apart.
    pub method: EventMethod,
    /// Speeds come from parabolas fitted to the samples this near on either side \[ms\], at least one.
    /// Wider windows bear more noise and begin saccades earlier, by about half of their width: 10 ms, as in
    /// Nyström & Holmqvist 2010, puts onsets 10 ms before EyeLink's, 5 ms puts them 5 ms before.
    pub half_window_ms: f64,
    /// Where the search for the limit of speed begins \[deg/s\].
    pub initial_deg_per_s: f64,
    /// A saccade's speed reaches at least this, however low the noise \[deg/s\] (EyeLink's limit is 30).
    pub floor_deg_per_s: f64,
    /// Shortest saccade \[ms\].
    pub min_saccade_ms: f64,
    /// Speed that rises again within this time after a saccade is an oscillation of the eye, not another
    /// saccade \[ms\].
    pub settle_ms: f64,
    /// Shortest fixation \[ms\]: 40 by speed (Nyström & Holmqvist 2010), or as dispersion takes it.
    pub min_fixation_ms: f64,
    /// Largest dispersion of a fixation, the sum of its width and its height \[deg\] (Salvucci &
    /// Goldberg 2000).
    pub dispersion_deg: f64,
    /// Shortest and longest loss that is a blink \[ms\]; a shorter one is a dropout, a longer one a lost
    /// track.
    pub blink_ms: [f64; 2],
}

impl Default for EventOptions {
    fn default() -> Self {
        Self {
            method: EventMethod::Velocity,
            half_window_ms: 5.0,
            initial_deg_per_s: 200.0,
            floor_deg_per_s: 30.0,
            min_saccade_ms: 10.0,
            settle_ms: 20.0,
            min_fixation_ms: 40.0,
            dispersion_deg: 1.0,
            blink_ms: [50.0, 1000.0],
        }
    }
}

impl EventOptions {
    /// Checks every option.
    ///
    /// # Errors
    /// If one is out of range; the error names it.
    pub fn validate(&self) -> Result<(), TraceError> {
        option_in("half_window_ms", self.half_window_ms, 0.1..=200.0)?;
        option_in("initial_deg_per_s", self.initial_deg_per_s, 1.0..=1000.0)?;
        option_in("floor_deg_per_s", self.floor_deg_per_s, 0.1..=1000.0)?;
        option_in("min_saccade_ms", self.min_saccade_ms, 0.0..=1000.0)?;
        option_in("settle_ms", self.settle_ms, 0.0..=1000.0)?;
        option_in("min_fixation_ms", self.min_fixation_ms, 0.0..=10_000.0)?;
        option_in("dispersion_deg", self.dispersion_deg, 0.01..=90.0)?;
        let [short, long] = self.blink_ms;
        option_in("blink_ms", short, 0.0..=10_000.0)?;
        option_in("blink_ms", long, short..=60_000.0)?;
        Ok(())
    }
}

/// The speeds that told saccades from the rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedLimits {
    /// A saccade exceeds this \[deg/s\].
    pub peak_deg_per_s: f64,
    /// It begins where the speed rises above this \[deg/s\].
    pub onset_deg_per_s: f64,
}

/// What was found.
#[derive(Debug, Clone, PartialEq)]
pub struct GazeEvents {
    /// Events in order of time, without overlap.
    pub events: Vec<GazeEvent>,
    /// The limits, where the method has them.
    pub limits: Option<SpeedLimits>,
    /// Samples per second \[Hz\].
    pub rate_hz: f64,
    /// Whether the samples are dense enough for the shape of a saccade (300 Hz: its peak speed and its
    /// duration are biased below).
    pub shapes_reliable: bool,
}

impl GazeEvents {
    /// The events of one kind.
    pub fn of(&self, kind: EventKind) -> impl Iterator<Item = &GazeEvent> {
        self.events.iter().filter(move |e| e.kind == kind)
    }
}

/// Below this the peak speed and the duration of saccades are not in the data \[Hz\] (Mack et al. 2017
/// find peak velocities biased below 300 Hz).
const SHAPE_RATE_HZ: f64 = 300.0;

/// Finds fixations, saccades and blinks in gaze sampled at `rate`, where a file states it, or else at that of the
/// median interval.
///
/// A blink is a loss of [`EventOptions::blink_ms`], with what is next to it and moves faster than a
/// saccade's onset: the lid. Between losses, and between holes of more than four intervals, saccades and
/// fixations are found by [`EventOptions::method`]; what is neither stays unnamed.
///
/// # Errors
/// If an option is out of range, or there are fewer than three samples with a value.
pub fn find_events(
    gaze: &GazeSeries,
    rate: Option<Rate>,
    options: &EventOptions,
) -> Result<GazeEvents, TraceError> {
    options.validate()?;
    let chunks = Chunks::new(gaze, rate);
    if chunks.samples() < 3 {
        return Err(TraceError::NoGaze {
            source_name: "gaze".into(),
            why: format!("{} samples with a value; events need 3", chunks.samples()),
        });
    }
    let speeds = velocity::speeds(&chunks, options.half_window_ms);
    let limits = adaptive::limits(&speeds, options);
    let mut blinks = blinks::Blinks::new(gaze, &chunks, options);
    let mut events = match options.method {
        EventMethod::Velocity => adaptive::events(&chunks, &speeds, limits, options, &mut blinks),
        EventMethod::Dispersion => dispersion::events(&chunks, &speeds, options),
    };
    events.extend(blinks.finish());
    events.sort_by_key(|e| (e.start, e.end));
    let rate_hz = 1e3 / chunks.interval_ms();
    Ok(GazeEvents {
        events,
        limits: (options.method == EventMethod::Velocity).then_some(limits),
        rate_hz,
        shapes_reliable: rate_hz >= SHAPE_RATE_HZ,
    })
}
