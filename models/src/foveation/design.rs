use std::num::NonZeroU32;

use glam::{DVec2, DVec3};

use super::optimise::{Chain, Placement};
use super::request::margin;
use super::{Coverage, Estimate, LayersSettings, PassEstimate, Screen};
use crate::error::in_range;
use crate::math::{atan_deg, tan_deg};
use crate::{Acuity, ModelError};

/// The frames between updates of every layer but the inner one: middle and outer layers take turns
/// (Guenter 2012, §4.4).
pub(super) const OUTER_EVERY: NonZeroU32 = NonZeroU32::new(2).expect("not zero");

/// Where eccentricity layers end and how coarse they are (Guenter 2012, Eqs 2–8), for gaze straight
/// ahead; continuous, nothing is rounded to whole samples.
///
/// With ω(e) = m·e + ω₀ the acuity line, ω* the display's sharpness, β the blending's reach (1, or 0.6
/// if strict) and δ the margin:
///
/// * s₁ = 1, s_{i+1} = max(1, ω(max(0, β·e_i − δ))/ω*) (Eq. 2 has β = 1, δ = 0);
/// * D_i = 2·tan e_i / (s_i · pixel), D_n = D*/s_n (Eqs 3, 5);
/// * P_i = D_i², clipped at the edges of the screen, P_n = α·D_n² (Eqs 4, 6);
/// * the radii e_i minimise Σ w_i·P_i.
///
/// **Displays coarser than the eye.** Where β·e − δ is so small that ω ≤ ω*, the layer outside e would
/// be as fine as the display: it merges with the inner one. So radii start where s exceeds 1, and a
/// design has fewer layers than asked for when that needs fewer samples (down to one, `full`). Radii
/// below that point are not searched, so ½-weights cannot delete the inner layer.
///
/// **Displays sharper than the eye.** s₂ > 1 from the smallest radius on; the inner layer stays on the
/// display's own grid, and has a radius of at least one pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerDesign {
    screen: Screen,
    layers: Vec<LayerSpec>,
    weighted: f64,
}

/// One layer of a design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerSpec {
    /// e_i, its angular radius \[deg\]; `None` for the outermost, which fills the screen.
    pub eccentricity_deg: Option<f64>,
    /// s_i, display pixels per sample along each axis.
    pub scale: f64,
    /// D_i, samples across, before clipping.
    pub width: f64,
    /// P_i, samples on the screen.
    pub samples: f64,
}

impl LayersSettings {
    /// The best radii for a screen.
    ///
    /// The cost comes within 1e-9 relative of the continuous optimum; it is flat there, so radii are
    /// known to about 1e-5 relative.
    ///
    /// # Errors
    /// If the margin is not from 0 to 90 degrees.
    pub fn design(
        &self,
        screen: &Screen,
        acuity: Acuity,
        margin_deg: f64,
    ) -> Result<LayerDesign, ModelError> {
        margin(margin_deg)?;
        let rule = Rule {
            settings: *self,
            screen: *screen,
            acuity,
            margin_deg,
        };
        Ok(rule.with_chain(|chain| rule.build(&chain.optimise(self.count))))
    }

    /// The best radii among whole multiples of `step_deg` up to e*, and exactly as many layers as
    /// asked for: what the paper's exhaustive search finds, by dynamic programming. `None` if the
    /// grid is too coarse for that many.
    ///
    /// # Errors
    /// If the margin is not from 0 to 90 degrees, or the step not from 0.001 to 90.
    pub fn design_on_grid(
        &self,
        screen: &Screen,
        acuity: Acuity,
        margin_deg: f64,
        step_deg: f64,
    ) -> Result<Option<LayerDesign>, ModelError> {
        margin(margin_deg)?;
        in_range("step [deg]", step_deg, 1e-3..=90.0)?;
        let points = (screen.reach_deg() / step_deg + 1e-9) as u32;
        let grid: Vec<f64> = (1..=points).map(|k| f64::from(k) * step_deg).collect();
        let rule = Rule {
            settings: *self,
            screen: *screen,
            acuity,
            margin_deg,
        };
        Ok(rule.with_chain(|c| c.optimise_on(self.count, &grid).map(|p| rule.build(&p))))
    }
}

/// How radii become scales and counts.
struct Rule {
    settings: LayersSettings,
    screen: Screen,
    acuity: Acuity,
    margin_deg: f64,
}

