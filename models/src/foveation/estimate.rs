use super::Screen;

/// Samples a method needs, in closed form: counts may be fractions.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Per pass, innermost first; those that are entirely off the screen count zero samples.
    pub passes: Vec<PassEstimate>,
    /// Pixels of the screen.
    pub display_pixels: f64,
}

/// Samples of one pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassEstimate {
    /// Samples each time it is drawn.
    pub samples: f64,
    /// Drawn in one frame of this many.
    pub every: u32,
    /// Display pixels per sample along each axis.
    pub scale: f64,
    /// How far from the gaze the pass reaches \[deg\]; `None` for one that fills the screen.
    pub radius_deg: Option<f64>,
}

impl Estimate {
    /// One sample per pixel.
    pub(super) fn full(screen: &Screen) -> Self {
        let samples = screen.pixels();
        let pass = PassEstimate {
            samples,
            every: 1,
            scale: 1.0,
            radius_deg: None,
        };
        Self {
            passes: vec![pass],
            display_pixels: samples,
        }
    }

    /// Samples when every pass is drawn.
    pub fn samples(&self) -> f64 {
        self.passes.iter().map(|p| p.samples).sum()
    }

    /// Samples per frame on average, each pass at its own cadence.
    pub fn samples_staggered(&self) -> f64 {
        self.passes
            .iter()
            .map(|p| p.samples / f64::from(p.every))
            .sum()
    }

    /// Pixels per sample (P*/P, Guenter 2012, Eq. 8).
    pub fn ratio(&self) -> f64 {
        self.display_pixels / self.samples()
    }

    /// Pixels per sample drawn, each pass at its own cadence.
    pub fn ratio_staggered(&self) -> f64 {
        self.display_pixels / self.samples_staggered()
    }
}
