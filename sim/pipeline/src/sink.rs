use std::ops::ControlFlow;

use crate::{Displayed, GazeStamp, Rendered};

/// What the pipeline reports to, in the order of simulated time.
///
/// Records are pushed, not returned as an iterator, so that the engine keeps one scan record and
/// reuses it; a sink copies what it wants to keep. `Break` ends the run.
pub trait Sink {
    /// A gaze sample reached the host.
    fn delivered(&mut self, _gaze: &GazeStamp) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// A frame is finished.
    fn rendered(&mut self, _frame: &Rendered) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// A scan is complete: its last row has been read.
    fn displayed(&mut self, _scan: &Displayed) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Keeps every record.
#[derive(Debug, Clone, Default)]
pub struct Recorder {
    /// Gaze samples that reached the host.
    pub delivered: Vec<GazeStamp>,
    /// Finished frames.
    pub rendered: Vec<Rendered>,
    /// Complete scans.
    pub displayed: Vec<Displayed>,
}

impl Sink for Recorder {
    fn delivered(&mut self, gaze: &GazeStamp) -> ControlFlow<()> {
        self.delivered.push(*gaze);
        ControlFlow::Continue(())
    }

    fn rendered(&mut self, frame: &Rendered) -> ControlFlow<()> {
        self.rendered.push(*frame);
        ControlFlow::Continue(())
    }

    fn displayed(&mut self, scan: &Displayed) -> ControlFlow<()> {
        self.displayed.push(scan.clone());
        ControlFlow::Continue(())
    }
}
