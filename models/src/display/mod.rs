mod hmd;
mod lens;
mod planar;
mod scan;
mod scan_spec;
mod skew;

use std::collections::BTreeMap;

use glam::DVec3;
use serde::{Deserialize, Serialize};

pub use hmd::HmdSpec;
pub use lens::{Lens, LensSpec};
pub use planar::PlanarSpec;
pub use scan::{Emission, PixelResponse, ScanClock, ScanDirection};
pub use scan_spec::{EyeOrder, LightAt, ScanSpec};
pub use skew::ScanSkew;

use crate::presets::Source;
use crate::{Eye, GazeDirection, ModelError, Pose, View, Viewport};

/// A display as people write it (TOML): exactly one of `planar` and `hmd`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DisplaySpec {
    /// Short name, as given to `--display`.
    pub name: String,
    /// Full name.
    #[serde(default)]
    pub title: String,
    /// A flat screen at a distance.
    pub planar: Option<PlanarSpec>,
    /// A head-mounted display.
    pub hmd: Option<HmdSpec>,
    /// How the picture gets from the buffer to light.
    pub scan: ScanSpec,
    /// Where each number comes from, by path (`planar.width_m`).
    #[serde(default)]
    pub sources: BTreeMap<String, Source>,
}

/// One eye's image: what is rendered, and where it sits.
#[derive(Debug, Clone, PartialEq)]
pub struct EyePanel {
    /// Which eye.
    pub eye: Eye,
    /// The image that is rendered for it (the eye buffer).
    pub viewport: Viewport,
    /// Pixels of the panel that shows it, width × height.
    pub panel_px: [u32; 2],
    /// Where the eye sits in the head, canted outwards where the display is.
    pub head_from_eye: Pose,
    /// Fraction of the eye buffer that the optics never show. Sample counts of sweeps leave it out of
    /// the display and of the layer that fills it; the reference renderer draws the whole buffer.
    pub hidden_area_fraction: f64,
    /// The lens before it, if its distortion is known. Its image plane is `viewport`.
    pub lens: Option<LensSpec>,
}

/// What kind of display it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Geometry {
    /// A flat screen seen by both eyes as by one in the middle.
    Planar {
        /// Active width \[m\].
        width_m: f64,
        /// Viewing distance \[m\].
        distance_m: f64,
    },
    /// One image per eye.
    HeadMounted,
}

/// A valid display.
#[derive(Debug, Clone, PartialEq)]
pub struct Display {
    /// Short name.
    pub name: String,
    /// Full name.
    pub title: String,
    /// Planar or head-mounted.
    pub geometry: Geometry,
    /// One image (planar), or left then right.
    pub eyes: Vec<EyePanel>,
    /// When each row is scanned, for the first eye.
    pub scan: ScanClock,
    /// Whether the second eye is scanned together with the first, or after it.
    pub eye_order: EyeOrder,
    /// When a scanned row becomes light.
    pub response: PixelResponse,
}

/// How sharp a display is, in pixels per degree; a bare number is ambiguous by 1.6× at 120°.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelDensity {
    /// Straight ahead, horizontally.
    pub centre: f64,
    /// Width in pixels over horizontal field of view in degrees.
    pub mean: f64,
    /// The lowest anywhere on the image, along either axis.
    pub min: f64,
}

impl Display {
    /// The first eye's image: the only one of a planar display.
    pub fn primary(&self) -> &EyePanel {
        &self.eyes[0]
    }

    /// Pixels rendered for all eyes, hidden area included.
    pub fn render_pixels(&self) -> u64 {
        self.eyes
            .iter()
            .map(|e| u64::from(e.viewport.size.x) * u64::from(e.viewport.size.y))
            .sum()
    }

    /// The same display if it holds `frames` whole frames before it scans them.
    ///
    /// # Errors
    /// If they are more than 4.
    pub fn holding(mut self, frames: u32) -> Result<Self, ModelError> {
        self.scan.buffered_frames = scan_spec::buffered(frames)?;
        Ok(self)
    }

