use glam::{DMat2, DVec2, UVec2};
use serde::{Deserialize, Serialize};

use crate::ModelError;
use crate::error::{above, in_range};
use crate::math::{hypot, sqrt};

/// A lens between panel and eye, as people write it (TOML).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LensSpec {
    /// k₁ and k₂ of 1 + k₁·r² + k₂·r⁴.
    pub coefficients: [f64; 2],
    /// Where the lens's axis meets the image, as shares of its width and height.
    #[serde(default = "middle")]
    pub centre: [f64; 2],
    /// The radius r = 1, in half widths of the image.
    #[serde(default = "one")]
    pub radius: f64,
    /// How much larger red, green and blue are seen.
    #[serde(default = "alike")]
    pub chromatic: [f64; 3],
}

fn middle() -> [f64; 2] {
    [0.5; 2]
}

fn one() -> f64 {
    1.0
}

fn alike() -> [f64; 3] {
    [1.0; 3]
}

impl LensSpec {
    /// The other eye's.
    #[must_use]
    pub fn mirrored(self) -> Self {
        let [x, y] = self.centre;
        Self {
            centre: [1.0 - x, y],
            ..self
        }
    }

    /// The lens over an image of `image_px`.
    ///
    /// # Errors
    /// As [`Lens::new`].
    pub fn over(&self, image_px: UVec2) -> Result<Lens, ModelError> {
        let size = image_px.as_dvec2();
        let [x, y] = self.centre;
        in_range("lens.centre x", x, 0.0..=1.0)?;
        in_range("lens.centre y", y, 0.0..=1.0)?;
        above("lens.radius", self.radius, 0.0, 1e3)?;
        let (centre, unit) = (DVec2::new(x, y) * size, self.radius * size.x / 2.0);
        Lens::new(centre, unit, self.coefficients, self.chromatic, image_px)
    }
}

/// What a lens does to an image: light from the panel at distance r from the axis is seen at
///
/// r·(1 + k₁·r² + k₂·r⁴),
///
/// r in units of a given number of pixels (the radial terms of Brown 1966; k > 0 is a pincushion). So the
/// renderer, which asks where the light of a panel pixel is seen, needs the polynomial itself, and only
/// where something seen lights on the panel takes its inverse.
///
/// Colours differ by a factor each. They are rendered together, for a factor of 1, and moved apart at the
/// end: see [`Lens::source_of`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    centre_px: DVec2,
    unit_px: f64,
    coefficients: [f64; 2],
    chromatic: [f64; 3],
    /// Up to this r the polynomial grows.
    grows_to: f64,
}

/// Radii beyond it are never on an image.
const FARTHEST: f64 = 1e6;

impl Lens {
    /// Its axis through `centre_px`, r = 1 at `unit_px` pixels, k₁ and k₂ in `coefficients`, and a factor
    /// for each of red, green and blue, over an image of `image_px`.
    ///
    /// # Errors
    /// If a number is out of range, or the polynomial does not grow as far as to the image's farthest
    /// corner: then two places of the panel would be seen at one.
    pub fn new(
        centre_px: DVec2,
        unit_px: f64,
        coefficients: [f64; 2],
        chromatic: [f64; 3],
        image_px: UVec2,
    ) -> Result<Self, ModelError> {
        in_range("lens centre x [px]", centre_px.x, -1e6..=1e6)?;
        in_range("lens centre y [px]", centre_px.y, -1e6..=1e6)?;
        above("lens unit [px]", unit_px, 0.0, 1e6)?;
        for k in coefficients {
            in_range("lens coefficient", k, -1e3..=1e3)?;
        }
        for factor in chromatic {
            in_range("chromatic factor of a lens", factor, 0.5..=2.0)?;
        }
        let lens = Self {
            centre_px,
            unit_px,
            coefficients,
            chromatic,
            grows_to: grows_to(coefficients),
        };
        let farthest = centre_px.abs().max((image_px.as_dvec2() - centre_px).abs());
        let corner = hypot(farthest.x, farthest.y) / unit_px;
        if corner >= lens.grows_to {
            let valid = format!(
                "such that r·(1 + k₁·r² + k₂·r⁴) grows to the farthest corner, r = {corner}; it does to {}",
                lens.grows_to
            );
            let value = format!("{coefficients:?}");
            return Err(ModelError::range("lens coefficients", value, valid));
        }
        Ok(lens)
    }

    /// Over the part of the image that begins at pixel `first`, at `n` pixels for each of the whole's.
    #[must_use]
    pub fn of_part(&self, first: DVec2, n: f64) -> Self {
        Self {
            centre_px: (self.centre_px - first) * n,
            unit_px: self.unit_px * n,
            ..*self
        }
    }

