use foveasim_assets::{Scene, study_camera, study_scene};
use foveasim_models::foveation::{Method, Request};
use foveasim_models::math::{atan_deg, to_rad};
use foveasim_models::{GazeDirection, Image, Nanos, Pose, Resolve, SamplePlan};
use foveasim_quality::Measures;
use foveasim_reports::{
    Cell, ERROR_FULL_SCALE, ErrorMap, Outline, Table, error_map, image_digest, overlay, png,
    shrink, side_by_side,
};
use glam::{DQuat, DVec3};

use super::RunError;
use crate::frame::{QUALITY_COLUMNS, work_columns};
use crate::{
    Drawing, FrameOutcome, FrameStudy, Replay, ReplayFrame, ScanMotion, Scenario, Shot, Sight,
};

/// The pictures of a moment, as in their files' names: `moment-1-reference.png`.
pub const MOMENT_PICTURES: [&str; 5] = ["reference", "frame", "layers", "error", "overview"];

/// Where along the fly-through the recording's first head pose is put: objects near and far in view.
const CAMERA_AT: f64 = 0.1;
/// Each of the three pictures of an overview is at most this wide.
const OVERVIEW_PX: u32 = 640;
/// Pictures kept for the page are at most this wide; the files have all pixels.
pub(super) const PAGE_IMAGE_PX: u32 = 960;

/// One displayed frame, drawn as the first eye would see it by every method but `full`, which is the
/// reference. Pictures are encoded as they are drawn: a raw one takes 12 bytes a pixel.
#[derive(Debug, Clone)]
pub struct Moment {
    /// The displayed frame.
    pub frame: ReplayFrame,
    /// When its gaze row was lit, from the start of the recording.
    pub time: Nanos,
    /// What was asked of the methods; the gaze is where they took it to be.
    pub request: Request,
    /// Where the eye really looked when the gaze row was lit, in its own frame; `None` if not known.
    pub gaze: Option<GazeDirection>,
    /// Every method against the reference, over the whole image.
    pub measures: Vec<(Method, Measures)>,
    /// PNG files of the featured method, by the names of [`MOMENT_PICTURES`].
    pub files: Vec<(&'static str, Vec<u8>)>,
    /// Digests of the pictures, the reference first.
    pub digests: Vec<(String, String)>,
    pub(super) quality: Vec<Vec<Cell>>,
    pub(super) work: Vec<Vec<Cell>>,
    pub(super) small: Small,
}

/// A moment's pictures at the size of the page.
#[derive(Debug, Clone)]
pub(super) struct Small {
    pub(super) reference: Image,
    /// The featured method's picture, what to draw over it, and its error.
    pub(super) featured: Option<(Image, Vec<Outline>, ErrorMap)>,
}

pub(super) fn moments(
    scenario: &Scenario,
    replay: &Replay,
    progress: &dyn Fn(f64),
) -> Result<Vec<Moment>, RunError> {
    let seen: Vec<&ReplayFrame> = replay
        .frames
        .iter()
        .filter(|f| f.true_gaze.is_some())
        .collect();
    // Without a known gaze there is nothing to be sharp for; a fovea at the centre is worth seeing.
    let from = if seen.is_empty() {
        replay.frames.iter().collect()
    } else {
        seen
    };
    let count = (scenario.spec.images as usize).min(from.len());
    if count == 0 {
        return Ok(Vec::new());
    }
    let scene = study_scene(scenario.spec.seed);
    let first_head = replay.frames[0].head();
    let mut moments = Vec::with_capacity(count);
    for k in 0..count {
        progress(k as f64 / count as f64);
        let frame = *from[(2 * k + 1) * from.len() / (2 * count)];
        moments.push(moment(
            scenario,
            &scene,
            first_head,
            frame,
            frame.lit - replay.start,
        )?);
    }
    Ok(moments)
}

fn moment(
    scenario: &Scenario,
    scene: &Scene,
    first_head: Pose,
    frame: ReplayFrame,
    time: Nanos,
) -> Result<Moment, RunError> {
    let panel = scenario.display.primary();
    let request = Request {
        acuity: scenario.acuity,
        gaze: panel.in_eye(frame.fovea),
        margin_deg: scenario.spec.margin_deg,
        ..Request::ahead(panel)
    };
    let gaze = frame.true_gaze.map(|g| panel.in_eye(g));
    // Recorded heads start anywhere: put the first one on the camera's way, upright in both worlds.
    let camera = upright(study_camera(CAMERA_AT, scenario.spec.seed));
    let scene_from_world = camera.then(upright(first_head).inverse());
    let eye = |head: Pose| scene_from_world.then(head).then(panel.head_from_eye);
    let rolling = scenario.spec.rolling && frame.heads.is_some();
    let study = FrameStudy {
        sight: Sight {
            scene,
            world_from_eye: eye(frame.head()),
            scan: rolling.then(|| ScanMotion {
                end: eye(frame.head_at_end()),
                skew: scenario.display.scan.picture_skew(),
            }),
        },
        before: Vec::new(),
        first_frame: 0,
        gaze: gaze.unwrap_or(request.gaze),
        request: request.clone(),
        drawing: Drawing::default(),
    };
    let foveated = scenario
        .methods
        .iter()
        .copied()
        .filter(|m| *m != Method::Full);
    let outcome = study.run(&foveated.collect::<Vec<_>>())?;

    let reference = &outcome.reference.image;
    let mut digests = vec![("reference".to_owned(), image_digest(reference))];
    for shot in &outcome.shots {
        digests.push((shot.method.to_string(), image_digest(&shot.frame.image)));
    }
    let mut moment = Moment {
        frame,
        time,
        request,
        gaze,
        measures: outcome
            .shots
            .iter()
            .map(|s| (s.method, s.measures))
            .collect(),
        files: vec![("reference", png(reference)?)],
        digests,
        quality: outcome.quality_rows().collect(),
        work: outcome.work_rows().collect(),
        small: Small {
            reference: shrink(reference, PAGE_IMAGE_PX),
            featured: None,
        },
    };
    let featured = scenario.featured();
    if let Some(shot) = outcome.shots.iter().find(|s| s.method == *featured) {
        moment.show(shot, &outcome)?;
    }
    Ok(moment)
}

/// A pose's position and heading, without pitch and roll: up stays up.
fn upright(pose: Pose) -> Pose {
    let heading = GazeDirection::from_vector(pose.direction(DVec3::NEG_Z)).azimuth_deg;
    Pose::new(
        pose.position,
        DQuat::from_axis_angle(DVec3::Y, -to_rad(heading)),
    )
}

impl Moment {
    /// Encodes the featured method's pictures.
    fn show(&mut self, shot: &Shot, outcome: &FrameOutcome) -> Result<(), RunError> {
        let (image, reference) = (&shot.frame.image, &outcome.reference.image);
        let mut outlines = self.outlines(shot);
        let layers = overlay(image, &outlines);
        let mut error = error_map(image, reference, ERROR_FULL_SCALE)?;
        let overview = [&layers, reference, &error.image].map(|i| shrink(i, OVERVIEW_PX));
        self.files.extend([
            ("frame", png(image)?),
            ("layers", png(&layers)?),
            ("error", png(&error.image)?),
            ("overview", png(&side_by_side(&overview.each_ref(), 8))?),
        ]);
        let small = shrink(image, PAGE_IMAGE_PX);
        let shrunk = f64::from(image.size.x) / f64::from(small.size.x);
        for point in outlines.iter_mut().flat_map(|o| &mut o.points) {
            *point /= shrunk;
        }
        error.image = shrink(&error.image, PAGE_IMAGE_PX);
        self.small.featured = Some((small, outlines, error));
        Ok(())
    }

