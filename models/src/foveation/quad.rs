use std::fmt;
use std::str::FromStr;

use glam::{DVec2, DVec3, UVec2};

use super::cover::{TanBox, cone_edges};
use super::estimate::{Estimate, PassEstimate};
use super::need::Need;
use super::text::{Setting, settings};
use super::{Aim, Coverage, Method, Request, Screen, lattice};
use crate::error::in_range;
use crate::math::{to_deg, to_rad};
use crate::{Affine, Lattice, Map, ModelError, Pass, Resolve, SamplePlan};

/// Settings of quad views (OpenXR `XR_VARJO_quad_views`): per eye a focus rectangle at full resolution
/// and a coarser one over everything, written `quad[:setting]…`:
///
/// | setting | meaning |
/// |---|---|
/// | `focus=SHARE` | the focus as a share of each side, above 0 to 1 (0.35) |
/// | `focus=auto` (`auto`) | the focus is as large as the acuity line asks for beside the periphery's scale |
/// | `peripheral=SCALE` | samples per display pixel along each axis of the periphery, 0.01 to 1 (0.5) |
/// | `tracked`, `fixed`, `fixed=DEG` | whether it follows the gaze (see [`Aim`]) |
///
/// A focus of given size lies about the gaze, clamped inside the display; a fixed one covers all the places
/// where it would lie for a gaze within reach. The periphery is drawn beneath the focus as well, as the
/// runtime does: the defaults cost 0.35² + 0.5² = 0.3725 of full. Only an `auto` focus promises that
/// the acuity line is met.
///
/// [`Display`](fmt::Display) writes what differs from the default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuadSettings {
    focus: Focus,
    peripheral: f64,
    aim: Aim,
}

/// How large the focus of quad views is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Focus {
    /// A share of each side.
    Share(f64),
    /// As the acuity line asks.
    Auto,
}

const SHARES: &str = "auto, or a number above 0, at most 1";

impl QuadSettings {
    /// A focus of given size beside a periphery of `peripheral` samples per pixel along each axis.
    ///
    /// # Errors
    /// If the focus's share is not above 0 and at most 1, or `peripheral` not from 0.01 to 1.
    pub fn new(focus: Focus, peripheral: f64, aim: Aim) -> Result<Self, ModelError> {
        match focus {
            Focus::Share(share) if !(share > 0.0 && share <= 1.0) => {
                return Err(ModelError::range("focus", share, SHARES));
            }
            _ => {}
        }
        in_range("peripheral", peripheral, 0.01..=1.0)?;
        Ok(Self {
            focus,
            peripheral,
            aim,
        })
    }

    /// How large the focus is.
    pub fn focus(&self) -> Focus {
        self.focus
    }

    /// Samples per display pixel along each axis of the periphery.
    pub fn peripheral(&self) -> f64 {
        self.peripheral
    }

    /// Whether it follows the gaze.
    pub fn aim(&self) -> Aim {
        self.aim
    }

    pub(super) fn with_aim(self, aim: Aim) -> Self {
        Self { aim, ..self }
    }

    /// Which samples are drawn. Where no focus is needed it is left out, and an `auto` one becomes the
    /// whole image where focus and periphery together need as many samples.
    pub(super) fn plan(&self, request: &Request) -> SamplePlan {
        let screen = Screen::from(&request.viewport);
        let need = request.need(&screen, None);
        let full = SamplePlan {
            method: Method::Quad(*self).to_string(),
            ..SamplePlan::full(request.eye, request.viewport.size)
        };
        let focus = match self.focus {
            Focus::Share(share) => Some(self.given(share, &need)),
            Focus::Auto => {
                let area = self.needed(&need);
                if self.is_full(area, &need) {
                    return full;
                }
                area.map(|area| lattice::covering(&request.viewport, area, 1.0))
            }
        };
        let periphery = lattice::whole(&request.viewport, 1.0 / self.peripheral);
        let pass = |(lattice, map): (Lattice, Map)| Pass {
            lattice,
            map,
            ..full.passes[0].clone()
        };
        SamplePlan {
            passes: focus.into_iter().chain([periphery]).map(pass).collect(),
            resolve: Resolve::Mosaic,
            ..full
        }
    }

    /// The same with fractions of samples.
    pub(super) fn estimate(&self, need: &Need<'_>) -> Estimate {
        let screen = need.screen;
        let focus = match self.focus {
            Focus::Share(share) => {
                let [first, end] = self.sides(need, screen.size_px() * share);
                Some(PassEstimate::new(
                    (end - first).element_product(),
                    DVec2::ONE,
                ))
            }
            Focus::Auto => {
                let area = self.needed(need);
                if self.is_full(area, need) {
                    return Estimate::full(screen);
                }
                area.map(|area| PassEstimate {
                    radius_deg: Some(self.radius_deg(need)),
                    ..PassEstimate::new(area.pixels(screen), DVec2::ONE)
                })
            }
        };
        let periphery = PassEstimate::new(
            screen.pixels() * self.peripheral * self.peripheral,
            DVec2::splat(1.0 / self.peripheral),
        );
        Estimate {
            passes: focus.into_iter().chain([periphery]).collect(),
            display_pixels: screen.pixels(),
        }
    }

