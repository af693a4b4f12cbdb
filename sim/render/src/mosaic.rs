use std::ops::Range;

use foveasim_models::{Affine, CellMask, Image, Map, Pass, Region, SamplePlan, Work};
use glam::UVec2;
use rayon::prelude::*;

use crate::live::grid;

/// Puts together passes that each have their own part of the display: see
/// [`Resolve::Mosaic`](foveasim_models::Resolve::Mosaic).
/// The image is made in `image`, of whatever content.
pub(crate) fn mosaic(plan: &SamplePlan, passes: &[Image], mut image: Image) -> (Image, Work) {
    let size = plan.display_px;
    let parts: Vec<Part<'_>> = plan
        .passes
        .iter()
        .zip(passes)
        .map(|(pass, image)| Part::new(pass, image, size.x))
        .collect();
    let fetches: u64 = image
        .rgb
        .par_chunks_mut(size.x as usize)
        .enumerate()
        .map(|(y, row)| {
            // From the last pass to the first, which is to be seen where it is live.
            let parts = parts.iter().rev();
            parts.map(|part| part.fill(y as u32, row)).sum::<u64>()
        })
        .sum();
    let work = Work {
        pixels_resolved: u64::from(size.x) * u64::from(size.y),
        resolve_fetches: fetches,
        ..Work::default()
    };
    (image, work)
}

/// The first pixel that no pass is live at, if there is one.
pub(crate) fn uncovered(plan: &SamplePlan) -> Option<UVec2> {
    let size = plan.display_px;
    let nothing = Image::filled(UVec2::ZERO, [0.0; 3]);
    let part = |pass| Part::new(pass, &nothing, size.x);
    let parts: Vec<Part<'_>> = plan.passes.iter().map(part).collect();
    let mut had = vec![false; size.x as usize];
    let mut asked = None;
    for y in 0..size.y {
        // Rows that meet the same cells of every pass are alike.
        let row = |p: &Part<'_>| {
            let owner = p.beside(1, y)?.owner;
            Some(p.live.map_or(0, |mask| owner / mask.cell().y))
        };
        let rows: Vec<Option<u32>> = parts.iter().map(row).collect();
        if asked.as_ref() == Some(&rows) {
            continue;
        }
        asked = Some(rows);
        had.fill(false);
        for part in &parts {
            let Some(v) = part.beside(1, y) else { continue };
            let pixels = had.iter_mut().skip(part.first_px as usize);
            for (had, h) in pixels.zip(&part.columns) {
                *had |= part.is_live(h.owner, v.owner);
            }
        }
        if let Some(x) = had.iter().position(|had| !had) {
            return Some(UVec2::new(x as u32, y));
        }
    }
    None
}

/// The samples about a pixel along one axis.
#[derive(Debug, Clone, Copy)]
struct Beside {
    /// The sample whose cell holds the pixel's centre.
    owner: u32,
    /// The nearest two sample centres, and the share of the second.
    low: u32,
    high: u32,
    share: f32,
}

/// A pass as the display sees it.
struct Part<'a> {
    size: UVec2,
    map: Affine,
    live: Option<&'a CellMask>,
    image: &'a Image,
    /// The first pixel of a row that the lattice reaches.
    first_px: u32,
    /// Whether each sample is a pixel along x.
    has_pixels: bool,
    /// For it and those after it that the lattice reaches.
    columns: Vec<Beside>,
}

impl<'a> Part<'a> {
    fn new(pass: &'a Pass, image: &'a Image, width: u32) -> Self {
        let Map::Affine(map) = pass.map else {
            unreachable!("only affine maps pass the checks")
        };
        let live = match &pass.region {
            Region::Cells(mask) => Some(mask),
            _ => None,
        };
        let mut part = Self {
            size: grid(pass),
            map,
            live,
            image,
            first_px: 0,
            has_pixels: false,
            columns: Vec::new(),
        };
        let first = (0..width).find(|&x| part.beside(0, x).is_some());
        part.first_px = first.unwrap_or(width);
        let reached = (part.first_px..width).map_while(|x| part.beside(0, x));
        part.columns = reached.collect();
        part.has_pixels = map.scale.x == 1.0 && part.columns.iter().all(|h| h.share == 0.0);
        part
    }

