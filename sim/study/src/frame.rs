use foveasim_assets::Scene;
use foveasim_models::foveation::{Method, Request};
use foveasim_models::{GazeDirection, LensSpec, ModelError, Msaa, Pose, SamplePlan, View, Work};
use foveasim_quality::{Measures, QualityError, RingQuality, Rings, compare};
use foveasim_render::{Frame, RenderError, RenderOptions, Sequence, TemporalOptions, render};
use foveasim_reports::{Cell, Table};
use thiserror::Error;

use crate::ScanMotion;
use crate::supersample::supersampled_frame;

/// One view of a scene, drawn by any number of methods and compared with full resolution.
#[derive(Debug)]
pub struct FrameStudy<'a> {
    /// What there is to see, and from where.
    pub sight: Sight<'a>,
    /// What was seen in the frames before, oldest first: each method draws them, too, so that there is
    /// a history. None for a frame by itself.
    pub before: Vec<Sight<'a>>,
    /// Number of the first of them all; it grows by one from frame to frame. It says which passes are
    /// due, and where in their cells samples are taken.
    pub first_frame: u64,
    /// Image, acuity, and where the methods take the gaze to be.
    pub request: Request,
    /// Where the eye really looks, in its own frame: what rings are centred on.
    pub gaze: GazeDirection,
    /// How all are drawn.
    pub drawing: Drawing,
}

/// A scene as seen at one moment.
#[derive(Debug, Clone, Copy)]
pub struct Sight<'a> {
    /// What there is to see.
    pub scene: &'a Scene,
    /// From where.
    pub world_from_eye: Pose,
    /// How the display is scanned meanwhile, if it rolls: then `world_from_eye` is where the scan begins.
    pub scan: Option<ScanMotion>,
}

impl Sight<'_> {
    /// The view of it, on the image of `request` through `lens`.
    pub(crate) fn view(
        &self,
        request: &Request,
        lens: Option<LensSpec>,
    ) -> Result<View, FrameError> {
        let (eye, optics) = (request.eye, request.viewport);
        let lens = lens.map(|lens| lens.over(optics.size));
        let view = match self.scan {
            None => View::still(eye, optics, self.world_from_eye),
            Some(scan) => View::rolling(eye, optics, [self.world_from_eye, scan.end], scan.skew),
        };
        Ok(view.seen_through(lens.transpose()?))
    }
}

/// How the frames of a [`FrameStudy`] are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawing {
    /// What the renderer is told.
    pub options: RenderOptions,
    /// Positions of visibility in each sample, of the methods and of a reference that is not
    /// supersampled.
    pub msaa: Msaa,
    /// What the methods take from the frames before. The reference is always drawn by itself.
    pub temporal: TemporalOptions,
    /// Samples along each side of a pixel of the reference (see [`supersampled`](crate::supersampled));
    /// with 1 it is drawn as the methods are, at full resolution.
    pub reference_samples: u32,
    /// The lens through which the display is seen.
    pub lens: Option<LensSpec>,
}

impl Default for Drawing {
    /// Each frame by itself, one position to the sample, beside plain full resolution.
    fn default() -> Self {
        Self {
            options: RenderOptions::default(),
            msaa: Msaa::One,
            temporal: TemporalOptions::OFF,
            reference_samples: 1,
            lens: None,
        }
    }
}

/// What a [`FrameStudy`] found.
#[derive(Debug, Clone)]
pub struct FrameOutcome {
    /// The view at full resolution or above.
    pub reference: Frame,
    /// One for each method, in order.
    pub shots: Vec<Shot>,
}

/// A view by one method.
#[derive(Debug, Clone)]
pub struct Shot {
    /// The method.
    pub method: Method,
    /// Its samples.
    pub plan: SamplePlan,
    /// The picture, and what drawing it took.
    pub frame: Frame,
    /// Against the reference, over the whole image.
    pub measures: Measures,
    /// The same by ring of eccentricity.
    pub rings: Vec<RingQuality>,
}

/// Why a frame could not be studied.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FrameError {
    /// The method cannot be planned.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The plan cannot be drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The images cannot be compared.
    #[error(transparent)]
    Quality(#[from] QualityError),
}

