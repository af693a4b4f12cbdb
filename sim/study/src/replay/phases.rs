use foveasim_models::{Nanos, Provenance, Recording};
use foveasim_traces::{
    EventKind, EventOptions, GazeEvent, GazeEvents, TraceError, find_events, require_gaze,
};

/// What the eye does at a moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum GazePhase {
    /// It rests, and did so for [`LANDING`] or longer since the last saccade.
    Fixation,
    /// It jumps.
    Saccade,
    /// Up to [`LANDING`] after the end of a saccade.
    Landing,
    /// None of these was found: pursuit, the edges of a blink, too little between two losses.
    Other,
}

impl GazePhase {
    /// Every phase.
    pub const ALL: [Self; 4] = [Self::Fixation, Self::Saccade, Self::Landing, Self::Other];

    /// As in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixation => "fixation",
            Self::Saccade => "saccade",
            Self::Landing => "landing",
            Self::Other => "other",
        }
    }
}

/// How long after its end a saccade's landing lasts: 50 ms.
pub const LANDING: Nanos = Nanos(50_000_000);

/// The time around saccades in which jumps of the picture go unseen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Suppression {
    /// Before they begin: suppression starts tens of milliseconds ahead of the eye (Diamond, Ross & Morrone
    /// 2000), but how much of a jump of detail it hides then was not measured. By default nothing counts as
    /// hidden.
    pub before: Nanos,
    /// After they end.
    pub after: Nanos,
}

impl Default for Suppression {
    /// None before, and 60 ms after, up to which updates of the picture go unseen (Loschky & Wolverton
    /// 2007).
    fn default() -> Self {
        Self {
            before: Nanos::ZERO,
            after: Nanos(60_000_000),
        }
    }
}

/// When the eye fixates, jumps and lands in a recording, by the events found in the recording itself.
///
/// All times are those of the eye: the events of a tracker's output are moved back by the delay that it
/// states.
#[derive(Debug, Clone, PartialEq)]
pub struct GazePhases {
    events: Vec<GazeEvent>,
    rate_hz: f64,
    shapes_reliable: bool,
}

impl GazePhases {
    /// Finds the events of a recording.
    ///
    /// # Errors
    /// If it has no gaze, fewer than three samples with a value, or an option is out of range.
    pub fn find(recording: &Recording, options: &EventOptions) -> Result<Self, TraceError> {
        let gaze = require_gaze(recording)?;
        let delay = match gaze.provenance() {
            Provenance::Truth => Nanos::ZERO,
            Provenance::TrackerOutput { delay } => delay,
        };
        Ok(Self::new(
            find_events(gaze, recording.gaze_rate, options)?,
            delay,
        ))
    }

    /// Of events that were recorded `delay` after the eye made them.
    pub fn new(found: GazeEvents, delay: Nanos) -> Self {
        let moved = |e: GazeEvent| GazeEvent {
            start: e.start - delay,
            end: e.end - delay,
            ..e
        };
        Self {
            events: found.events.into_iter().map(moved).collect(),
            rate_hz: found.rate_hz,
            shapes_reliable: found.shapes_reliable,
        }
    }

    /// What the eye does at `t`.
    pub fn at(&self, t: Nanos) -> GazePhase {
        match self.during(t) {
            Some(EventKind::Saccade) => GazePhase::Saccade,
            Some(EventKind::Blink) => GazePhase::Other,
            _ if self.landed_within(t, LANDING) => GazePhase::Landing,
            Some(EventKind::Fixation) => GazePhase::Fixation,
            None => GazePhase::Other,
        }
    }

    /// Whether the eye is blind to jumps of the picture at `t`: in a saccade, in the time around it that
    /// `window` says, or in a blink.
    pub fn suppressed(&self, t: Nanos, window: Suppression) -> bool {
        match self.during(t) {
            Some(EventKind::Saccade | EventKind::Blink) => true,
            _ => self.landed_within(t, window.after) || self.leaves_within(t, window.before),
        }
    }

    /// Begin and end of each saccade.
    pub fn saccades(&self) -> impl Iterator<Item = [Nanos; 2]> {
        let saccades = self.events.iter().filter(|e| e.kind == EventKind::Saccade);
        saccades.map(|e| [e.start, e.end])
    }

