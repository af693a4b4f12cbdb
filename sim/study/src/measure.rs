//! The time of frames: the one way in which it is taken.

use std::time::Duration;

use foveasim_assets::Scene;
use foveasim_models::math::{mean, quantile_sorted};
use foveasim_models::{Image, SamplePlan, View, Work};
use foveasim_render::{RenderError, RenderOptions, Sequence, TemporalOptions};
use glam::UVec2;

/// A clock: the time since some moment of its own. Libraries read none: who runs a study hands one in, and chooses
/// between the time that passes and the processor's.
pub type Clock<'a> = dyn FnMut() -> Duration + 'a;

/// Consecutive frames to be drawn and timed.
#[derive(Debug, Clone)]
pub struct Job<'a> {
    /// What is drawn, one frame after the other.
    pub frames: Vec<JobFrame<'a>>,
    /// Of which so many at the beginning are not timed: there is then a history, and memory and caches hold what
    /// they hold in a program that draws nothing else.
    pub warm_up: usize,
    /// Number of the first frame.
    pub first_frame: u64,
    /// How all are drawn.
    pub options: RenderOptions,
    /// What they take from the frames before.
    pub temporal: TemporalOptions,
}

/// A frame of a [`Job`].
#[derive(Debug, Clone)]
pub struct JobFrame<'a> {
    /// What there is to see.
    pub scene: &'a Scene,
    /// From where, and on which image.
    pub view: View,
    /// The samples.
    pub plan: SamplePlan,
}

/// A job drawn between others, to see how fast the machine is meanwhile.
#[derive(Debug, Clone)]
pub struct Pace<'a> {
    job: Job<'a>,
    /// What it took when it was first measured \[ms\].
    usual_ms: Option<f64>,
}

impl<'a> Pace<'a> {
    /// That of a `job`, not measured yet.
    pub fn new(job: Job<'a>) -> Self {
        Self {
            job,
            usual_ms: None,
        }
    }
}

/// What drawing a [`Job`] took.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Measured {
    /// What was done in the timed frames of one round, exactly.
    pub work: Work,
    /// Times of the timed frames \[ms\], round by round.
    pub times_ms: Vec<Vec<f64>>,
}

impl<'a> Job<'a> {
    /// One frame by itself, timed twice in a round.
    pub fn still(frame: JobFrame<'a>, options: RenderOptions) -> Self {
        Self {
            frames: vec![frame; 3],
            warm_up: 1,
            ..Self::still_of(options)
        }
    }

    /// No frames yet, drawn so.
    pub(crate) fn still_of(options: RenderOptions) -> Self {
        Self {
            frames: Vec::new(),
            warm_up: 0,
            first_frame: 0,
            options,
            temporal: TemporalOptions::OFF,
        }
    }

    /// Draws all frames once, and takes the time of those that are timed.
    fn draw(&self, clock: &mut Clock<'_>) -> Result<(Work, Vec<f64>), RenderError> {
        let mut sequence = Sequence::new(self.temporal);
        let mut spare = Image::filled(UVec2::ZERO, [0.0; 3]);
        let (mut work, mut times_ms) = (Work::default(), Vec::new());
        for ((number, frame), k) in (self.first_frame..).zip(&self.frames).zip(0..) {
            let JobFrame { scene, view, plan } = frame;
            let began = clock();
            let drawn = sequence.draw_into(scene, view, plan, number, &self.options, spare)?;
            let took = clock().saturating_sub(began);
            if k >= self.warm_up {
                times_ms.push(took.as_secs_f64() * 1e3);
                work += drawn.work;
            }
            spare = drawn.image;
        }
        Ok((work, times_ms))
    }
}

