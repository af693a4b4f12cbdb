use std::sync::Arc;

use foveasim_models::{Image, Lattice, Pass, Region, View, Work};
use glam::UVec2;
use rayon::prelude::*;

use super::history::{History, Placed};
use super::motion::Motion;
use super::{Clamp, TemporalOptions};
use crate::Simd;
use crate::kernels::{Extremes, Past, ReprojectRow, Source, dispatch};
use crate::pass::PassSamples;

/// Blends new samples of a pass with its history, if there is one, and gives what is to be kept.
///
/// Where nothing moved, no motion is computed and nothing is tested: what was seen is still there, so
/// each sample is the plain mean of its cell.
pub(super) fn reproject(
    samples: PassSamples,
    now: (Pass, View, Arc<Placed>),
    before: Option<&History>,
    options: &TemporalOptions,
    simd: Simd,
) -> (History, Work) {
    let (pass, view, placed) = now;
    let samples = leave_out_dead(samples, &pass);
    let size = samples.image.size;
    let mut image = Image::filled(size, [0.0; 3]);
    let mut past = vec![Past::default(); image.rgb.len()];
    let motion = before
        .filter(|b| !is_still((&pass, &view, &placed), b))
        .map(|b| Motion::new((&pass, &view, &placed), (&b.pass, &b.view, &b.placed)));
    let source = match (before, &motion) {
        (None, _) => Source::Nowhere,
        (Some(b), None) => Source::InPlace(b.before()),
        (Some(b), Some(motion)) => Source::Moved {
            before: b.before(),
            warps: &motion.warps,
            // Samples that do not say what they see are of a scene at rest.
            warp_of_instance: if samples.instance.is_empty() {
                &[]
            } else {
                &motion.warp_of_instance
            },
            clamp: options.clamp == Clamp::Neighbourhood,
        },
    };
    let width = size.x.max(1) as usize;
    let works: Vec<Work> = image
        .rgb
        .par_chunks_mut(width)
        .zip(past.par_chunks_mut(width))
        .enumerate()
        .map_init(Extremes::default, |scratch, (y, (out, out_past))| {
            let row = ReprojectRow {
                y,
                width,
                rgb: &samples.image.rgb,
                inverse_w: &samples.inverse_w,
                instance: &samples.instance,
                source,
                longest: options.longest(),
                scratch,
                out,
                out_past,
            };
            dispatch(simd, row)
        })
        .collect();
    let mut work = Work::default();
    for row in works {
        work += row;
    }
    let history = History {
        pass,
        view,
        placed,
        image,
        past,
    };
    (history, work)
}

/// Whether each sample sees what it saw before, but for its offset.
fn is_still((pass, view, placed): (&Pass, &View, &Placed), before: &History) -> bool {
    (pass.lattice, pass.map) == (before.pass.lattice, before.pass.map)
        && *view == before.view
        && placed.world_from_object == before.placed.world_from_object
}

/// Marks what is not drawn, so that it counts as no neighbour and no history.
fn leave_out_dead(mut samples: PassSamples, pass: &Pass) -> PassSamples {
    let Lattice::Grid(size) = pass.lattice else {
        unreachable!("only grids pass the checks")
    };
    if let Region::Cells(mask) = &pass.region {
        let places = (0..size.y).flat_map(|y| (0..size.x).map(move |x| UVec2::new(x, y)));
        for (index, _) in places.enumerate().filter(|(_, p)| !mask.is_live(*p)) {
            samples.image.rgb[index] = [f32::NAN; 3];
            samples.inverse_w[index] = f32::NAN;
        }
    }
    samples
}
