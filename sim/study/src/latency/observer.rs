use std::ops::ControlFlow;

use foveasim_models::Nanos;
use foveasim_pipeline::{
    Displayed, GazeStamp, Rendered, STAGES, Segment, Sensed, Shown, Sink, Stage, Stages,
};

use super::LatencySample;
use super::band::Edges;
use super::quantity::{QUANTITIES, Quantity, ROWS, Rows};

/// Waits for the rows of the inner layer to be lit from pictures that knew of a movement of the eye,
/// and of one of the head at the same time.
#[derive(Debug)]
pub(super) struct Observer {
    moved: Nanos,
    /// A finished frame replaces the picture at once.
    tears: bool,
    /// The first gaze sample that saw the movement.
    gaze: Option<GazeStamp>,
    /// The first head sample that did.
    head: Sensed,
    answers: [Answer; 2],
}

/// How one movement is answered.
#[derive(Debug)]
struct Answer {
    edges: Edges,
    /// The first frame that knew.
    first: Option<Rendered>,
    /// The first picture that knew, and how far the beam had come when the display began to read it.
    flip: Option<(Shown, Nanos)>,
    /// When the rows were lit, and the stages on the way to the gaze row.
    lit: [Option<Nanos>; 4],
    stages: Option<Stages>,
}

impl Observer {
    /// Waits for the answer to movements at `moved`; the host knows of the head's as `head` says.
    pub(super) fn new(moved: Nanos, head: Sensed, edges: Edges, tears: bool) -> Self {
        Self {
            moved,
            tears,
            gaze: None,
            head,
            answers: [Answer::new(edges), Answer::new(edges)],
        }
    }

    /// What was measured, once everything has been.
    pub(super) fn sample(&self) -> Option<LatencySample> {
        let mut sample = [Nanos::ZERO; QUANTITIES.len()];
        let [gaze, head] = &self.answers;
        let moved = self.moved;
        gaze.measured(moved, Quantity::Stage, Quantity::Gaze, &mut sample)?;
        head.measured(moved, Quantity::MotionStage, Quantity::Motion, &mut sample)?;
        Some(sample)
    }
}

impl Answer {
    fn new(edges: Edges) -> Self {
        Self {
            edges,
            first: None,
            flip: None,
            lit: [None; 4],
            stages: None,
        }
    }

    /// Writes what was measured since `moved` to its places; `None` if not all has been.
    fn measured(
        &self,
        moved: Nanos,
        stage_of: fn(Stage) -> Quantity,
        rows_of: fn(Rows) -> Quantity,
        sample: &mut LatencySample,
    ) -> Option<()> {
        let stages = self.stages?;
        for stage in STAGES {
            sample[stage_of(stage).index()] = stages.get(stage);
        }
        for rows in ROWS {
            sample[rows_of(rows).index()] = self.lit[rows as usize]? - moved;
        }
        Some(())
    }

    fn is_complete(&self) -> bool {
        self.lit[Rows::CompletePass as usize].is_some()
    }

    /// Looks at a scan. `knows` judges pictures; `stages` is asked once, for the first picture that
    /// knew and the scan that renewed the gaze row.
    fn look(
        &mut self,
        scan: &Displayed,
        knows: impl Fn(&Shown) -> bool,
        stages: impl FnOnce(&Shown, &Displayed) -> Option<Stages>,
    ) {
        if self.is_complete() {
            return;
        }
        let (from, above) = match self.flip {
            Some((_, from)) => (Nanos::ZERO, Some(from)),
            None => {
                let knowing = |s: &&Segment| s.shown.as_ref().is_some_and(&knows);
                let segment = scan.segments.iter().find(knowing);
                let Some((segment, shown)) = segment.and_then(|s| Some((s, s.shown?))) else {
                    return;
                };
                self.flip = Some((shown, segment.from));
                (segment.from, None)
            }
        };
        self.renew(scan, from, above);
        if self.lit[Rows::Gaze as usize].is_some()
            && self.stages.is_none()
            && let Some((shown, _)) = self.flip
        {
            self.stages = stages(&shown, scan);
        }
    }

    /// A scan whose rows from `from` on knew; those above were renewed no earlier than at `above`, the
    /// beam's place in the scan before, if they wait since then.
    fn renew(&mut self, scan: &Displayed, from: Nanos, above: Option<Nanos>) {
        let edges = self.edges;
        let Edges {
            first, gaze, last, ..
        } = edges;
        let lit = |offset: Nanos| scan.vblank + scan.buffered + edges.lit(offset);
        let mut set = |rows: Rows, offset: Nanos| {
            self.lit[rows as usize].get_or_insert_with(|| lit(offset));
        };
        if from < last || from <= first {
            set(Rows::First, first.max(from));
        }
        if from <= gaze {
            set(Rows::Gaze, gaze);
        }
        if from <= first {
            // The beam was inside the layer at the flip: the row just above it is the last one.
            let above = above.filter(|a| first < *a && *a < last);
            set(Rows::Last, above.unwrap_or(last));
            set(Rows::CompletePass, last);
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
        let [gaze, head] = &mut self.answers;
        if frame.gaze.is_some_and(|g| g.exposure_start >= self.moved) {
            gaze.first.get_or_insert(*frame);
        }
        if frame.pose_latched >= self.head.times[3] {
            head.first.get_or_insert(*frame);
        }
        ControlFlow::Continue(())
    }

    fn displayed(&mut self, scan: &Displayed) -> ControlFlow<()> {
        // A picture that tears is there from the end of its frame, also if a newer one replaces it before
        // the beam has left the blanking.
        let tears = self.tears;
        let flip = |shown: &Shown, frame: &Rendered| match tears {
            true => Shown {
                composed: frame.end,
                flipped: frame.end,
                ..*shown
            },
            false => *shown,
        };
        let (moved, sensed, known) = (self.moved, self.head, self.head.times[3]);
        let [gaze, head] = &mut self.answers;
        if let (Some(first), Some(sample)) = (gaze.first, self.gaze) {
            let row = gaze.edges.row;
            gaze.look(
                scan,
                |shown| shown.frame.id >= first.id,
                |shown, scan| {
                    let shown = flip(shown, &first);
                    Some(Stages::of_gaze(moved, &sample, &first, &shown, scan, row))
                },
            );
        }
        let (row, first) = (head.edges.row, head.first);
        head.look(
            scan,
            |shown| shown.pose_latched() >= known,
            |shown, scan| {
                // A warp may know before any frame does.
                let frame = first.unwrap_or(shown.frame);
                let shown = &flip(shown, &frame);
                Some(Stages::of_motion(moved, sensed, &frame, shown, scan, row))
            },
        );
        // Every row is known once a whole scan is.
        match self.answers.iter().all(Answer::is_complete) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}