    /// The samples about pixel `p` along `axis`; `None` where the lattice does not reach.
    fn beside(&self, axis: usize, p: u32) -> Option<Beside> {
        let at = (f64::from(p) + 0.5 - self.map.origin[axis]) / self.map.scale[axis];
        let size = f64::from(self.size[axis]);
        if !(0.0..size).contains(&at) {
            return None;
        }
        let between = (at - 0.5).clamp(0.0, size - 1.0);
        let low = between as u32;
        Some(Beside {
            owner: at as u32,
            low,
            high: (low + 1).min(self.size[axis] - 1),
            share: (between - f64::from(low)) as f32,
        })
    }

    fn is_live(&self, x: u32, y: u32) -> bool {
        self.live.is_none_or(|mask| mask.is_live(UVec2::new(x, y)))
    }

    /// Writes the pixels of row `y` that this pass is live at; how many samples were read.
    fn fill(&self, y: u32, row: &mut [[f32; 3]]) -> u64 {
        let Some(v) = self.beside(1, y) else { return 0 };
        let Some(mask) = self.live else {
            return self.fill_run(&v, 0..self.size.x, [true; 2], row);
        };
        let across = mask.cell().x;
        let beside = [v.low, v.high].map(|y| mask.row(y));
        let mut end = 0;
        let runs = mask.row(v.owner).chunk_by(|a, b| a == b);
        runs.map(|run| {
            let cells = end..end + run.len();
            end = cells.end;
            if !run[0] {
                return 0;
            }
            let whole = beside.map(|row| row[cells.clone()].iter().all(|live| *live));
            let [from, to] = [cells.start, cells.end].map(|c| (c as u32 * across).min(self.size.x));
            self.fill_run(&v, from..to, whole, row)
        })
        .sum()
    }

    /// Writes the pixels that a run of live `samples` owns. Whether the same samples of the nearest rows are live as
    /// a `whole`: what is known then need not be asked for each.
    fn fill_run(
        &self,
        v: &Beside,
        samples: Range<u32>,
        whole: [bool; 2],
        row: &mut [[f32; 3]],
    ) -> u64 {
        // Owners do not fall from pixel to pixel.
        let place = |sample: u32| self.columns.partition_point(|h| h.owner < sample);
        let pixels = place(samples.start)..place(samples.end);
        let columns = &self.columns[pixels.clone()];
        let first = self.first_px as usize;
        let row = &mut row[first + pixels.start..first + pixels.end];
        let (Some(begin), true) = (columns.first(), v.share == 0.0 && self.has_pixels) else {
            return self.blend(v, samples, whole, row, columns);
        };
        let begin = begin.owner as usize;
        row.copy_from_slice(&self.line(v.owner)[begin..begin + row.len()]);
        row.len() as u64
    }

    /// The same of pixels between samples.
    fn blend(
        &self,
        v: &Beside,
        samples: Range<u32>,
        whole: [bool; 2],
        row: &mut [[f32; 3]],
        columns: &[Beside],
    ) -> u64 {
        // What is surely live, and what has to be asked for.
        let inner = match whole {
            [true, true] => {
                let begin = columns.partition_point(|h| h.low < samples.start);
                let end = columns.partition_point(|h| h.high < samples.end);
                begin..end.max(begin)
            }
            _ => 0..0,
        };
        let [upper, lower] = [v.low, v.high].map(|y| self.line(y));
        let both = row[inner.clone()].iter_mut().zip(&columns[inner.clone()]);
        let mut fetches = 0;
        for (out, h) in both {
            let [low, high] = [h.low, h.high].map(|x| x as usize);
            let taps = [upper[low], upper[high], lower[low], lower[high]];
            let is_one = h.share == 0.0 && v.share == 0.0;
            fetches += if is_one { 1 } else { 4 };
            *out = between(taps, h.share, v.share);
        }
        for outer in [0..inner.start, inner.end..columns.len()] {
            fetches +=
                self.blend_edge(v, &samples, whole, &mut row[outer.clone()], &columns[outer]);
        }
        fetches
    }

