use crate::error::above;
use crate::foveation::gauss;
use crate::math::{exp, log, sqrt};
use crate::{Acuity, ModelError};

/// What a Gaussian is to follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FitTarget {
    /// Relative acuity, ω₀/ω(e).
    Acuity,
    /// Its square: rays per area.
    Density,
}

/// How errors at different eccentricities are weighed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FitWeight {
    /// Alike.
    Line,
    /// By eccentricity: as there is area.
    Area,
}

/// The Gaussian exp(−e²/2σ²) that follows acuity best, by least squares from 0 to some eccentricity; and how
/// badly it does: the target falls off as 1/e or 1/e².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussianFit {
    /// σ \[deg\].
    pub sigma_deg: f64,
    /// Root of the (weighted) mean square of the error.
    pub rms: f64,
    /// Largest error.
    pub max_error: f64,
    /// Where it is \[deg\].
    pub max_at_deg: f64,
    /// Gaussian over target at the greatest eccentricity.
    pub ratio_at_end: f64,
}

impl GaussianFit {
    /// Fits up to `to_deg`.
    ///
    /// # Errors
    /// If acuity does not fall off, or `to_deg` is not above 0, at most 180.
    pub fn new(
        acuity: Acuity,
        target: FitTarget,
        weight: FitWeight,
        to_deg: f64,
    ) -> Result<Self, ModelError> {
        above("slope [deg/cycle per deg]", acuity.slope(), 0.0, 10.0)?;
        above("eccentricity [deg]", to_deg, 0.0, 180.0)?;
        let half = acuity.omega_0_deg() / acuity.slope();
        let wanted = |e: f64| {
            let relative = 1.0 / (1.0 + e / half);
            match target {
                FitTarget::Acuity => relative,
                FitTarget::Density => relative * relative,
            }
        };
        let weigh = |e: f64| match weight {
            FitWeight::Line => 1.0,
            FitWeight::Area => e,
        };
        let bell = |e: f64, sigma: f64| exp(-0.5 * (e / sigma) * (e / sigma));
        // Pieces grow with e, as the target's detail does.
        const PIECES: u32 = 96;
        let end = |k: u32| {
            half * (exp(f64::from(k) / f64::from(PIECES) * log(1.0 + to_deg / half)) - 1.0)
        };
        let integral = |f: &dyn Fn(f64) -> f64| {
            let pieces: Vec<f64> = (0..PIECES).map(|k| gauss(end(k), end(k + 1), f)).collect();
            crate::math::sum(&pieces)
        };
        // d/dσ of half the squared error, but for the factor σ⁻³.
        let slope = |sigma: f64| {
            integral(&|e| weigh(e) * (bell(e, sigma) - wanted(e)) * bell(e, sigma) * e * e)
        };
        let (mut low, mut high) = (half * 1e-2, half * 20.0 + to_deg * 20.0);
        for _ in 0..80 {
            let mid = sqrt(low * high);
            if slope(mid) < 0.0 {
                low = mid;
            } else {
                high = mid;
            }
        }
        let sigma = sqrt(low * high);
        let error = |e: f64| bell(e, sigma) - wanted(e);
        let squares = integral(&|e| weigh(e) * error(e) * error(e));
        const STEPS: u32 = 20_000;
        let (mut max_error, mut max_at_deg) = (0.0, 0.0);
        for k in 0..=STEPS {
            let e = to_deg * f64::from(k) / f64::from(STEPS);
            if error(e).abs() > max_error {
                (max_error, max_at_deg) = (error(e).abs(), e);
            }
        }
        Ok(Self {
            sigma_deg: sigma,
            rms: sqrt(squares / integral(&weigh)),
            max_error,
            max_at_deg,
            ratio_at_end: bell(to_deg, sigma) / wanted(to_deg),
        })
    }
}
