use foveasim_models::{Filter, Image, Interpolation, LogPolar, Map, SamplePlan, Work};
use glam::{DVec2, UVec2};
use rayon::prelude::*;

use crate::gather::Gather;
use crate::kernels::{
    FetchMips, FetchRow, LocateRadialRow, LocateRow, PolarInverse, RadialInverse, WIDTH, dispatch,
};
use crate::live::grid;
use crate::texels::{Stretch, Texels};
use crate::{FrameMemory, Simd};

/// Looks each pixel up in the last pass, by the inverse of that pass's map: see
/// [`Resolve::Inverse`](foveasim_models::Resolve::Inverse).
pub(crate) fn invert(
    plan: &SamplePlan,
    filter: &Filter,
    image: &Image,
    simd: Simd,
    memory: &mut FrameMemory,
) -> (Image, Work) {
    let Some(pass) = plan.passes.last() else {
        unreachable!("a plan without passes does not pass the checks")
    };
    let rgba = &mut memory.rgba;
    let mut texels = Texels::new(image, &pass.region, pass.map.wraps(), rgba);
    if let Some(first) = filter.smooth_from {
        let smoothed = texels.smoothed(first, rgba);
        rgba.give(std::mem::replace(&mut texels, smoothed).rgba);
    }
    let size = plan.display_px;
    let out = Image {
        size,
        rgb: memory.rgb.any(size.x as usize * size.y as usize, [0.0; 3]),
    };
    if filter.interpolation == Interpolation::Gather {
        let gather = Gather::new(&pass.map, &texels);
        let found = by_rows(out, |(): &mut (), y, row| gather.row(y, row));
        memory.rgba.give(texels.rgba);
        return found;
    }
    let inverse = Inverse::new(&pass.map, size);
    let finer = match &pass.map {
        Map::LogPolar(map) if filter.mips => Finer::new(map, grid(pass)),
        _ => None,
    };
    let most = match finer {
        None if filter.mips => inverse.densest(),
        _ => 1.0,
    };
    let levels = texels.chain(most, &mut memory.rgba);
    let found = by_rows(out, |scratch: &mut Scratch, y, row| {
        let places = inverse.row(simd, y, row.len(), scratch);
        let read = match filter.interpolation {
            Interpolation::Nearest => 1,
            Interpolation::Cubic => 16,
            _ => 4,
        };
        let [xs, ys, density] = places;
        let mut fetches = if levels.len() > 1 || filter.interpolation == Interpolation::Cubic {
            let kernel = FetchMips {
                levels: &levels,
                interpolation: filter.interpolation,
                xs,
                ys,
                density,
                row,
            };
            dispatch(simd, kernel)
        } else {
            let kernel = FetchRow {
                texels: &levels[0],
                nearest: filter.interpolation == Interpolation::Nearest,
                xs,
                ys,
                row,
            };
            dispatch(simd, kernel)
        };
        if let Some(finer) = &finer {
            fetches = fetches.saturating_add_signed(finer.average(&levels[0], y, row, read));
        }
        Work {
            pixels_resolved: row.len() as u64,
            resolve_fetches: fetches,
            ..Work::default()
        }
    });
    for level in levels {
        memory.rgba.give(level.rgba);
    }
    found
}

/// Writes over all rows of an image by what `fill` makes of each number.
fn by_rows<T: Default>(
    mut out: Image,
    fill: impl Fn(&mut T, u32, &mut [[f32; 3]]) -> Work + Sync,
) -> (Image, Work) {
    let width = out.size.x as usize;
    let works: Vec<Work> = out
        .rgb
        .par_chunks_mut(width)
        .enumerate()
        .map_init(T::default, |scratch, (y, row)| fill(scratch, y as u32, row))
        .collect();
    let mut work = Work::default();
    for row in works {
        work += row;
    }
    (out, work)
}

/// Memory of a thread: x, y and density of a row's pixels in the lattice.
type Scratch = [Vec<f32>; 3];

/// How pixels are looked up.
enum Inverse<'a> {
    Polar(PolarInverse),
    Radial(RadialInverse),
    /// One by one in double precision.
    Exact(&'a Map),
}

impl<'a> Inverse<'a> {
    fn new(map: &'a Map, display: UVec2) -> Self {
        match map {
            Map::LogPolar(map) => Self::Polar(PolarInverse::new(map)),
            Map::Radial(radial) => match RadialInverse::new(radial, display) {
                Some(inverse) => Self::Radial(inverse),
                None => Self::Exact(map),
            },
            _ => Self::Exact(map),
        }
    }

    /// More samples than so many are in no pixel's length; 1 where that is answered otherwise.
    fn densest(&self) -> f32 {
        match self {
            // Beyond that, a pixel about the gaze is one texel.
            Self::Radial(_) => 1024.0,
            Self::Exact(Map::Radial(_)) => 1024.0,
            Self::Exact(map @ Map::Affine(_)) => density(map, DVec2::ZERO),
            Self::Exact(Map::LensMatched(map)) => map.scale() as f32,
            Self::Polar(_) | Self::Exact(_) => 1.0,
        }
    }

    /// Places and density of the pixels of a row.
    fn row<'s>(
        &self,
        simd: Simd,
        y: u32,
        width: usize,
        scratch: &'s mut Scratch,
    ) -> [&'s [f32]; 3] {
        let length = width.next_multiple_of(WIDTH);
        for room in scratch.iter_mut() {
            room.resize(length, 0.0);
        }
        let [xs, ys, densities] = scratch;
        match self {
            Self::Polar(inverse) => {
                let kernel = LocateRow {
                    inverse,
                    y,
                    x_out: xs,
                    y_out: ys,
                };
                dispatch(simd, kernel);
            }
            Self::Radial(inverse) => {
                let kernel = LocateRadialRow {
                    inverse,
                    y,
                    x_out: xs,
                    y_out: ys,
                    density: densities,
                };
                dispatch(simd, kernel);
            }
            Self::Exact(map) => {
                let places = xs.iter_mut().zip(ys.iter_mut()).zip(densities.iter_mut());
                for (x, ((x_out, y_out), dense)) in places.enumerate() {
                    let px = DVec2::new(x as f64 + 0.5, f64::from(y) + 0.5);
                    let at = map.lattice_from_display(px);
                    (*x_out, *y_out) = (at.x as f32, at.y as f32);
                    *dense = match map {
                        Map::LogPolar(_) => 1.0,
                        _ => density(map, at),
                    };
                }
            }
        }
        [xs, ys, densities]
    }
}

/// Samples in a pixel's length, along the axis of the lattice that has more.
fn density(map: &Map, at: DVec2) -> f32 {
    let steps = map.steps(at);
    let shortest = steps.x_axis.length().min(steps.y_axis.length());
    (1.0 / shortest) as f32
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
    fn average(&self, texels: &Texels, y: u32, row: &mut [[f32; 3]], read: i64) -> i64 {
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
            // In place of those that were read there.
            fetches += (across.count() * down.count()) as i64 - read;
            *out = texels.mean(own, across, down);
        }
        fetches
    }
}
