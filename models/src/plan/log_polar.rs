use std::f64::consts::TAU;

use glam::{DMat2, DVec2, UVec2};

use crate::ModelError;
use crate::error::{above, in_range};
use crate::math::{atan2, cos, exp, hypot, log, pow, sin};

/// The log-polar map with a kernel (Meng 2018; Meng 2020, Eqs 1–5): lattice x runs outwards from the
/// gaze and y around it, so that
///
/// r = exp(L·(x/n_x)^α), θ = 2π·y/n_y, display = gaze + r·(cos θ, sin θ)
///
/// in display pixels, y downwards, with L the logarithm of the distance to the farthest corner. Within
/// one pixel of the gaze the logarithm would be negative: there r counts as 1, x as 0, and the map has
/// no inverse.
///
/// In the paper's terms u = x/W and v = y/H with n_x = W/σ and n_y = H/σ. Its print differs in places
/// that cannot be meant: Eq. 2 has the exponent −α where Eq. 5 needs 1/α, factors W/2 and H/2 though
/// x′ and y′ are pixels already, and an arctangent of one argument, which folds the left half over the
/// right one; Eq. 5 lacks σ on v.
///
/// Steps along x are r·L·α·(x/n_x)^(α−1)/n_x pixels long, those along y 2πr/n_y. At x = 0 itself the former
/// is infinite for α < 1 and zero for α > 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogPolar {
    gaze_px: DVec2,
    log_reach: f64,
    alpha: f64,
    samples: DVec2,
}

/// The map reaches at least so far \[px\], or a display of one pixel would have none.
const LEAST_REACH_PX: f64 = 2.0;

impl LogPolar {
    /// About `gaze_px`, on the display or not, out to the farthest corner of a display of
    /// `display_px` pixels, with `samples` lattice steps from the first ring to the farthest corner
    /// and around.
    ///
    /// # Errors
    /// If the gaze is not within ±1e9 pixels, α not from 0.01 to 100, or a number of samples not above
    /// 0 and at most 1e12.
    pub fn new(
        gaze_px: DVec2,
        display_px: UVec2,
        alpha: f64,
        samples: DVec2,
    ) -> Result<Self, ModelError> {
        Self::over(gaze_px, display_px.as_dvec2(), alpha, samples)
    }

    /// The same for a display of any size.
    pub(crate) fn over(
        gaze_px: DVec2,
        display_px: DVec2,
        alpha: f64,
        samples: DVec2,
    ) -> Result<Self, ModelError> {
        in_range("gaze x [px]", gaze_px.x, -1e9..=1e9)?;
        in_range("gaze y [px]", gaze_px.y, -1e9..=1e9)?;
        in_range("alpha", alpha, 0.01..=100.0)?;
        above("samples outwards", samples.x, 0.0, 1e12)?;
        above("samples around", samples.y, 0.0, 1e12)?;
        // The farther side along each axis makes the farthest corner.
        let farthest = gaze_px.abs().max((display_px - gaze_px).abs());
        let reach = hypot(farthest.x, farthest.y);
        Ok(Self {
            gaze_px,
            log_reach: log(reach.max(LEAST_REACH_PX)),
            alpha,
            samples,
        })
    }

    /// The display position about which it is laid.
    pub fn gaze_px(&self) -> DVec2 {
        self.gaze_px
    }

    /// L, the logarithm of the distance in pixels that x = n_x stands for.
    pub fn log_reach(&self) -> f64 {
        self.log_reach
    }

    /// The kernel's exponent.
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// Lattice steps from the first ring to the farthest corner, and around.
    pub fn samples(&self) -> DVec2 {
        self.samples
    }

    /// The distance from the gaze \[px\] at lattice x; below 0 counts as 0.
    pub fn radius(&self, x: f64) -> f64 {
        exp(self.log_reach * pow(x.max(0.0) / self.samples.x, self.alpha))
    }

    /// The unit direction away from the gaze at lattice y.
    pub fn direction(&self, y: f64) -> DVec2 {
        let angle = TAU * (y / self.samples.y);
        DVec2::new(cos(angle), sin(angle))
    }

    /// The lattice x at a distance from the gaze \[px\].
    pub fn x_at(&self, radius: f64) -> f64 {
        pow(log(radius.max(1.0)) / self.log_reach, 1.0 / self.alpha) * self.samples.x
    }

    /// The lattice y in a direction of any length, from 0 to below n_y; 0 for no direction.
    pub fn y_at(&self, direction: DVec2) -> f64 {
        let turns = atan2(direction.y, direction.x) / TAU;
        let y = if turns < 0.0 { turns + 1.0 } else { turns } * self.samples.y;
        if y < self.samples.y { y } else { 0.0 }
    }

    /// Lattice position to display pixels: to the bit `gaze_px() + radius(x) * direction(y)`.
    pub fn display_from_lattice(&self, p: DVec2) -> DVec2 {
        self.gaze_px + self.radius(p.x) * self.direction(p.y)
    }

    /// Display pixels to lattice position.
    pub fn lattice_from_display(&self, p: DVec2) -> DVec2 {
        let away = p - self.gaze_px;
        DVec2::new(self.x_at(hypot(away.x, away.y)), self.y_at(away))
    }

    /// Lengths of a step outwards and of a step around \[px\] at lattice x.
    pub fn step_lengths(&self, x: f64) -> [f64; 2] {
        let radius = self.radius(x);
        let share = x.max(0.0) / self.samples.x;
        let outwards = radius * self.log_reach * self.alpha / self.samples.x;
        [
            outwards * pow(share, self.alpha - 1.0),
            TAU * radius / self.samples.y,
        ]
    }

