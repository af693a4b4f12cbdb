use std::num::NonZeroU32;
use std::time::Duration;

use foveasim_assets::{STUDY_FRAMES, Scene, StudyGaze, study_camera};
use foveasim_models::foveation::{Method, Prepared, Request};
use foveasim_models::math::{mean, quantile_sorted, sum};
use foveasim_models::{
    Acuity, Cadence, CellMask, Eye, GazeDirection, Image, Lattice, ModelError, Msaa, Region,
    Resolve, SamplePlan, View, Viewport, Visibility,
};
use foveasim_render::{Frame, RenderOptions, Sequence, TemporalOptions};
use glam::UVec2;

use super::payoff::coarser;
use crate::FrameError;

/// The three techniques of §4.2, each on or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Antialiasing {
    /// Visibility at four positions of each sample.
    pub msaa: bool,
    /// Each layer's samples are shifted within their cells, from frame to frame.
    pub jitter: bool,
    /// What was seen before is blended in where it is found again.
    pub reproject: bool,
}

/// Gaze and camera of the fly-through on one display.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Flight {
    pub(super) viewport: Viewport,
    pub(super) seed: u64,
    gaze: StudyGaze,
}

/// Draws consecutive frames of the fly-through in one way.
#[derive(Debug)]
pub(super) struct Shooter<'a> {
    flight: &'a Flight,
    scene: &'a Scene,
    method: Prepared,
    antialiasing: Antialiasing,
    due: Due,
    /// How many times farther apart samples are, and then put together by interpolation.
    step: Option<f64>,
    in_turns: bool,
    /// Whether no sample is drawn.
    empty: bool,
    /// More frames than are needed are drawn before one is timed.
    settle: u32,
    sequence: Sequence,
    /// Memory for the next image.
    spare: Image,
}

/// Which layers are drawn once all have been.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Due {
    /// Those whose turn it is.
    Planned,
    /// One of inner (0), middle (1) and outer (2), in every frame.
    Only(usize),
    /// None: what is left is putting images together.
    Nothing,
}

/// Times of some frames.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Times {
    /// One for each moment: the mean of an even and an odd frame \[ms\].
    pub frame_ms: Vec<f64>,
}

/// Frames drawn before a moment is timed, so that history and every layer are there.
const WARM_UP: u32 = 2;
/// In no frame.
const NEVER: Cadence = Cadence {
    every: NonZeroU32::MIN,
    phase: 1,
};
/// Frames timed at each moment: one of each turn of the staggered layers.
const TIMED: u32 = 2;

impl Antialiasing {
    /// Only MSAA.
    pub const MSAA: Self = Self {
        msaa: true,
        jitter: false,
        reproject: false,
    };

    /// All three, as in the paper's user study.
    pub const ALL: Self = Self {
        msaa: true,
        jitter: true,
        reproject: true,
    };

    /// How frames follow one another: whether layers take turns, as their cadence says.
    fn temporal(self, staggered: bool) -> TemporalOptions {
        TemporalOptions {
            jitter: self.jitter,
            reproject: self.reproject,
            staggered,
            ..TemporalOptions::default()
        }
    }
}

impl Flight {
    /// The fly-through of the scene of `seed`, seen on `viewport`.
    pub(super) fn new(viewport: Viewport, seed: u64) -> Self {
        let gaze = StudyGaze::record(seed);
        Self {
            viewport,
            seed,
            gaze,
        }
    }

    /// Where the eye is in `frame`, and what through.
    pub(super) fn view(&self, frame: u32) -> View {
        let t = f64::from(frame) / f64::from(STUDY_FRAMES);
        View::still(Eye::Cyclopean, self.viewport, study_camera(t, self.seed))
    }

    /// Where it looks, in its own frame: at the nearest approaching object.
    pub(super) fn gaze(&self, frame: u32) -> GazeDirection {
        self.gaze.direction(frame)
    }

