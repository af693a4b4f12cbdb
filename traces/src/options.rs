use foveasim_models::Provenance;

use crate::TraceError;
use crate::error::option_in;

/// What a file does not say about itself; the defaults suit most files.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadOptions {
    /// The screen on which a screen-centred recording was made.
    pub screen: Screen,
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

/// A screen and the eye before its centre.
///
/// The default is the set-up of the published screen-centred recordings that this reader was
/// written for (ETDQualitizer's examples, Niehorster 2024): 1920×1080 px, 528×297 mm, 650 mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screen {
    /// Width and height \[px\].
    pub size_px: [f64; 2],
    /// Width and height \[mm\].
    pub size_mm: [f64; 2],
    /// From the eye to the screen's centre \[mm\].
    pub distance_mm: f64,
}

impl Default for Screen {
    fn default() -> Self {
        Self {
            size_px: [1920.0, 1080.0],
            size_mm: [528.0, 297.0],
            distance_mm: 650.0,
        }
    }
}

impl ReadOptions {
    /// Checks every option.
    ///
    /// # Errors
    /// If one is out of range; the error names it.
    pub fn validate(&self) -> Result<(), TraceError> {
        for px in self.screen.size_px {
            option_in("screen_px", px, 1.0..=1e6)?;
        }
        for mm in self.screen.size_mm {
            option_in("screen_mm", mm, 1.0..=1e5)?;
        }
        option_in("distance_mm", self.screen.distance_mm, 1.0..=1e6)?;
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
