use foveasim_models::math::{quantile_sorted, to_deg};
use foveasim_models::{GazeDirection, Nanos, Pose, Provenance, Recording, Sample};
use glam::{DQuat, DVec3};

use super::super::number::Row;
use super::super::segments::choose;
use super::super::{GAZE_ASSUMED, POSE_ASSUMED, count, in_order, no_rows, series};
use super::{COLUMNS, EyeRow};
use crate::{ReadOptions, TraceError};

/// Mean distance between adults' pupils \[m\] (Dodgson 2004: 63.36 mm), from which the scale is
/// estimated where it is not given. Headset settings of 62 to 66 mm make that estimate right to ±4 %.
const MEAN_EYE_SEPARATION_M: f64 = 0.063_36;

/// A session's clock starts at 0, so a later one in the same file is told from damaged order by its
/// first time being below this \[ns\].
const SESSION_START: Nanos = Nanos(1_000_000_000);

/// The view of the right eye.
const RIGHT: usize = 1;

/// The two rows of a frame made one.
struct Frame {
    t: Nanos,
    position: DVec3,
    orientation: DQuat,
    gaze: Option<GazeDirection>,
    /// The view of a row without partner.
    single: Option<usize>,
}

/// Frames as they come, and what is to be said about them.
#[derive(Default)]
pub(super) struct Frames {
    frames: Vec<Frame>,
    /// Index of the first frame of each session.
    sessions: Vec<usize>,
    /// A left eye's row, waiting for the right eye's.
    pending: Option<EyeRow>,
    /// Right rows just after a left one whose head points elsewhere.
    turned: usize,
    previous: Option<Nanos>,
    /// Distance between the eyes of each frame \[scene units\].
    separations: Vec<f64>,
    one_eyed: usize,
    stray: usize,
    pub(super) decimals: usize,
    /// FOV1..4 of the first row of each view \[rad\].
    fov: [Option<[f64; 4]>; 2],
    pub(super) notes: Vec<String>,
}

impl Frames {
    pub(super) fn push(&mut self, row: &Row<'_>, eye: EyeRow) -> Result<(), TraceError> {
        self.stray += usize::from(eye.stray_gaze_position);
        if self
            .previous
            .is_none_or(|p| eye.t < p && eye.t < SESSION_START && row.complete)
        {
            self.flush();
            self.sessions.push(self.frames.len());
        } else {
            in_order(row, self.previous, eye.t)?;
        }
        self.previous = Some(eye.t);
        match self.pending.take() {
            Some(left) if eye.view == RIGHT && left.world_from_head == eye.world_from_head => {
                self.pair(left, eye);
                return Ok(());
            }
            Some(left) => {
                self.turned += usize::from(eye.view == RIGHT);
                self.single(left);
            }
            None => {}
        }
        if eye.view == RIGHT {
            self.single(eye);
        } else {
            self.pending = Some(eye);
        }
        Ok(())
    }

    /// A left row and the right row of the same frame.
    fn pair(&mut self, first: EyeRow, second: EyeRow) {
        self.separations
            .push(first.position.distance(second.position));
        let gaze = match (first.gaze, second.gaze) {
            (Some(a), Some(b)) => Some(a + b),
            (a, b) => {
                self.one_eyed += usize::from(a.is_some() != b.is_some());
                a.or(b)
            }
        };
        self.frames.push(Frame {
            t: first.t,
            position: 0.5 * (first.position + second.position),
            orientation: first.world_from_head,
            // Eyes that look in opposite directions have no mean.
            gaze: gaze
                .filter(|g| g.length() > 1e-3)
                .map(GazeDirection::from_vector),
            single: None,
        });
    }

    fn single(&mut self, eye: EyeRow) {
        self.frames.push(Frame {
            t: eye.t,
            position: eye.position,
            orientation: eye.world_from_head,
            gaze: eye.gaze.map(GazeDirection::from_vector),
            single: Some(eye.view),
        });
    }

    fn flush(&mut self) {
        if let Some(eye) = self.pending.take() {
            self.single(eye);
        }
    }

    pub(super) fn fields_of_view(
        &mut self,
        row: &Row<'_>,
        texts: &[&str; 20],
        present: bool,
    ) -> Result<(), TraceError> {
        let view = usize::from(texts[0] == "1");
        if present && self.fov[view].is_none() {
            let mut fov = [0.0; 4];
            for (i, angle) in fov.iter_mut().enumerate() {
                *angle = row.number(COLUMNS[1 + i], texts[1 + i], -1.6..=1.6)?;
            }
            self.fov[view] = Some(fov);
        }
        Ok(())
    }

