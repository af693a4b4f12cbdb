use std::ops::ControlFlow;

use foveasim_models::{
    Display, Emission, EyePanel, GazeDirection, GazeMode, Interpolate, Nanos, Pose, ScanClock,
};
use foveasim_pipeline::{Cursor, Displayed, Rendered, Setup, Shown, Sink, Stages};

use super::played::Track;
use super::{GazeState, ReplayFrame};

/// Compares every scan with what was true when it gave light.
pub(super) struct Observer<'a, F> {
    panel: &'a EyePanel,
    mode: GazeMode,
    gaze: Option<Truth<'a, GazeDirection>>,
    pose: Option<Truth<'a, Pose>>,
    fresh: Nanos,
    end: Nanos,
    each: F,
    dark_scans: u64,
}

/// What was so at a time, from a recording of the truth or of a tracker that reports it later.
#[derive(Debug)]
struct Truth<'a, T> {
    cursor: Cursor<'a, T>,
    delay: Nanos,
    max_gap: Nanos,
}

impl<'a, T: Interpolate> Truth<'a, T> {
    fn new(track: Track<'a, T>, max_gap: Nanos) -> Self {
        Self {
            cursor: Cursor::new(track.samples),
            delay: track.delay(),
            max_gap,
        }
    }

    /// Nothing before `t` will be asked for any more.
    fn release(&mut self, t: Nanos) {
        self.cursor.seek(t + self.delay);
        self.cursor.release();
    }

    fn at(&mut self, t: Nanos) -> Option<T> {
        self.cursor.at(t + self.delay, self.max_gap)
    }
}

impl<'a, F: FnMut(ReplayFrame)> Observer<'a, F> {
    /// Gives each displayed frame to `each`. Compares with `gaze` and `pose`; frames
    /// that start with gaze older than `fresh` hold it, and rows lit after `end` are not looked at.
    pub(super) fn new(
        display: &'a Display,
        setup: &Setup<'a>,
        mode: GazeMode,
        gaze: Option<Track<'a, GazeDirection>>,
        pose: Option<Track<'a, Pose>>,
        fresh: Nanos,
        end: Nanos,
        each: F,
    ) -> Self {
        Self {
            panel: display.primary(),
            mode,
            gaze: gaze.map(|track| Truth::new(track, setup.max_gap)),
            pose: pose.map(|track| Truth::new(track, setup.max_gap)),
            fresh,
            end,
            each,
            dark_scans: 0,
        }
    }

    /// How many scans showed no frame.
    pub(super) fn dark_scans(&self) -> u64 {
        self.dark_scans
    }

    fn fovea(&self, frame: &Rendered) -> (GazeDirection, GazeState) {
        match (self.mode, frame.gaze) {
            (GazeMode::Fixed, _) => (GazeDirection::AHEAD, GazeState::Fixed),
            (GazeMode::Tracked, None) => (GazeDirection::AHEAD, GazeState::Lost),
            (GazeMode::Tracked, Some(g)) if frame.start - g.middle() > self.fresh => {
                (g.value, GazeState::Held)
            }
            (GazeMode::Tracked, Some(g)) => (g.value, GazeState::Tracked),
        }
    }

    /// The panel row (or column, where they are scanned) that `gaze` falls on, or the nearest one.
    fn row_of(&self, gaze: GazeDirection, clock: &ScanClock) -> u32 {
        let in_eye = self.panel.in_eye(gaze).vector();
        let (rows, across) = (clock.rows, clock.direction.across());
        let last = f64::from(rows - 1);
        let size = self.panel.viewport.size.as_dvec2();
        // Rows count from the top, columns from the left.
        let first = match across {
            true => in_eye.x < 0.0,
            false => in_eye.y > 0.0,
        };
        let row = match self.panel.viewport.project(in_eye) {
            Some(px) if across => px.x / size.x * f64::from(rows),
            Some(px) => px.y / size.y * f64::from(rows),
            None if first => 0.0,
            None => last,
        };
        row.floor().clamp(0.0, last) as u32
    }

    fn head_error_deg(&mut self, scan: &Displayed, middle: u32) -> Option<f64> {
        let drawn = scan.at_row(middle)?.pose()?.pose;
        let truth = self.pose.as_mut()?.at(scan.lit(middle))?;
        Some(drawn.angle_to_deg(truth))
    }

    fn heads(&mut self, scan: &Displayed) -> Option<[Pose; 2]> {
        let [first, last] = scan.lit_span();
        if scan.response.emission == Emission::Global {
            return None;
        }
        let truth = self.pose.as_mut()?;
        Some([truth.at(first)?, truth.at(last)?])
    }

    fn look(&mut self, scan: &Displayed) -> Option<ReplayFrame> {
        let rows = scan.clock.rows;
        let middle = rows / 2;
        let looked_at = self.gaze.as_mut().and_then(|g| g.at(scan.lit(middle)));
        let drawn = scan.at_row(middle).map(|shown| self.fovea(&shown.frame).0);
        let gaze_row = self.row_of(looked_at.or(drawn)?, &scan.clock);
        let shown = scan.at_row(gaze_row)?;
        let (fovea, state) = self.fovea(&shown.frame);
        let fovea = as_warped(fovea, shown);
        let lit = scan.lit(gaze_row);
        let id = |row| scan.at_row(row).map(|shown| shown.frame.id);
        Some(ReplayFrame {
            scan: scan.scan,
            vblank: scan.vblank,
            frame: shown.frame,
            composed: shown.composed,
            warped: shown.warp.is_some(),
            flipped: shown.flipped,
            pose: shown.pose(),
            stages: shown.frame.gaze.map(|gaze| {
                let exposed = gaze.exposure_start;
                Stages::of_gaze(exposed, &gaze, &shown.frame, shown, scan, gaze_row)
            }),
            frame_ids: [id(0), id(rows - 1)],
            gaze_row,
            scanned: scan.scanned(gaze_row),
            lit,
            fovea,
            state,
            true_gaze: self.gaze.as_mut().and_then(|g| g.at(lit)),
            head_error_deg: self.head_error_deg(scan, middle),
            heads: self.heads(scan),
        })
    }
}

impl<F: FnMut(ReplayFrame)> Sink for Observer<'_, F> {
    fn displayed(&mut self, scan: &Displayed) -> ControlFlow<()> {
        // No row of this scan or a later one is lit before it begins.
        if let Some(gaze) = &mut self.gaze {
            gaze.release(scan.vblank);
        }
        if let Some(pose) = &mut self.pose {
            pose.release(scan.vblank);
        }
        match self.look(scan) {
            None => self.dark_scans += 1,
            Some(frame) if frame.lit <= self.end => (self.each)(frame),
            Some(_) => return ControlFlow::Break(()),
        }
        ControlFlow::Continue(())
    }
}

/// Where a fovea drawn at `fovea` is seen, relative to the head: a late warp moves the whole picture,
/// the fovea with it.
fn as_warped(fovea: GazeDirection, shown: &Shown) -> GazeDirection {
    match (shown.frame.pose, shown.warp.and_then(|w| w.pose)) {
        (Some(drawn), Some(warped)) => {
            let in_world = drawn.pose.direction(fovea.vector());
            GazeDirection::from_vector(warped.pose.inverse().direction(in_world))
        }
        _ => fovea,
    }
}
