use std::fmt;
use std::str::FromStr;

use glam::{DVec2, DVec3};

use super::estimate::{Estimate, PassEstimate};
use super::quadrature::around;
use super::text::{Setting, number, settings};
use super::{Aim, Method, Request, Screen};
use crate::error::in_range;
use crate::{
    Affine, Falloff, Filter, Interpolation, Lattice, Map, ModelError, Pass, Radial, Reach, Region,
    Resolve, SamplePlan, unknown_name,
};

/// Settings of a buffer that magnifies the fovea (Friston 2019, §3.1.1), written `radial:K[:setting]…`:
///
/// | setting | meaning |
/// |---|---|
/// | `K` | the exponent of d_u = R·(d_b/R)^K, distances from the gaze on the display and in the buffer; 1 to 16, 1 magnifies nothing |
/// | `scale=S` | lattice steps per pixel of the buffer; 0.05 to 4 |
/// | `reach=corner` (`corner`), `reach=boundary` (`boundary`) | the distance R on which buffer and display agree: the farthest corner, or the boundary in each direction (see [`Reach`]) |
/// | `filter=bilinear`, `nearest`, `cubic`, `gather` | between samples (see [`Interpolation`]) |
/// | `mips` | the mean where several samples fall into a pixel |
/// | `tracked`, `fixed`, `fixed=DEG` | whether it follows the gaze (see [`Aim`]) |
///
/// A buffer as large as the display (S = 1) saves nothing: it has a pixel's samples for each pixel, and more of
/// them at the fovea. With K = 1 and S = 1 it is full resolution, and planned and drawn as that. K and S say where samples lie,
/// whatever the acuity line and the margin; a fixed one is only moved, not made finer.
///
/// In a library the falloff may be any monotone table ([`RadialSettings::with_falloff`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadialSettings {
    falloff: Falloff,
    scale: f64,
    /// On which distance buffer and display agree.
    pub reach: Reach,
    /// Between samples.
    pub interpolation: Interpolation,
    /// Whether several samples in a pixel are averaged.
    pub mips: bool,
    aim: Aim,
}

const EXPONENT: std::ops::RangeInclusive<f64> = 1.0..=16.0;
const SCALE: std::ops::RangeInclusive<f64> = 0.05..=4.0;

impl RadialSettings {
    /// With exponent `k`, a buffer of the display's scale that agrees with it at the farthest corner, following the gaze.
    ///
    /// # Errors
    /// If the exponent is not from 1 to 16.
    pub fn new(k: f64) -> Result<Self, ModelError> {
        Ok(Self {
            falloff: Falloff::power(k)?,
            scale: 1.0,
            reach: Reach::Corner,
            interpolation: Interpolation::Bilinear,
            mips: false,
            aim: Aim::Tracked,
        })
    }

    /// How distances grow outwards.
    pub fn falloff(&self) -> Falloff {
        self.falloff
    }

    /// Lattice steps per pixel of the buffer.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Whether it follows the gaze.
    pub fn aim(&self) -> Aim {
        self.aim
    }

    pub(super) fn with_aim(self, aim: Aim) -> Self {
        Self { aim, ..self }
    }

    /// The same with another buffer scale.
    ///
    /// # Errors
    /// If it is not from 0.05 to 4.
    pub fn with_scale(self, scale: f64) -> Result<Self, ModelError> {
        let scale = in_range("scale of radial", scale, SCALE)?;
        Ok(Self { scale, ..self })
    }

    /// The same with another falloff, a table for one. Its method has no text that reads back: a table is
    /// written as `table`.
    #[must_use]
    pub fn with_falloff(self, falloff: Falloff) -> Self {
        Self { falloff, ..self }
    }

    /// Which samples are drawn: those whose cells have a part of the display.
    pub(super) fn plan(&self, request: &Request) -> Result<SamplePlan, ModelError> {
        let display = request.viewport.size;
        let gaze = Screen::from(&request.viewport).nearest_px(request.gaze.vector());
        let map = Radial::new(gaze, display, self.falloff, self.reach, self.scale)?;
        let full = SamplePlan {
            method: Method::Radial(*self).to_string(),
            ..SamplePlan::full(request.eye, display)
        };
        let lattice = map.lattice();
        let map = match map.as_affine() {
            Some(Affine::IDENTITY) => return Ok(full),
            Some(affine) => Map::Affine(affine),
            None => Map::Radial(map),
        };
        let pass = Pass {
            lattice: Lattice::Grid(lattice),
            region: Region::on_display(&map, lattice, display),
            map,
            ..full.passes[0].clone()
        };
        Ok(SamplePlan {
            passes: vec![pass],
            resolve: Resolve::Inverse(Filter {
                interpolation: self.interpolation,
                smooth_from: None,
                mips: self.mips,
            }),
            ..full
        })
    }