    /// Whether a focus over `area` and the periphery need as many samples as the whole image.
    fn is_full(&self, area: Option<TanBox>, need: &Need<'_>) -> bool {
        let whole = need.screen.pixels();
        let focus = area.map_or(0.0, |area| area.pixels(need.screen));
        focus + whole * self.peripheral * self.peripheral >= whole
    }

    /// The grid of a focus whose size is given: whole pixels.
    fn given(&self, share: f64, need: &Need<'_>) -> (Lattice, Map) {
        let size = (need.screen.size_px() * share).round().max(DVec2::ONE);
        let [first, end] = self.sides(need, size).map(DVec2::round);
        let map = Affine {
            origin: first,
            ..Affine::IDENTITY
        };
        let size: UVec2 = (end - first).as_uvec2();
        (Lattice::Grid(size), Map::Affine(map))
    }

    /// The first and the last corner \[px\] of the union of rectangles of `size` about each gaze within
    /// reach, each clamped inside the screen.
    fn sides(&self, need: &Need<'_>, size: DVec2) -> [DVec2; 2] {
        let around = gazes(need.gaze, self.aim.reach_deg());
        let [left, _, up, _] = need.screen.tan();
        let pixel = need.screen.pixel_tan();
        let first = DVec2::new(around.min.x - left, up - around.max.y) / pixel;
        let last = DVec2::new(around.max.x - left, up - around.min.y) / pixel;
        let room = (need.screen.size_px() - size).max(DVec2::ZERO);
        [
            (first - size / 2.0).clamp(DVec2::ZERO, room),
            (last - size / 2.0).clamp(DVec2::ZERO, room) + size,
        ]
    }

    /// What the periphery is too coarse for: `None` if nothing on the screen.
    fn needed(&self, need: &Need<'_>) -> Option<TanBox> {
        let radius = self.radius_deg(need);
        let cone = (radius > 0.0).then(|| Coverage::Exact.rectangle(need.gaze, radius));
        cone.flatten().and_then(|area| area.clipped(need.screen))
    }

    /// The eccentricity from which on the periphery is fine enough \[deg\], by its largest step: where
    /// ω(e − δ)/2 is the angle of 1/`peripheral` pixels at the axis.
    fn radius_deg(&self, need: &Need<'_>) -> f64 {
        if self.peripheral >= 1.0 {
            return 0.0;
        }
        let step = to_deg(need.screen.pixel_tan().max_element() / self.peripheral);
        let excess = 2.0 * step - need.acuity.omega_0_deg();
        if excess <= 0.0 {
            return 0.0;
        }
        // A slope of zero never gets there: infinite.
        excess / need.acuity.slope() + need.margin_deg
    }
}

/// The tangents within which gazes up to `reach_deg` from unit vector `gaze` meet the image plane. A gaze
/// that does not meet it counts by its direction.
fn gazes(gaze: DVec3, reach_deg: f64) -> TanBox {
    let span = |along: f64| {
        let edges = cone_edges(along, -gaze.z, to_rad(reach_deg));
        edges.unwrap_or((along, along))
    };
    let (x, y) = (span(gaze.x), span(gaze.y));
    TanBox {
        min: DVec2::new(x.0, y.0),
        max: DVec2::new(x.1, y.1),
    }
}

impl Default for QuadSettings {
    fn default() -> Self {
        Self {
            focus: Focus::Share(0.35),
            peripheral: 0.5,
            aim: Aim::Tracked,
        }
    }
}

impl FromStr for QuadSettings {
    type Err = ModelError;

    /// Reads what follows `quad:`.
    fn from_str(text: &str) -> Result<Self, ModelError> {
        let mut read = Self::default();
        for setting in settings(text) {
            read = match setting {
                Setting("auto", None) | Setting("focus", Some("auto")) => Self {
                    focus: Focus::Auto,
                    ..read
                },
                Setting("focus", Some(value)) => {
                    let share = value.parse();
                    let share = share.map_err(|_| ModelError::range("focus", value, SHARES))?;
                    Self::new(Focus::Share(share), read.peripheral, read.aim)?
                }
                Setting("peripheral", Some(value)) => {
                    let valid = "a number from 0.01 to 1";
                    let scale = value.parse();
                    let scale = scale.map_err(|_| ModelError::range("peripheral", value, valid))?;
                    Self::new(read.focus, scale, read.aim)?
                }
                other => {
                    let others = ["auto", "focus=", "peripheral="];
                    read.with_aim(other.aim("setting of quad", &others)?)
                }
            };
        }
        Ok(read)
    }
}

impl fmt::Display for QuadSettings {
    /// What follows `quad`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let default = Self::default();
        match self.focus {
            Focus::Auto => f.write_str(":focus=auto")?,
            Focus::Share(share) if self.focus != default.focus => write!(f, ":focus={share}")?,
            Focus::Share(_) => {}
        }
        if self.peripheral.to_bits() != default.peripheral.to_bits() {
            write!(f, ":peripheral={}", self.peripheral)?;
        }
        self.aim.fmt(f)
    }
}
