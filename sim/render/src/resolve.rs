use foveasim_models::{Feather, Image, Resolve, SamplePlan, View, Work};
use rayon::prelude::*;

use crate::chromatic::separate;
use crate::feather::{Layer, ResolveRow, RowScratch};
use crate::inverse::invert;
use crate::kernels::dispatch;
use crate::mosaic::mosaic;
use crate::{FrameMemory, RenderOptions, Simd};

/// Puts the passes together to the displayed image, with the colours of a lens apart; also gives back the passes, if they are
/// to be kept.
pub(crate) fn resolve(
    view: &View,
    plan: &SamplePlan,
    passes: Vec<Image>,
    options: &RenderOptions,
    memory: &mut FrameMemory,
) -> (Image, Vec<Image>, Work) {
    let (image, mut passes, work) = join(view, plan, passes, options, memory);
    if !options.keep_passes {
        passes.drain(..).for_each(|pass| memory.give(pass));
    }
    let image = match &view.lens {
        Some(lens) => separate(image, lens, memory),
        None => image,
    };
    (image, passes, work)
}

/// The same without a lens.
fn join(
    view: &View,
    plan: &SamplePlan,
    mut passes: Vec<Image>,
    options: &RenderOptions,
    memory: &mut FrameMemory,
) -> (Image, Vec<Image>, Work) {
    let size = plan.display_px;
    // All of it is written.
    let room = |memory: &mut FrameMemory| Image {
        size,
        rgb: memory.rgb.any(size.x as usize * size.y as usize, [0.0; 3]),
    };
    match &plan.resolve {
        Resolve::Feather(feather) => {
            let (image, work) = blend(view, plan, feather, &passes, options.simd, room(memory));
            (image, passes, work)
        }
        Resolve::Mosaic => {
            let (image, work) = mosaic(plan, &passes, room(memory));
            (image, passes, work)
        }
        Resolve::Inverse(filter) => {
            let Some(last) = passes.last() else {
                unreachable!("a plan without passes does not pass the checks")
            };
            let (image, work) = invert(plan, filter, last, options.simd, memory);
            (image, passes, work)
        }
        // The one pass is the image; nothing is interpolated.
        _ => {
            let image = passes.remove(0);
            if options.keep_passes {
                let mut kept = room(memory);
                kept.rgb.copy_from_slice(&image.rgb);
                passes.push(kept);
            }
            let work = Work {
                pixels_resolved: plan.count().display_pixels,
                ..Work::default()
            };
            (image, passes, work)
        }
    }
}

/// Interpolates the passes and blends them by eccentricity, over whatever `image` shows.
fn blend(
    view: &View,
    plan: &SamplePlan,
    feather: &Feather,
    passes: &[Image],
    simd: Simd,
    mut image: Image,
) -> (Image, Work) {
    let size = image.size;
    let layers: Vec<Layer<'_>> = plan
        .passes
        .iter()
        .zip(passes)
        .map(|(p, image)| Layer::new(p.lattice, p.map, image, size.x))
        .collect();
    let works: Vec<Work> = image
        .rgb
        .par_chunks_mut(size.x as usize)
        .enumerate()
        .map_init(RowScratch::default, |scratch, (y, row)| {
            let kernel = ResolveRow {
                view,
                feather,
                layers: &layers,
                y: y as u32,
                row,
                scratch,
            };
            dispatch(simd, kernel)
        })
        .collect();
    let mut work = Work::default();
    for row in works {
        work += row;
    }
    (image, work)
}

#[cfg(test)]
mod tests {
    use foveasim_models::{Eye, Pose, Viewport};
    use glam::UVec2;

    use super::*;

    #[test]
    fn the_only_pass_is_moved_not_copied() {
        let size = UVec2::new(8, 4);
        let optics = Viewport::symmetric(size, 1.0).expect("a viewport");
        let view = View::still(Eye::Cyclopean, optics, Pose::IDENTITY);
        let plan = SamplePlan::full(Eye::Cyclopean, size);
        let pass = Image::filled(size, [0.25; 3]);
        let memory = pass.rgb.as_ptr();
        let (image, kept, _) = resolve(
            &view,
            &plan,
            vec![pass],
            &RenderOptions::default(),
            &mut FrameMemory::default(),
        );
        assert_eq!(image.rgb.as_ptr(), memory);
        assert!(kept.is_empty());
    }
}
