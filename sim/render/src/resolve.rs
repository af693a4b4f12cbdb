use foveasim_models::{Feather, Image, Resolve, SamplePlan, View, Work};
use glam::UVec2;
use rayon::prelude::*;

use crate::chromatic::separate_colours;
use crate::feather::{Layer, ResolveRow, RowScratch};
use crate::inverse::invert;
use crate::kernels::dispatch;
use crate::mosaic::mosaic;
use crate::{RenderOptions, Simd};

/// Puts the passes together to the displayed image, with the colours of a lens apart; also gives back the passes, if they are
/// to be kept. The image is made in the memory of `spare`, where that fits.
pub(crate) fn resolve(
    view: &View,
    plan: &SamplePlan,
    passes: Vec<Image>,
    options: &RenderOptions,
    spare: Vec<[f32; 3]>,
) -> (Image, Vec<Image>, Work) {
    let (image, passes, work) = join(view, plan, passes, options, spare);
    let image = match &view.lens {
        Some(lens) => separate_colours(image, lens),
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
    spare: Vec<[f32; 3]>,
) -> (Image, Vec<Image>, Work) {
    match &plan.resolve {
        Resolve::Feather(feather) => {
            let (image, work) = blend(view, plan, feather, &passes, options.simd, spare);
            if !options.keep_passes {
                passes.clear();
            }
            (image, passes, work)
        }
        Resolve::Mosaic => {
            let (image, work) = mosaic(plan, &passes, room(plan.display_px, spare));
            if !options.keep_passes {
                passes.clear();
            }
            (image, passes, work)
        }
        Resolve::Inverse(filter) => {
            let Some(last) = passes.last() else {
                unreachable!("a plan without passes does not pass the checks")
            };
            let (image, work) = invert(plan, filter, last, options.simd);
            if !options.keep_passes {
                passes.clear();
            }
            (image, passes, work)
        }
        // The one pass is the image; nothing is interpolated.
        _ => {
            let image = passes.remove(0);
            if options.keep_passes {
                let mut kept = room(image.size, spare);
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

/// An image of whatever content, in the memory of another where that fits.
fn room(size: UVec2, mut spare: Vec<[f32; 3]>) -> Image {
    let pixels = size.x as usize * size.y as usize;
    if spare.capacity() < pixels {
        return Image::filled(size, [0.0; 3]);
    }
    spare.resize(pixels, [0.0; 3]);
    Image { size, rgb: spare }
}

/// Interpolates the passes and blends them by eccentricity.
fn blend(
    view: &View,
    plan: &SamplePlan,
    feather: &Feather,
    passes: &[Image],
    simd: Simd,
    spare: Vec<[f32; 3]>,
) -> (Image, Work) {
    let size = plan.display_px;
    let layers: Vec<Layer<'_>> = plan
        .passes
        .iter()
        .zip(passes)
        .map(|(p, image)| Layer::new(p.lattice, p.map, image, size.x))
        .collect();
    let mut image = room(size, spare);
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
            Vec::new(),
        );
        assert_eq!(image.rgb.as_ptr(), memory);
        assert!(kept.is_empty());
    }
}
