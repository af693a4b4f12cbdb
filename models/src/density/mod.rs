//! How densely rays are cast around the gaze.

mod fit;
mod solve;

pub use fit::{FitTarget, FitWeight, GaussianFit};

use std::f64::consts::{PI, SQRT_2, TAU};

use glam::DVec2;

use crate::error::{above, in_range};
use crate::foveation::adaptive;
use crate::math::{atan, cos, erf, exp, log};
use crate::{Acuity, ModelError, Rect, Viewport};

/// Rays per display pixel, 0 to 1, by distance from the gaze \[px\] (Bruder 2019, §3: Φ).
///
/// Its integral over an area is the number of rays there. All integrals are closed forms, or one
/// quadrature over an angle of a closed form.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum RayDensity {
    /// floor + (1 − floor)·exp(−r²/2σ²): one ray per pixel at the gaze. The paper's, with no floor: beyond
    /// 4.8 σ a mask of 80,000 rays has none.
    Gaussian {
        /// σ \[px\].
        sigma_px: f64,
        /// What is left far from the gaze.
        floor: f64,
    },
    /// min(1, (s/(1 + r/r₂))²): the square of acuity, whose falloff is hyperbolic. The eccentricity of a place
    /// is taken to be r times the angle of a pixel at the gaze; on a planar display that asks for more rays
    /// than the true angle would, never for fewer.
    Mar {
        /// s: spacing of pixels over what the fovea can tell apart. Above 1, there is one ray per pixel up to
        /// r₂·(s − 1).
        peak: f64,
        /// r₂: where the smallest angle that can be told apart has doubled \[px\].
        half_px: f64,
    },
}

/// Farthest that any length of a density may be \[px\].
const MOST_PX: f64 = 1e6;

impl RayDensity {
    /// A Gaussian of `sigma_px`, and no rays far out.
    ///
    /// # Errors
    /// If σ is not from 0.01 to 10⁶ px.
    pub fn gaussian(sigma_px: f64) -> Result<Self, ModelError> {
        in_range("sigma [px]", sigma_px, 0.01..=MOST_PX)?;
        Ok(Self::Gaussian {
            sigma_px,
            floor: 0.0,
        })
    }

    /// The density that acuity asks for on `viewport` with the gaze in its middle: samples half a cycle
    /// apart.
    ///
    /// # Errors
    /// If the acuity does not fall off.
    pub fn mar(acuity: Acuity, viewport: &Viewport) -> Result<Self, ModelError> {
        let pixel_deg = viewport.sharpness_deg() / 2.0;
        above("slope [deg/cycle per deg]", acuity.slope(), 0.0, 10.0)?;
        Self::of_parts(
            pixel_deg / (acuity.omega_0_deg() / 2.0),
            acuity.omega_0_deg() / acuity.slope() / pixel_deg,
        )
    }

    /// A MAR density of its two parameters.
    ///
    /// # Errors
    /// If `peak` is not from 0.001 to 10⁶, or `half_px` not from 0.001 to 10⁶ px.
    pub fn of_parts(peak: f64, half_px: f64) -> Result<Self, ModelError> {
        in_range("peak", peak, 1e-3..=1e6)?;
        in_range("half [px]", half_px, 1e-3..=MOST_PX)?;
        Ok(Self::Mar { peak, half_px })
    }

    /// The same with `floor` rays per pixel far from the gaze; a MAR density has enough and stays as it is.
    ///
    /// # Errors
    /// If `floor` is not from 0 to 1.
    pub fn with_floor(self, floor: f64) -> Result<Self, ModelError> {
        in_range("floor [rays per pixel]", floor, 0.0..=1.0)?;
        Ok(match self {
            Self::Gaussian { sigma_px, .. } => Self::Gaussian { sigma_px, floor },
            mar @ Self::Mar { .. } => mar,
        })
    }

