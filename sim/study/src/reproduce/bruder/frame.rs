use foveasim_mask::{Mask, PlacedMask, StepLaw};
use foveasim_models::{Image, View};
use foveasim_volume::{CastWork, Caster, Ray, over};
use glam::DVec2;
use rayon::prelude::*;

use super::ReproduceError;

/// A foveated frame, in its two halves so that each can be timed.
pub(super) struct Foveated<'a> {
    placed: PlacedMask<'a>,
    values: Vec<[f32; 4]>,
    pub(super) work: CastWork,
}

impl<'a> Foveated<'a> {
    /// Places the mask and casts its rays.
    pub(super) fn cast(
        caster: &Caster,
        view: &View,
        mask: &'a Mask,
        gaze_px: DVec2,
        law: StepLaw,
    ) -> Result<Self, ReproduceError> {
        let placed = PlacedMask::new(mask, gaze_px);
        let mut values = vec![[0.0; 4]; placed.rays()];
        let ray = |k: usize| Ray {
            px: placed.position(k),
            step: placed.step(k, law),
        };
        let work = caster.cast(view, ray, &mut values)?;
        Ok(Self {
            placed,
            values,
            work,
        })
    }

    /// Makes the image of what they saw.
    pub(super) fn reconstruct(&self, background: [f32; 3]) -> Result<Image, ReproduceError> {
        let size = self.placed.mask().spec().display_px;
        let mut pixels = vec![[0.0; 4]; size.element_product() as usize];
        self.placed.reconstruct(&self.values, &mut pixels)?;
        let rgb = pixels.par_iter().map(|&p| over(p, background)).collect();
        Ok(Image { size, rgb })
    }
}
