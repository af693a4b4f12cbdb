use foveasim_models::{Filter, Image, Interpolation, LogPolar, Map, SamplePlan, Work};
use glam::{DVec2, UVec2};
use rayon::prelude::*;

use crate::Simd;
use crate::kernels::{FetchRow, LocateRow, PolarInverse, dispatch};
use crate::live::grid;
use crate::texels::{Stretch, Texels};

/// Looks each pixel up in the last pass, by the inverse of that pass's map: see
/// [`Resolve::Inverse`](foveasim_models::Resolve::Inverse).
pub(crate) fn invert(
    plan: &SamplePlan,
    filter: &Filter,
    image: &Image,
    simd: Simd,
) -> (Image, Work) {
    let Some(pass) = plan.passes.last() else {
        unreachable!("a plan without passes does not pass the checks")
    };
    let mut texels = Texels::new(image, &pass.region, pass.map.wraps());
    if let Some(first) = filter.smooth_from {
        texels = texels.smoothed(first);
    }
    let inverse = match &pass.map {
        Map::LogPolar(map) => Some(PolarInverse::new(map)),
        _ => None,
    };
    let finer = match &pass.map {
        Map::LogPolar(map) if filter.mips => Finer::new(map, grid(pass)),
        _ => None,
    };
    let size = plan.display_px;
    let mut out = Image::filled(size, [0.0; 3]);
    let works: Vec<Work> = out
        .rgb
        .par_chunks_mut(size.x as usize)
        .enumerate()
        .map_init(Vec::<f32>::new, |scratch, (y, row)| {
            let y = y as u32;
            let length = row.len().next_multiple_of(16);
            scratch.resize(2 * length, 0.0);
            let (xs, ys) = scratch.split_at_mut(length);
            match &inverse {
                Some(inverse) => {
                    let kernel = LocateRow {
                        inverse,
                        y,
                        x_out: xs,
                        y_out: ys,
                    };
                    dispatch(simd, kernel);
                }
                None => {
                    for (x, (x_out, y_out)) in xs.iter_mut().zip(ys.iter_mut()).enumerate() {
                        let px = DVec2::new(x as f64 + 0.5, f64::from(y) + 0.5);
                        let at = pass.map.lattice_from_display(px);
                        (*x_out, *y_out) = (at.x as f32, at.y as f32);
                    }
                }
            }
            let nearest = filter.interpolation == Interpolation::Nearest;
            let kernel = FetchRow {
                texels: &texels,
                nearest,
                xs,
                ys,
                row,
            };
            let mut fetches = dispatch(simd, kernel);
            if let Some(finer) = &finer {
                fetches += finer.average(&texels, y, row, if nearest { 1 } else { 4 });
            }
            Work {
                pixels_resolved: row.len() as u64,
                resolve_fetches: fetches,
                ..Work::default()
            }
        })
        .collect();
    let mut work = Work::default();
    for row in works {
        work += row;
    }
    (out, work)
}

/// Where several samples of a log-polar lattice fall into a pixel.
struct Finer<'a> {
    map: &'a LogPolar,
    grid: UVec2,
    /// Out to where \[px\].
    reach: f64,
}

impl<'a> Finer<'a> {
    /// `None` if they nowhere do.
    fn new(map: &'a LogPolar, grid: UVec2) -> Option<Self> {
        // Half a pixel: two samples to one, along either axis.
        let is_finer = |x: &u32| {
            let steps = map.step_lengths(f64::from(*x) + 0.5);
            steps.iter().any(|step| *step <= 0.5)
        };
        let last = (0..grid.x).rev().find(is_finer)?;
        Some(Self {
            map,
            grid,
            reach: map.radius(f64::from(last) + 1.0),
        })
    }

    /// Makes those pixels of a row the mean of the samples in them, for which `read` samples each were read
    /// before; how many more are read than without.
    ///
    /// A pixel reaches half a pixel to either side along the radius and across it. What a mip chain would
    /// approximate is exact here, and costs no more than each sample about once.
    fn average(&self, texels: &Texels, y: u32, row: &mut [[f32; 3]], read: u64) -> u64 {
        let gaze = self.map.gaze_px();
        let dy = f64::from(y) + 0.5 - gaze.y;
        if dy.abs() > self.reach {
            return 0;
        }
        let first = (gaze.x - self.reach).floor().max(0.0) as usize;
        let end = ((gaze.x + self.reach).ceil().max(0.0) as usize).min(row.len());
        let mut fetches = 0;
        for (x, out) in row.iter_mut().enumerate().take(end).skip(first) {
            let away = DVec2::new(x as f64 + 0.5 - gaze.x, dy);
            let radius = away.length();
            if radius > self.reach {
                continue;
            }
            let at = DVec2::new(self.map.x_at(radius), self.map.y_at(away));
            let low = self.map.x_at(radius - 0.5).round() as u32;
            let high = self.map.x_at(radius + 0.5).round() as u32;
            let around = std::f64::consts::TAU * radius.max(0.5) / self.map.samples().y;
            let rows = ((1.0 / around).round() as u32).clamp(1, self.grid.y);
            if high <= low + 1 && rows == 1 {
                continue;
            }
            let own = [at.x, at.y].map(|c| c as u32);
            let own = [own[0].min(self.grid.x - 1), own[1].min(self.grid.y - 1)];
            // Along an axis with but one sample to the pixel, between the two beside it.
            let across = match high.min(self.grid.x).saturating_sub(low) {
                0 | 1 => Stretch::beside(at.x),
                count => Stretch::Run(low.into(), count),
            };
            let down = match rows {
                1 => Stretch::beside(at.y),
                // The rows whose middles are nearest to the pixel's.
                count => Stretch::Run((at.y - 0.5 * f64::from(rows)).round() as i64, count),
            };
            // In place of those that were read there: never more than four.
            fetches += across.count() * down.count() - read;
            *out = texels.mean(own, across, down);
        }
        fetches
    }
}
