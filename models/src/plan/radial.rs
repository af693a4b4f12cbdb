use glam::{DMat2, DVec2, UVec2};

use super::{Affine, Falloff};
use crate::ModelError;
use crate::error::{above, in_range};
use crate::math::hypot;

/// A buffer that magnifies the fovea (Friston 2019, §3.1.1): with b = origin + lattice/scale the position in
/// the buffer in display pixels, a = b − gaze, and s the length of a as a share of the reach,
///
/// display = gaze + a·p(s)/s.
///
/// For p(s) = s^k that is d_u = R·(d_b/R)^k. The paper's text has the directions swapped; this is the one
/// that magnifies the fovea, and its γ = 2 is k = 2. Distances are in pixels, where the paper has the same
/// in units of half the image along each axis.
///
/// A step outwards is p′(s) display pixels over the scale, one around p(s)/s; with [`Reach::Boundary`]
/// a step around also goes outwards where the boundary recedes. With p(s) = s and scale 1 it is the identity to
/// the bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Radial {
    gaze_px: DVec2,
    display_px: DVec2,
    falloff: Falloff,
    reach: Reach,
    /// The reach in pixels of all directions, but for the boundary.
    radius: f64,
    /// Buffer position of lattice position 0, 0.
    origin: DVec2,
    scale: f64,
}

/// The distance on which buffer and display agree.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Reach {
    /// To the farthest corner (the paper). The display's nearer edges then bulge out of a buffer of its size, to
    /// 1.19 of it for k = 2 and a gaze in the middle of a square, so the buffer is larger (the paper cuts them off);
    /// what of its corners is mapped beyond the display is never shaded.
    Corner,
    /// To the display's boundary in each direction: the whole buffer, as large as the display, is on the
    /// display.
    Boundary,
    /// A distance in pixels.
    Px(f64),
}

/// Reaches are at least so long \[px\].
const LEAST_REACH_PX: f64 = 0.5;
/// Less than this share of the display's side beside the gaze is nothing beside it.
const ROUNDING: f64 = 1e-13;

impl Radial {
    /// About `gaze_px` on a display of `display_px` pixels, with `scale` lattice steps per pixel of the
    /// buffer.
    ///
    /// # Errors
    /// If the gaze is not on the display or its edge, the falloff's exponent not from 1 to 16, a reach not
    /// from 0.5 to 1e6 pixels, or the scale not above 0 and at most 64.
    pub fn new(
        gaze_px: DVec2,
        display_px: UVec2,
        falloff: Falloff,
        reach: Reach,
        scale: f64,
    ) -> Result<Self, ModelError> {
        Self::over(gaze_px, display_px.as_dvec2(), falloff, reach, scale)
    }

    /// The same on a display whose pixel counts may be fractions.
    pub(crate) fn over(
        gaze_px: DVec2,
        size: DVec2,
        falloff: Falloff,
        reach: Reach,
        scale: f64,
    ) -> Result<Self, ModelError> {
        in_range("gaze x [px]", gaze_px.x, 0.0..=size.x)?;
        in_range("gaze y [px]", gaze_px.y, 0.0..=size.y)?;
        above("scale of a radial map", scale, 0.0, 64.0)?;
        if let Falloff::Power(k) = falloff {
            Falloff::power(k)?;
        }
        let radius = match reach {
            Reach::Px(px) => in_range("reach [px]", px, LEAST_REACH_PX..=1e6)?,
            Reach::Corner | Reach::Boundary => {
                let farthest = gaze_px.max(size - gaze_px);
                hypot(farthest.x, farthest.y).max(LEAST_REACH_PX)
            }
        };
        let mut map = Self {
            gaze_px,
            display_px: size,
            // Straight lines of slope 1 would be exact but for rounding.
            falloff: match falloff.is_identity() {
                true => Falloff::Power(1.0),
                false => falloff,
            },
            reach,
            radius,
            origin: DVec2::ZERO,
            scale,
        };
        map.origin = map.buffer_edge(-gaze_px);
        Ok(map)
    }

