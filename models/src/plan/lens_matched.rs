use glam::{DMat2, DVec2};

use crate::ModelError;
use crate::error::{above, in_range};

/// Lens-matched shading: in each of four quadrants about a centre, clip space is warped by
/// w′ = w + A·|x| + B·|y| before the perspective divide (NVIDIA's Lens Matched Shading; Friston 2019, §6).
/// Lines stay lines within a quadrant, and the quadrants meet without a gap:
///
/// lattice − c = S·d / (1 + a·|d_x| + b·|d_y|), d = display − centre,
/// display − centre = l / (1 − a·|l_x| − b·|l_y|), l = (lattice − c)/S.
///
/// At the centre there are S lattice steps to the pixel: 1, unless [scaled](LensMatched::scaled).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensMatched {
    centre_px: DVec2,
    centre: DVec2,
    growth: DVec2,
    scale: f64,
}

/// What is left of w from where on a place counts as this far away: it is never on a display.
const LEAST_W: f64 = 1e-9;

impl LensMatched {
    /// Lattice position `centre` at display position `centre_px`; w grows by `growth` per pixel along x and
    /// y (a and b above).
    ///
    /// # Errors
    /// If a position is not within ±1e9, or a growth not from 0 to 1e6.
    pub fn new(centre_px: DVec2, centre: DVec2, growth: DVec2) -> Result<Self, ModelError> {
        for (position, x) in [("display", centre_px), ("lattice", centre)] {
            in_range(&format!("{position} centre x"), x.x, -1e9..=1e9)?;
            in_range(&format!("{position} centre y"), x.y, -1e9..=1e9)?;
        }
        in_range("growth of w along x [1/px]", growth.x, 0.0..=1e6)?;
        in_range("growth of w along y [1/px]", growth.y, 0.0..=1e6)?;
        Ok(Self {
            centre_px,
            centre,
            growth,
            scale: 1.0,
        })
    }

    /// The same with `scale` lattice steps to the pixel at the centre.
    ///
    /// # Errors
    /// If the scale is not above 0 and at most 64.
    pub fn scaled(self, scale: f64) -> Result<Self, ModelError> {
        let scale = above("scale of a lens-matched map", scale, 0.0, 64.0)?;
        Ok(Self { scale, ..self })
    }

    /// Lattice steps to the pixel at the centre.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The display position where the quadrants meet.
    pub fn centre_px(&self) -> DVec2 {
        self.centre_px
    }

    /// The lattice position where they meet.
    pub fn centre(&self) -> DVec2 {
        self.centre
    }

    /// How much w grows per display pixel along x and y.
    pub fn growth(&self) -> DVec2 {
        self.growth
    }

    /// Lattice position to display pixels. Positions beyond the horizon of a quadrant are very far away.
    pub fn display_from_lattice(&self, p: DVec2) -> DVec2 {
        let l = (p - self.centre) / self.scale;
        self.centre_px + l / self.remaining(l)
    }

    /// Display pixels to lattice position.
    pub fn lattice_from_display(&self, p: DVec2) -> DVec2 {
        let d = p - self.centre_px;
        self.centre + d / (1.0 + self.growth.dot(d.abs())) * self.scale
    }

    /// Display pixels per lattice step (see [`Map::steps`](super::Map::steps)).
    pub fn steps(&self, p: DVec2) -> DMat2 {
        let l = (p - self.centre) / self.scale;
        let w = self.remaining(l);
        let slope = self.growth * DVec2::new(1f64.copysign(l.x), 1f64.copysign(l.y));
        // d(l/w) = dl/w + l·(slope · dl)/w².
        DMat2::from_cols(
            (DVec2::X + l * slope.x / w) / w / self.scale,
            (DVec2::Y + l * slope.y / w) / w / self.scale,
        )
    }

    /// 1 − a·|l_x| − b·|l_y|, kept above zero.
    fn remaining(&self, l: DVec2) -> f64 {
        (1.0 - self.growth.dot(l.abs())).max(LEAST_W)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn map() -> LensMatched {
        let centre = DVec2::new(500.0, 300.0);
        LensMatched::new(DVec2::new(640.0, 720.0), centre, DVec2::new(1e-3, 2e-3)).unwrap()
    }

    proptest! {
        #[test]
        fn the_inverse_inverts(x in -100.0f64..1400.0, y in -100.0f64..1500.0, scale in 0.3f64..4.0) {
            let p = DVec2::new(x, y);
            let map = map().scaled(scale).unwrap();
            let lattice = map.lattice_from_display(p);
            prop_assert!(map.display_from_lattice(lattice).distance(p) < 1e-9);
        }

        #[test]
        fn steps_are_the_derivative(
            x in 1.0f64..200.0, y in 1.0f64..200.0, left: bool, up: bool, scale in 0.9f64..4.0,
        ) {
            let map = || map().scaled(scale).unwrap();
            let l = DVec2::new(if left { -x } else { x }, if up { -y } else { y });
            let (p, h) = (map().centre() + l, 1e-4);
            let step = |d: DVec2| {
                (map().display_from_lattice(p + d) - map().display_from_lattice(p - d)) / (2.0 * h)
            };
            let found = DMat2::from_cols(step(DVec2::X * h), step(DVec2::Y * h));
            let error = (found - map().steps(p)).to_cols_array();
            prop_assert!(error.into_iter().all(|e| e.abs() < 1e-6), "{error:?}");
        }
    }

    #[test]
    fn a_step_is_a_pixel_at_the_centre() {
        assert!(map().scaled(0.0).is_err() && map().scaled(f64::NAN).is_err());
        let at = map().steps(map().centre());
        assert_eq!(at, DMat2::IDENTITY);
        assert!(map().display_from_lattice(DVec2::splat(1e5)).is_finite());
    }
}
