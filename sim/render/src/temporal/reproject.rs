use std::sync::Arc;

use foveasim_models::{Image, Pass, View, Work};
use glam::DVec2;
use rayon::prelude::*;

use super::history::{History, Past, Placed};
use super::motion::Motion;
use super::{Clamp, Interpolation, TemporalOptions};
use crate::kernels::{Centre, ReprojectRow, ReprojectScratch, Source, dispatch};
use crate::pass::PassSamples;
use crate::{FrameMemory, Simd};

/// Blends new samples of a pass with its history, if there is one, and gives what is to be kept. The
/// samples were taken `offset` beside the middles of their cells.
///
/// Where nothing moved, no motion is computed and nothing is tested: what was seen is still there, so
/// each sample is the plain mean of its cell.
pub(super) fn reproject(
    samples: PassSamples,
    offset: DVec2,
    now: (Pass, View, Arc<Placed>),
    before: Option<History>,
    options: &TemporalOptions,
    simd: Simd,
    memory: &mut FrameMemory,
) -> (History, Work) {
    let (pass, view, placed) = now;
    let samples = leave_out_dead(samples);
    let all_drawn = samples.all_drawn;
    let size = samples.image.size;
    let count = samples.image.rgb.len();
    let mut image = Image {
        size,
        rgb: memory.rgb.any(count, [0.0; 3]),
    };
    let mut past = Past {
        length: memory.reals.any(count, 0.0),
        nearest: memory.reals.any(count, 0.0),
        all_drawn,
    };
    let motion = before
        .as_ref()
        .filter(|b| !is_still((&pass, &view, &placed), b))
        .map(|b| Motion::new((&pass, &view, &placed), (&b.pass, &b.view, &b.placed)));
    let source = match (&before, &motion) {
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
            cubic: options.interpolation == Interpolation::CatmullRom,
            centre: match options.interpolation {
                Interpolation::CatmullRom => Centre::of(offset),
                Interpolation::Bilinear => None,
            },
        },
    };
    let longest = options.longest(matches!(source, Source::InPlace(_)));
    let width = size.x.max(1) as usize;
    let works: Vec<Work> = image
        .rgb
        .par_chunks_mut(width)
        .zip(past.length.par_chunks_mut(width))
        .zip(past.nearest.par_chunks_mut(width))
        .enumerate()
        .map_init(ReprojectScratch::default, |scratch, (y, row)| {
            let ((out, out_length), out_nearest) = row;
            let row = ReprojectRow {
                y,
                width,
                rgb: &samples.image.rgb,
                inverse_w: &samples.inverse_w,
                instance: &samples.instance,
                source,
                longest,
                scratch,
                out,
                out_length,
                out_nearest,
            };
            dispatch(simd, row)
        })
        .collect();
    let mut work = Work::default();
    for row in works {
        work += row;
    }
    // For the next frame: fresh memory would cost as much as the blending.
    if let Some(before) = before {
        memory.give(before.image);
        memory.reals.give(before.past.length);
        memory.reals.give(before.past.nearest);
    }
    memory.give(samples.image);
    memory.reals.give(samples.inverse_w);
    memory.names.give(samples.instance);
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
fn leave_out_dead(mut samples: PassSamples) -> PassSamples {
    if !samples.all_drawn {
        let colours = samples.image.rgb.par_iter_mut().with_min_len(1 << 14);
        colours
            .zip(&samples.inverse_w)
            .for_each(|(rgb, inverse_w)| {
                if inverse_w.is_nan() {
                    *rgb = [f32::NAN; 3];
                }
            });
    }
    samples
}

#[cfg(test)]
mod tests {
    use foveasim_assets::{Mesh, Scene, Sky, Sun, Vertex};
    use foveasim_models::{CellMask, Eye, Pose, Region, SamplePlan, Viewport};
    use glam::{DVec3, UVec2};

    use super::*;