    /// Lengths outwards and around \[px\] of a sample's cell about lattice x: r(x + ½) − r(x − ½), and
    /// 2πr/n_y. Unlike a step's they are finite everywhere: within half a step of the gaze it is the first
    /// sample's cell.
    pub fn cell_lengths(&self, x: f64) -> [f64; 2] {
        let middle = x.max(0.5);
        [
            self.radius(middle + 0.5) - self.radius(middle - 0.5),
            TAU * self.radius(x) / self.samples.y,
        ]
    }

    /// The distance \[px\] from which on samples are sparser than pixels: where
    /// ρ(r) = n_x·n_y/(2π·α·L·r²)·(ln r/L)^(1/α − 1) falls to 1 for the last time; 0 if it is less
    /// everywhere, and the farthest corner's if it is not.
    pub fn dense_within(&self) -> f64 {
        let kernel = 1.0 / self.alpha - 1.0;
        let all = self.samples.element_product() / (TAU * self.alpha * self.log_reach);
        // ln ρ over l = ln r, which falls from its peak on.
        let log_density = |l: f64| log(all) + kernel * log(l / self.log_reach) - 2.0 * l;
        let (mut near, mut far) = ((kernel / 2.0).max(0.0), self.log_reach);
        if log_density(far) >= 0.0 {
            return exp(far);
        }
        if near > 0.0 && (near >= far || log_density(near) < 0.0) {
            return 0.0;
        }
        // Bisection until the two are neighbouring numbers.
        let mut middle = (near + far) / 2.0;
        while middle > near && middle < far {
            if log_density(middle) >= 0.0 {
                near = middle;
            } else {
                far = middle;
            }
            middle = (near + far) / 2.0;
        }
        exp(near)
    }

    /// Display pixels per lattice step (see [`Map::steps`](super::Map::steps)).
    pub fn steps(&self, p: DVec2) -> DMat2 {
        let [outwards, around] = self.step_lengths(p.x);
        let direction = self.direction(p.y);
        DMat2::from_cols(outwards * direction, around * direction.perp())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn about(x: f64, y: f64, alpha: f64) -> LogPolar {
        let (display, samples) = (UVec2::new(1280, 1440), DVec2::new(1280.0, 1440.0));
        LogPolar::new(DVec2::new(x, y), display, alpha, samples / 1.8).unwrap()
    }

    proptest! {
        /// There and back to 1e-9 px: relative errors of ε in x/n_x become α·L·ε·r pixels, 4e-10 at the
        /// far end of all.
        #[test]
        fn the_inverse_inverts(
            gx in -2000.0f64..4000.0, gy in -2000.0f64..4000.0, x in 0.0f64..1280.0, y in 0.0f64..1440.0,
            log_alpha in -3.0f64..3.0,
        ) {
            let map = about(gx, gy, log_alpha.exp());
            let p = DVec2::new(x, y);
            prop_assume!(p.distance(map.gaze_px()) > 1.0);
            let lattice = map.lattice_from_display(p);
            prop_assert!((0.0..=map.samples().x * (1.0 + 1e-12)).contains(&lattice.x));
            prop_assert!((0.0..map.samples().y).contains(&lattice.y));
            prop_assert!(map.display_from_lattice(lattice).distance(p) < 1e-9);
        }

        #[test]
        fn steps_are_the_derivative(
            x in 1.0f64..700.0, y in 0.0f64..800.0, log_alpha in -1.5f64..1.5,
        ) {
            let map = about(600.0, 800.0, log_alpha.exp());
            let (p, h) = (DVec2::new(x, y), 1e-5);
            let step = |d: DVec2| {
                (map.display_from_lattice(p + d) - map.display_from_lattice(p - d)) / (2.0 * h)
            };
            let found = DMat2::from_cols(step(DVec2::X * h), step(DVec2::Y * h));
            let error = (found - map.steps(p)).to_cols_array().map(f64::abs);
            let size = map.steps(p).to_cols_array().map(f64::abs).into_iter().fold(0.0, f64::max);
            prop_assert!(error.into_iter().all(|e| e < 1e-6 * size + 1e-5), "{error:?} of {size}");
        }
    }

    /// At the gaze, on one pixel, with kernels of any steepness: finite, and on the first ring.
    #[test]
    fn edge_cases_are_finite() {
        for alpha in [0.01, 0.05, 0.25, 1.0, 4.0, 20.0, 100.0] {
            for size in [UVec2::ONE, UVec2::new(1, 4000), UVec2::new(1279, 1441)] {
                for gaze in [DVec2::ZERO, size.as_dvec2() / 2.0, DVec2::new(-5e3, 9e5)] {
                    let map = LogPolar::new(gaze, size, alpha, DVec2::new(3.0, 5.0)).unwrap();
                    let at = map.lattice_from_display(gaze);
                    assert_eq!(at, DVec2::ZERO);
                    assert_eq!(map.display_from_lattice(at), gaze + DVec2::X);
                    for p in [DVec2::ZERO, size.as_dvec2(), DVec2::new(0.5, 0.5)] {
                        assert!(map.lattice_from_display(p).is_finite());
                    }
                    let steps = map.step_lengths(0.5);
                    assert!(
                        steps.iter().all(|s| s.is_finite() && *s >= 0.0),
                        "{steps:?}"
                    );
                }
            }
        }
        let bad =
            |gaze, alpha, samples| LogPolar::new(gaze, UVec2::new(8, 8), alpha, samples).is_err();
        assert!(bad(DVec2::NAN, 1.0, DVec2::ONE) && bad(DVec2::ZERO, 0.0, DVec2::ONE));
        assert!(bad(DVec2::ZERO, f64::NAN, DVec2::ONE) && bad(DVec2::ZERO, 1.0, DVec2::ZERO));
    }
}