    /// The same lens for light of one colour.
    #[must_use]
    pub fn without_colours(self) -> Self {
        Self {
            chromatic: [1.0; 3],
            ..self
        }
    }

    /// Where its axis meets the image \[px\].
    pub fn centre_px(&self) -> DVec2 {
        self.centre_px
    }

    /// The pixels of r = 1.
    pub fn unit_px(&self) -> f64 {
        self.unit_px
    }

    /// k₁ and k₂.
    pub fn coefficients(&self) -> [f64; 2] {
        self.coefficients
    }

    /// How much larger red, green and blue are seen.
    pub fn chromatic(&self) -> [f64; 3] {
        self.chromatic
    }

    /// The r up to which the polynomial grows and has an inverse; infinite if it always does.
    pub fn grows_to(&self) -> f64 {
        self.grows_to
    }

    /// Where light from panel radius `r` is seen.
    pub fn seen_radius(&self, r: f64) -> f64 {
        r * self.growth(r)
    }

    /// The panel radius whose light is seen at radius `seen`; `None` where no light is seen.
    ///
    /// Newton's method from `seen`, held within a bracket that each step narrows, so that it always ends; the
    /// result is within 4 ε of the inverse, relatively, where the polynomial is not flat.
    pub fn panel_radius(&self, seen: f64) -> Option<f64> {
        let end = self.grows_to.min(FARTHEST);
        if !(0.0..=self.seen_radius(end)).contains(&seen) {
            return None;
        }
        let (mut low, mut high) = (0.0, end);
        let mut r = seen.min(end);
        // Halving alone would need 53 steps, and more only near 0, where Newton's are exact.
        for _ in 0..100 {
            let excess = self.seen_radius(r) - seen;
            if excess > 0.0 {
                high = r;
            } else {
                low = r;
            }
            let newton = r - excess / self.slope(r);
            let next = match newton > low && newton < high {
                true => newton,
                false if excess == 0.0 => r,
                false => low + (high - low) / 2.0,
            };
            if (next - r).abs() <= f64::EPSILON * r {
                return Some(next);
            }
            r = next;
        }
        Some(r)
    }

    /// Panel position \[px\] to where its light is seen: the image position of its ray \[px\].
    pub fn ray_from_display(&self, px: DVec2) -> DVec2 {
        let away = px - self.centre_px;
        // Added to px, a lens that does nothing does nothing to the bit.
        px + away * (self.growth(hypot(away.x, away.y) / self.unit_px) - 1.0)
    }

    /// The panel position whose light is seen at a place; `None` where none is.
    pub fn display_from_ray(&self, px: DVec2) -> Option<DVec2> {
        let away = px - self.centre_px;
        let seen = hypot(away.x, away.y) / self.unit_px;
        let r = self.panel_radius(seen)?;
        Some(match seen > 0.0 {
            true => px + away * (r / seen - 1.0),
            false => px,
        })
    }

    /// Where the light of one colour (0 red, 1 green, 2 blue) of a panel position is seen.
    ///
    /// # Panics
    /// If there is no such colour.
    pub fn ray_of_colour(&self, colour: usize, px: DVec2) -> DVec2 {
        let ray = self.ray_from_display(px);
        ray + (ray - self.centre_px) * (self.chromatic[colour] - 1.0)
    }

    /// Where a picture that was rendered for [`Lens::ray_from_display`] holds what one colour of panel
    /// position `px` is to show; `None` where it cannot hold it.
    ///
    /// # Panics
    /// If there is no such colour.
    pub fn source_of(&self, colour: usize, px: DVec2) -> Option<DVec2> {
        match self.chromatic[colour] == 1.0 {
            true => Some(px),
            false => self.display_from_ray(self.ray_of_colour(colour, px)),
        }
    }

    /// Image pixels per panel pixel (the Jacobian of [`Lens::ray_from_display`]; columns are steps along
    /// x and y).
    pub fn steps(&self, px: DVec2) -> DMat2 {
        let away = px - self.centre_px;
        let r = hypot(away.x, away.y) / self.unit_px;
        let growth = self.growth(r);
        let plain = DMat2::from_diagonal(DVec2::splat(growth));
        if r == 0.0 {
            return plain;
        }
        let along = away / (r * self.unit_px);
        let more = along * (self.slope(r) - growth);
        plain + DMat2::from_cols(more * along.x, more * along.y)
    }

    /// 1 + k₁·r² + k₂·r⁴.
    fn growth(&self, r: f64) -> f64 {
        let ([k1, k2], q) = (self.coefficients, r * r);
        1.0 + q * (k1 + q * k2)
    }

    /// The polynomial's derivative.
    fn slope(&self, r: f64) -> f64 {
        let ([k1, k2], q) = (self.coefficients, r * r);
        1.0 + q * (3.0 * k1 + q * 5.0 * k2)
    }
}

