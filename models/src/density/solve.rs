use glam::{DVec2, UVec2};

use super::RayDensity;
use crate::error::above;
use crate::math::{erf, sqrt, sum};
use crate::{Acuity, ModelError, Viewport};

/// What is bisected is known to one part in 2⁵² after this many halvings.
const HALVINGS: u32 = 200;

impl RayDensity {
    /// The Gaussian with `fraction` of a ray per pixel of a display of `size`, if the display held all of it:
    /// 2πσ² = fraction·w·h.
    ///
    /// # Errors
    /// If `fraction` is not above 0, at most 1, or σ out of range.
    pub fn gaussian_of_fraction(fraction: f64, size: DVec2) -> Result<Self, ModelError> {
        above("fraction of rays", fraction, 0.0, 1.0)?;
        let rays = fraction * size.x * size.y;
        Self::gaussian(sqrt(rays / std::f64::consts::TAU))
    }

    /// The Gaussian with `fraction` of a ray per pixel, on average over gazes at the middle of every pixel of a
    /// display of `size`.
    ///
    /// # Errors
    /// If `fraction` is not above 0, below 1, or σ out of range.
    pub fn gaussian_of_mean_fraction(fraction: f64, size: UVec2) -> Result<Self, ModelError> {
        above("fraction of rays", fraction, 0.0, 1.0 - 1e-9)?;
        let sigma = bisect([1e-2, 1e6], |sigma| mean_fraction(sigma, size) - fraction);
        Self::gaussian(sigma)
    }

    /// The MAR density for the pixels of `viewport` and the foveal limit of `acuity` whose slope gives
    /// `fraction` of a ray per pixel, gaze in the middle; with that slope \[deg/cycle per deg\].
    ///
    /// # Errors
    /// If no slope from 10⁻⁶ to 10 does.
    pub fn mar_of_fraction(
        fraction: f64,
        acuity: Acuity,
        viewport: &Viewport,
    ) -> Result<(Self, f64), ModelError> {
        let size = viewport.size.as_dvec2();
        let of = |slope: f64| {
            let acuity = Acuity::with_foveal(slope, acuity.omega_0_deg())?;
            Self::mar(acuity, viewport)
        };
        let share = |slope: f64| of(slope).map(|d| d.on_display(size) / (size.x * size.y));
        let [most, least] = [share(1e-6)?, share(10.0)?];
        if !(fraction >= least && fraction <= most) {
            let valid = format!("from {least:.4} to {most:.4}, what slopes from 10 to 0 give");
            return Err(ModelError::range("fraction of rays", fraction, valid));
        }
        // More slope, fewer rays; `share` holds for all slopes between those tried.
        let slope = bisect([1e-6, 10.0], |slope| {
            fraction - share(slope).unwrap_or(f64::NAN)
        });
        Ok((of(slope)?, slope))
    }

    /// Rays on a display of `size` over its pixels, on average over gazes at the middle of each; `None` for densities
    /// that are no Gaussian without floor.
    pub fn mean_fraction(&self, size: UVec2) -> Option<f64> {
        match *self {
            Self::Gaussian {
                sigma_px,
                floor: 0.0,
            } => Some(mean_fraction(sigma_px, size)),
            _ => None,
        }
    }
}

/// Per axis of n pixels, the mean over g = ½, 1½ … n − ½ of ∫₀ⁿ exp(−(x − g)²/2σ²) dx / n.
fn mean_fraction(sigma: f64, size: UVec2) -> f64 {
    let side = |v: f64| erf(v / (sigma * std::f64::consts::SQRT_2));
    let axis = |pixels: u32| {
        let length = f64::from(pixels);
        let seen: Vec<f64> = (0..pixels)
            .map(|k| f64::from(k) + 0.5)
            .map(|gaze| side(gaze) + side(length - gaze))
            .collect();
        sqrt(std::f64::consts::FRAC_PI_2) * sigma * sum(&seen) / (length * length)
    };
    axis(size.x) * axis(size.y)
}

/// Where increasing `f` crosses zero, between the two ends.
fn bisect([mut low, mut high]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..HALVINGS {
        let mid = 0.5 * (low + high);
        if f(mid) < 0.0 {
            low = mid;
        } else {
            high = mid;
        }
        if high - low <= f64::EPSILON * high {
            break;
        }
    }
    0.5 * (low + high)
}
