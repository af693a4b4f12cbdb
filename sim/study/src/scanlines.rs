use foveasim_models::math::sqrt;
use foveasim_models::{HeadPredictor, HeadTracker, Nanos, Pose, PoseSeries, Rate, Recording};
use foveasim_reports::{Cell, LineChart, LineSeries, Table};
use foveasim_traces::{TraceError, require_pose};

/// Rows of a frame that are looked at, first and last included.
const ROWS: usize = 17;

/// What an image shows while it is scanned out (Friston 2019, Fig. 16).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageKind {
    /// Rendered for the pose known when rendering began, a frame before scan-out: its last row is E1.
    Plain,
    /// The same, warped to the pose known when scan-out begins: its last row is E2.
    Warped,
    /// Each row rendered for the pose predicted for its own time when rendering began: E3.
    Rolling,
    /// Rendered for the pose predicted for the middle of scan-out, and each row warped to the pose
    /// predicted for its own time when scan-out begins.
    RollingWarp,
    /// What that last image cannot mend: how far the pose it was rendered for is from the one it is seen
    /// from. Occlusion and shading are of the former; its last row is E4.
    RollingWarpContent,
}

impl ImageKind {
    /// Every kind.
    pub const ALL: [Self; 5] = [
        Self::Plain,
        Self::Warped,
        Self::Rolling,
        Self::RollingWarp,
        Self::RollingWarpContent,
    ];

    /// Short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Warped => "warped",
            Self::Rolling => "rolling",
            Self::RollingWarp => "rolling-warp",
            Self::RollingWarpContent => "rolling-warp-content",
        }
    }
}

/// How far the view of each row is off when its light comes out.
///
/// Frame k is rendered from `tick(k)` with the samples up to then, and scanned out from `tick(k + 1)` to
/// `tick(k + 2)`; the row at share s lights at `tick(k + 1 + s)`. The display adds nothing else.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanlineStudy {
    /// Frames per second.
    pub refresh: Rate,
    /// How poses are predicted where they are.
    pub predictor: HeadPredictor,
    /// A hole longer than this is neither predicted nor judged across.
    pub max_gap: Nanos,
}

/// RMS errors of a kind of image at each of the rows looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanlineErrors {
    /// The kind.
    pub kind: ImageKind,
    /// Of each row, from the first to the last \[deg\].
    pub rotation_deg: Vec<f64>,
    /// Of each row \[mm\].
    pub translation_mm: Vec<f64>,
}

/// Errors over a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Scanlines {
    /// The recording.
    pub source: String,
    /// Frames that all rows were judged of.
    pub frames: usize,
    /// One per kind.
    pub errors: Vec<ScanlineErrors>,
}

/// Squared errors of a frame: rotation and translation, kinds × rows.
type Squares = [[[f64; ROWS]; ImageKind::ALL.len()]; 2];

impl ScanlineStudy {
    /// Plays a recording and compares, frame by frame and row by row.
    ///
    /// # Errors
    /// If the recording has no head pose.
    ///
    /// # Panics
    /// If the predictor has settings out of range ([`HeadTracker::new`] says which).
    pub fn run(&self, recording: &Recording) -> Result<Scanlines, TraceError> {
        let poses = require_pose(recording)?;
        let new = |predictor| {
            HeadTracker::new(predictor, self.max_gap).expect("settings were checked by the caller")
        };
        let (mut held, mut head) = (new(HeadPredictor::Constant), new(self.predictor));
        let mut next = 0;
        let mut frames = 0;
        let mut sums: Squares = [[[0.0; ROWS]; ImageKind::ALL.len()]; 2];
        // What was believed when the frame that is now scanned out began to be rendered.
        let mut rendered: Option<(Pose, HeadTracker)> = None;
        let mut k = 0;
        loop {
            let now = poses.start() + self.refresh.tick(k);
            if now > poses.end() {
                break;
            }
            while let Some(sample) = poses.samples().get(next).filter(|s| s.t <= now) {
                held.observe(*sample);
                head.observe(*sample);
                next += 1;
            }
            // Inside a hole nobody knows where the head is, and nothing is foreseen.
            let known = held
                .motion()
                .filter(|m| now - m.t <= self.max_gap)
                .map(|m| m.pose);
            if let Some(((plain, then), known)) = rendered.as_ref().zip(known) {
                let frame = self.frame(poses, k, *plain, known, then, &head);
                frames += usize::from(frame.is_some());
                add(&mut sums, &frame.unwrap_or_default());
            }
            rendered = known.map(|pose| (pose, head.clone()));
            k += 1;
            if rendered.is_none()
                && let Some(sample) = poses.samples().get(next)
            {
                // A hole may be as long as a clock that was set.
                k = k.max(self.refresh.first_at_or_after(sample.t - poses.start()));
            }
        }
        Ok(Scanlines {
            source: recording.source.clone(),
            frames,
            errors: errors(&sums, frames),
        })
    }