    /// `method` at an acuity, ready for any gaze.
    pub(super) fn prepare(&self, method: Method, acuity: Acuity) -> Result<Prepared, ModelError> {
        method.prepare(&Request {
            eye: Eye::Cyclopean,
            viewport: self.viewport,
            acuity,
            gaze: GazeDirection::AHEAD,
            ahead: GazeDirection::AHEAD,
            margin_deg: 0.0,
        })
    }
}

impl<'a> Shooter<'a> {
    /// Draws all passes of the method, those outside the inner layer in every second frame.
    pub(super) fn new(
        flight: &'a Flight,
        scene: &'a Scene,
        method: Prepared,
        antialiasing: Antialiasing,
    ) -> Self {
        Self {
            flight,
            scene,
            method,
            antialiasing,
            due: Due::Planned,
            step: None,
            in_turns: true,
            empty: false,
            settle: 0,
            sequence: Sequence::new(antialiasing.temporal(true)),
            spare: Image::filled(UVec2::ZERO, [0.0; 3]),
        }
    }

    /// The same with every layer drawn in every frame.
    pub(super) fn in_every_frame(self) -> Self {
        Self {
            in_turns: false,
            sequence: Sequence::new(self.antialiasing.temporal(false)),
            ..self
        }
    }

    /// The same with samples `step` times as far apart, put together by interpolation: of the same meshes, and shaded
    /// as finely.
    pub(super) fn coarser(self, step: f64) -> Self {
        Self {
            step: Some(step),
            ..self
        }
    }

    /// The same without drawing any sample: what is left is geometry, and putting images together.
    pub(super) fn without_samples(self) -> Self {
        Self {
            empty: true,
            ..self
        }
    }

    /// The same with more frames drawn before one is timed, so that caches hold what they hold in a program
    /// that shows nothing else.
    pub(super) fn settled(self) -> Self {
        Self { settle: 4, ..self }
    }

    /// Whether layers are drawn in the frames of their cadence alone.
    pub(super) fn takes_turns(&self) -> bool {
        self.in_turns
    }

    /// The same with other layers due.
    pub(super) fn due(self, due: Due) -> Self {
        Self { due, ..self }
    }

    /// Whether nothing is drawn but what the first frame needs.
    pub(super) fn is_idle(&self) -> bool {
        self.due == Due::Nothing
    }

    /// What is drawn in `frame`.
    pub(super) fn plan(&self, frame: u32) -> Result<SamplePlan, ModelError> {
        let gaze = self.flight.gaze(frame);
        let mut plan = self.method.plan(gaze)?;
        if let Some(step) = self.step {
            plan = coarser(plan, step, gaze.vector());
        }
        let count = plan.passes.len();
        for (k, pass) in plan.passes.iter_mut().enumerate() {
            if self.antialiasing.msaa {
                pass.visibility = Visibility::Own(Msaa::Four);
            }
            if let (true, Lattice::Grid(size)) = (self.empty, pass.lattice) {
                pass.region = Region::Cells(CellMask::new(size, size, |_| false));
            }
            pass.cadence = match self.due {
                Due::Planned => pass.cadence,
                Due::Only(layer) if layer == layer_of(k, count) => Cadence::EVERY_FRAME,
                Due::Only(_) | Due::Nothing => NEVER,
            };
        }
        Ok(plan)
    }

    /// Forgets the frames before.
    pub(super) fn cut(&mut self) {
        self.sequence.cut();
    }

    /// Draws `frame`, which follows the one drawn last.
    pub(super) fn draw(&mut self, frame: u32) -> Result<Frame, FrameError> {
        let plan = self.plan(frame)?;
        let view = self.flight.view(frame);
        let mut options = RenderOptions::default();
        if let Some(step) = self.step {
            options.lod_error /= step;
            options.footprint /= step;
        }
        let frame = u64::from(frame);
        let spare = std::mem::replace(&mut self.spare, Image::filled(UVec2::ZERO, [0.0; 3]));
        Ok(self
            .sequence
            .draw_into(self.scene, &view, &plan, frame, &options, spare)?)
    }

