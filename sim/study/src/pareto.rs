//! Time against error: every method and setting on chosen scenes and recordings.

mod answer;
mod export;
mod judge;
mod measure_of;
mod outcome;
mod row;
mod scores;

pub use answer::Answer;
pub use export::Export;
pub use measure_of::ErrorMeasure;
pub use outcome::ParetoOutcome;
pub use row::{Errors as ParetoErrors, ParetoRing, ParetoRow};
pub use scores::Scores;

use foveasim_models::foveation::{Method, Request};
use foveasim_models::math::mean;
use foveasim_models::{FrameWork, GazeDirection, Resolve, SamplePlan, View};
use foveasim_quality::Rings;
use foveasim_render::Frame;

use crate::measure::{Clock, Job, JobFrame, Measured, Pace, measure};
use crate::{Drawing, FrameError, Sight, Terms};

/// Methods beside each other: what a frame takes, and how far it is from the reference.
#[derive(Debug, Clone)]
pub struct Pareto<'a> {
    /// What is drawn: at least one clip.
    pub clips: Vec<Clip<'a>>,
    /// How. Full resolution need not be among them: it is always drawn, first.
    pub methods: Vec<Method>,
    /// Image, acuity and margin. Where the eye looks, the clips say.
    pub request: Request,
    /// How all are drawn, and the reference.
    pub drawing: Drawing,
    /// Rings of eccentricity about where the eye really looks.
    pub rings: Rings,
    /// So many frames at the beginning of each clip are drawn, but neither judged nor timed.
    pub warm_up: usize,
    /// What memory costs; and time, where none is measured.
    pub terms: Terms,
}

/// Consecutive frames.
#[derive(Debug, Clone)]
pub struct Clip<'a> {
    /// Its name.
    pub name: String,
    /// The frames, oldest first.
    pub frames: Vec<ClipFrame<'a>>,
    /// Number of the first.
    pub first_frame: u64,
}

/// A frame of a [`Clip`].
#[derive(Debug, Clone, Copy)]
pub struct ClipFrame<'a> {
    /// What there is to see.
    pub sight: Sight<'a>,
    /// Where the eye really looks, in its own frame: rings are about it.
    pub gaze: GazeDirection,
    /// Where the methods take it to look.
    pub believed: GazeDirection,
}

/// How the time of a frame is found.
pub enum Timing<'c, 'k> {
    /// Measured by a clock, in so many rounds.
    Measured(&'c mut Clock<'k>, u32),
    /// By the cost profile of [`Pareto::terms`], on the plan's own counts: the same on every machine.
    Predicted,
}

