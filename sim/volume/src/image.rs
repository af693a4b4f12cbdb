use foveasim_lanes::wide::WIDTH;
use foveasim_models::{Image, Lattice, SamplePlan, Shading, ShadingRate, View};
use glam::UVec2;
use rayon::prelude::*;

use crate::packet::{Packet, Sight};
use crate::{CastError, CastWork, Caster, Ray};

/// Samples along each side of a packet of a lattice.
const SIDE: u32 = 4;
/// Samples along each side of a tile, in which a thread goes on before it takes another.
const TILE: u32 = 32;

/// A drawn image.
#[derive(Debug, Clone, PartialEq)]
pub struct VolumeFrame {
    /// Linear light.
    pub image: Image,
    /// What drawing it took.
    pub work: CastWork,
}

/// What a ray sees (weighted by opacity) before something else.
pub fn over(seen: [f32; 4], background: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|c| seen[c] + (1.0 - seen[3]) * background[c])
}

impl Caster {
    /// Every pixel, in its middle.
    ///
    /// # Errors
    /// If the view moves or is not finite.
    pub fn full(&self, view: &View) -> Result<VolumeFrame, CastError> {
        let size = view.optics.size;
        self.lattice(view, size, &|at| {
            Some(Ray {
                px: at.as_dvec2() + 0.5,
                step: 1.0,
            })
        })
    }

    /// The samples of each pass of a plan, one image for each; what is not live is black. All passes are drawn,
    /// whatever their cadence, and every live sample once: volumes have no visibility apart from shading.
    /// A block of coarse shading is one ray through its middle. Rays off the screen are not cast.
    ///
    /// # Errors
    /// If the view moves or is not finite, or the plan is for an image of another size.
    pub fn passes(&self, view: &View, plan: &SamplePlan) -> Result<Vec<VolumeFrame>, CastError> {
        if plan.display_px != view.optics.size {
            let text = |size: UVec2| format!("{} x {}", size.x, size.y);
            return Err(CastError::OtherSize {
                method: plan.method.clone(),
                plan: text(plan.display_px),
                view: text(view.optics.size),
            });
        }
        let draw = |index: usize| self.pass(view, plan, index);
        (0..plan.passes.len()).map(draw).collect()
    }

    fn pass(&self, view: &View, plan: &SamplePlan, index: usize) -> Result<VolumeFrame, CastError> {
        let pass = &plan.passes[index];
        let Lattice::Grid(size) = pass.lattice else {
            return Err(CastError::Lattice {
                method: plan.method.clone(),
                pass: index,
            });
        };
        let rates = match &pass.shading {
            // What only finds visibility for others has nothing to find.
            Shading::Nowhere => {
                return Ok(VolumeFrame {
                    image: Image::filled(UVec2::ZERO, [0.0; 3]),
                    work: CastWork::default(),
                });
            }
            Shading::Coarse(rates) => Some(rates),
            _ => None,
        };
        let rate = |at| rates.map_or(ShadingRate::FULL, |r| r.rate(at));
        let first = |at: UVec2| {
            let r = rate(at);
            UVec2::new(at.x - at.x % r.x, at.y - at.y % r.y)
        };
        let ray = |at: UVec2| {
            if !pass.region.is_live(at) {
                return None;
            }
            let r = rate(at);
            if r == ShadingRate::FULL {
                let px = plan.position(index, at);
                return Some(Ray { px, step: 1.0 });
            }
            // The first live sample of a block casts the ray of all.
            let corner = first(at);
            let past = (corner + UVec2::new(r.x, r.y)).min(size);
            let live = |s: &UVec2| pass.region.is_live(*s);
            let mut block =
                (corner.y..past.y).flat_map(|y| (corner.x..past.x).map(move |x| UVec2::new(x, y)));
            if block.find(live) != Some(at) {
                return None;
            }
            let ends = [corner, past - 1].map(|s| plan.position(index, s));
            let px = (ends[0] + ends[1]) / 2.0;
            Some(Ray { px, step: 1.0 })
        };
        let mut drawn = self.lattice(view, size, &ray)?;
        if rates.is_some() {
            spread(&mut drawn.image, &first, &|s| pass.region.is_live(s));
        }
        Ok(drawn)
    }