    fn placed() -> Arc<Placed> {
        let corner = |x: f64| Vertex {
            position: DVec3::new(x, x * x, 0.0),
            normal: DVec3::Z,
            uv: [0.0; 2],
        };
        let mesh = Mesh::new(&[0.0, 1.0, 2.0].map(corner), vec![[0, 1, 2]]).expect("a mesh");
        let sun = Sun {
            direction: DVec3::Y,
            radiance: [1.0; 3],
        };
        let sky = Sky::Uniform([0.0; 3]);
        let scene = Scene::new(vec![mesh], vec![], vec![], sky, sun).expect("a scene");
        Arc::new(Placed::of(&scene))
    }

    fn samples(size: UVec2, colour: impl Fn(u32, u32) -> f32) -> PassSamples {
        let mut image = Image::filled(size, [0.0; 3]);
        for (index, rgb) in image.rgb.iter_mut().enumerate() {
            let index = index as u32;
            *rgb = [colour(index % size.x, index / size.x); 3];
        }
        PassSamples {
            inverse_w: vec![0.5; image.rgb.len()],
            instance: vec![0; image.rgb.len()],
            image,
            all_drawn: true,
        }
    }

    #[test]
    fn what_is_not_drawn_is_no_neighbour_and_no_history() {
        let size = UVec2::new(30, 20);
        let optics = Viewport::symmetric(size, 1.0).expect("a viewport");
        let plan = SamplePlan::full(Eye::Cyclopean, size);
        let placed = placed();
        let at = |x: f64| {
            let eye = Pose::new(DVec3::new(x, 0.0, 0.0), Pose::IDENTITY.orientation);
            View::still(Eye::Cyclopean, optics, eye)
        };
        let pass = |first_live: u32| {
            let mask = CellMask::new(size, UVec2::new(5, 20), |c| c.x >= first_live);
            let mut pass = plan.passes[0].clone();
            pass.region = Region::Cells(mask);
            pass
        };
        let options = TemporalOptions::default();
        // What is not drawn holds rubbish, which must show nowhere.
        let live = |first: u32, value: f32| {
            let mut samples = samples(size, move |x, _| if x >= first { value } else { 99.0 });
            samples.all_drawn = first == 0;
            for (index, inverse_w) in samples.inverse_w.iter_mut().enumerate() {
                if (index as u32 % size.x) < first {
                    *inverse_w = f32::NAN;
                }
            }
            samples
        };
        let draw = |value, first: u32, view, before: Option<History>| {
            let now = (pass(first / 5), view, Arc::clone(&placed));
            reproject(
                live(first, value),
                DVec2::ZERO,
                now,
                before,
                &options,
                Simd::Auto,
                &mut FrameMemory::default(),
            )
        };
        let (first, work) = draw(1.0, 10, at(0.0), None);
        assert_eq!(work, Work::default());
        // The eye steps right by two samples at w = 2: 2 · 2/15 tangents per sample.
        let step = 2.0 * 2.0 * optics.pixel_tan().x;
        let (second, work) = draw(1.0, 5, at(step), Some(first));
        let count = |x: std::ops::Range<u32>| u64::from(20 * (x.end - x.start));
        assert_eq!(work.samples_reprojected, count(5..30));
        // Samples 5 to 7 look for 7 to 9, which had not been drawn; the last two leave the lattice.
        assert_eq!(work.history_rejected, count(5..8) + count(28..30));
        assert_eq!(work.history_clamped, 0);
        for y in 0..20 {
            for x in 0..30 {
                let length = second.past.length[(30 * y + x) as usize];
                let colour = second.image.at(x, y)[0];
                let expected = match x {
                    0..5 => (0.0, 0.0),
                    5..8 | 28.. => (1.0, 1.0),
                    _ => (1.0, 2.0),
                };
                assert_eq!((colour, length), expected, "({x}, {y})");
            }
        }
        // In place, too: where there is no history the new colour stands alone.
        let (third, work) = draw(3.0, 0, at(step), Some(second.clone()));
        assert_eq!(work.samples_in_place, count(5..30));
        assert_eq!(
            (third.image.at(0, 3)[0], third.image.at(6, 3)[0]),
            (3.0, 2.0)
        );
    }
}