    /// Takes back an image that is no longer needed, as programs do that draw frame after frame.
    pub(super) fn reuse(&mut self, image: Image) {
        self.spare = image;
    }

    /// Frames to draw before one can be timed: until every layer and a history are there.
    fn warm_up(&self) -> u32 {
        let together =
            self.antialiasing == Antialiasing::default() || self.antialiasing == Antialiasing::MSAA;
        let alone = self.plan(0).is_ok_and(|p| p.resolve == Resolve::Direct);
        let needed = if together && alone && self.due == Due::Planned {
            0
        } else {
            WARM_UP
        };
        needed + self.settle
    }
}

/// Inner (0), middle (1) or outer (2) for pass `k` of `count`: the outermost is the outer one, however
/// many there are.
pub(super) fn layer_of(k: usize, count: usize) -> usize {
    if k + 1 == count { 2 } else { k.min(1) }
}

/// `count` moments spread evenly over the fly-through, at even frames.
pub(super) fn moments(count: u32) -> Vec<u32> {
    let usable = u64::from(STUDY_FRAMES - WARM_UP - TIMED);
    let at = |k: u32| (2 * u64::from(k) + 1) * usable / (2 * u64::from(count));
    (0..count)
        .map(|k| (at(k) as u32 + WARM_UP) / 2 * 2)
        .collect()
}

/// Times all of them at each moment, one after the other, so that what disturbs the machine disturbs
/// all alike. `done` hears of every shooter at every moment.
pub(super) fn time(
    shooters: &mut [Shooter<'_>],
    moments: &[u32],
    clock: &mut dyn FnMut() -> Duration,
    done: &mut dyn FnMut(),
) -> Result<Vec<Times>, FrameError> {
    let mut times = vec![Times::default(); shooters.len()];
    for &moment in moments {
        for (shooter, times) in shooters.iter_mut().zip(&mut times) {
            shooter.cut();
            for frame in moment.saturating_sub(shooter.warm_up())..moment {
                let drawn = shooter.draw(frame)?;
                shooter.reuse(drawn.image);
            }
            let mut ms = Vec::new();
            for frame in moment..moment + TIMED {
                let begin = clock();
                let drawn = shooter.draw(frame)?;
                ms.push((clock().saturating_sub(begin)).as_secs_f64() * 1e3);
                shooter.reuse(drawn.image);
            }
            shooter.cut();
            times.frame_ms.push(mean(&ms));
            done();
        }
    }
    Ok(times)
}

impl Times {
    /// Of all timed frames \[ms\].
    pub fn total_ms(&self) -> f64 {
        f64::from(TIMED) * sum(&self.frame_ms)
    }

    /// Mean of a frame \[ms\].
    pub fn mean_ms(&self) -> f64 {
        mean(&self.frame_ms)
    }

    /// Median over the moments \[ms\].
    pub fn median_ms(&self) -> f64 {
        let mut sorted = self.frame_ms.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        quantile_sorted(&sorted, 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_leave_room_before_and_after() {
        for count in [1, 2, 24, 1000] {
            let all = moments(count);
            assert_eq!(all.len(), count as usize);
            assert!(all.windows(2).all(|w| w[0] < w[1]));
            assert!(all.iter().all(|m| m % 2 == 0 && *m >= WARM_UP));
            assert!(all[all.len() - 1] + TIMED <= STUDY_FRAMES);
        }
        assert_eq!(moments(1), [2688]);
    }

    #[test]
    fn times_are_of_frames() {
        let times = Times {
            frame_ms: vec![3.0, 1.0, 2.0, 10.0],
        };
        assert_eq!((times.median_ms(), times.mean_ms()), (2.5, 4.0));
        assert_eq!(times.total_ms(), 32.0);
    }
}
