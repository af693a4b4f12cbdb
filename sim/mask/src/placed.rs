use foveasim_models::math;
use glam::{DVec2, IVec2, UVec2};
use rayon::prelude::*;

use crate::weights::{TILE, Tile, tiles, unpack};
use crate::{Mask, MaskError, StepLaw, WEIGHT_STEP};

/// A mask with its middle where the eye looks: the rays of one frame, and the image from what they saw.
#[derive(Debug, Clone)]
pub struct PlacedMask<'a> {
    mask: &'a Mask,
    /// Mask pixel of the display's first.
    origin: UVec2,
    /// Sites that rays are cast for, in the mask's order.
    live: Vec<u32>,
    /// For every site its place among these.
    slot: Vec<u32>,
}

/// No ray.
const DEAD: u32 = u32::MAX;

impl<'a> PlacedMask<'a> {
    /// With the gaze at display pixel `gaze_px`, rounded to whole pixels and to the display.
    pub fn new(mask: &'a Mask, gaze_px: DVec2) -> Self {
        let display = mask.spec.display_px;
        // NaN becomes 0 in the cast.
        let gaze = (gaze_px + 0.5)
            .floor()
            .clamp(DVec2::ZERO, display.as_dvec2());
        let origin = display - gaze.as_uvec2();
        let mut placed = Self {
            mask,
            origin,
            live: Vec::new(),
            slot: vec![DEAD; mask.sites.len()],
        };
        placed.find_live();
        placed
    }

    /// Marks the sites that pixels of the display take from, and numbers them.
    fn find_live(&mut self) {
        let (min, end) = (self.origin, self.origin + self.mask.spec.display_px);
        let weights = &self.mask.weights;
        let first = min / TILE;
        let last = (end - 1) / TILE;
        for y in first.y..=last.y {
            for x in first.x..=last.x {
                let tile = weights.tile(UVec2::new(x, y));
                let inside = tile.min.cmpge(min).all() && (tile.min + tile.size).cmple(end).all();
                if inside {
                    for &site in tile.sites {
                        self.slot[site as usize] = 0;
                    }
                    continue;
                }
                for_each_pixel(&tile, |at, entries| {
                    if at.cmpge(min).all() && at.cmplt(end).all() {
                        for &entry in entries {
                            self.slot[tile.sites[unpack(entry).0] as usize] = 0;
                        }
                    }
                });
            }
        }
        for (site, slot) in (0..).zip(&mut self.slot) {
            if *slot != DEAD {
                *slot = self.live.len() as u32;
                self.live.push(site);
            }
        }
    }

