use std::ops::ControlFlow;

use foveasim_models::Nanos;
use foveasim_pipeline::{Displayed, GazeStamp, Rendered, STAGES, Segment, Sink, Stages};

use super::LatencySample;
use super::band::Edges;
use super::quantity::{QUANTITIES, Quantity};

/// Waits for the rows of the inner layer to be lit from frames that knew of the eye movement.
#[derive(Debug)]
pub(super) struct Observer {
    moved: Nanos,
    edges: Edges,
    /// The first gaze sample that saw the movement.
    gaze: Option<GazeStamp>,
    /// The first frame that knew.
    first: Option<Rendered>,
    /// When a frame that knew was first read by the display, and how far the beam had come in that
    /// scan.
    flip: Option<(Nanos, Nanos)>,
    first_row: Option<Nanos>,
    gaze_row: Option<(Nanos, Nanos)>,
    last_row: Option<Nanos>,
    complete_pass: Option<Nanos>,
}

impl Observer {
    /// Waits for the answer to a movement at `moved`.
    pub(super) fn new(moved: Nanos, edges: Edges) -> Self {
        Self {
            moved,
            edges,
            gaze: None,
            first: None,
            flip: None,
            first_row: None,
            gaze_row: None,
            last_row: None,
            complete_pass: None,
        }
    }

    /// What was measured, once everything has been.
    pub(super) fn sample(&self) -> Option<LatencySample> {
        let (flipped, _) = self.flip?;
        let (scanned, lit) = self.gaze_row?;
        let (gaze, frame) = (self.gaze.as_ref()?, self.first.as_ref()?);
        let stages = Stages::new(self.moved, gaze, frame, flipped, scanned, lit);
        let (first, last, pass) = (self.first_row?, self.last_row?, self.complete_pass?);
        let mut sample = [Nanos::ZERO; QUANTITIES.len()];
        for stage in STAGES {
            sample[stage as usize] = stages.get(stage);
        }
        sample[Quantity::FirstRow.index()] = first - self.moved;
        sample[Quantity::GazeRow.index()] = lit - self.moved;
        sample[Quantity::LastRow.index()] = last - self.moved;
        sample[Quantity::CompletePass.index()] = pass - self.moved;
        Some(sample)
    }

    /// A scan whose rows from `from` on knew; those above were renewed no earlier than at `above`, the
    /// beam's place in the scan before, if they wait since then.
    fn scan(&mut self, vblank: Nanos, from: Nanos, above: Option<Nanos>) {
        let edges = self.edges;
        let Edges {
            top, gaze, bottom, ..
        } = edges;
        let lit = |offset: Nanos| vblank + edges.lit(offset);
        if from < bottom || from <= top {
            self.first_row.get_or_insert_with(|| lit(top.max(from)));
        }
        if from <= gaze {
            self.gaze_row
                .get_or_insert_with(|| (vblank + gaze, lit(gaze)));
        }
        if from <= top {
            // The beam was inside the layer at the flip: the row just above it is the last one.
            let last = above.filter(|a| top < *a && *a < bottom).unwrap_or(bottom);
            self.last_row.get_or_insert_with(|| lit(last));
            self.complete_pass.get_or_insert_with(|| lit(bottom));
        }
    }
}

impl Sink for Observer {
    fn delivered(&mut self, gaze: &GazeStamp) -> ControlFlow<()> {
        if gaze.exposure_start >= self.moved {
            self.gaze.get_or_insert(*gaze);
        }
        ControlFlow::Continue(())
    }

    fn rendered(&mut self, frame: &Rendered) -> ControlFlow<()> {
        if frame.gaze.is_some_and(|g| g.exposure_start >= self.moved) {
            self.first.get_or_insert(*frame);
        }
        ControlFlow::Continue(())
    }

    fn displayed(&mut self, scan: &Displayed) -> ControlFlow<()> {
        let Some(first) = &self.first else {
            return ControlFlow::Continue(());
        };
        match self.flip {
            None => {
                let knows = |s: &&Segment| s.shown.is_some_and(|shown| shown.frame.id >= first.id);
                let segment = scan.segments.iter().find(knows);
                if let Some((segment, shown)) = segment.and_then(|s| Some((s, s.shown?))) {
                    self.flip = Some((shown.flipped, segment.from));
                    self.scan(scan.vblank, segment.from, None);
                }
            }
            Some((_, from)) => self.scan(scan.vblank, Nanos::ZERO, Some(from)),
        }
        // Every row is known once a whole scan is.
        if self.complete_pass.is_some() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}
