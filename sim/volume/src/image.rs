use foveasim_lanes::wide::WIDTH;
use foveasim_models::{Image, Lattice, SamplePlan, Shading, ShadingRate, View};
use glam::UVec2;
use rayon::prelude::*;

use crate::caster::total;
use crate::packet::{Packet, Sight};
use crate::{CastError, CastWork, Caster, Ray};

/// Samples along each side of a packet of a lattice.
const SIDE: u32 = 4;

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

    /// The samples of a lattice, each by the ray that `ray` gives for it, in blocks of 4 × 4.
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
        let width = size.x as usize;
        let works: Vec<Result<CastWork, CastError>> = image
            .rgb
            .par_chunks_mut(width * SIDE as usize)
            .enumerate()
            .map(|(strip, rows)| self.strip(&sight, strip as u32 * SIDE, size, ray, rows))
            .collect();
        let work = total(works)?;
        Ok(VolumeFrame { image, work })
    }

    /// Up to four rows of a lattice, from row `top` on.
    fn strip(
        &self,
        sight: &Sight,
        top: u32,
        size: UVec2,
        ray: &(dyn Fn(UVec2) -> Option<Ray> + Sync),
        rows: &mut [[f32; 3]],
    ) -> Result<CastWork, CastError> {
        let mut work = CastWork::default();
        let background = self.options().background;
        for left in (0..size.x).step_by(SIDE as usize) {
            let mut packet = Packet::EMPTY;
            let mut drawn = [None; WIDTH];
            for (lane, drawn) in drawn.iter_mut().enumerate() {
                let at = UVec2::new(left + lane as u32 % SIDE, top + lane as u32 / SIDE);
                if at.cmpge(size).any() {
                    continue;
                }
                let Some(ray) = ray(at) else { continue };
                let index = at.y as usize * size.x as usize + at.x as usize;
                sight.aim(&mut packet, lane, ray, index, &mut work)?;
                *drawn = Some((at.y - top) as usize * size.x as usize + at.x as usize);
            }
            let seen = self.follow(&packet, &mut work);
            for (place, seen) in drawn.into_iter().zip(seen) {
                if let Some(place) = place {
                    rows[place] = over(seen, background);
                }
            }
        }
        Ok(work)
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
