use std::sync::Arc;

use foveasim_assets::Scene;
use foveasim_models::{Image, Map, Pass, SamplePlan, View, Work};
use glam::{DVec2, UVec2};

use super::history::{History, Past, Placed};
use super::reproject::reproject;
use super::{TemporalOptions, jitter};
use crate::check::check;
use crate::moving::Warp;
use crate::pass::PassSamples;
use crate::passes::draw_passes;
use crate::{Frame, FrameMemory, RenderError, RenderOptions, resolve};

/// Draws frames that follow one another, and keeps of each pass what the next frame can use.
///
/// History is dropped, and every pass drawn afresh, after [`cut`](Self::cut) and whenever a frame
/// cannot follow the one before: another number of passes, method, eye or image size; another number
/// of instances or of meshes, other meshes or materials for an instance, meshes of other sizes, another
/// sun. Within a sequence a scene's instances may move, grow and turn; whoever changes what a mesh,
/// a material or the sky looks like calls `cut`. A view that jumps needs no cut: the history fails its
/// test wherever it shows something else.
///
/// ```
/// use foveasim_assets::{study_camera, study_scene};
/// use foveasim_models::{Eye, SamplePlan, View, Viewport};
/// use foveasim_render::{RenderOptions, Sequence, TemporalOptions};
/// use glam::UVec2;
///
/// let scene = study_scene(1);
/// let optics = Viewport::symmetric(UVec2::new(32, 18), 0.43)?;
/// let plan = SamplePlan::full(Eye::Cyclopean, optics.size);
/// let mut sequence = Sequence::new(TemporalOptions::default());
/// for index in 0..3 {
///     let eye = study_camera(index as f64 / 5_377.0, 1);
///     let view = View::still(Eye::Cyclopean, optics, eye);
///     let frame = sequence.draw(&scene, &view, &plan, index, &RenderOptions::default())?;
///     assert_eq!(frame.work.samples_reprojected > 0, index > 0);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Sequence {
    options: TemporalOptions,
    previous: Option<Previous>,
    memory: FrameMemory,
}

/// What is left of the frame before.
#[derive(Debug)]
struct Previous {
    method: String,
    display_px: UVec2,
    placed: Arc<Placed>,
    /// The last image of each pass.
    passes: Vec<History>,
}

impl Sequence {
    /// An empty sequence.
    pub fn new(options: TemporalOptions) -> Self {
        Self {
            options,
            previous: None,
            memory: FrameMemory::default(),
        }
    }

    /// Forgets everything: the next frame is the first of its kind.
    pub fn cut(&mut self) {
        self.previous = None;
    }

    /// Draws the next frame. Its `frame` number decides where in their cells samples are taken and
    /// which passes are due; numbers that grow by one from call to call give every pass its cadence.
    ///
    /// A pass that is not due is shown as it was drawn last: where it lay on the display then, whatever
    /// view and gaze are now (Guenter 2012, §4.1). It is blended by the present gaze; where that has left
    /// the pass's old place, the pass's edge is seen until it is due.
    ///
    /// The [passes](Frame::passes) of the frame, if they are kept, are those that are shown, blended
    /// with their history.
    ///
    /// # Errors
    /// As [`render`](crate::render), and if an option of the sequence cannot be used. The sequence is
    /// then as it was before.
    pub fn draw(
        &mut self,
        scene: &Scene,
        view: &View,
        plan: &SamplePlan,
        frame: u64,
        options: &RenderOptions,
    ) -> Result<Frame, RenderError> {
        let nothing = Image::filled(UVec2::ZERO, [0.0; 3]);
        self.draw_into(scene, view, plan, frame, options, nothing)
    }

