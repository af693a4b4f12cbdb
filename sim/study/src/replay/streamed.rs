use std::cell::RefCell;
use std::collections::VecDeque;

use foveasim_models::{GazeDirection, Pose, Provenance, Sample};
use foveasim_pipeline::{SampleWindow, Samples};
use foveasim_traces::{SampleReader, StreamedRecording, TraceError};

use super::played::{Played, Track};

/// The samples of a file between the one that some reader still needs and the one read last.
pub(super) struct Passing<'a>(RefCell<State<'a>>);

struct State<'a> {
    reader: SampleReader<'a>,
    gaze: Queue<GazeDirection>,
    pose: Queue<Pose>,
    /// Nothing more can be read.
    ended: bool,
    failure: Option<TraceError>,
}

struct Queue<T> {
    /// Whether anybody reads it.
    wanted: bool,
    samples: VecDeque<Sample<T>>,
    /// How many samples before those were let go.
    dropped: usize,
    /// What each reader has released.
    released: Vec<usize>,
}

impl<'a> Passing<'a> {
    /// Reads `reader`, of both series what will be used.
    pub(super) fn new(reader: SampleReader<'a>, [uses_gaze, uses_pose]: [bool; 2]) -> Self {
        Self(RefCell::new(State {
            reader,
            gaze: Queue::new(uses_gaze),
            pose: Queue::new(uses_pose),
            ended: false,
            failure: None,
        }))
    }

    /// The series of `recording`, whose reader this has.
    pub(super) fn windows(&self, recording: &StreamedRecording) -> Windows<'_, 'a> {
        let truth = Provenance::Truth;
        Windows {
            gaze: Window {
                passing: self,
                queue: |state| &mut state.gaze,
                provenance: recording.gaze.map_or(truth, |o| o.provenance),
            },
            pose: Window {
                passing: self,
                queue: |state| &mut state.pose,
                provenance: recording.pose.map_or(truth, |o| o.provenance),
            },
        }
    }

    /// Why the samples ended before the file did.
    pub(super) fn failure(&self) -> Option<TraceError> {
        self.0.borrow_mut().failure.take()
    }
}

impl State<'_> {
    /// Reads the next row, if there is one.
    fn read(&mut self) {
        match self.reader.next_row() {
            Ok(Some(row)) => {
                self.gaze.push(row.gaze);
                self.pose.push(row.pose);
            }
            Ok(None) => self.ended = true,
            Err(e) => {
                self.ended = true;
                self.failure = Some(e);
            }
        }
    }
}

impl<T> Queue<T> {
    fn new(wanted: bool) -> Self {
        Self {
            wanted,
            samples: VecDeque::new(),
            dropped: 0,
            released: Vec::new(),
        }
    }

    fn push(&mut self, sample: Option<Sample<T>>) {
        if self.wanted {
            self.samples.extend(sample);
        }
    }
}

/// Both series of a file that passes by.
pub(super) struct Windows<'p, 'a> {
    gaze: Window<'p, 'a, GazeDirection>,
    pose: Window<'p, 'a, Pose>,
}

impl Windows<'_, '_> {
    pub(super) fn played<'w>(&'w self, recording: &'w StreamedRecording) -> Played<'w> {
        Played {
            origin: &recording.source,
            gaze: recording.gaze.map(|outline| Track {
                samples: Samples::Window(&self.gaze),
                outline,
            }),
            pose: recording.pose.map(|outline| Track {
                samples: Samples::Window(&self.pose),
                outline,
            }),
        }
    }
}

/// One series of a file that passes by.
struct Window<'p, 'a, T> {
    passing: &'p Passing<'a>,
    queue: for<'s> fn(&'s mut State<'a>) -> &'s mut Queue<T>,
    provenance: Provenance,
}

impl<T: Copy> SampleWindow<T> for Window<'_, '_, T> {
    fn provenance(&self) -> Provenance {
        self.provenance
    }

    fn enter(&self) -> usize {
        let mut state = self.passing.0.borrow_mut();
        let queue = (self.queue)(&mut state);
        debug_assert!(
            queue.dropped == 0,
            "readers enter before samples are dropped"
        );
        queue.released.push(0);
        queue.released.len() - 1
    }

    fn get(&self, index: usize) -> Option<Sample<T>> {
        let mut state = self.passing.0.borrow_mut();
        loop {
            let queue = (self.queue)(&mut state);
            debug_assert!(index >= queue.dropped, "sample {index} was let go");
            if let Some(sample) = queue.samples.get(index.checked_sub(queue.dropped)?) {
                return Some(*sample);
            }
            if state.ended || !(self.queue)(&mut state).wanted {
                return None;
            }
            state.read();
        }
    }

    fn release(&self, reader: usize, index: usize) {
        let mut state = self.passing.0.borrow_mut();
        let queue = (self.queue)(&mut state);
        queue.released[reader] = queue.released[reader].max(index);
        let needed = queue.released.iter().copied().min().unwrap_or(index);
        while queue.dropped < needed && queue.samples.pop_front().is_some() {
            queue.dropped += 1;
        }
    }
}
