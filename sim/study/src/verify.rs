//! Predicted frame times beside measured ones.

mod choice;
mod judge;
mod model;
mod outcome;
mod probe;
mod row;
mod terms;
mod zones;

pub use outcome::VerifyOutcome;
pub use row::{HeldOutFor, VerifyRow};

use std::collections::BTreeMap;

use foveasim_assets::Scene;
use foveasim_models::foveation::Method;
use foveasim_models::math::mean;
use foveasim_models::{ModelError, Pose, SamplePlan, View, Viewport};
use foveasim_render::RenderOptions;

use crate::kernel::one_colour;
use crate::measure::{Clock, Job, JobFrame, Measured, Pace, measure};
use crate::{FrameError, Sweep};
use choice::{Pick, spread};
use probe::{Pictures, Probe};
use terms::{TERMS, Terms, terms};
use zones::zones;

/// Some cells of a [`Sweep`] drawn by this project's renderer, and their time beside what is predicted before they are
/// drawn.
///
/// The prediction knows the plan, small pictures of the scene (160 pixels across, a tenth of the least cell's samples), and a fit to at most half of
/// the cells: whole scenes, whole methods and the largest size are held out.
#[derive(Debug, Clone)]
pub struct Verify<'a> {
    /// Where cells come from: of each display the first eye's image.
    pub sweep: &'a Sweep,
    /// What is drawn; at least one.
    pub scenes: &'a [VerifyScene],
    /// How many cells are drawn, besides full resolution where they are compared with it.
    pub cells: usize,
    /// How often each is drawn.
    pub rounds: u32,
    /// How all are drawn.
    pub options: RenderOptions,
    /// Which cells, and which of them are held out.
    pub seed: u64,
}

/// A scene to be drawn.
pub struct VerifyScene {
    /// Its name.
    pub name: String,
    /// What there is to see.
    pub scene: Scene,
    /// Where the eye is, for an image of these optics.
    pub eye: Box<dyn Fn(&Viewport) -> Pose + Send + Sync>,
    /// Nothing nearer than this is drawn \[m\].
    pub near_m: f64,
}

impl std::fmt::Debug for VerifyScene {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("VerifyScene")
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

/// The most pixels of an image: larger ones are not drawn.
const MOST_PIXELS: u64 = 3840 * 2400;
/// The fewest cells: a fit needs more rows than terms.
pub(crate) const FEWEST_CELLS: usize = 2 * TERMS.len();
/// The most cells.
pub(crate) const MOST_CELLS: usize = 10_000;
/// Rounds of the probes' pictures: they are small.
const PROBE_ROUNDS: u32 = 9;
/// Pixels across the image that sets the pace.
const PACE_PX: u32 = 480;

/// A cell, ready to be drawn.
struct Cell<'a> {
    pick: Pick,
    job: Job<'a>,
    viewport: Viewport,
    terms: Terms,
}

