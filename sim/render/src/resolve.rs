use foveasim_models::{Feather, Image, Resolve, SamplePlan, View, Work};
use rayon::prelude::*;

use crate::feather::{Layer, ResolveRow, RowScratch};
use crate::kernels::dispatch;
use crate::mosaic::mosaic;
use crate::{RenderOptions, Simd};

/// Puts the passes together to the displayed image; also gives back the passes, if they are to be
/// kept.
pub(crate) fn resolve(
    view: &View,
    plan: &SamplePlan,
    mut passes: Vec<Image>,
    options: &RenderOptions,
) -> (Image, Vec<Image>, Work) {
    match &plan.resolve {
        Resolve::Feather(feather) => {
            let (image, work) = blend(view, plan, feather, &passes, options.simd);
            if !options.keep_passes {
                passes.clear();
            }
            (image, passes, work)
        }
        Resolve::Mosaic => {
            let (image, work) = mosaic(plan, &passes);
            if !options.keep_passes {
                passes.clear();
            }
            (image, passes, work)
        }
        // The one pass is the image; nothing is interpolated.
        _ => {
            let image = passes.remove(0);
            if options.keep_passes {
                passes.push(image.clone());
            }
            let work = Work {
                pixels_resolved: plan.count().display_pixels,
                ..Work::default()
            };
            (image, passes, work)
        }
    }
}

/// Interpolates the passes and blends them by eccentricity.
fn blend(
    view: &View,
    plan: &SamplePlan,
    feather: &Feather,
    passes: &[Image],
    simd: Simd,
) -> (Image, Work) {
    let size = plan.display_px;
    let layers: Vec<Layer<'_>> = plan
        .passes
        .iter()
        .zip(passes)
        .map(|(p, image)| Layer::new(p.lattice, p.map, image, size.x))
        .collect();
    let mut image = Image::filled(size, [0.0; 3]);
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
        let (image, kept, _) = resolve(&view, &plan, vec![pass], &RenderOptions::default());
        assert_eq!(image.rgb.as_ptr(), memory);
        assert!(kept.is_empty());
    }
}