    /// As [`draw`](Self::draw), with the memory of `spare`, an image that is no longer needed, of whatever size and
    /// content. A sequence keeps the [memory](FrameMemory) of its frames but for their images: who gives each back
    /// when it was shown lets frames be drawn without any new one.
    ///
    /// # Errors
    /// As [`draw`](Self::draw).
    pub fn draw_into(
        &mut self,
        scene: &Scene,
        view: &View,
        plan: &SamplePlan,
        frame: u64,
        options: &RenderOptions,
        spare: Image,
    ) -> Result<Frame, RenderError> {
        self.options.check()?;
        let mut plan = plan.clone();
        if self.options.jitter {
            for pass in &mut plan.passes {
                pass.offset = jitter(self.draws_before(pass, frame));
            }
        }
        check(scene, view, &plan, options)?;
        self.check_maps(&plan)?;
        if self.options.reproject && Warp::of(scene, view, options).is_some() {
            return Err(RenderError::Still {
                what: "a history of samples",
                of: "rolling views, through a lens or with a bound asked for",
                valid: "frames can be drawn one by one, or jittered",
            });
        }
        let placed = Arc::new(Placed::of(scene));
        let previous = self.previous.take();
        let mut histories = match previous.filter(|p| p.leads_to(&plan, &placed)) {
            Some(previous) => previous.passes.into_iter().map(Some).collect(),
            None => plan.passes.iter().map(|_| None).collect::<Vec<_>>(),
        };
        let waits: Vec<bool> = plan
            .passes
            .iter()
            .zip(&histories)
            .map(|(pass, h)| h.is_some() && self.options.staggered && !pass.cadence.is_due(frame))
            .collect();
        let due: Vec<bool> = waits.iter().map(|waits| !waits).collect();
        let mut options = *options;
        // What inner layers hide now may show while this pass waits, if the gaze moves.
        options.skip.hidden &= !self.options.staggered;
        if self.options.jitter && self.options.reproject {
            options.footprint *= self.options.footprint;
        }
        self.memory.give(spare);
        let drawn = draw_passes(
            scene,
            view,
            &plan,
            &due,
            &options,
            self.options.reproject,
            &mut self.memory,
        );
        let mut pass_work = Vec::new();
        for ((pass, history), new) in plan.passes.iter().zip(&mut histories).zip(drawn.passes) {
            let work = match new {
                None => Work {
                    passes_not_due: 1,
                    ..Work::default()
                },
                Some((samples, mut work)) => {
                    let before = history.take();
                    let (kept, blending) =
                        self.blend(samples, view, pass, &placed, before, &options);
                    *history = Some(kept);
                    work += blending;
                    work
                }
            };
            pass_work.push(work);
        }
        let shown: Vec<History> = histories.into_iter().flatten().collect();
        let mut frame = self.put_together(view, plan, placed, shown, pass_work, &options);
        frame.work += drawn.shared;
        Ok(frame)
    }

    /// Where a surface was in a pass before is known of samples that lie evenly.
    fn check_maps(&self, plan: &SamplePlan) -> Result<(), RenderError> {
        let bent = |p: &Pass| !matches!(p.map, Map::Affine(_));
        match plan.passes.iter().position(bent) {
            Some(pass) if self.options.reproject => Err(RenderError::Pass {
                method: plan.method.clone(),
                pass,
                why: "its samples do not lie evenly: it cannot be reprojected, but drawn frame by frame or jittered".into(),
            }),
            _ => Ok(()),
        }
    }

    /// How often a pass was due before `frame`.
    fn draws_before(&self, pass: &Pass, frame: u64) -> u64 {
        if self.options.staggered {
            frame / u64::from(pass.cadence.every.get())
        } else {
            frame
        }
    }

    /// Blends new samples of a pass with its history, if the sequence does so.
    fn blend(
        &mut self,
        samples: PassSamples,
        view: &View,
        pass: &Pass,
        placed: &Arc<Placed>,
        before: Option<History>,
        options: &RenderOptions,
    ) -> (History, Work) {
        let middle = Pass {
            offset: DVec2::ZERO,
            ..pass.clone()
        };
        let now = (middle, *view, Arc::clone(placed));
        if self.options.reproject {
            return reproject(
                samples,
                pass.offset,
                now,
                before,
                &self.options,
                options.simd,
                &mut self.memory,
            );
        }
        if let Some(before) = before {
            self.memory.give(before.image);
        }
        let PassSamples { image, .. } = samples;
        let (pass, view, placed) = now;
        let history = History {
            pass,
            view,
            placed,
            image,
            past: Past::default(),
        };
        (history, Work::default())
    }

    /// Makes the image of the passes as they were drawn last, and keeps them for the next frame.
    fn put_together(
        &mut self,
        view: &View,
        mut plan: SamplePlan,
        placed: Arc<Placed>,
        mut shown: Vec<History>,
        pass_work: Vec<Work>,
        options: &RenderOptions,
    ) -> Frame {
        plan.passes = shown.iter().map(|h| h.pass.clone()).collect();
        let images = shown
            .iter_mut()
            .map(|h| std::mem::replace(&mut h.image, Image::filled(UVec2::ZERO, [0.0; 3])));
        let keeps = self.options.reproject || self.options.staggered;
        let keep = RenderOptions {
            keep_passes: options.keep_passes || keeps,
            ..*options
        };
        let (image, mut images, mut work) =
            resolve::resolve(view, &plan, images.collect(), &keep, &mut self.memory);
        for pass in &pass_work {
            work += *pass;
        }
        let passes = match (options.keep_passes, keeps) {
            (true, true) => images.clone(),
            (true, false) => std::mem::take(&mut images),
            _ => Vec::new(),
        };
        if keeps {
            for (history, image) in shown.iter_mut().zip(images) {
                history.image = image;
            }
            self.previous = Some(Previous {
                method: plan.method,
                display_px: plan.display_px,
                placed,
                passes: shown,
            });
        }
        Frame {
            image,
            work,
            pass_work,
            passes,
        }
    }
}

impl Previous {
    /// Whether a frame can follow.
    fn leads_to(&self, plan: &SamplePlan, placed: &Placed) -> bool {
        let eyes = plan.passes.iter().map(|p| p.eye);
        self.method == plan.method
            && self.display_px == plan.display_px
            && self.passes.iter().map(|h| h.pass.eye).eq(eyes)
            && self.placed.is_same_scene(placed)
    }
}
