use glam::{DVec2, DVec3, UVec2};
use serde::{Deserialize, Serialize};

use crate::gaze::angle_deg;
use crate::math::{atan, atan_deg, hypot, sqrt, to_deg};
use crate::plan::Map;
use crate::raster::Sampling;
use crate::{GazeDirection, Lens, ModelError, PixelDensity, Pose, Rect, ScanSkew};

/// Whose image it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Eye {
    /// One image for both eyes.
    Cyclopean,
    /// The left eye's.
    Left,
    /// The right eye's.
    Right,
}

impl Eye {
    /// `cyclopean`, `left` or `right`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cyclopean => "cyclopean",
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

/// An image plane one unit in front of an eye: pixels spread evenly over tangents.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewport {
    /// Pixels, width × height.
    pub size: UVec2,
    /// Tangents of the left, right, upper and lower edge (left and lower are usually negative).
    pub tan: [f64; 4],
}

impl Viewport {
    /// An image plane with the given edges.
    ///
    /// # Errors
    /// If it has no pixels, or its edges are not finite and in order.
    pub fn new(size: UVec2, tan: [f64; 4]) -> Result<Self, ModelError> {
        let [left, right, up, down] = tan;
        if size.x == 0 || size.y == 0 || size.max_element() > 65_536 {
            let value = format!("{} x {}", size.x, size.y);
            return Err(ModelError::range(
                "viewport",
                value,
                "1 to 65536 pixels on each axis",
            ));
        }
        if !(tan.iter().all(|t| t.is_finite()) && left < right && down < up) {
            let valid = "finite tangents with left < right and down < up";
            return Err(ModelError::range(
                "viewport edges",
                format!("{tan:?}"),
                valid,
            ));
        }
        Ok(Self { size, tan })
    }

    /// Square pixels, straight ahead, `half_width_tan` to either side.
    ///
    /// # Errors
    /// As [`Viewport::new`].
    pub fn symmetric(size: UVec2, half_width_tan: f64) -> Result<Self, ModelError> {
        let half_height = half_width_tan * f64::from(size.y) / f64::from(size.x.max(1));
        Self::new(
            size,
            [-half_width_tan, half_width_tan, half_height, -half_height],
        )
    }

    /// Tangent units per pixel, horizontally and vertically.
    pub fn pixel_tan(&self) -> DVec2 {
        let [left, right, up, down] = self.tan;
        DVec2::new(
            (right - left) / f64::from(self.size.x),
            (up - down) / f64::from(self.size.y),
        )
    }

    /// The direction through pixel position `px`, with z = −1 (not normalised), eye frame.
    pub fn direction(&self, px: DVec2) -> DVec3 {
        let step = self.pixel_tan();
        DVec3::new(
            self.tan[0] + step.x * px.x,
            self.tan[2] - step.y * px.y,
            -1.0,
        )
    }

    /// Where a direction (eye frame) meets the image plane, in pixels; `None` from 90° on. The
    /// position may lie outside the image.
    pub fn project(&self, d: DVec3) -> Option<DVec2> {
        (d.z < 0.0).then(|| {
            let step = self.pixel_tan();
            let (tx, ty) = (d.x / -d.z, d.y / -d.z);
            DVec2::new((tx - self.tan[0]) / step.x, (self.tan[2] - ty) / step.y)
        })
    }

    /// Where the eye's axis meets the image plane \[px\].
    pub fn axis_px(&self) -> DVec2 {
        let step = self.pixel_tan();
        DVec2::new(-self.tan[0] / step.x, self.tan[2] / step.y)
    }

    /// The middle of the image \[px\].
    pub fn centre_px(&self) -> DVec2 {
        self.size.as_dvec2() / 2.0
    }

    /// The whole image.
    pub fn rect(&self) -> Rect {
        Rect {
            min: DVec2::ZERO,
            max: self.size.as_dvec2(),
        }
    }

    /// The angle between the ray through `px` and the unit direction `gaze`, eye frame \[deg\].
    pub fn eccentricity_deg(&self, px: DVec2, gaze: DVec3) -> f64 {
        angle_deg(self.direction(px), gaze)
    }

    /// Gaze through pixel position `px`, eye frame.
    pub fn gaze_at(&self, px: DVec2) -> GazeDirection {
        GazeDirection::from_vector(self.direction(px))
    }

    /// ω*, the angle of two pixels straight ahead \[deg/cycle\]: atan(2·pixel) (Guenter 2012, Eq. 7).
    pub fn sharpness_deg(&self) -> f64 {
        atan_deg(2.0 * self.pixel_tan().max_element())
    }

    /// Horizontal and vertical field of view \[deg\].
    pub fn fov_deg(&self) -> DVec2 {
        let [left, right, up, down] = self.tan;
        DVec2::new(
            to_deg(atan(right) - atan(left)),
            to_deg(atan(up) - atan(down)),
        )
    }

    /// Pixels per square degree at pixel position `px`: a pixel there covers
    /// `pixel area · cos³θ` of solid angle, θ from the axis.
    pub fn pixels_per_square_degree(&self, px: DVec2) -> f64 {
        let d = self.direction(px);
        let step = self.pixel_tan();
        let secant = hypot(1.0, hypot(d.x, d.y));
        let square_degrees =
            step.x * step.y / (secant * secant * secant) * to_deg(1.0) * to_deg(1.0);
        1.0 / square_degrees
    }

