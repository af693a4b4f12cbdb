use foveasim_models::{GazeDirection, Provenance};
use glam::DVec3;

use crate::TraceError;
use crate::error::option_in;

/// What a file does not say about itself; the defaults suit most files.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadOptions {
    /// The screen on which gaze was recorded in pixels; what is absent is what the file says, or the
    /// set-up of the format's published recordings, and noted.
    pub screen: ScreenSpec,
    /// Scene units per metre of an EyeNavGS recording (its `scene_setting.csv` lists them: 2.7 for
    /// `playroom`); estimated from the distance between the eyes where absent, and noted.
    pub scale: Option<f64>,
    /// Which of several sessions joined in one file is read, from 1; the one with the most samples
    /// where absent, and noted.
    pub segment: Option<usize>,
    /// What the gaze samples are, where the reader knows better than the file. Of the head pose the
    /// file alone tells: it comes from another tracker, with another delay.
    pub provenance: Option<Provenance>,
}

/// What is known of a screen from elsewhere than the recording.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ScreenSpec {
    /// Width and height \[px\].
    pub size_px: Option<[f64; 2]>,
    /// Width and height \[mm\].
    pub size_mm: Option<[f64; 2]>,
    /// From the eye to the screen's centre \[mm\].
    pub distance_mm: Option<f64>,
}

impl ScreenSpec {
    /// This screen, with what is not known of it taken from `other`.
    #[must_use]
    pub fn or(self, other: Screen) -> Screen {
        Screen {
            size_px: self.size_px.unwrap_or(other.size_px),
            size_mm: self.size_mm.unwrap_or(other.size_mm),
            distance_mm: self.distance_mm.unwrap_or(other.distance_mm),
        }
    }
}

/// A screen and the eye before its centre, looking along its normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screen {
    /// Width and height \[px\].
    pub size_px: [f64; 2],
    /// Width and height \[mm\].
    pub size_mm: [f64; 2],
    /// From the eye to the screen's centre \[mm\].
    pub distance_mm: f64,
}

impl Screen {
    /// The direction of a place on the screen \[mm from its centre, x right, y down\].
    pub(crate) fn direction(&self, mm: [f64; 2]) -> GazeDirection {
        GazeDirection::from_vector(DVec3::new(mm[0], -mm[1], -self.distance_mm))
    }
}

impl std::fmt::Display for Screen {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ([px, py], [mx, my]) = (self.size_px, self.size_mm);
        write!(f, "{px}x{py} px, {mx}x{my} mm at {} mm", self.distance_mm)
    }
}

impl ReadOptions {
    /// Checks every option.
    ///
    /// # Errors
    /// If one is out of range; the error names it.
    pub fn validate(&self) -> Result<(), TraceError> {
        for px in self.screen.size_px.into_iter().flatten() {
            option_in("screen_px", px, 1.0..=1e6)?;
        }
        for mm in self.screen.size_mm.into_iter().flatten() {
            option_in("screen_mm", mm, 1.0..=1e5)?;
        }
        if let Some(mm) = self.screen.distance_mm {
            option_in("distance_mm", mm, 1.0..=1e6)?;
        }
        if let Some(scale) = self.scale {
            option_in("scale", scale, 1e-6..=1e6)?;
        }
        if self.segment == Some(0) {
            return Err(TraceError::option(
                "segment",
                0,
                "1 or more (segments count from 1)",
            ));
        }
        Ok(())
    }
}