    /// The layers' outlines and, if it is known, where the eye looked.
    fn outlines(&self, shot: &Shot) -> Vec<Outline> {
        let viewport = &self.request.viewport;
        let fovea = self.request.gaze.vector();
        let mut outlines: Vec<Outline> = layer_radii_deg(&shot.plan)
            .map(|e| Outline::eccentricity(format!("{e:.1}°"), viewport, fovea, e))
            .collect();
        if let Some(at) = self.gaze.and_then(|g| viewport.project(g.vector())) {
            outlines.push(Outline::cross("eye", at, f64::from(viewport.size.x) / 80.0));
        }
        outlines
    }
}

/// Where each layer but the outermost ends \[deg\].
fn layer_radii_deg(plan: &SamplePlan) -> impl Iterator<Item = f64> {
    let edges: &[[f64; 2]] = match &plan.resolve {
        Resolve::Feather(feather) => &feather.edges_tan,
        _ => &[],
    };
    edges.iter().map(|[_, end]| atan_deg(*end))
}

/// Quality of every method at every moment: the whole image, then ring by ring.
pub(super) fn quality_table(moments: &[Moment]) -> Table {
    let mut table = Table::new(
        ["moment", "time_ms", "eye"]
            .into_iter()
            .chain(QUALITY_COLUMNS),
    );
    for (k, moment) in moments.iter().enumerate() {
        for row in &moment.quality {
            let eye = moment.request.eye.name();
            let head = [(k + 1).into(), moment.time.as_ms().into(), eye.into()];
            table.push(head.into_iter().chain(row.iter().cloned()).collect());
        }
    }
    table
}

/// What drawing each picture took.
pub(super) fn work_table(moments: &[Moment]) -> Table {
    let mut table = Table::new(["moment"].into_iter().chain(work_columns()));
    for (k, moment) in moments.iter().enumerate() {
        for row in &moment.work {
            table.push(
                std::iter::once((k + 1).into())
                    .chain(row.iter().cloned())
                    .collect(),
            );
        }
    }
    table
}