    /// The frame scanned out from `tick(k)`; `None` where the truth of some row is not known.
    fn frame(
        &self,
        poses: &PoseSeries,
        k: i64,
        plain: Pose,
        warped: Pose,
        then: &HeadTracker,
        now: &HeadTracker,
    ) -> Option<Squares> {
        let start = poses.start() + self.refresh.tick(k);
        let period = self.refresh.tick(k + 1) - self.refresh.tick(k);
        let content = then.predict(start + Nanos(period.0 / 2))?;
        let mut squares: Squares = [[[0.0; ROWS]; ImageKind::ALL.len()]; 2];
        let [turned, moved] = &mut squares;
        for row in 0..ROWS {
            let t = start + Nanos(period.0 * row as i64 / (ROWS as i64 - 1));
            let truth = poses.at(t, self.max_gap)?;
            let images = [plain, warped, then.predict(t)?, now.predict(t)?, content];
            for ((image, turned), moved) in images.iter().zip(&mut *turned).zip(&mut *moved) {
                let deg = image.angle_to_deg(truth);
                turned[row] = deg * deg;
                moved[row] = 1e6 * (image.position - truth.position).length_squared();
            }
        }
        Some(squares)
    }
}

fn add(sums: &mut Squares, frame: &Squares) {
    let all = sums.as_flattened_mut().as_flattened_mut();
    for (sum, square) in all.iter_mut().zip(frame.as_flattened().as_flattened()) {
        *sum += square;
    }
}

fn errors(sums: &Squares, frames: usize) -> Vec<ScanlineErrors> {
    let rms = |sums: &[f64; ROWS]| sums.iter().map(|s| sqrt(s / frames as f64)).collect();
    let of = |(i, kind): (usize, ImageKind)| ScanlineErrors {
        kind,
        rotation_deg: rms(&sums[0][i]),
        translation_mm: rms(&sums[1][i]),
    };
    ImageKind::ALL.into_iter().enumerate().map(of).collect()
}

/// The share of the frame at which row `i` of those looked at is.
fn share(i: usize) -> f64 {
    i as f64 / (ROWS - 1) as f64
}

impl Scanlines {
    /// One row per kind of image and row of the display.
    pub fn table(&self) -> Table {
        let mut table = Table::new([
            "file",
            "image",
            "row_share",
            "frames",
            "rotation_rms_deg",
            "translation_rms_mm",
        ]);
        let number = |v: f64| if v.is_finite() { v.into() } else { Cell::Empty };
        for e in &self.errors {
            for (i, (deg, mm)) in e.rotation_deg.iter().zip(&e.translation_mm).enumerate() {
                table.push(vec![
                    self.source.as_str().into(),
                    e.kind.name().into(),
                    share(i).into(),
                    self.frames.into(),
                    number(*deg),
                    number(*mm),
                ]);
            }
        }
        table
    }

    /// RMS error of rotation from the first row to the last, a line per kind of image.
    pub fn rotation_chart(&self) -> LineChart {
        self.chart(
            "View error over a frame: rotation",
            "RMS error [deg]",
            |e| &e.rotation_deg,
        )
    }

    /// The same of translation.
    pub fn translation_chart(&self) -> LineChart {
        self.chart(
            "View error over a frame: translation",
            "RMS error [mm]",
            |e| &e.translation_mm,
        )
    }

    fn chart(
        &self,
        title: &str,
        y_label: &str,
        pick: fn(&ScanlineErrors) -> &Vec<f64>,
    ) -> LineChart {
        let line = |e: &ScanlineErrors| LineSeries {
            label: e.kind.name().replace('-', " "),
            points: pick(e)
                .iter()
                .enumerate()
                .map(|(i, v)| [share(i), *v])
                .collect(),
        };
        LineChart {
            title: title.into(),
            x_label: "row, as a share of the scan-out".into(),
            y_label: y_label.into(),
            series: self.errors.iter().map(line).collect(),
            ..LineChart::default()
        }
    }
}

#[cfg(test)]
mod tests;
