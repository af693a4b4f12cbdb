use foveasim_models::Nanos;

use crate::{EventKind, LabelledEvent};

/// Events from rows that carry a label: rows in a run with the same text are one event.
#[derive(Debug)]
pub(super) struct Runs {
    kind: EventKind,
    label: String,
    open: Option<(Nanos, Nanos)>,
    events: Vec<LabelledEvent>,
}

impl Runs {
    pub(super) fn new(kind: EventKind) -> Self {
        Self {
            kind,
            label: String::new(),
            open: None,
            events: Vec::new(),
        }
    }

    pub(super) fn kind(&self) -> EventKind {
        self.kind
    }

    /// Takes the next row; whether it is inside an event.
    pub(super) fn push(&mut self, t: Nanos, label: &str) -> bool {
        if label != self.label {
            self.close();
            label.clone_into(&mut self.label);
        }
        if label.is_empty() {
            return false;
        }
        let start = self.open.map_or(t, |(start, _)| start);
        self.open = Some((start, t));
        true
    }

    pub(super) fn finish(&mut self) -> Vec<LabelledEvent> {
        self.close();
        std::mem::take(&mut self.events)
    }

    fn close(&mut self) {
        if let Some((start, end)) = self.open.take() {
            self.events.push(LabelledEvent {
                kind: self.kind,
                eye: None,
                start,
                end,
            });
        }
    }
}