    /// The same with fractions of samples: the area that the display has in the buffer.
    pub(super) fn estimate(&self, screen: &Screen, gaze: DVec3) -> Result<Estimate, ModelError> {
        let (size, gaze) = (screen.size_px(), screen.nearest_px(gaze));
        let map = Radial::over(gaze, size, self.falloff, self.reach, self.scale)?;
        let farthest = DVec2::select((size - gaze).cmpgt(gaze), size, DVec2::ZERO);
        let steps = map.steps(map.lattice_from_display(farthest));
        let scale = DVec2::new(steps.x_axis.length(), steps.y_axis.length());
        Ok(Estimate {
            passes: vec![PassEstimate::new(samples(&map, size), scale)],
            display_pixels: screen.pixels(),
        })
    }
}

/// The relative error of the estimate's integral.
const RELATIVE_ERROR: f64 = 1e-6;

/// The area of a display of `size` pixels in the buffer, in samples.
fn samples(map: &Radial, size: DVec2) -> f64 {
    if map.reach() == Reach::Boundary || map.falloff().is_identity() {
        return size.element_product() * map.scale() * map.scale();
    }
    let (gaze, centre) = (map.gaze_px(), map.gaze());
    around(gaze, size, RELATIVE_ERROR, |towards, to_edge| {
        let inside = map.lattice_from_display(gaze + towards * to_edge);
        inside.distance_squared(centre) / 2.0
    })
}

impl FromStr for RadialSettings {
    type Err = ModelError;

    /// Reads what follows `radial:`.
    fn from_str(text: &str) -> Result<Self, ModelError> {
        const OWN: [&str; 6] = ["scale=", "reach=", "corner", "boundary", "filter=", "mips"];
        let mut parts = settings(text);
        let k = number("exponent of radial", parts.next(), EXPONENT, "radial:2")?;
        let mut read = Self::new(k)?;
        for setting in parts {
            match setting {
                Setting("scale", value) => {
                    let value = value.map(|v| Setting(v, None));
                    let scale = number("scale", value, SCALE, "radial:2:scale=0.7")?;
                    read = read.with_scale(scale)?;
                }
                Setting("corner", None) | Setting("reach", Some("corner")) => {
                    read.reach = Reach::Corner;
                }
                Setting("boundary", None) | Setting("reach", Some("boundary")) => {
                    read.reach = Reach::Boundary;
                }
                Setting("reach", Some(reach)) => {
                    return Err(unknown_name("reach", reach, &["corner", "boundary"]));
                }
                Setting("filter", Some(filter)) => read.interpolation = filter.parse()?,
                Setting("mips", None) => read.mips = true,
                other => read.aim = other.aim("setting of radial", &OWN)?,
            }
        }
        Ok(read)
    }
}

impl fmt::Display for RadialSettings {
    /// What follows `radial`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.falloff {
            Falloff::Power(k) => write!(f, ":{k}")?,
            Falloff::Table(_) => f.write_str(":table")?,
        }
        if self.scale != 1.0 {
            write!(f, ":scale={}", self.scale)?;
        }
        match self.reach {
            Reach::Corner => {}
            Reach::Boundary => f.write_str(":boundary")?,
            Reach::Px(px) => write!(f, ":reach={px}px")?,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::presets;

    #[test]
    fn estimates_are_what_is_drawn() {
        let display = presets::display("lg-w2363d").unwrap();
        let panel = display.primary();
        let screen = Screen::from(&panel.viewport);
        for text in [
            "2",
            "2:boundary",
            "4:scale=0.5",
            "1.5:scale=0.7",
            "1:scale=0.5",
        ] {
            let settings: RadialSettings = text.parse().unwrap();
            for px in [[960.0, 540.0], [3.0, 1079.0], [1500.0, 100.0]] {
                let request = Request {
                    gaze: panel.viewport.gaze_at(px.into()),
                    ..Request::ahead(panel)
                };
                let plan = settings.plan(&request).unwrap();
                let found = settings.estimate(&screen, request.gaze.vector()).unwrap();
                // Cells on the edge count whole: at most one at either end of each row and column.
                let drawn = plan.count().samples() as f64;
                let Lattice::Grid(lattice) = plan.passes[0].lattice;
                let rim = 2.0 * f64::from(lattice.x + lattice.y);
                let more = drawn - found.samples();
                assert!(
                    (-1.0..=rim).contains(&more),
                    "{text} {px:?}: {more} of {drawn}"
                );
            }
        }
    }

    #[test]
    fn nothing_magnified_is_full_resolution() {
        let display = presets::display("lg-w2363d").unwrap();
        let request = Request::ahead(display.primary());
        for text in ["1", "1:boundary:fixed", "1:scale=1"] {
            let settings: RadialSettings = text.parse().unwrap();
            let plan = settings.plan(&request).unwrap();
            let full = SamplePlan::full(request.eye, request.viewport.size);
            assert_eq!((plan.passes, plan.resolve), (full.passes, full.resolve));
        }
    }
}