    /// The display position about which it is laid.
    pub fn gaze_px(&self) -> DVec2 {
        self.gaze_px
    }

    /// How distances grow outwards.
    pub fn falloff(&self) -> Falloff {
        self.falloff
    }

    /// On which distance buffer and display agree.
    pub fn reach(&self) -> Reach {
        self.reach
    }

    /// The reach in pixels of all directions; to the farthest corner for [`Reach::Boundary`], which differs by direction.
    pub fn reach_px(&self) -> f64 {
        self.radius
    }

    /// Lattice steps per pixel of the buffer.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The lattice position of the gaze.
    pub fn gaze(&self) -> DVec2 {
        self.unmagnified(self.gaze_px)
    }

    /// The lattice that holds the whole display.
    pub fn lattice(&self) -> UVec2 {
        let end = self.buffer_edge(self.display_px - self.gaze_px);
        // A touch of a further step is no step.
        (self.unmagnified(end) - 1e-9)
            .ceil()
            .max(DVec2::ONE)
            .as_uvec2()
    }

    /// The same map if it is a plain one, so that it costs no more than a plain one.
    pub fn as_affine(&self) -> Option<Affine> {
        self.falloff.is_identity().then(|| Affine {
            origin: self.origin,
            scale: DVec2::splat(1.0 / self.scale),
        })
    }

    /// Lattice position to display pixels.
    pub fn display_from_lattice(&self, p: DVec2) -> DVec2 {
        let b = self.origin + p / self.scale;
        let away = b - self.gaze_px;
        match self.share(away) {
            // Added to b, nothing is to the bit nothing.
            Some(s) => b + away * (self.falloff.ratio(s) - 1.0),
            None => b,
        }
    }

    /// Display pixels to lattice position.
    pub fn lattice_from_display(&self, p: DVec2) -> DVec2 {
        self.unmagnified(self.buffer_from_display(p))
    }

    /// The lattice position of a display position if nothing were magnified.
    pub fn unmagnified(&self, p: DVec2) -> DVec2 {
        (p - self.origin) * self.scale
    }

    /// Where in the buffer the display's edges `away` from the gaze along x and y end: of each edge the place
    /// nearest the gaze is farthest out.
    fn buffer_edge(&self, away: DVec2) -> DVec2 {
        let at = |axis: DVec2| self.buffer_from_display(self.gaze_px + axis * away);
        DVec2::new(at(DVec2::X).x, at(DVec2::Y).y)
    }

    fn buffer_from_display(&self, p: DVec2) -> DVec2 {
        let away = p - self.gaze_px;
        match self.share(away) {
            Some(s) if s > 0.0 => p + away * (self.falloff.inverse_ratio(s) - 1.0),
            _ => p,
        }
    }

    /// Display pixels per lattice step (see [`Map::steps`](super::Map::steps)).
    pub fn steps(&self, p: DVec2) -> DMat2 {
        let away = self.origin + p / self.scale - self.gaze_px;
        let plain = DMat2::from_diagonal(DVec2::splat(1.0 / self.scale));
        let Some(s) = self.share(away) else {
            return plain;
        };
        let ratio = self.falloff.ratio(s);
        if s == 0.0 {
            return plain * ratio;
        }
        // d(a·p(s)/s) = p/s·da + a/s·(p′ − p/s)·(∇s·da), ∇s by Euler's rule for a length.
        let outwards = away / s * (self.falloff.slope(s) - ratio);
        let grows = self.share_gradient(away);
        let column = |axis: DVec2| (ratio * axis + outwards * grows.dot(axis)) / self.scale;
        DMat2::from_cols(column(DVec2::X), column(DVec2::Y))
    }