    pub(super) fn finish(
        mut self,
        file: &str,
        options: &ReadOptions,
    ) -> Result<Recording, TraceError> {
        self.flush();
        if self.frames.is_empty() {
            return Err(no_rows(file));
        }
        self.describe();
        self.separations.sort_by(f64::total_cmp);
        let separation = quantile_sorted(&self.separations, 0.5);
        let scale = self.scale(separation, options)?;
        let half = if separation.is_nan() {
            0.0
        } else {
            0.5 * separation
        };
        let range = self.session(file, options)?;
        let mut poses = Vec::with_capacity(range.len());
        let mut gaze = Vec::with_capacity(range.len());
        for frame in &self.frames[range] {
            let to_middle = match frame.single {
                None => 0.0,
                Some(0) => half,
                Some(_) => -half,
            };
            let position = frame.position + frame.orientation * DVec3::X * to_middle;
            let pose = Pose::new(position / scale, frame.orientation);
            poses.push(Sample {
                t: frame.t,
                value: Some(pose),
            });
            gaze.push(Sample {
                t: frame.t,
                value: frame.gaze,
            });
        }
        let truth = Provenance::Truth;
        Ok(Recording {
            gaze: series(gaze, truth),
            pose: series(poses, truth),
            notes: self.notes,
            ..Recording::default()
        })
    }

    /// Scene units per metre.
    fn scale(&mut self, separation: f64, options: &ReadOptions) -> Result<f64, TraceError> {
        if let Some(scale) = options.scale {
            let mm = 1e3 * separation / scale;
            let eyes = if mm.is_nan() {
                String::new()
            } else {
                format!("; eyes {mm:.1} mm apart")
            };
            self.notes
                .push(format!("{scale} scene units to a metre, as given{eyes}"));
            return Ok(scale);
        }
        let estimate = separation / MEAN_EYE_SEPARATION_M;
        if estimate.is_finite() && estimate > 1e-6 {
            self.notes.push(format!(
                "{estimate:.3} scene units to a metre, estimated from eyes {separation:.4} units apart \
                 (right to 4 %); --scale sets it"
            ));
            return Ok(estimate);
        }
        self.notes
            .push("scene units taken as metres: no pair of eyes to estimate the scale from".into());
        Ok(1.0)
    }

    /// The frames of the session that is read.
    fn session(
        &mut self,
        file: &str,
        options: &ReadOptions,
    ) -> Result<std::ops::Range<usize>, TraceError> {
        let (range, note) = choose(file, &self.sessions, self.frames.len(), "frame", options)?;
        self.notes.extend(note);
        Ok(range)
    }

    fn describe(&mut self) {
        let mut note = |text: String| self.notes.push(text);
        note(GAZE_ASSUMED.into());
        note(POSE_ASSUMED.into());
        let singles = self.frames.iter().filter(|f| f.single.is_some()).count();
        note(format!(
            "{} of two rows each made one: position midway between the eyes, gaze their mean",
            count(self.frames.len() - singles, "frame")
        ));
        if singles > 0 {
            note(format!(
                "{} without the other eye's row, moved from that eye to the middle",
                count(singles, "frame")
            ));
        }
        if self.turned > 0 {
            note(format!(
                "{} not paired with the left eye's before: its head orientation is another",
                count(self.turned, "right eye's row")
            ));
        }
        if self.frames.iter().all(|f| f.gaze.is_none()) {
            note("no row has a gaze direction: the recording is of the head alone".into());
        }
        if self.one_eyed > 0 {
            note(format!(
                "{} with gaze of one eye alone",
                count(self.one_eyed, "frame")
            ));
        }
        if self.stray > 0 {
            note(format!(
                "{} with a GazePos but no gaze direction (GazeQ is the identity): gaze counts as lost",
                count(self.stray, "row")
            ));
        }
        // One unit in the last place of a component turns by up to twice that angle.
        let step = to_deg(2.0 * foveasim_models::math::pow(10.0, -(self.decimals as f64)));
        note(format!(
            "orientations have {} decimals and were renormalised: angles come in steps of some {step:.3} deg",
            self.decimals
        ));
        for (view, name) in ["left", "right"].into_iter().enumerate() {
            if let Some([a, b, c, d]) = self.fov[view] {
                let [left, right, down, up] = [a.min(b), a.max(b), c.min(d), c.max(d)].map(to_deg);
                note(format!(
                    "{name} eye sees {:.1} deg left, {right:.1} right, {:.1} down, {up:.1} up",
                    -left, -down
                ));
            }
        }
    }
}