    /// What a reader must know of a recording too slow for the shape of saccades.
    pub fn warning(&self) -> Option<String> {
        (!self.shapes_reliable).then(|| {
            format!(
                "gaze at {:.0} Hz: below 300 Hz the shape of saccades is not in the samples, and angles in \
                 and after them come out too low",
                self.rate_hz
            )
        })
    }

    /// Events that began by `t`; they do not overlap.
    fn begun(&self, t: Nanos) -> &[GazeEvent] {
        &self.events[..self.events.partition_point(|e| e.start <= t)]
    }

    fn during(&self, t: Nanos) -> Option<EventKind> {
        let last = self.begun(t).last()?;
        (t <= last.end).then_some(last.kind)
    }

    fn leaves_within(&self, t: Nanos, window: Nanos) -> bool {
        let mut coming = self.events[self.begun(t).len()..].iter();
        let next = coming.find(|e| e.kind == EventKind::Saccade);
        next.is_some_and(|e| e.start - t <= window && window > Nanos::ZERO)
    }

    fn landed_within(&self, t: Nanos, window: Nanos) -> bool {
        let events = self.begun(t).iter().rev();
        let mut recent = events.take_while(|e| t - e.end <= window);
        recent.any(|e| e.kind == EventKind::Saccade)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    fn phases(delay_ms: i64) -> GazePhases {
        let event = |kind, start: i64, end: i64| GazeEvent {
            kind,
            start: Nanos(start * MS),
            end: Nanos(end * MS),
            from: None,
            to: None,
            amplitude_deg: 0.0,
            peak_deg_per_s: 0.0,
        };
        let found = GazeEvents {
            events: vec![
                event(EventKind::Fixation, 0, 99),
                event(EventKind::Saccade, 100, 140),
                event(EventKind::Fixation, 141, 400),
                event(EventKind::Blink, 410, 500),
            ],
            limits: None,
            rate_hz: 1000.0,
            shapes_reliable: true,
        };
        GazePhases::new(found, Nanos(delay_ms * MS))
    }

    #[test]
    fn phases_change_at_the_nanosecond() {
        let p = phases(0);
        for (ns, want) in [
            (-1, GazePhase::Other),
            (0, GazePhase::Fixation),
            (99 * MS, GazePhase::Fixation),
            (99 * MS + 1, GazePhase::Other),
            (100 * MS, GazePhase::Saccade),
            (140 * MS, GazePhase::Saccade),
            (140 * MS + 1, GazePhase::Landing),
            (190 * MS, GazePhase::Landing),
            (190 * MS + 1, GazePhase::Fixation),
            (405 * MS, GazePhase::Other),
            (450 * MS, GazePhase::Other),
        ] {
            assert_eq!(p.at(Nanos(ns)), want, "{ns} ns");
        }
        assert_eq!(
            p.saccades().collect::<Vec<_>>(),
            [[Nanos(100 * MS), Nanos(140 * MS)]]
        );
    }

    #[test]
    fn suppression_ends_with_its_window() {
        let p = phases(0);
        let blind = |ns: i64| p.suppressed(Nanos(ns), Suppression::default());
        assert!(!blind(100 * MS - 1) && blind(100 * MS) && blind(200 * MS));
        assert!(!blind(200 * MS + 1));
        assert!(blind(450 * MS) && !blind(501 * MS), "a blink hides as well");
        let none = Suppression {
            after: Nanos::ZERO,
            ..Suppression::default()
        };
        assert!(!p.suppressed(Nanos(140 * MS + 1), none));
    }

    #[test]
    fn suppression_may_begin_before_its_saccade() {
        let p = phases(0);
        let window = Suppression {
            before: Nanos(50 * MS),
            ..Suppression::default()
        };
        let blind = |ns: i64| p.suppressed(Nanos(ns), window);
        assert!(!blind(50 * MS - 1) && blind(50 * MS) && blind(99 * MS));
        assert!(!blind(360 * MS), "no window before a blink");
        assert!(!phases(0).suppressed(Nanos(99 * MS), Suppression::default()));
    }

    #[test]
    fn a_recorded_delay_moves_events_back() {
        let p = phases(30);
        assert_eq!(p.at(Nanos(70 * MS)), GazePhase::Saccade);
        assert_eq!(p.at(Nanos(111 * MS)), GazePhase::Landing);
    }
}