/// Told of every judged frame: clip, method, its number from 0 among those judged, the frame, and the reference.
pub type ShowPair<'s, E> =
    dyn FnMut(&Clip<'_>, Method, usize, &Frame, &Frame) -> Result<(), E> + 's;

impl Pareto<'_> {
    /// The methods, full resolution first.
    pub fn methods(&self) -> Vec<Method> {
        let others = self.methods.iter().filter(|m| **m != Method::Full);
        let mut all = vec![Method::Full];
        for method in others {
            if !all.contains(method) {
                all.push(*method);
            }
        }
        all
    }

    /// How many steps [`Self::run`] tells of.
    pub fn steps(&self, rounds: u32) -> u64 {
        let judged: usize = self.clips.iter().map(|c| c.frames.len()).sum();
        let timed = self.clips.len() * (self.methods().len() + 1) * rounds as usize;
        (judged + timed) as u64
    }

    /// Draws, judges and times. `show` is given every judged frame beside its reference; its errors end the run.
    /// `done` hears of every step ([`Self::steps`]).
    ///
    /// # Errors
    /// If a method cannot be planned, or a frame not be drawn or compared; those of `show`.
    pub fn run<E: From<FrameError>>(
        &self,
        timing: Timing<'_, '_>,
        show: &mut ShowPair<'_, E>,
        done: &mut dyn FnMut(),
    ) -> Result<ParetoOutcome, E> {
        let methods = self.methods();
        let mut judged = Vec::new();
        for clip in &self.clips {
            judged.push(self.judge(clip, &methods, show, done)?);
        }
        let (times, noise, measured) = match timing {
            Timing::Measured(clock, rounds) => {
                let (times, noise) = self.times(&methods, rounds, clock, done)?;
                (times, Some(noise), true)
            }
            Timing::Predicted => (self.predicted(&methods)?, None, false),
        };
        let mut rows = Vec::new();
        for ((clip, judged), times) in self.clips.iter().zip(judged).zip(times) {
            for ((&method, judged), time_ms) in methods.iter().zip(judged).zip(times) {
                let (samples, shadings, memory_mb) = self.needs(clip, method)?;
                rows.push(ParetoRow {
                    clip: clip.name.clone(),
                    method,
                    time_ms,
                    samples,
                    shadings,
                    memory_mb,
                    errors: judged,
                    jod: None,
                });
            }
        }
        Ok(ParetoOutcome::new(methods, rows, noise, measured))
    }

    fn view(&self, sight: &Sight<'_>) -> Result<View, FrameError> {
        sight.view(&self.request, self.drawing.lens)
    }

    fn plan(&self, method: Method, frame: &ClipFrame<'_>) -> Result<SamplePlan, FrameError> {
        let request = Request {
            gaze: frame.believed,
            ..self.request.clone()
        };
        Ok(method.plan(&request)?.with_msaa(self.drawing.msaa))
    }

    fn job<'a>(&self, clip: &Clip<'a>, method: Method) -> Result<Job<'a>, FrameError> {
        let frame = |frame: &ClipFrame<'a>| {
            Ok(JobFrame {
                scene: frame.sight.scene,
                view: self.view(&frame.sight)?,
                plan: self.plan(method, frame)?,
            })
        };
        Ok(Job {
            frames: clip
                .frames
                .iter()
                .map(frame)
                .collect::<Result<_, FrameError>>()?,
            warm_up: self.warm_up,
            first_frame: clip.first_frame,
            options: self.drawing.options,
            temporal: self.drawing.temporal,
        })
    }

    /// Frame times of each clip's methods \[ms\], and by how much full resolution again differs: the largest of the clips.
    fn times(
        &self,
        methods: &[Method],
        rounds: u32,
        clock: &mut Clock<'_>,
        done: &mut dyn FnMut(),
    ) -> Result<(Vec<Vec<f64>>, f64), FrameError> {
        let (mut times, mut noise) = (Vec::new(), 0.0_f64);
        for clip in &self.clips {
            let again = methods.iter().chain([&Method::Full]);
            let jobs = again.map(|&method| self.job(clip, method));
            let jobs: Vec<Job<'_>> = jobs.collect::<Result<_, _>>()?;
            let mut pace = jobs.last().cloned().map(Pace::new);
            let found = measure(&jobs, pace.as_mut(), rounds, clock, done)?;
            let mut ms: Vec<f64> = found.iter().map(Measured::frame_ms).collect();
            let again = ms.pop().unwrap_or(f64::NAN);
            noise = noise.max((again / ms[0] - 1.0).abs());
            times.push(ms);
        }
        Ok((times, noise))
    }

    /// The same by the cost profile.
    fn predicted(&self, methods: &[Method]) -> Result<Vec<Vec<f64>>, FrameError> {
        let of = |clip: &Clip<'_>, method: Method| {
            let frames = self.judged(clip).iter();
            let ms = frames.map(|frame| {
                let work = frame_work(&self.plan(method, frame)?, self.drawing.temporal.staggered);
                Ok(self.terms.cost.time_ns(&work) / 1e6)
            });
            Ok(mean(&ms.collect::<Result<Vec<f64>, FrameError>>()?))
        };
        let clip = |clip| methods.iter().map(|&method| of(clip, method)).collect();
        self.clips.iter().map(clip).collect()
    }

    /// Samples and evaluations of shading per frame, and memory of a frame \[MB\].
    fn needs(&self, clip: &Clip<'_>, method: Method) -> Result<(f64, f64, f64), FrameError> {
        let mut all = [Vec::new(), Vec::new(), Vec::new()];
        for frame in self.judged(clip) {
            let plan = self.plan(method, frame)?;
            let work = frame_work(&plan, self.drawing.temporal.staggered);
            let lattices: u64 = plan.passes.iter().map(|p| p.lattice.samples()).sum();
            let memory = &self.terms.buffers;
            all[0].push(work.samples);
            all[1].push(work.samples_shaded);
            all[2].push(memory.megabytes(lattices as f64, work.pixels_resolved));
        }
        let [samples, shadings, memory] = all.map(|v| mean(&v));
        Ok((samples, shadings, memory))
    }

    fn judged<'a, 'c>(&self, clip: &'c Clip<'a>) -> &'c [ClipFrame<'a>] {
        &clip.frames[self.warm_up.min(clip.frames.len())..]
    }
}

/// What a planner can say of a plan's frame; with `staggered`, on average, each pass at its own cadence.
fn frame_work(plan: &SamplePlan, staggered: bool) -> FrameWork {
    let count = plan.count();
    let of = |every: u32| {
        if staggered {
            1.0 / f64::from(every)
        } else {
            1.0
        }
    };
    let sum = |f: &dyn Fn(&foveasim_models::PassCount) -> f64| {
        count
            .passes
            .iter()
            .fold(0.0, |sum, p| sum + f(p) * of(p.every))
    };
    FrameWork {
        samples_shaded: sum(&|p| p.shadings as f64),
        samples: sum(&|p| p.samples as f64),
        pixels_resolved: match plan.resolve {
            Resolve::Direct => 0.0,
            _ => count.display_pixels as f64,
        },
        passes: sum(&|_| 1.0),
    }
}

#[cfg(test)]
mod tests;
