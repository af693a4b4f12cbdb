use glam::{DVec2, DVec3};

use crate::error::in_range;
use crate::math::{atan_deg, tan_deg};
use crate::{Acuity, GazeDirection, ModelError, Viewport};

/// An image plane one unit in front of the eye whose pixel counts need not be whole: a display as
/// the closed forms see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screen {
    tan: [f64; 4],
    pixel_tan: DVec2,
}

impl Screen {
    /// A flat screen seen from in front of its centre: `width_px` square pixels (D* in Guenter 2012)
    /// to `half_width_tan` (W/2V) on either side, `aspect` (α) times as high as wide.
    ///
    /// # Errors
    /// If the width is not from 1 to 1e9 pixels, the half-width not from 1e-6 to 1e6, or the aspect
    /// not from 0.001 to 1,000.
    pub fn planar(width_px: f64, half_width_tan: f64, aspect: f64) -> Result<Self, ModelError> {
        in_range("width [px]", width_px, 1.0..=1e9)?;
        in_range("half-width over distance", half_width_tan, 1e-6..=1e6)?;
        in_range("aspect (height over width)", aspect, 1e-3..=1e3)?;
        let (half, up) = (half_width_tan, half_width_tan * aspect);
        Ok(Self {
            tan: [-half, half, up, -up],
            pixel_tan: DVec2::splat(2.0 * half_width_tan / width_px),
        })
    }

    /// A flat screen that fills `fov_h_deg` and is as sharp at its centre as `fraction` of the
    /// fovea: ω* = ω₀/fraction, D* = 2·(W/V)/tan ω* (Guenter 2012, Eq. 9 has fraction 1).
    ///
    /// # Errors
    /// If the field of view is not above 0 and below 180 degrees, the fraction not from 0.001 to
    /// 1,000, or as [`Screen::planar`].
    pub fn from_sharpness(
        fov_h_deg: f64,
        acuity: Acuity,
        fraction: f64,
        aspect: f64,
    ) -> Result<Self, ModelError> {
        let half = Self::half_width_tan(fov_h_deg)?;
        in_range("sharpness (fraction of foveal)", fraction, 1e-3..=1e3)?;
        let omega = acuity.omega_0_deg() / fraction;
        in_range("display sharpness omega* [deg/cycle]", omega, 0.0..=80.0)?;
        Self::planar(4.0 * half / tan_deg(omega), half, aspect)
    }

    /// tan(FOV/2) of a flat screen.
    ///
    /// # Errors
    /// If the field of view is not above 0 and below 180 degrees.
    pub fn half_width_tan(fov_h_deg: f64) -> Result<f64, ModelError> {
        if fov_h_deg > 0.0 && fov_h_deg < 180.0 {
            Ok(tan_deg(fov_h_deg / 2.0))
        } else {
            let valid = "above 0 and below 180 degrees for a planar display";
            Err(ModelError::range("field of view [deg]", fov_h_deg, valid))
        }
    }

    /// Tangents of the left, right, upper and lower edge.
    pub fn tan(&self) -> [f64; 4] {
        self.tan
    }

    /// Tangent units per pixel, horizontally and vertically.
    pub fn pixel_tan(&self) -> DVec2 {
        self.pixel_tan
    }

    /// Pixels, width and height.
    pub fn size_px(&self) -> DVec2 {
        let [left, right, up, down] = self.tan;
        DVec2::new(right - left, up - down) / self.pixel_tan
    }

    /// Pixels in all.
    pub fn pixels(&self) -> f64 {
        let size = self.size_px();
        size.x * size.y
    }

    /// ω*, the angle of two pixels straight ahead \[deg/cycle\] (Guenter 2012, Eq. 7), along the axis
    /// on which pixels are larger: a scale that the eye cannot see there, it cannot see on the other.
    pub fn sharpness_deg(&self) -> f64 {
        atan_deg(2.0 * self.pixel_tan.max_element())
    }

    /// e*, the angle from the axis to the farthest edge along either axis \[deg\].
    pub fn reach_deg(&self) -> f64 {
        self.tan
            .iter()
            .map(|t| atan_deg(t.abs()))
            .fold(0.0, f64::max)
    }

    /// The angle from `gaze` (eye frame) to the farthest of the points beside, above and below it on
    /// the screen's edges \[deg\]; with gaze along the axis of a planar display that is e*.
    pub fn reach_from_deg(&self, gaze: GazeDirection) -> f64 {
        let [left, right, up, down] = self.tan;
        let d = gaze.vector();
        // A gaze off the screen counts from the screen's nearest point.
        let (x, y) = if d.z < 0.0 {
            (d.x / -d.z, d.y / -d.z)
        } else {
            (d.x, d.y)
        };
        let (x, y) = (x.clamp(left, right), y.clamp(down, up));
        let edges = [(left, y), (right, y), (x, up), (x, down)];
        let angle = |(x, y): (f64, f64)| {
            GazeDirection::from_vector(DVec3::new(x, y, -1.0)).angle_to_deg(gaze)
        };
        edges.into_iter().map(angle).fold(0.0, f64::max)
    }

    /// Horizontal and vertical field of view \[deg\].
    pub fn fov_deg(&self) -> DVec2 {
        let [left, right, up, down] = self.tan.map(atan_deg);
        DVec2::new(right - left, up - down)
    }

    /// The point of the screen nearest the axis, in tangents, for which layers are designed.
    pub(super) fn design_point(&self) -> DVec2 {
        let [left, right, up, down] = self.tan;
        DVec2::new(0f64.clamp(left, right), 0f64.clamp(down, up))
    }

    /// Where a direction (eye frame) meets the screen \[px\], or else the place on its edge nearest to
    /// where it meets the image plane. From 90° on, where it does not, it counts as just below.
    pub(super) fn nearest_px(&self, d: DVec3) -> DVec2 {
        let [left, _, up, _] = self.tan;
        let at = DVec2::new(d.x, d.y) / (-d.z).max(1e-9);
        let px = DVec2::new(at.x - left, up - at.y) / self.pixel_tan;
        px.clamp(DVec2::ZERO, self.size_px())
    }

    /// The direction through pixel position `px`, with z = −1 (not normalised), eye frame.
    pub fn direction(&self, px: DVec2) -> DVec3 {
        let step = self.pixel_tan;
        DVec3::new(
            self.tan[0] + step.x * px.x,
            self.tan[2] - step.y * px.y,
            -1.0,
        )
    }

    /// Where a direction (eye frame) meets the image plane, in pixels; `None` from 90° on.
    pub fn project(&self, d: DVec3) -> Option<DVec2> {
        let (x, y) = (d.x / -d.z, d.y / -d.z);
        let px = DVec2::new(x - self.tan[0], self.tan[2] - y) / self.pixel_tan;
        (d.z < 0.0).then_some(px)
    }
}

impl From<&Viewport> for Screen {
    fn from(viewport: &Viewport) -> Self {
        Self {
            tan: viewport.tan,
            pixel_tan: viewport.pixel_tan(),
        }
    }
}
