use serde::{Deserialize, Serialize};

use super::{EyePanel, Geometry, pixels};
use crate::error::in_range;
use crate::{Eye, ModelError, Pose, Viewport};

/// A flat screen, viewed straight on from in front of its centre.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanarSpec {
    /// Active width \[m\].
    pub width_m: f64,
    /// Viewing distance \[m\].
    pub distance_m: f64,
    /// Pixels, width and height; they are square.
    pub pixels: [u32; 2],
}

impl PlanarSpec {
    pub(super) fn build(&self) -> Result<(Geometry, Vec<EyePanel>), ModelError> {
        in_range("planar.width_m", self.width_m, 1e-4..=1e6)?;
        in_range("planar.distance_m", self.distance_m, 1e-4..=1e6)?;
        let px = pixels("planar.pixels", self.pixels)?;
        let half = self.width_m / 2.0 / self.distance_m;
        let viewport = Viewport::symmetric(px.into(), half)?;
        let eye = EyePanel {
            eye: Eye::Cyclopean,
            viewport,
            panel_px: px,
            head_from_eye: Pose::IDENTITY,
            hidden_area_fraction: 0.0,
            lens: None,
        };
        let (width_m, distance_m) = (self.width_m, self.distance_m);
        Ok((
            Geometry::Planar {
                width_m,
                distance_m,
            },
            vec![eye],
        ))
    }
}