impl FrameStudy<'_> {
    /// Draws the reference and every method, and compares them.
    ///
    /// # Errors
    /// If a method cannot be planned for the request, or a plan cannot be drawn.
    pub fn run(&self, methods: &[Method]) -> Result<FrameOutcome, FrameError> {
        self.run_showing(methods, &mut |_, _, _| Ok(()))
    }

    /// As [`run`](Self::run). `show` is given every frame of every method as it is drawn, with its
    /// number, the judged one last; its errors end the study.
    ///
    /// # Errors
    /// As [`run`](Self::run), and those of `show`.
    pub fn run_showing<E: From<FrameError>>(
        &self,
        methods: &[Method],
        show: &mut dyn FnMut(Method, u64, &Frame) -> Result<(), E>,
    ) -> Result<FrameOutcome, E> {
        let reference = self.reference()?;
        let mut shots = Vec::with_capacity(methods.len());
        for &method in methods {
            let plan = method.plan(&self.request).map_err(FrameError::from)?;
            let plan = plan.with_msaa(self.drawing.msaa);
            let mut sequence = Sequence::new(self.drawing.temporal);
            let mut number = self.first_frame;
            let mut draw = |sight: &Sight<'_>| -> Result<Frame, E> {
                let (view, options) = (self.view(sight)?, &self.drawing.options);
                let frame = sequence.draw(sight.scene, &view, &plan, number, options);
                let frame = frame.map_err(FrameError::from)?;
                show(method, number, &frame)?;
                number += 1;
                Ok(frame)
            };
            for sight in &self.before {
                draw(sight)?;
            }
            let frame = draw(&self.sight)?;
            shots.push(self.judge(method, plan, frame, &reference)?);
        }
        Ok(FrameOutcome { reference, shots })
    }

    fn view(&self, sight: &Sight<'_>) -> Result<View, FrameError> {
        sight.view(&self.request, self.drawing.lens)
    }

    fn reference(&self) -> Result<Frame, FrameError> {
        let Drawing {
            options,
            msaa,
            reference_samples,
            ..
        } = &self.drawing;
        let (scene, view) = (self.sight.scene, self.view(&self.sight)?);
        Ok(match reference_samples {
            1 => {
                let plan = SamplePlan::full(self.request.eye, self.request.viewport.size);
                render(scene, &view, &plan.with_msaa(*msaa), options)?
            }
            n => supersampled_frame(scene, &view, *n, options)?,
        })
    }

    fn judge(
        &self,
        method: Method,
        plan: SamplePlan,
        frame: Frame,
        reference: &Frame,
    ) -> Result<Shot, FrameError> {
        let comparison = compare(&frame.image, &reference.image)?;
        let gaze = self.gaze.vector();
        let rings = comparison.rings(&self.request.viewport, gaze, &Rings::default())?;
        Ok(Shot {
            method,
            plan,
            frame,
            measures: comparison.whole,
            rings,
        })
    }
}

/// Columns of [`FrameOutcome::quality_rows`]. `from_deg` and `to_deg` are empty for the whole image;
/// an infinite PSNR means equal images.
pub(crate) const QUALITY_COLUMNS: [&str; 7] = [
    "method",
    "from_deg",
    "to_deg",
    "pixels",
    "ssim",
    "psnr_luma_db",
    "bias_grey_levels",
];

impl FrameOutcome {
    /// Closeness to the reference: for each method one row for the whole image, then one per ring of
    /// eccentricity about the true gaze.
    pub fn quality_table(&self) -> Table {
        let mut table = Table::new(QUALITY_COLUMNS);
        self.quality_rows().for_each(|row| table.push(row));
        table
    }

    pub(crate) fn quality_rows(&self) -> impl Iterator<Item = Vec<Cell>> {
        self.shots.iter().flat_map(|shot| {
            let m = &shot.measures;
            let whole = vec![
                shot.method.to_string().into(),
                Cell::Empty,
                Cell::Empty,
                self.reference.image.rgb.len().into(),
                m.ssim.into(),
                m.psnr_luma_db.into(),
                m.bias.into(),
            ];
            let rings = shot.rings.iter().map(|ring| {
                vec![
                    shot.method.to_string().into(),
                    ring.from_deg.into(),
                    ring.to_deg.into(),
                    ring.pixels.into(),
                    ring.ssim.into(),
                    ring.psnr_db.into(),
                    ring.bias.into(),
                ]
            });
            std::iter::once(whole).chain(rings)
        })
    }

    /// What drawing took: for each image one row per pass and one for all (`pass` = `all`), with every
    /// counter of [`Work`].
    pub fn work_table(&self) -> Table {
        let mut table = Table::new(work_columns());
        self.work_rows().for_each(|row| table.push(row));
        table
    }

    pub(crate) fn work_rows(&self) -> impl Iterator<Item = Vec<Cell>> {
        let reference = ("reference", Method::Full, &self.reference);
        let shots = self.shots.iter().map(|s| ("frame", s.method, &s.frame));
        std::iter::once(reference)
            .chain(shots)
            .flat_map(|(image, method, frame)| {
                let passes = frame
                    .pass_work
                    .iter()
                    .enumerate()
                    .map(|(k, w)| (k.to_string(), w));
                let all = std::iter::once(("all".to_owned(), &frame.work));
                passes.chain(all).map(move |(pass, work)| {
                    let head = [image.into(), method.to_string().into(), pass.into()];
                    head.into_iter()
                        .chain(work.rows().map(|(_, n)| n.into()))
                        .collect()
                })
            })
    }
}

/// Columns of [`FrameOutcome::work_rows`].
pub(crate) fn work_columns() -> impl Iterator<Item = &'static str> {
    let counters = Work::default().rows().map(|(name, _)| name);
    ["image", "method", "pass"].into_iter().chain(counters)
}
