use foveasim_assets::Scene;
use foveasim_models::{Image, Lattice, Pass, SamplePlan, Shading, View, Work};

use crate::check::{check, check_plan};
use crate::passes::draw_passes;
use crate::{FrameMemory, RenderError, RenderOptions, resolve};

/// A drawn frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// The displayed image, linear light.
    pub image: Image,
    /// All work: of the passes, and of putting them together.
    pub work: Work,
    /// The work of each pass, in the plan's order; without vertices, where passes share them.
    pub pass_work: Vec<Work>,
    /// The samples of each pass, in the plan's order; empty unless
    /// [`keep_passes`](RenderOptions::keep_passes) asks for them.
    pub passes: Vec<Image>,
}

/// Draws `plan` of `scene` as seen through `view`. All passes are drawn, whatever their cadence.
///
/// The image depends on nothing else: not on the number of threads (rayon's current pool is used),
/// nor on the instructions the kernels use.
///
/// # Errors
/// If the view moves without a scan, the plan is for another size or eye, or a number in it cannot be used.
pub fn render(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    options: &RenderOptions,
) -> Result<Frame, RenderError> {
    render_into(scene, view, plan, options, &mut FrameMemory::default())
}

/// As [`render`], in the memory of earlier frames: it is the same frame, sooner drawn. Who
/// [gives](FrameMemory::give) the image back when it was shown needs no more for it than the first time.
///
/// # Errors
/// As [`render`].
pub fn render_into(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    options: &RenderOptions,
    memory: &mut FrameMemory,
) -> Result<Frame, RenderError> {
    check(scene, view, plan, options)?;
    let due = vec![true; plan.passes.len()];
    let drawn = draw_passes(scene, view, plan, &due, options, false, memory);
    let (mut passes, mut pass_work) = (Vec::new(), Vec::new());
    for (samples, work) in drawn.passes.into_iter().flatten() {
        passes.push(samples.image);
        pass_work.push(work);
    }
    Ok(put_together(
        view,
        plan,
        passes,
        pass_work,
        drawn.shared,
        options,
        memory,
    ))
}

/// The frame of passes that something else drew, one image for each in the plan's order, as their lattices
/// have it; a pass that shades nothing may be left empty. The frame's work is that of putting them together.
///
/// # Errors
/// As [`render`], and if images are missing or of another size.
pub fn assemble(
    view: &View,
    plan: &SamplePlan,
    passes: Vec<Image>,
    options: &RenderOptions,
) -> Result<Frame, RenderError> {
    check_plan(view, plan, options, !view.is_still() || view.lens.is_some())?;
    let fits = |(pass, image): (&Pass, &Image)| {
        let empty = pass.shading == Shading::Nowhere && image.rgb.is_empty();
        let full = pass.lattice == Lattice::Grid(image.size)
            && image.rgb.len() as u64 == pass.lattice.samples();
        full || empty
    };
    if passes.len() != plan.passes.len() || !plan.passes.iter().zip(&passes).all(fits) {
        let sizes: Vec<String> = passes.iter().map(|p| p.size.to_string()).collect();
        return Err(RenderError::OutOfRange {
            field: "images of passes",
            value: sizes.join(", "),
            valid: format!(
                "one for each pass of {}, as large as its lattice",
                plan.method
            ),
        });
    }
    let works = vec![Work::default(); passes.len()];
    let (shared, memory) = (Work::default(), &mut FrameMemory::default());
    Ok(put_together(
        view, plan, passes, works, shared, options, memory,
    ))
}

/// The frame of passes that were drawn, each with its work; `shared` is work that they share.
pub(crate) fn put_together(
    view: &View,
    plan: &SamplePlan,
    passes: Vec<Image>,
    pass_work: Vec<Work>,
    shared: Work,
    options: &RenderOptions,
    memory: &mut FrameMemory,
) -> Frame {
    let (image, passes, resolve_work) = resolve::resolve(view, plan, passes, options, memory);
    let mut work = resolve_work;
    work += shared;
    for w in &pass_work {
        work += *w;
    }
    Frame {
        image,
        work,
        pass_work,
        passes,
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::{Eye, Pose, Viewport};
    use glam::UVec2;

    use super::*;

    #[test]
    fn passes_that_do_not_fit_are_refused() {
        let size = UVec2::new(8, 4);
        let optics = Viewport::symmetric(size, 1.0).expect("a viewport");
        let view = View::still(Eye::Cyclopean, optics, Pose::IDENTITY);
        let plan = SamplePlan::full(Eye::Cyclopean, size);
        let image = |size| Image::filled(size, [0.5; 3]);
        let put = |passes| assemble(&view, &plan, passes, &RenderOptions::default());
        assert_eq!(put(vec![image(size)]).expect("it fits").image, image(size));
        assert!(put(vec![]).is_err());
        assert!(put(vec![image(size + 1)]).is_err());
        assert!(put(vec![image(size), image(size)]).is_err());
    }
}
