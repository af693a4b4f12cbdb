use foveasim_assets::Scene;
use foveasim_models::foveation::{Method, Request};
use foveasim_models::{GazeDirection, ModelError, Pose, SamplePlan, View, Work};
use foveasim_quality::{Measures, QualityError, RingQuality, Rings, compare};
use foveasim_render::{Frame, RenderError, RenderOptions, render};
use foveasim_reports::{Cell, Table};
use thiserror::Error;

/// One view of a scene, drawn by any number of methods and compared with full resolution.
#[derive(Debug)]
pub struct FrameStudy<'a> {
    /// What there is to see.
    pub scene: &'a Scene,
    /// From where.
    pub world_from_eye: Pose,
    /// Image, acuity, and where the methods take the gaze to be.
    pub request: Request,
    /// Where the eye really looks, in its own frame: what rings are centred on.
    pub gaze: GazeDirection,
    /// How all are drawn.
    pub options: RenderOptions,
}

/// What a [`FrameStudy`] found.
#[derive(Debug, Clone)]
pub struct FrameOutcome {
    /// The view at full resolution.
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
        let (eye, viewport) = (self.request.eye, self.request.viewport);
        let view = View::still(eye, viewport, self.world_from_eye);
        let draw = |plan: &SamplePlan| render(self.scene, &view, plan, &self.options);
        let reference = draw(&SamplePlan::full(eye, viewport.size))?;
        let shot = |&method: &Method| -> Result<Shot, FrameError> {
            let plan = method.plan(&self.request)?;
            let frame = draw(&plan)?;
            let comparison = compare(&frame.image, &reference.image)?;
            let rings = comparison.rings(&viewport, self.gaze.vector(), &Rings::default())?;
            Ok(Shot {
                method,
                plan,
                frame,
                measures: comparison.whole,
                rings,
            })
        };
        let shots = methods.iter().map(shot).collect::<Result<_, _>>()?;
        Ok(FrameOutcome { reference, shots })
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