    /// The samples of a lattice, each by the ray that `ray` gives for it, in tiles: what neighbours read of the volume is
    /// still at hand.
    fn lattice(
        &self,
        view: &View,
        size: UVec2,
        ray: &(dyn Fn(UVec2) -> Option<Ray> + Sync),
    ) -> Result<VolumeFrame, CastError> {
        let sight = self.sight(view)?;
        let mut image = Image::filled(size, [0.0; 3]);
        if size.min_element() == 0 {
            let work = CastWork::default();
            return Ok(VolumeFrame { image, work });
        }
        let across = size.x.div_ceil(TILE) as usize;
        let tiles = across * size.y.div_ceil(TILE) as usize;
        let corner = |k: usize| UVec2::new((k % across) as u32, (k / across) as u32) * TILE;
        let draw = |k: usize| {
            let mut work = CastWork::default();
            let pixels = self.tile(&sight, corner(k), size, ray, &mut work)?;
            Ok((work, pixels))
        };
        // Some take much longer than others: each can be taken by whichever thread has nothing to do.
        let drawn: Vec<Result<_, CastError>> = (0..tiles)
            .into_par_iter()
            .with_max_len(1)
            .map(draw)
            .collect();
        let drawn = drawn.into_iter().collect::<Result<Vec<_>, _>>()?;
        let mut work = CastWork::default();
        for (k, (of_tile, pixels)) in drawn.into_iter().enumerate() {
            work += of_tile;
            let corner = corner(k);
            let width = (size.x - corner.x).min(TILE) as usize;
            for (y, row) in pixels.chunks_exact(width).enumerate() {
                let first = (corner.y as usize + y) * size.x as usize + corner.x as usize;
                image.rgb[first..first + width].copy_from_slice(row);
            }
        }
        Ok(VolumeFrame { image, work })
    }

    /// The samples of a tile within a lattice of `size`, in blocks of 4 × 4.
    fn tile(
        &self,
        sight: &Sight,
        corner: UVec2,
        size: UVec2,
        ray: &(dyn Fn(UVec2) -> Option<Ray> + Sync),
        work: &mut CastWork,
    ) -> Result<Vec<[f32; 3]>, CastError> {
        let tile = (size - corner).min(UVec2::splat(TILE));
        let mut pixels = vec![[0.0; 3]; tile.element_product() as usize];
        let background = self.options().background;
        let blocks = tile.map(|n| n.div_ceil(SIDE));
        for block in 0..blocks.element_product() {
            let first = UVec2::new(block % blocks.x, block / blocks.x) * SIDE;
            let mut packet = Packet::EMPTY;
            let mut drawn = [None; WIDTH];
            for (lane, drawn) in drawn.iter_mut().enumerate() {
                let within = first + UVec2::new(lane as u32 % SIDE, lane as u32 / SIDE);
                if within.cmpge(tile).any() {
                    continue;
                }
                let at = corner + within;
                let Some(ray) = ray(at) else { continue };
                let index = at.y as usize * size.x as usize + at.x as usize;
                sight.aim(&mut packet, lane, ray, index, work)?;
                *drawn = Some((within.y * tile.x + within.x) as usize);
            }
            let seen = self.follow(&packet, work);
            for (place, seen) in drawn.into_iter().zip(seen) {
                if let Some(place) = place {
                    pixels[place] = over(seen, background);
                }
            }
        }
        Ok(pixels)
    }
}

/// Gives each live sample of a block what the block's first live sample saw.
fn spread(image: &mut Image, first: &dyn Fn(UVec2) -> UVec2, is_live: &dyn Fn(UVec2) -> bool) {
    let size = image.size;
    let width = size.x as usize;
    for y in 0..size.y {
        for x in 0..size.x {
            let at = UVec2::new(x, y);
            if !is_live(at) {
                continue;
            }
            let corner = first(at);
            // Blocks are scanned in the order in which their rays were chosen.
            let source = (corner.y..=y)
                .flat_map(|sy| {
                    (corner.x..size.x.min(corner.x + 4)).map(move |sx| UVec2::new(sx, sy))
                })
                .find(|s| first(*s) == corner && is_live(*s));
            if let Some(s) = source {
                image.rgb[y as usize * width + x as usize] =
                    image.rgb[s.y as usize * width + s.x as usize];
            }
        }
    }
}
