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
            for (had, h) in had.iter_mut().zip(&part.columns) {
                *had |= h.is_some_and(|h| part.is_live(h.owner, v.owner));
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
    /// For each pixel of a row.
    columns: Vec<Option<Beside>>,
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
            columns: Vec::new(),
        };
        part.columns = (0..width).map(|x| part.beside(0, x)).collect();
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
        let (mut fetches, mut asked) = (0, None);
        for (out, column) in row.iter_mut().zip(&self.columns) {
            let Some(h) = column else { continue };
            // Pixels of one sample lie side by side: what holds of it is asked once.
            let live = match asked {
                Some((owner, live)) if owner == h.owner => live,
                _ => self.is_live(h.owner, v.owner),
            };
            asked = Some((h.owner, live));
            if !live {
                continue;
            }
            let owner = self.image.at(h.owner, v.owner);
            let exact = h.share == 0.0 && v.share == 0.0;
            if exact {
                fetches += 1;
                *out = owner;
                continue;
            }
            fetches += 4;
            let tap = |x, y| {
                if self.is_live(x, y) {
                    self.image.at(x, y)
                } else {
                    owner
                }
            };
            let (a, b) = (tap(h.low, v.low), tap(h.high, v.low));
            let (c, d) = (tap(h.low, v.high), tap(h.high, v.high));
            *out = std::array::from_fn(|i| {
                let upper = a[i] + h.share * (b[i] - a[i]);
                let lower = c[i] + h.share * (d[i] - c[i]);
                upper + v.share * (lower - upper)
            });
        }
        fetches
    }
}