    /// `gaussian` or `mar`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Gaussian { .. } => "gaussian",
            Self::Mar { .. } => "mar",
        }
    }

    /// Its two numbers: σ and floor, or peak and r₂.
    pub fn parameters(&self) -> [f64; 2] {
        match *self {
            Self::Gaussian { sigma_px, floor } => [sigma_px, floor],
            Self::Mar { peak, half_px } => [peak, half_px],
        }
    }

    /// Φ at `r_px` from the gaze \[rays per pixel\].
    pub fn at(&self, r_px: f64) -> f64 {
        match *self {
            Self::Gaussian { sigma_px, floor } => {
                let x = r_px / sigma_px;
                floor + (1.0 - floor) * exp(-0.5 * x * x)
            }
            Self::Mar { peak, half_px } => {
                let root = (peak / (1.0 + r_px / half_px)).min(1.0);
                root * root
            }
        }
    }

    /// How far rays are apart at `r_px` from the gaze, 1/√Φ \[px\].
    pub fn spacing_px(&self, r_px: f64) -> f64 {
        1.0 / crate::math::sqrt(self.at(r_px))
    }

    /// Rays within `r_px` of the gaze.
    pub fn in_disc(&self, r_px: f64) -> f64 {
        TAU * self.radial(r_px)
    }

    /// Rays on the whole plane; infinite unless it is a Gaussian without floor.
    pub fn on_plane(&self) -> f64 {
        match *self {
            Self::Gaussian {
                sigma_px,
                floor: 0.0,
            } => TAU * sigma_px * sigma_px,
            _ => f64::INFINITY,
        }
    }

    /// Rays in `area`, given relative to the gaze \[px\].
    pub fn in_rect(&self, area: Rect) -> f64 {
        let [a, b] = [area.min, area.max];
        self.up_to(b) - self.up_to(DVec2::new(a.x, b.y)) - self.up_to(DVec2::new(b.x, a.y))
            + self.up_to(a)
    }

    /// Rays on a display of `size` pixels with the gaze in its middle.
    pub fn on_display(&self, size: DVec2) -> f64 {
        4.0 * self.up_to(size / 2.0)
    }

    /// ∫₀ᴿ Φ(r)·r dr.
    fn radial(&self, r: f64) -> f64 {
        match *self {
            Self::Gaussian { sigma_px, floor } => {
                let x = r / sigma_px;
                let bell = sigma_px * sigma_px * (1.0 - exp(-0.5 * x * x));
                (1.0 - floor) * bell + floor * r * r / 2.0
            }
            Self::Mar { peak, half_px } => {
                let flat = (half_px * (peak - 1.0)).max(0.0);
                if r <= flat {
                    return r * r / 2.0;
                }
                let scale = (peak * half_px) * (peak * half_px);
                let primitive = |r: f64| {
                    let y = 1.0 + r / half_px;
                    log(y) + 1.0 / y
                };
                flat * flat / 2.0 + scale * (primitive(r) - primitive(flat))
            }
        }
    }

    /// ∫∫ Φ over the rectangle from the gaze up to `corner`, negative where one coordinate is.
    fn up_to(&self, corner: DVec2) -> f64 {
        let sign = corner.x.signum() * corner.y.signum();
        let DVec2 { x, y } = corner.abs();
        if x == 0.0 || y == 0.0 {
            return 0.0;
        }
        match *self {
            Self::Gaussian { sigma_px, floor } => {
                let side = |v: f64| (PI / 2.0).sqrt() * sigma_px * erf(v / (sigma_px * SQRT_2));
                sign * ((1.0 - floor) * side(x) * side(y) + floor * x * y)
            }
            Self::Mar { .. } => sign * (self.triangle(x, y) + self.triangle(y, x)),
        }
    }

    /// ∫∫ Φ over the right triangle with its right angle `near` from the gaze and `far` along from there.
    fn triangle(&self, near: f64, far: f64) -> f64 {
        let end = atan(far / near);
        adaptive(&[0.0, end], 1e-12, |angle| self.radial(near / cos(angle)))
    }
}

#[cfg(test)]
mod tests;