impl Verify<'_> {
    /// Draws and predicts. `progress` hears what is done, and what share of all is.
    ///
    /// # Errors
    /// If no display has whole pixels, there are too few or too many cells, or one cannot be drawn.
    pub fn run(
        &self,
        clock: &mut Clock<'_>,
        progress: &dyn Fn(&str, f64),
    ) -> Result<VerifyOutcome, FrameError> {
        self.check()?;
        let picks = self.picks()?;
        let bare: Vec<Scene> = self
            .scenes
            .iter()
            .map(|s| one_colour(&s.scene).expect("the parts of a scene make one"))
            .collect();
        let mut pace = Pace::new(self.pace()?);
        let (probes, probe_ms) = self.probes(&picks, &bare, &mut pace, clock, progress)?;
        let cells = self.cells_of(&picks, &probes)?;
        let jobs: Vec<Job<'_>> = cells.iter().map(|c| c.job.clone()).collect();
        let mut done = 0.0;
        let all = jobs.len() as f64 * f64::from(self.rounds);
        let measured = measure(&jobs, Some(&mut pace), self.rounds, clock, &mut || {
            done += 1.0;
            progress("drawing cells", 0.2 + 0.8 * done / all);
        })?;
        Ok(self.judge(&cells, &measured, probe_ms))
    }

    fn check(&self) -> Result<(), ModelError> {
        let range = |what: &str, n: usize, from: usize, to: usize| match (from..=to).contains(&n) {
            true => Ok(()),
            false => Err(ModelError::range(what, n, format!("from {from} to {to}"))),
        };
        range("scenes", self.scenes.len(), 1, 1000)?;
        range("cells to be drawn", self.cells, FEWEST_CELLS, MOST_CELLS)?;
        range("rounds", self.rounds as usize, 2, 1000)
    }

    /// The cells, and full resolution of each display and scene among them.
    fn picks(&self) -> Result<Vec<Pick>, FrameError> {
        let mut candidates = Vec::new();
        for group in 0..self.sweep.groups() {
            for (place, &method) in self.sweep.methods.iter().enumerate() {
                let Some(request) = self.sweep.request(group, method) else {
                    continue;
                };
                let pixels = pixels(&request.viewport);
                if pixels > MOST_PIXELS {
                    continue;
                }
                let fov = (self.sweep.named(group).1 * 1e3) as u64;
                for scene in 0..self.scenes.len() {
                    let pick = Pick {
                        scene,
                        group,
                        method: place,
                    };
                    candidates.push((pick, [scene as u64, pixels, fov, place as u64]));
                }
            }
        }
        if candidates.is_empty() {
            let text = format!(
                "no display has whole pixels, at most {MOST_PIXELS} of them: give --pixels, --ppd or --display"
            );
            return Err(ModelError::Syntax(text).into());
        }
        let mut picks = spread(&candidates, self.cells, self.seed);
        if let Some(full) = self.full() {
            let beside = picks.iter().map(|p| Pick { method: full, ..*p });
            let beside: Vec<Pick> = beside.collect();
            picks.extend(beside);
        }
        picks.sort_unstable();
        picks.dedup();
        if picks.len() < FEWEST_CELLS {
            let valid =
                format!("at least {FEWEST_CELLS}: more fields of view, sizes, methods or scenes");
            return Err(ModelError::range("cells that can be drawn", picks.len(), valid).into());
        }
        Ok(picks)
    }

    /// Place of full resolution in the list of methods.
    fn full(&self) -> Option<usize> {
        self.sweep.methods.iter().position(|m| *m == Method::Full)
    }

    fn view(&self, pick: &Pick) -> Result<(View, SamplePlan), ModelError> {
        let method = self.sweep.methods[pick.method];
        let request = self.sweep.request(pick.group, method);
        let request = request.expect("a candidate has whole pixels");
        let eye = (self.scenes[pick.scene].eye)(&request.viewport);
        let view = View::still(request.eye, request.viewport, eye);
        Ok((view, method.plan(&request)?))
    }

    fn options(&self, scene: usize) -> RenderOptions {
        RenderOptions {
            near_m: self.scenes[scene].near_m,
            ..self.options
        }
    }

    /// The first scene at a small size: what all times are taken beside.
    fn pace(&self) -> Result<Job<'_>, FrameError> {
        let first = &self.scenes[0];
        let size = glam::UVec2::new(PACE_PX, PACE_PX * 9 / 16);
        let viewport = Viewport::symmetric(size, 0.7)?;
        let eye = foveasim_models::Eye::Cyclopean;
        let frame = JobFrame {
            scene: &first.scene,
            view: View::still(eye, viewport, (first.eye)(&viewport)),
            plan: SamplePlan::full(eye, size),
        };
        Ok(Job {
            warm_up: 0,
            frames: vec![frame; 1],
            ..Job::still_of(self.options(0))
        })
    }

    /// Which views are probed: the same scene, place and optics need one probe, whatever the size and the method.
    fn probe_key(&self, pick: &Pick) -> Result<(usize, [u64; 10]), ModelError> {
        let (view, _) = self.view(pick)?;
        let gaze = self.gaze(pick);
        let at = view.poses[0].position;
        let shape = f64::from(view.optics.size.y) / f64::from(view.optics.size.x);
        let [l, r, u, d] = view.optics.tan;
        // To a thousandth of the image: sizes that are not quite of one shape share a probe.
        let rounded = [l, r, u, d, shape, gaze.x, gaze.y].map(|v| (v * 1e3).round().to_bits());
        let place = at.to_array().map(f64::to_bits);
        let mut key = [0; 10];
        key[..7].copy_from_slice(&rounded);
        key[7..].copy_from_slice(&place);
        Ok((pick.scene, key))
    }

    fn gaze(&self, pick: &Pick) -> glam::DVec3 {
        let method = self.sweep.methods[pick.method];
        let request = self.sweep.request(pick.group, method);
        request.expect("a candidate has whole pixels").gaze.vector()
    }

    /// A probe for each pick, and the mean time of one \[ms\]: of each of its pictures once.
    fn probes(
        &self,
        picks: &[Pick],
        bare: &[Scene],
        pace: &mut Pace<'_>,
        clock: &mut Clock<'_>,
        progress: &dyn Fn(&str, f64),
    ) -> Result<(Vec<Probe>, f64), FrameError> {
        let mut found: BTreeMap<(usize, [u64; 10]), Probe> = BTreeMap::new();
        let (mut of_picks, mut took) = (Vec::new(), Vec::new());
        for (k, pick) in picks.iter().enumerate() {
            progress("probing scenes", 0.2 * k as f64 / picks.len() as f64);
            let key = self.probe_key(pick)?;
            if let Some(probe) = found.get(&key) {
                of_picks.push(probe.clone());
                continue;
            }
            let (view, _) = self.view(pick)?;
            let scenes = [&self.scenes[pick.scene].scene, &bare[pick.scene]];
            let options = self.options(pick.scene);
            let gaze = self.gaze(pick);
            let (pictures, jobs) =
                Pictures::new(scenes, &view.optics, view.poses[0], gaze, &options)?;
            debug_assert_eq!(jobs.len(), pictures.len());
            let times = measure(&jobs, Some(&mut *pace), PROBE_ROUNDS, clock, &mut || ())?;
            took.push(times.iter().map(Measured::frame_ms).sum::<f64>());
            let probe = pictures.read(&times);
            of_picks.push(probe.clone());
            found.insert(key, probe);
        }
        Ok((of_picks, mean(&took)))
    }

    fn cells_of<'a>(
        &'a self,
        picks: &[Pick],
        probes: &[Probe],
    ) -> Result<Vec<Cell<'a>>, FrameError> {
        let cell = |(pick, probe): (&Pick, &Probe)| {
            let (view, plan) = self.view(pick)?;
            let passes = zones(&plan, &view.optics, self.gaze(pick));
            let terms = terms(&plan, &view.optics, &passes, probe);
            let frame = JobFrame {
                scene: &self.scenes[pick.scene].scene,
                view,
                plan,
            };
            Ok(Cell {
                pick: *pick,
                viewport: frame.view.optics,
                job: Job::still(frame, self.options(pick.scene)),
                terms,
            })
        };
        picks.iter().zip(probes).map(cell).collect()
    }
}

fn pixels(viewport: &Viewport) -> u64 {
    u64::from(viewport.size.x) * u64::from(viewport.size.y)
}

#[cfg(test)]
mod tests;