    /// The same of pixels of which some samples may not be live: the owner stands for those.
    fn blend_edge(
        &self,
        v: &Beside,
        samples: &Range<u32>,
        whole: [bool; 2],
        row: &mut [[f32; 3]],
        columns: &[Beside],
    ) -> u64 {
        let [own, upper, lower] = [v.owner, v.low, v.high].map(|y| self.line(y));
        let mut fetches = 0;
        for (out, h) in row.iter_mut().zip(columns) {
            let owner = own[h.owner as usize];
            if h.share == 0.0 && v.share == 0.0 {
                fetches += 1;
                *out = owner;
                continue;
            }
            fetches += 4;
            let tap = |line: &[[f32; 3]], x: u32, y: u32, whole: bool| {
                if (whole && samples.contains(&x)) || self.is_live(x, y) {
                    line[x as usize]
                } else {
                    owner
                }
            };
            let taps = [
                tap(upper, h.low, v.low, whole[0]),
                tap(upper, h.high, v.low, whole[0]),
                tap(lower, h.low, v.high, whole[1]),
                tap(lower, h.high, v.high, whole[1]),
            ];
            *out = between(taps, h.share, v.share);
        }
        fetches
    }

    /// A row of samples.
    fn line(&self, y: u32) -> &[[f32; 3]] {
        let first = y as usize * self.size.x as usize;
        &self.image.rgb[first..first + self.size.x as usize]
    }
}

/// Between the two samples of an upper row and the two below, by the share of the second and of the lower.
#[inline(always)]
fn between([a, b, c, d]: [[f32; 3]; 4], across: f32, down: f32) -> [f32; 3] {
    std::array::from_fn(|i| {
        let upper = a[i] + across * (b[i] - a[i]);
        let lower = c[i] + across * (d[i] - c[i]);
        upper + down * (lower - upper)
    })
}

#[cfg(test)]
mod tests {
    use foveasim_models::foveation::{Method, Request};
    use foveasim_models::{Acuity, Eye, GazeDirection, Role, Stream, Viewport};

    use super::*;

    /// As [`mosaic`], each pixel by itself.
    fn pixel_by_pixel(plan: &SamplePlan, passes: &[Image]) -> (Vec<[f32; 3]>, u64) {
        let size = plan.display_px;
        let (mut rgb, mut fetches) = (Vec::new(), 0);
        for (x, y) in (0..size.y).flat_map(|y| (0..size.x).map(move |x| (x, y))) {
            let mut pixel = [f32::NAN; 3];
            for (pass, image) in plan.passes.iter().zip(passes).rev() {
                let part = Part::new(pass, image, size.x);
                let (Some(h), Some(v)) = (part.beside(0, x), part.beside(1, y)) else {
                    continue;
                };
                if !part.is_live(h.owner, v.owner) {
                    continue;
                }
                let owner = image.at(h.owner, v.owner);
                if h.share == 0.0 && v.share == 0.0 {
                    (pixel, fetches) = (owner, fetches + 1);
                    continue;
                }
                fetches += 4;
                let tap = |x, y| match part.is_live(x, y) {
                    true => image.at(x, y),
                    false => owner,
                };
                let between = |a: f32, b: f32, share: f32| a + share * (b - a);
                pixel = std::array::from_fn(|i| {
                    let row = |y| between(tap(h.low, y)[i], tap(h.high, y)[i], h.share);
                    between(row(v.low), row(v.high), v.share)
                });
            }
            rgb.push(pixel);
        }
        (rgb, fetches)
    }

    #[test]
    fn runs_of_pixels_are_what_each_pixel_by_itself_is() {
        let viewport = Viewport::symmetric(UVec2::new(93, 61), 1.0).unwrap();
        for (method, gaze) in [
            ("fdm", 0.0),
            ("fdm:tile=8", 0.3),
            ("rates", -0.2),
            ("quad", 0.1),
        ] {
            let gaze = GazeDirection::from_vector([gaze, 0.5 * gaze, -1.0].into());
            let request = Request {
                eye: Eye::Cyclopean,
                viewport,
                acuity: Acuity::default(),
                gaze,
                ahead: GazeDirection::AHEAD,
                margin_deg: 0.0,
            };
            let plan = method.parse::<Method>().unwrap().plan(&request).unwrap();
            let mut stream = Stream::new(7, Role::Population, 0);
            let mut noise = |pass: &Pass| {
                let mut image = Image::filled(grid(pass), [0.0; 3]);
                image
                    .rgb
                    .fill_with(|| [(); 3].map(|()| stream.uniform() as f32));
                image
            };
            let images: Vec<Image> = plan.passes.iter().map(&mut noise).collect();
            let (found, work) = mosaic(&plan, &images, Image::filled(plan.display_px, [0.0; 3]));
            let (expected, fetches) = pixel_by_pixel(&plan, &images);
            assert!(found.rgb == expected, "{method}");
            assert_eq!(work.resolve_fetches, fetches, "{method}");
        }
    }
}