/// The first r > 0 at which r·(1 + k₁·r² + k₂·r⁴) stops growing: of 1 + 3k₁·q + 5k₂·q², q = r², the smallest
/// positive root, in the form that does not cancel.
fn grows_to([k1, k2]: [f64; 2]) -> f64 {
    let (a, b) = (5.0 * k2, 3.0 * k1);
    let square = b * b - 4.0 * a;
    if square < 0.0 {
        return f64::INFINITY;
    }
    let half = -(b + sqrt(square).copysign(b)) / 2.0;
    let roots = [half / a, 1.0 / half];
    let first = roots.into_iter().filter(|q| *q > 0.0);
    sqrt(first.fold(f64::INFINITY, f64::min))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn lens(k1: f64, k2: f64) -> Result<Lens, ModelError> {
        let spec = LensSpec {
            coefficients: [k1, k2],
            centre: [0.45, 0.52],
            radius: 1.0,
            chromatic: [0.99, 1.0, 1.015],
        };
        spec.over(UVec2::new(1280, 1440))
    }

    proptest! {
        #[test]
        fn the_inverse_inverts(
            k1 in -0.1f64..0.5, k2 in 0.0f64..0.5, x in 0.0f64..1280.0, y in 0.0f64..1440.0,
        ) {
            let (lens, p) = (lens(k1, k2).unwrap(), DVec2::new(x, y));
            let ray = lens.ray_from_display(p);
            prop_assert!(lens.display_from_ray(ray).unwrap().distance(p) < 1e-9);
            for colour in 0..3 {
                let source = lens.source_of(colour, p).unwrap();
                let back = lens.ray_from_display(source).distance(lens.ray_of_colour(colour, p));
                prop_assert!(back < 1e-9, "{colour}: {back}");
            }
        }

        #[test]
        fn steps_are_the_derivative(
            k1 in -0.1f64..0.5, k2 in 0.0f64..0.5, x in 0.0f64..1280.0, y in 0.0f64..1440.0,
        ) {
            let (lens, p, h) = (lens(k1, k2).unwrap(), DVec2::new(x, y), 1e-3);
            let step = |d: DVec2| (lens.ray_from_display(p + d) - lens.ray_from_display(p - d)) / (2.0 * h);
            let found = DMat2::from_cols(step(DVec2::X * h), step(DVec2::Y * h));
            let error = (found - lens.steps(p)).to_cols_array();
            prop_assert!(error.into_iter().all(|e| e.abs() < 1e-6), "{error:?}");
        }

        /// Anything that can be built ends, and ends where it should; anything else says so.
        #[test]
        fn any_coefficients(k1 in -10.0f64..10.0, k2 in -10.0f64..10.0, share in 0.0f64..1.0) {
            let made = Lens::new(DVec2::ZERO, 100.0, [k1, k2], [1.0; 3], UVec2::ONE);
            // The farthest corner is at r = 0.014, which all of these reach.
            let lens = made.unwrap();
            let r = share * lens.grows_to().min(50.0);
            let seen = lens.seen_radius(r);
            let back = lens.panel_radius(seen).unwrap();
            // Where it is flat, the place is uncertain and what is seen is not.
            let error = (lens.seen_radius(back) - seen).abs();
            prop_assert!(error <= 1e-14 * (seen + r * (1.0 + k1.abs() * r * r + k2.abs() * r * r * r * r)), "{error}");
        }
    }

    #[test]
    fn a_lens_that_folds_is_refused() {
        let error = lens(-0.35, 0.0).unwrap_err().to_string();
        assert!(
            error.contains("grows to the farthest corner, r = 1.6"),
            "{error}"
        );
        assert!(lens(f64::NAN, 0.0).is_err() && lens(0.0, f64::INFINITY).is_err());
        let alone = lens(-0.1, 0.0).unwrap();
        assert!((alone.grows_to() - (1.0f64 / 0.3).sqrt()).abs() < 1e-15);
        assert_eq!(
            alone.panel_radius(alone.seen_radius(alone.grows_to()) + 1e-9),
            None
        );
        assert_eq!(alone.panel_radius(f64::NAN), None);
        assert_eq!(alone.panel_radius(-1.0), None);
        assert_eq!(lens(0.22, 0.24).unwrap().grows_to(), f64::INFINITY);
    }

    #[test]
    fn no_lens_to_the_bit() {
        let none = lens(0.0, 0.0).unwrap();
        let p = DVec2::new(1234.567, 0.1);
        assert_eq!(none.ray_from_display(p), p);
        assert_eq!(none.display_from_ray(p), Some(p));
        assert_eq!(none.steps(p), DMat2::IDENTITY);
    }
}