/// Takes the time of every job, `rounds` times: a round draws one job after the other, so that what disturbs the machine
/// disturbs all alike. `done` hears of every job of every round.
///
/// With a job to set the `pace`, that is drawn between the others, and times are given at its usual pace: divided by what
/// it takes meanwhile, times what it took when it was first measured. A machine that others use runs now faster, now
/// slower, for longer than all of one measurement.
///
/// Of all draws the lower quartile counts, of jobs as of the pace: what disturbs only ever adds, and seldom all the time.
/// [`Measured::noise`] says how far rounds then repeat themselves.
///
/// Frames are drawn on rayon's current pool. Processor time is best taken on a pool of one thread: nothing then waits
/// for another.
///
/// # Errors
/// The first of drawing.
pub fn measure(
    jobs: &[Job<'_>],
    mut pace: Option<&mut Pace<'_>>,
    rounds: u32,
    clock: &mut Clock<'_>,
    done: &mut dyn FnMut(),
) -> Result<Vec<Measured>, RenderError> {
    let mut found = vec![Measured::default(); jobs.len()];
    let pacing = pace.as_ref().map(|pace| pace.job.clone());
    let mut beats = Vec::new();
    for _ in 0..rounds {
        for (job, measured) in jobs.iter().zip(&mut found) {
            if let Some(job) = &pacing {
                beats.push(mean(&job.draw(clock)?.1));
            }
            let (work, times_ms) = job.draw(clock)?;
            measured.work = work;
            measured.times_ms.push(times_ms);
            done();
        }
    }
    if let Some(pace) = &mut pace {
        let now = lower_quartile(beats);
        let faster = *pace.usual_ms.get_or_insert(now) / now;
        for ms in found.iter_mut().flat_map(|m| &mut m.times_ms).flatten() {
            *ms *= faster;
        }
    }
    Ok(found)
}

fn lower_quartile(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    quantile_sorted(&values, 0.25)
}

impl Measured {
    /// Time of a frame \[ms\]: the lower quartile over the rounds of each one's, and the mean of those; NaN if nothing was
    /// timed.
    pub fn frame_ms(&self) -> f64 {
        self.of_rounds(0, 1)
    }

    /// How far the time of the odd rounds is from that of the even ones, as a share: what the same job again differs
    /// by. NaN of fewer than two rounds.
    pub fn noise(&self) -> f64 {
        (self.of_rounds(1, 2) / self.of_rounds(0, 2) - 1.0).abs()
    }

    /// As [`Self::frame_ms`], of every `step`-th round from `first` on.
    fn of_rounds(&self, first: usize, step: usize) -> f64 {
        let frames = self.times_ms.first().map_or(0, Vec::len);
        let of = |k: usize| {
            let rounds = self.times_ms.iter().skip(first).step_by(step);
            lower_quartile(rounds.map(|r| r[k]).collect())
        };
        mean(&(0..frames).map(of).collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use foveasim_assets::{GeneratedScene, study_camera};
    use foveasim_models::{Eye, Viewport};

    use super::*;

    #[test]
    fn every_job_is_timed_in_every_round() {
        let scene = GeneratedScene::Hairball { strands: 20 }.build(1);
        let viewport = Viewport::symmetric(UVec2::new(32, 18), 0.7).unwrap();
        let view = View::still(Eye::Cyclopean, viewport, study_camera(0.1, 1));
        let frame = JobFrame {
            scene: &scene,
            view,
            plan: SamplePlan::full(Eye::Cyclopean, viewport.size),
        };
        let one = Job::still(frame, RenderOptions::default());
        let many = Job {
            frames: vec![one.frames[0].clone(); 5],
            warm_up: 2,
            ..one.clone()
        };
        let mut ticks = 0_u64;
        let mut clock = || {
            ticks += 1;
            Duration::from_millis(ticks * ticks)
        };
        let mut told = 0;
        let found = measure(&[one, many], None, 4, &mut clock, &mut || told += 1).unwrap();
        assert_eq!((told, ticks), (8, 4 * 2 * (3 + 5)));
        let timed: Vec<_> = found.iter().map(|m| m.times_ms[3].len()).collect();
        assert_eq!(timed, [2, 3]);
        let pixels = 32 * 18;
        assert_eq!(found[0].work.samples(), 2 * pixels);
        assert_eq!(found[1].work.samples(), 3 * pixels);
    }

    /// A clock that runs twice as fast from the second measurement on, and for one frame in five in between: at the usual
    /// pace nothing is seen of that.
    #[test]
    fn a_pace_takes_out_what_lasts() {
        let scene = GeneratedScene::Hairball { strands: 5 }.build(1);
        let viewport = Viewport::symmetric(UVec2::new(16, 16), 0.7).unwrap();
        let frame = JobFrame {
            scene: &scene,
            view: View::still(Eye::Cyclopean, viewport, study_camera(0.1, 1)),
            plan: SamplePlan::full(Eye::Cyclopean, viewport.size),
        };
        let job = Job::still(frame, RenderOptions::default());
        let (mut asked, mut now) = (0, 0.0);
        let mut clock = || {
            asked += 1;
            // Two readings a frame, three frames a draw.
            let disturbed = (asked - 1) / 6 % 5 == 0;
            now += if asked > 6 * 2 * 2 * 5 || disturbed {
                2.0
            } else {
                1.0
            };
            Duration::from_secs_f64(now)
        };
        let jobs = [job.clone(), job.clone()];
        let mut pace = Pace::new(job);
        let found = measure(&jobs, Some(&mut pace), 5, &mut clock, &mut || ()).unwrap();
        assert_ne!(found[0].times_ms, found[1].times_ms);
        assert_eq!(found[0].frame_ms(), found[1].frame_ms());
        // … nor when it is measured again, all of it at half the speed.
        let again = measure(&jobs, Some(&mut pace), 5, &mut clock, &mut || ()).unwrap();
        assert_eq!(again[0].frame_ms(), found[0].frame_ms());
    }

    #[test]
    fn times_and_noise() {
        let measured = |times_ms: Vec<Vec<f64>>| Measured {
            times_ms,
            ..Measured::default()
        };
        let m = measured(vec![vec![1.0, 10.0], vec![2.0, 20.0], vec![9.0, 30.0]]);
        assert_eq!(m.frame_ms(), (1.5 + 15.0) / 2.0);
        // Of the odd round 11, of the even ones (3 + 15) / 2.
        assert!((m.noise() - (11.0 / 9.0 - 1.0)).abs() < 1e-12);
        assert!(measured(vec![]).frame_ms().is_nan());
        assert!(measured(vec![vec![1.0]]).noise().is_nan());
    }
}
