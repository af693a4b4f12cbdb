use glam::DVec2;

use super::need::Need;
use super::{PlanCache, Screen};
use crate::error::in_range;
use crate::{Acuity, Eye, EyePanel, GazeDirection, ModelError, Viewport};

/// What a method plans one image for.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// Whose image it is.
    pub eye: Eye,
    /// The image: pixels and edges.
    pub viewport: Viewport,
    /// How sharply the viewer sees.
    pub acuity: Acuity,
    /// Where the sharpest part belongs, in the eye's own frame.
    pub gaze: GazeDirection,
    /// Straight ahead of the head, in the eye's own frame: where methods that do not follow the gaze
    /// put it.
    pub ahead: GazeDirection,
    /// How far the eye may look away from `gaze` without seeing the difference: tracking error and
    /// lag \[deg\].
    pub margin_deg: f64,
}

impl Request {
    /// For a panel's image with gaze straight ahead of the head, acuity slope A and no margin.
    pub fn ahead(panel: &EyePanel) -> Self {
        Self {
            eye: panel.eye,
            viewport: panel.viewport,
            acuity: Acuity::default(),
            gaze: panel.ahead(),
            ahead: panel.ahead(),
            margin_deg: 0.0,
        }
    }

    /// The same for gazes that stand for all on the image, its middle first: 13 × 13, closer together
    /// towards the edges, where what a method needs changes fastest.
    pub fn wherever(&self) -> Vec<Self> {
        const SHARES: [f64; 13] = [
            0.5, 0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.65, 0.8, 0.9, 0.95, 0.98, 1.0,
        ];
        let size = self.viewport.size.as_dvec2();
        let at = |x: f64, y: f64| Self {
            gaze: self.viewport.gaze_at(DVec2::new(x, y) * size),
            ..self.clone()
        };
        let columns = |y: f64| SHARES.map(|x| at(x, y));
        SHARES.into_iter().flat_map(columns).collect()
    }

    /// Checks what the types cannot: a finite gaze and a margin from 0 to 90 degrees.
    pub(super) fn check(&self) -> Result<(), ModelError> {
        check(self.gaze, self.margin_deg)?;
        in_range(
            "azimuth of ahead [deg]",
            self.ahead.azimuth_deg,
            -360.0..=360.0,
        )?;
        in_range(
            "elevation of ahead [deg]",
            self.ahead.elevation_deg,
            -90.0..=90.0,
        )?;
        Ok(())
    }

    /// What the eye needs of the image, which `screen` describes.
    pub(super) fn need<'a>(&self, screen: &'a Screen, cache: Option<&'a PlanCache>) -> Need<'a> {
        Need {
            screen,
            acuity: self.acuity,
            gaze: self.gaze.vector(),
            margin_deg: self.margin_deg,
            cache,
        }
    }
}

/// Checks a finite gaze and a margin from 0 to 90 degrees.
pub(super) fn check(gaze: GazeDirection, margin_deg: f64) -> Result<(), ModelError> {
    in_range("gaze azimuth [deg]", gaze.azimuth_deg, -360.0..=360.0)?;
    in_range("gaze elevation [deg]", gaze.elevation_deg, -90.0..=90.0)?;
    margin(margin_deg)?;
    Ok(())
}

/// Checks a margin.
pub(super) fn margin(margin_deg: f64) -> Result<f64, ModelError> {
    in_range("margin [deg]", margin_deg, 0.0..=90.0)
}