    /// When each row of eye `index` is scanned.
    pub fn scan_of_eye(&self, index: usize) -> ScanClock {
        self.scan.of_eye(index, self.eye_order)
    }

    /// Field of view that any eye sees, horizontally \[deg\].
    pub fn fov_h_deg(&self) -> f64 {
        let edge = |f: fn(&EyePanel) -> f64| self.eyes.iter().map(f);
        let left = edge(|e| e.edges_deg().0).fold(f64::INFINITY, f64::min);
        let right = edge(|e| e.edges_deg().1).fold(f64::NEG_INFINITY, f64::max);
        right - left
    }
}

impl EyePanel {
    /// What this eye sees of the world when the head is at `world_from_head`.
    /// With its lens, if it has one.
    pub fn view(&self, world_from_head: Pose) -> View {
        let world_from_eye = world_from_head.then(self.head_from_eye);
        View::still(self.eye, self.viewport, world_from_eye).seen_through(self.lens())
    }

    /// Its lens over its own image.
    pub fn lens(&self) -> Option<Lens> {
        // Checked when the display was built.
        self.lens
            .and_then(|lens| lens.over(self.viewport.size).ok())
    }

    /// Where this eye turns to look at a point of the head's frame \[m\]: unlike [`in_eye`](Self::in_eye),
    /// the eyes converge.
    pub fn looking_at(&self, point: DVec3) -> GazeDirection {
        GazeDirection::from_vector(self.head_from_eye.inverse().point(point))
    }

    /// A gaze given relative to the head, in this eye's own frame. Both eyes look in the same
    /// direction: at infinity.
    pub fn in_eye(&self, gaze: GazeDirection) -> GazeDirection {
        GazeDirection::from_vector(self.head_from_eye.inverse().direction(gaze.vector()))
    }

    /// Straight ahead of the head, in this eye's own frame: what every part of foveasim means by the
    /// centre of a display. With a cant it is not the eye's axis, and on a headset not the image's
    /// middle.
    pub fn ahead(&self) -> GazeDirection {
        self.in_eye(GazeDirection::AHEAD)
    }

    /// Left and right edge of the image at eye height, as azimuth in the head \[deg\].
    pub fn edges_deg(&self) -> (f64, f64) {
        let azimuth = |x: f64| {
            let v = &self.viewport;
            let d = v.direction(glam::DVec2::new(x, v.axis_px().y));
            GazeDirection::from_vector(self.head_from_eye.direction(d)).azimuth_deg
        };
        (azimuth(0.0), azimuth(f64::from(self.viewport.size.x)))
    }
}

impl TryFrom<DisplaySpec> for Display {
    type Error = ModelError;

    fn try_from(spec: DisplaySpec) -> Result<Self, ModelError> {
        let (geometry, eyes) = match (&spec.planar, &spec.hmd) {
            (Some(planar), None) => planar.build()?,
            (None, Some(hmd)) => hmd.build()?,
            _ => {
                return Err(ModelError::range(
                    "display",
                    &spec.name,
                    "either a [planar] or an [hmd] section, not both or none",
                ));
            }
        };
        let (scan, response) = spec.scan.build(eyes[0].panel_px, eyes.len())?;
        Ok(Self {
            name: spec.name,
            title: spec.title,
            geometry,
            eyes,
            scan,
            eye_order: spec.scan.eyes,
            response,
        })
    }
}

/// Checks a pixel count per axis.
fn pixels(field: &str, px: [u32; 2]) -> Result<[u32; 2], ModelError> {
    if px.iter().all(|p| (1..=65_536).contains(p)) {
        Ok(px)
    } else {
        let value = format!("{} x {}", px[0], px[1]);
        Err(ModelError::range(
            field,
            value,
            "1 to 65536 pixels on each axis",
        ))
    }
}