    /// Pixels per degree at the centre, on average, and at the least sharp place.
    pub fn pixel_density(&self) -> PixelDensity {
        let step = self.pixel_tan();
        // Along x, a tangent step dx turns the ray by dx·√(1+y²)/(1+x²+y²): least dense nearest the axis.
        let d = self.direction(self.axis_px().clamp(DVec2::ZERO, self.size.as_dvec2()));
        let square = 1.0 + d.x * d.x + d.y * d.y;
        let along_x = square / (to_deg(step.x) * sqrt(1.0 + d.y * d.y));
        let along_y = square / (to_deg(step.y) * sqrt(1.0 + d.x * d.x));
        PixelDensity {
            centre: 1.0 / to_deg(step.x),
            mean: f64::from(self.size.x) / self.fov_deg().x,
            min: along_x.min(along_y),
        }
    }
}

/// All that a renderer must know about one image: whose it is, through what, and from where.
///
/// `poses` are `world_from_eye` at the scan's start and end. They are equal for a
/// still view; a renderer that cannot draw a moving one must refuse it. [`Sampling`](crate::raster::Sampling) puts scan, lens
/// and the map of a pass together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Whose image.
    pub eye: Eye,
    /// The image plane: pixels of the display as they are seen without a lens.
    pub optics: Viewport,
    /// `world_from_eye` at the scan's start and end, t = 0 and 1.
    pub poses: [Pose; 2],
    /// When each pixel lights between them; without it all do at the start.
    pub scan: Option<ScanSkew>,
    /// The lens through which the display is seen: where `optics` has the light of a display position.
    pub lens: Option<Lens>,
}

impl View {
    /// A view that does not move while it is scanned.
    pub fn still(eye: Eye, optics: Viewport, world_from_eye: Pose) -> Self {
        Self {
            eye,
            optics,
            poses: [world_from_eye; 2],
            scan: None,
            lens: None,
        }
    }

    /// A view on a rolling display, `world_from_eye` at t = 0 and at t = 1 of its scan.
    pub fn rolling(eye: Eye, optics: Viewport, world_from_eye: [Pose; 2], scan: ScanSkew) -> Self {
        Self {
            poses: world_from_eye,
            scan: Some(scan),
            ..Self::still(eye, optics, world_from_eye[0])
        }
    }

    /// The same seen through a lens, or none.
    #[must_use]
    pub fn seen_through(self, lens: Option<Lens>) -> Self {
        Self { lens, ..self }
    }

    /// The part of it that is `part` pixels large from pixel `first` on, with `n` pixels along each side of one of
    /// its own: the same light at the same places and times.
    #[must_use]
    pub fn part(&self, first: UVec2, part: UVec2, n: u32) -> Self {
        let corner = |px: UVec2| self.optics.direction(px.as_dvec2());
        let (upper_left, lower_right) = (corner(first), corner(first + part));
        let whole = self.optics.size.as_dvec2();
        let (from, size) = (first.as_dvec2(), part.as_dvec2());
        Self {
            optics: Viewport {
                size: part * n,
                tan: [upper_left.x, lower_right.x, upper_left.y, lower_right.y],
            },
            scan: self.scan.map(|scan| scan.of_part(from, size, whole)),
            lens: self.lens.map(|lens| lens.of_part(from, n.into())),
            ..*self
        }
    }

    /// Whether the view stays where it is while it is scanned.
    pub fn is_still(&self) -> bool {
        self.poses[0] == self.poses[1]
    }

    /// Where and when the samples of a map look.
    pub fn sampling(&self, map: Map) -> Sampling {
        Sampling {
            map,
            lens: self.lens,
            scan: self.scan,
            display_px: self.optics.size.as_dvec2(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The study display of Guenter 2012, §5.
    fn study() -> Viewport {
        Viewport::symmetric(UVec2::new(1920, 1080), 0.51 / 2.0 / 0.59).unwrap()
    }

    #[test]
    fn study_display_angles() {
        // oracle s1 study_display
        assert!((study().fov_deg().x / 2.0 - 23.374_164_365_048_21).abs() < 1e-12);
        assert!((study().sharpness_deg() - 0.051_590_465_491_907_15).abs() < 1e-14);
    }

    #[test]
    fn project_inverts_direction() {
        let v = Viewport::new(UVec2::new(700, 900), [-1.3, 0.8, 1.0, -1.2]).unwrap();
        for px in [
            DVec2::ZERO,
            DVec2::new(699.5, 3.25),
            DVec2::new(-40.0, 1200.0),
        ] {
            assert!((v.project(v.direction(px) * 2.5).unwrap() - px).length() < 1e-10);
        }
        assert_eq!(v.project(DVec3::Z), None);
    }

    #[test]
    fn bare_pixels_per_degree_are_ambiguous() {
        // methods.md §1: 120° at 40 per degree is 7,939 pixels at the centre, 4,800 on average.
        let at_centre = Viewport::symmetric(UVec2::new(7939, 4466), 3f64.sqrt()).unwrap();
        let density = at_centre.pixel_density();
        assert!((density.centre - 40.0).abs() < 1e-3 && (density.min - 40.0).abs() < 1e-2);
        assert!((density.mean - 7939.0 / 120.0).abs() < 1e-9);
    }

    #[test]
    fn density_integrates_to_the_pixel_count() {
        // Mean over the image of 1/density is the image's solid angle over its pixel count.
        let v = Viewport::symmetric(UVec2::new(400, 300), 0.7).unwrap();
        let mut square_degrees = 0.0;
        for y in 0..300 {
            for x in 0..400 {
                let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                square_degrees += 1.0 / v.pixels_per_square_degree(px);
            }
        }
        // Closed form of a rectangle's solid angle: 4·asin(ab/√((1+a²)(1+b²))) with half-tangents a, b.
        let (a, b) = (0.7f64, 0.525f64);
        let exact = 4.0 * (a * b / ((1.0 + a * a) * (1.0 + b * b)).sqrt()).asin();
        assert!((square_degrees / (to_deg(1.0) * to_deg(1.0)) / exact - 1.0).abs() < 1e-5);
    }
}
