use foveasim_models::{Eye, GazeDirection, Nanos};

/// What an eye does for a while.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EventKind {
    /// It rests on one place.
    Fixation,
    /// It jumps to another.
    Saccade,
    /// The lid is over it.
    Blink,
}

impl EventKind {
    /// Every kind.
    pub const ALL: [Self; 3] = [Self::Fixation, Self::Saccade, Self::Blink];

    /// Short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixation => "fixation",
            Self::Saccade => "saccade",
            Self::Blink => "blink",
        }
    }
}

/// An event as somebody else found it: the maker's software, or a person.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LabelledEvent {
    /// What it is.
    pub kind: EventKind,
    /// The eye it was found in, where each has its own.
    pub eye: Option<Eye>,
    /// Its first sample.
    pub start: Nanos,
    /// Its last sample.
    pub end: Nanos,
}

/// Where a viewer was asked to look from some time on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetStep {
    /// From when.
    pub t: Nanos,
    /// Where to; `None` while no target is known.
    pub target: Option<GazeDirection>,
}

/// What a file says of its samples besides their values.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Labels {
    /// Events, in the order of the file.
    pub events: Vec<LabelledEvent>,
    /// Targets, in order of time; empty where there are none.
    pub targets: Vec<TargetStep>,
}
