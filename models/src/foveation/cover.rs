use glam::{DVec2, DVec3};

use super::Screen;
use crate::math::{asin, atan2, cos, hypot, sin, tan, tan_deg, to_rad};

/// Which rectangle of the screen a layer of half-angle e covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Coverage {
    /// The bounding box of the cone of half-angle e about the gaze: what is drawn. Off the axis it is
    /// larger than the paper's square.
    #[default]
    Exact,
    /// The square of side 2·tan e about the gaze point (Guenter 2012, Eq. 3 applied anywhere).
    Paper,
}

/// A rectangle in tangents; edges may be infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TanBox {
    pub(super) min: DVec2,
    pub(super) max: DVec2,
}

impl Coverage {
    /// The rectangle a layer of half-angle `e_deg` (below 90) covers about unit direction `gaze`;
    /// `None` if it does not reach the image plane.
    pub(super) fn rectangle(self, gaze: DVec3, e_deg: f64) -> Option<TanBox> {
        match self {
            Self::Exact => {
                let (x0, x1) = cone_edges(gaze.x, -gaze.z, to_rad(e_deg))?;
                let (y0, y1) = cone_edges(gaze.y, -gaze.z, to_rad(e_deg))?;
                Some(TanBox {
                    min: DVec2::new(x0, y0),
                    max: DVec2::new(x1, y1),
                })
            }
            Self::Paper => {
                let centre = DVec2::new(gaze.x, gaze.y) / -gaze.z;
                let half = DVec2::splat(tan_deg(e_deg));
                (gaze.z < 0.0).then(|| TanBox {
                    min: centre - half,
                    max: centre + half,
                })
            }
        }
    }
}

impl TanBox {
    /// The part on the screen, if any.
    pub(super) fn clipped(self, screen: &Screen) -> Option<Self> {
        let [left, right, up, down] = screen.tan();
        let min = self.min.max(DVec2::new(left, down));
        let max = self.max.min(DVec2::new(right, up));
        (min.cmplt(max).all()).then_some(Self { min, max })
    }

    /// Display pixels inside, in fractions.
    pub(super) fn pixels(self, screen: &Screen) -> f64 {
        let size = (self.max - self.min) / screen.pixel_tan();
        size.x * size.y
    }
}

/// Where a cone of half-angle `e` [rad] ends along one axis of the image plane, given its unit
/// direction's component along that axis and forwards. The planes that contain the other axis and
/// touch the cone stand at azimuth ± asin(sin e / ρ), ρ the direction's length within this axis and
/// forwards; a plane at 90° or more meets the image plane at infinity.
pub(super) fn cone_edges(along: f64, forward: f64, e: f64) -> Option<(f64, f64)> {
    const RIGHT_ANGLE: f64 = std::f64::consts::FRAC_PI_2;
    let rho = hypot(along, forward);
    let sine = sin(e) / rho;
    if e >= RIGHT_ANGLE || rho == 0.0 || sine >= 1.0 {
        return Some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let (azimuth, half) = (atan2(along, forward), asin(sine));
    let (low, high) = (azimuth - half, azimuth + half);
    if low >= RIGHT_ANGLE || high <= -RIGHT_ANGLE {
        return None;
    }
    let edge = |angle: f64| {
        if angle.abs() < RIGHT_ANGLE && cos(angle) > 0.0 {
            tan(angle)
        } else {
            f64::INFINITY.copysign(angle)
        }
    };
    Some((edge(low), edge(high)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::GazeDirection;

    proptest! {
        /// Every direction on the cone's rim that meets the image plane lies in the box, and the box
        /// is no larger than a dense walk along the rim finds.
        #[test]
        fn cone_box_is_tight(az in -60.0f64..60.0, el in -50.0f64..50.0, e in 0.1f64..25.0) {
            let gaze = GazeDirection::new(az, el).vector();
            let found = Coverage::Exact.rectangle(gaze, e).unwrap();
            let (u, v) = gaze.any_orthonormal_pair();
            let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
            for k in 0..4000 {
                let a = to_rad(f64::from(k) * 0.09);
                let d = gaze * cos(to_rad(e)) + (u * cos(a) + v * sin(a)) * sin(to_rad(e));
                prop_assume!(d.z < -0.02);
                let p = DVec2::new(d.x, d.y) / -d.z;
                (min, max) = (min.min(p), max.max(p));
            }
            let size = (found.max - found.min).max_element();
            prop_assert!((found.min - min).abs().max_element() < 1e-5 * size);
            prop_assert!((found.max - max).abs().max_element() < 1e-5 * size);
            prop_assert!((found.min - min).max_element() < 1e-9 && (max - found.max).max_element() < 1e-9);
        }
    }

    #[test]
    fn cones_beside_and_behind() {
        // Looking 90° to the side with 10°: nothing before azimuth 80°.
        let side = Coverage::Exact.rectangle(DVec3::X, 10.0).unwrap();
        assert!((side.min.x - tan_deg(80.0)).abs() < 1e-9 && side.max.x == f64::INFINITY);
        assert_eq!(Coverage::Exact.rectangle(DVec3::Z, 10.0), None);
        assert_eq!(Coverage::Paper.rectangle(DVec3::X, 10.0), None);
    }
}