impl Rule {
    /// s of the layer outside radius e.
    fn scale(&self, e_deg: f64) -> f64 {
        let from = self.settings.blending.reach() * e_deg - self.margin_deg;
        (self.acuity.mar_deg(from) / self.screen.sharpness_deg()).max(1.0)
    }

    /// The radius outside which s is `scale`; infinite if the acuity line never gets there.
    fn radius(&self, scale: f64) -> f64 {
        let rise = scale * self.screen.sharpness_deg() - self.acuity.omega_0_deg();
        let slope = self.acuity.slope();
        let from = if rise <= 0.0 { 0.0 } else { rise / slope };
        (from + self.margin_deg) / self.settings.blending.reach()
    }

    /// Display pixels inside radius e, clipped.
    fn area(&self, e_deg: f64) -> f64 {
        let [left, right, up, down] = self.screen.tan();
        let (c, t) = (self.screen.design_point(), tan_deg(e_deg));
        let width = t.min(right - c.x) + t.min(c.x - left);
        let height = t.min(up - c.y) + t.min(c.y - down);
        let pixel = self.screen.pixel_tan();
        width / pixel.x * (height / pixel.y)
    }

    fn with_chain<R>(&self, use_it: impl FnOnce(&Chain<'_>) -> R) -> R {
        let density = |e: f64| {
            let s = self.scale(e);
            1.0 / (s * s)
        };
        let one_pixel = atan_deg(self.screen.pixel_tan().max_element());
        use_it(&Chain {
            area: &|e| self.area(e),
            density: &density,
            whole: self.screen.pixels(),
            outer_weight: self.settings.weights.outer(),
            range: [self.radius(1.0).max(one_pixel), self.screen.reach_deg()],
            first: self
                .settings
                .second_scale
                .map(|s| self.radius(s).max(one_pixel)),
        })
    }

    fn build(&self, placement: &Placement) -> LayerDesign {
        let pixel = self.screen.pixel_tan();
        let mut scale = 1.0;
        let mut layers = Vec::with_capacity(placement.radii.len() + 1);
        for &e in &placement.radii {
            layers.push(LayerSpec {
                eccentricity_deg: Some(e),
                scale,
                width: 2.0 * tan_deg(e) / pixel.x / scale,
                samples: self.area(e) / (scale * scale),
            });
            scale = self.scale(e);
        }
        layers.push(LayerSpec {
            eccentricity_deg: None,
            scale,
            width: self.screen.size_px().x / scale,
            samples: self.screen.pixels() / (scale * scale),
        });
        LayerDesign {
            screen: self.screen,
            layers,
            weighted: placement.cost,
        }
    }
}

impl LayerDesign {
    /// Layers, innermost first.
    pub fn layers(&self) -> &[LayerSpec] {
        &self.layers
    }

    /// P = ΣP_i for gaze straight ahead, all layers counted fully.
    pub fn samples(&self) -> f64 {
        self.layers.iter().map(|l| l.samples).sum()
    }

    /// Σ w_i·P_i: what was minimised.
    pub fn weighted_samples(&self) -> f64 {
        self.weighted
    }

    /// P*/P for gaze straight ahead (Eq. 8).
    pub fn ratio(&self) -> f64 {
        self.screen.pixels() / self.samples()
    }

    /// P*/P with P₂ and up counted half (Guenter 2012, §4.4).
    pub fn ratio_staggered(&self) -> f64 {
        let outer: f64 = self.layers.iter().skip(1).map(|l| l.samples).sum();
        self.screen.pixels() / (self.layers[0].samples + outer / f64::from(OUTER_EVERY.get()))
    }

    /// Samples with the same radii about unit direction `gaze` (eye frame), clipped to the screen.
    pub fn estimate(&self, gaze: DVec3, coverage: Coverage) -> Estimate {
        let pass = |(i, layer): (usize, &LayerSpec)| {
            let pixels = match layer.eccentricity_deg {
                Some(e) => coverage
                    .rectangle(gaze, e)
                    .and_then(|r| r.clipped(&self.screen))
                    .map_or(0.0, |r| r.pixels(&self.screen)),
                None => self.screen.pixels(),
            };
            let samples = pixels / (layer.scale * layer.scale);
            PassEstimate {
                every: if i == 0 { 1 } else { OUTER_EVERY.get() },
                radius_deg: layer.eccentricity_deg,
                ..PassEstimate::new(samples, DVec2::splat(layer.scale))
            }
        };
        Estimate {
            passes: self.layers.iter().enumerate().map(pass).collect(),
            display_pixels: self.screen.pixels(),
        }
    }
}