    /// The mask.
    pub fn mask(&self) -> &'a Mask {
        self.mask
    }

    /// How many rays to cast.
    pub fn rays(&self) -> usize {
        self.live.len()
    }

    /// The sites they are for, in Morton order.
    pub fn live(&self) -> &[u32] {
        &self.live
    }

    /// Where ray `k` is cast \[display px\]: at its site, or at the nearest place on the display for the few beside it
    /// that pixels at its edge take from.
    ///
    /// # Panics
    /// If there is no such ray.
    pub fn position(&self, k: usize) -> DVec2 {
        let at = self.mask.sites[self.live[k] as usize] - self.origin.as_dvec2();
        at.clamp(DVec2::ZERO, self.mask.spec.display_px.as_dvec2())
    }

    /// Base steps that ray `k` takes at once.
    ///
    /// # Panics
    /// If there is no such ray.
    pub fn step(&self, k: usize, law: StepLaw) -> f32 {
        let site = self.live[k] as usize;
        let away = self.mask.sites[site] - self.mask.spec.display_px.as_dvec2();
        let distance = math::sqrt(away.length_squared());
        law.factor(self.mask.spacing[site], distance as f32)
    }

    /// The gaze, as it was rounded \[display px\].
    pub fn gaze_px(&self) -> UVec2 {
        self.mask.spec.display_px - self.origin
    }

    /// The display's pixels, row by row, from what the rays saw: `values[k]` is ray k's.
    ///
    /// A pixel is its first site's value and the weighted differences of the others from it, so what is constant stays
    /// so exactly.
    ///
    /// # Errors
    /// If there is not one value per ray, or not one pixel per display pixel.
    pub fn reconstruct(
        &self,
        values: &[[f32; 4]],
        pixels: &mut [[f32; 4]],
    ) -> Result<(), MaskError> {
        let display = self.mask.spec.display_px;
        let wanted = display.x as usize * display.y as usize;
        for (what, given, wanted) in [
            ("values of rays", values.len(), self.live.len()),
            ("pixels", pixels.len(), wanted),
        ] {
            if given != wanted {
                return Err(MaskError::Length {
                    what,
                    given,
                    wanted,
                });
            }
        }
        // Rows of tiles write to rows of pixels of their own; the first and last may be cut.
        let width = display.x as usize;
        let head = ((TILE - self.origin.y % TILE) % TILE).min(display.y) as usize * width;
        let (head, rest) = pixels.split_at_mut(head);
        let first = self.origin.y / TILE;
        if !head.is_empty() {
            self.row(first, values, head);
        }
        let first = first + u32::from(!head.is_empty());
        rest.par_chunks_mut(width * TILE as usize)
            .zip(first..tiles(self.mask.size()).y)
            .for_each(|(rows, tile)| self.row(tile, values, rows));
        Ok(())
    }

    /// The rows of the display that lie in row `tile` of tiles.
    fn row(&self, tile: u32, values: &[[f32; 4]], rows: &mut [[f32; 4]]) {
        let display = self.mask.spec.display_px.as_ivec2();
        let origin = self.origin.as_ivec2();
        let width = display.x as usize;
        // Row of the display that `rows` begins with.
        let top = ((tile * TILE) as i32 - origin.y).max(0);
        let height = (rows.len() / width) as i32;
        let mut local: Vec<[f32; 4]> = Vec::new();
        let columns = self.origin.x / TILE..=(self.origin.x + display.x as u32 - 1) / TILE;
        for column in columns {
            let tile = self.mask.weights.tile(UVec2::new(column, tile));
            local.clear();
            local.extend(tile.sites.iter().map(|&site| {
                // Sites that only pixels beside the display take from have no ray.
                let slot = self.slot[site as usize];
                values.get(slot as usize).copied().unwrap_or_default()
            }));
            for_each_pixel(&tile, |at, entries| {
                let IVec2 { x, y } = at.as_ivec2() - origin;
                let y = y - top;
                if (0..display.x).contains(&x) && (0..height).contains(&y) {
                    rows[y as usize * width + x as usize] = mix(&local, entries);
                }
            });
        }
    }
}

/// Calls `f` with every pixel of a tile and its entries.
#[inline]
fn for_each_pixel(tile: &Tile<'_>, mut f: impl FnMut(UVec2, &[u32])) {
    let mut entries = tile.entries;
    for y in 0..tile.size.y {
        let row = &tile.counts[(y * tile.size.x) as usize..][..tile.size.x as usize];
        for (x, &count) in (0..).zip(row) {
            let (these, rest) = entries.split_at(usize::from(count));
            entries = rest;
            f(tile.min + UVec2::new(x, y), these);
        }
    }
}

#[inline]
fn mix(values: &[[f32; 4]], entries: &[u32]) -> [f32; 4] {
    let first = values[unpack(entries[0]).0];
    let mut sum = [0.0f32; 4];
    for &entry in &entries[1..] {
        let (site, parts) = unpack(entry);
        let weight = parts as f32;
        for ((s, v), f) in sum.iter_mut().zip(values[site]).zip(first) {
            *s += weight * (v - f);
        }
    }
    std::array::from_fn(|k| first[k] + sum[k] * WEIGHT_STEP as f32)
}