    /// The length of `away` as a share of the reach in its direction; `None` where there is no reach: off
    /// the display from a gaze on its edge.
    fn share(&self, away: DVec2) -> Option<f64> {
        match self.reach {
            Reach::Corner | Reach::Px(_) => Some(hypot(away.x, away.y) / self.radius),
            Reach::Boundary => {
                let [x, y] = self.shares_of_boundary(away);
                Some(x.max(y)).filter(|s| s.is_finite())
            }
        }
    }

    /// Shares of the way to the vertical and to the horizontal edge ahead.
    fn shares_of_boundary(&self, away: DVec2) -> [f64; 2] {
        [0, 1].map(|axis| match away[axis] {
            // Beside a gaze on the edge there is no room: rounding must not put a place off the display.
            a if a.abs() <= ROUNDING * self.display_px[axis] => 0.0,
            a if a > 0.0 => a / (self.display_px[axis] - self.gaze_px[axis]),
            a if a < 0.0 => -a / self.gaze_px[axis],
            _ => 0.0,
        })
    }

    /// How the share grows per pixel.
    fn share_gradient(&self, away: DVec2) -> DVec2 {
        match self.reach {
            Reach::Corner | Reach::Px(_) => away / (hypot(away.x, away.y) * self.radius),
            Reach::Boundary => {
                let [x, y] = self.shares_of_boundary(away);
                // The share is linear towards an edge, so its slope is share over distance.
                match x >= y {
                    true => DVec2::X * (x / away.x),
                    false => DVec2::Y * (y / away.y),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::FalloffTable;

    fn falloff(k: f64) -> Falloff {
        match k < 1.0 {
            // Below 1 stands a table here.
            true => {
                let points = [[0.0, 0.0], [0.3, 0.06], [0.6, 0.3], [0.9, 0.8], [1.0, 1.0]];
                Falloff::Table(FalloffTable::new(&points).unwrap())
            }
            false => Falloff::power(k).unwrap(),
        }
    }

    fn map(gx: f64, gy: f64, k: f64, reach: Reach, scale: f64) -> Radial {
        let gaze = DVec2::new(gx * 1280.0, gy * 720.0);
        Radial::new(gaze, UVec2::new(1280, 720), falloff(k), reach, scale).unwrap()
    }

    fn reach(which: u8) -> Reach {
        [Reach::Corner, Reach::Boundary, Reach::Px(900.0)][usize::from(which)]
    }

    proptest! {
        #[test]
        fn the_inverse_inverts(
            gx in 0.0f64..=1.0, gy in 0.0f64..=1.0, x in 0.0f64..1280.0, y in 0.0f64..720.0,
            k in 0.5f64..5.0, which in 0u8..3, scale in 0.1f64..3.0,
        ) {
            let map = map(gx, gy, k, reach(which), scale);
            let p = DVec2::new(x, y);
            let lattice = map.lattice_from_display(p);
            prop_assert!(lattice.is_finite());
            prop_assert!(map.display_from_lattice(lattice).distance(p) < 1e-9);
        }

        #[test]
        fn steps_are_the_derivative(
            gx in 0.0f64..=1.0, gy in 0.0f64..=1.0, x in 0.0f64..1280.0, y in 0.0f64..720.0,
            k in 1.0f64..4.0, which in 0u8..3, scale in 0.3f64..2.0,
        ) {
            let map = map(gx, gy, k, reach(which), scale);
            let (p, h) = (DVec2::new(x, y) * scale, 1e-3);
            let away = map.origin + p / scale - map.gaze_px();
            let [sx, sy] = map.shares_of_boundary(away);
            // Where the boundary has a corner, the map has a crease.
            prop_assume!(which != 1 || ((sx - sy).abs() > 1e-2 && sx.max(sy) < 1.0));
            prop_assume!(away.length() > 0.1);
            let step = |d: DVec2| {
                (map.display_from_lattice(p + d) - map.display_from_lattice(p - d)) / (2.0 * h)
            };
            let found = DMat2::from_cols(step(DVec2::X * h), step(DVec2::Y * h));
            let error = (found - map.steps(p)).to_cols_array();
            prop_assert!(error.into_iter().all(|e| e.abs() < 1e-4), "{error:?}");
        }

        #[test]
        fn without_magnification_it_is_the_identity(
            gx in 0.0f64..=1.0, gy in 0.0f64..=1.0, x in -50.0f64..1500.0, y in -50.0f64..1500.0, which in 0u8..3,
        ) {
            let map = map(gx, gy, 1.0, reach(which), 1.0);
            let p = DVec2::new(x, y);
            prop_assert_eq!(map.display_from_lattice(p), p);
            prop_assert_eq!(map.lattice_from_display(p), p);
            prop_assert_eq!(map.as_affine(), Some(Affine::IDENTITY));
        }
    }

    #[test]
    fn the_boundary_stays_and_the_fovea_grows() {
        let map = map(0.2, 0.7, 2.0, Reach::Boundary, 1.0);
        for p in [DVec2::new(1280.0, 300.0), DVec2::new(5.0, 0.0), DVec2::ZERO] {
            assert!(map.display_from_lattice(p).distance(p) < 1e-9);
        }
        // A tenth of the way out, a step outwards is a fifth of a pixel and one around a tenth.
        let near = map.gaze_px() + DVec2::new(102.4, 0.0);
        let steps = map.steps(near);
        assert!((steps.x_axis - DVec2::new(0.2, 0.0)).length() < 1e-12);
        assert!((steps.y_axis - DVec2::new(0.0, 0.1)).length() < 1e-12);
        assert_eq!(map.steps(map.gaze_px()), DMat2::ZERO);
    }

    #[test]
    fn edge_cases_are_finite() {
        for size in [UVec2::ONE, UVec2::new(1, 4000), UVec2::new(1279, 1441)] {
            for share in [DVec2::ZERO, DVec2::ONE, DVec2::new(0.0, 0.5)] {
                for k in [1.0, 2.0, 16.0] {
                    for reach in [Reach::Corner, Reach::Boundary] {
                        let gaze = share * size.as_dvec2();
                        let map = Radial::new(gaze, size, falloff(k), reach, 0.7).unwrap();
                        for p in [
                            DVec2::ZERO,
                            DVec2::splat(-3.0),
                            size.as_dvec2() * 1.5,
                            gaze * 0.7,
                        ] {
                            assert!(map.display_from_lattice(p).is_finite());
                            assert!(map.lattice_from_display(p).is_finite());
                            assert!(map.steps(p).is_finite(), "{map:?} {p}");
                        }
                    }
                }
            }
        }
        let bad = |gaze: DVec2, k, reach, scale| {
            Radial::new(gaze, UVec2::new(8, 8), Falloff::Power(k), reach, scale).is_err()
        };
        let middle = DVec2::splat(4.0);
        assert!(bad(DVec2::splat(8.1), 2.0, Reach::Corner, 1.0));
        assert!(bad(DVec2::NAN, 2.0, Reach::Corner, 1.0));
        assert!(bad(middle, 0.5, Reach::Corner, 1.0) && bad(middle, f64::NAN, Reach::Corner, 1.0));
        assert!(bad(middle, 2.0, Reach::Px(0.0), 1.0) && bad(middle, 2.0, Reach::Corner, 0.0));
    }

    /// A gaze on the display's edge has no room beyond it; what rounding puts there is still magnified along the edge.
    #[test]
    fn places_along_the_edge_with_the_gaze_come_back() {
        let size = UVec2::new(48, 1054);
        let falloff = Falloff::power(11.765372109930606).unwrap();
        let scale = 5.8461866139613665;
        let map = Radial::new(size.as_dvec2(), size, falloff, Reach::Boundary, scale).unwrap();
        for k in 0..=1000 {
            let px = DVec2::new(48.0, 1.054 * f64::from(k));
            let back = map.display_from_lattice(map.lattice_from_display(px));
            assert!((back - px).length() < 1e-9, "{px} {back}");
        }
    }
}
