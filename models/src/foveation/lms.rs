use std::fmt;
use std::str::FromStr;

use glam::{DVec2, DVec3, UVec2};

use super::estimate::{Estimate, PassEstimate};
use super::text::{Setting, number, settings};
use super::{Aim, Method, Request, Screen};
use crate::error::in_range;
use crate::{
    Filter, Interpolation, Lattice, LensMatched, Map, ModelError, Pass, Region, Resolve, SamplePlan,
};

/// Settings of lens-matched shading, a baseline, written `lms:A:B[:setting]…`:
///
/// | setting | meaning |
/// |---|---|
/// | `A`, `B` | how much w grows over half the image's width, and half its height: w′ = w + A·\|x\| + B·\|y\| with x and y from the centre in halves of the image; 0 to 20 |
/// | `scale=S` | lattice steps to the pixel at the centre; 0.05 to 8 |
/// | `mips` | the mean where several samples fall into a pixel |
/// | `filter=bilinear`, `nearest`, `cubic`, `gather` | between samples (see [`Interpolation`]) |
/// | `tracked`, `fixed`, `fixed=DEG` | whether the centre follows the gaze (see [`Aim`]); as sold it is `fixed` |
///
/// At the centre, a whole pixel's corner, samples are pixels but for the scale. `lms:0:0` is full resolution. A and B say where
/// samples lie, whatever the acuity line; [`LensSearch`](super::LensSearch) finds those that keep to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensMatchedSettings {
    growth: DVec2,
    scale: f64,
    /// Between samples.
    pub interpolation: Interpolation,
    /// Whether several samples in a pixel are averaged.
    pub mips: bool,
    aim: Aim,
}

const GROWTH: std::ops::RangeInclusive<f64> = 0.0..=20.0;
const SCALE: std::ops::RangeInclusive<f64> = 0.05..=8.0;

impl LensMatchedSettings {
    /// About the gaze, with coefficients `a` and `b`.
    ///
    /// # Errors
    /// If a coefficient is not from 0 to 20.
    pub fn new(a: f64, b: f64) -> Result<Self, ModelError> {
        let (a, b) = (in_range("A", a, GROWTH)?, in_range("B", b, GROWTH)?);
        Ok(Self {
            growth: DVec2::new(a, b),
            scale: 1.0,
            interpolation: Interpolation::Bilinear,
            mips: false,
            aim: Aim::Tracked,
        })
    }

    /// A and B.
    pub fn coefficients(&self) -> [f64; 2] {
        self.growth.into()
    }

    /// Lattice steps to the pixel at the centre.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The same with another scale.
    ///
    /// # Errors
    /// If it is not from 0.05 to 8.
    pub fn with_scale(self, scale: f64) -> Result<Self, ModelError> {
        let scale = in_range("scale of lms", scale, SCALE)?;
        Ok(Self { scale, ..self })
    }

    /// Whether the centre follows the gaze.
    pub fn aim(&self) -> Aim {
        self.aim
    }

    pub(super) fn with_aim(self, aim: Aim) -> Self {
        Self { aim, ..self }
    }

    /// Which samples are drawn.
    pub(super) fn plan(&self, request: &Request) -> Result<SamplePlan, ModelError> {
        let display = request.viewport.size;
        let size = display.as_dvec2();
        let screen = Screen::from(&request.viewport);
        let centre_px = screen.nearest_px(request.gaze.vector()).round();
        let growth = self.per_pixel(size);
        // Quadrants meet between cells.
        let cells = |far: DVec2| {
            let steps = self.scale * far / (1.0 + growth * far);
            (steps - 1e-9).ceil().max(DVec2::ZERO)
        };
        let centre = cells(centre_px);
        let lattice: UVec2 = (centre + cells(size - centre_px)).as_uvec2();
        let map = LensMatched::new(centre_px, centre, growth)?.scaled(self.scale)?;
        let map = Map::LensMatched(map);
        let full = SamplePlan::full(request.eye, display);
        let pass = Pass {
            lattice: Lattice::Grid(lattice),
            region: Region::on_display(&map, lattice, display),
            map,
            ..full.passes[0].clone()
        };
        Ok(SamplePlan {
            method: Method::Lms(*self).to_string(),
            passes: vec![pass],
            resolve: Resolve::Inverse(Filter {
                interpolation: self.interpolation,
                smooth_from: None,
                mips: self.mips,
            }),
            ..full
        })
    }

    /// The same with fractions of samples.
    pub(super) fn estimate(&self, screen: &Screen, gaze: DVec3) -> Result<Estimate, ModelError> {
        let (size, centre_px) = (screen.size_px(), screen.nearest_px(gaze));
        let growth = self.per_pixel(size);
        let map = LensMatched::new(centre_px, DVec2::ZERO, growth)?.scaled(self.scale)?;
        let (before, after) = (centre_px, size - centre_px);
        let samples = [
            before,
            after,
            DVec2::new(before.x, after.y),
            DVec2::new(after.x, before.y),
        ];
        let samples = samples
            .into_iter()
            .map(|far| self.scale * self.scale * warped_area(far, growth))
            .sum();
        let farthest = map.lattice_from_display(centre_px + before.max(after));
        let steps = map.steps(farthest);
        let scale = DVec2::new(steps.x_axis.length(), steps.y_axis.length());
        Ok(Estimate {
            passes: vec![PassEstimate::new(samples, scale)],
            display_pixels: screen.pixels(),
        })
    }

    /// How much w grows per display pixel.
    fn per_pixel(&self, size: DVec2) -> DVec2 {
        self.growth * 2.0 / size
    }
}

/// Samples of a quadrant of `far` pixels: it becomes the quadrilateral (0, 0), (x₁, 0), far/(1 + growth·far),
/// (0, y₁).
fn warped_area(far: DVec2, growth: DVec2) -> f64 {
    let edges = far / (1.0 + growth * far);
    let corner = far / (1.0 + growth.dot(far));
    (edges.x * corner.y + corner.x * edges.y) / 2.0
}

impl FromStr for LensMatchedSettings {
    type Err = ModelError;

    /// Reads what follows `lms:`.
    fn from_str(text: &str) -> Result<Self, ModelError> {
        let mut parts = settings(text);
        let a = number("A of lms", parts.next(), GROWTH, "lms:0.5:0.5")?;
        let b = number("B of lms", parts.next(), GROWTH, "lms:0.5:0.5")?;
        let mut read = Self::new(a, b)?;
        for setting in parts {
            match setting {
                Setting("scale", value) => {
                    let value = value.map(|v| Setting(v, None));
                    read.scale = number("scale of lms", value, SCALE, "lms:1:1:scale=2")?;
                }
                Setting("mips", None) => read.mips = true,
                Setting("filter", Some(filter)) => read.interpolation = filter.parse()?,
                other => read.aim = other.aim("setting of lms", &["scale=", "mips", "filter="])?,
            }
        }
        Ok(read)
    }
}

impl fmt::Display for LensMatchedSettings {
    /// What follows `lms`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, ":{}:{}", self.growth.x, self.growth.y)?;
        if self.scale != 1.0 {
            write!(f, ":scale={}", self.scale)?;
        }
        if self.interpolation != Interpolation::default() {
            write!(f, ":filter={}", self.interpolation.name())?;
        }
        if self.mips {
            f.write_str(":mips")?;
        }
        fmt::Display::fmt(&self.aim, f)
    }
}
