use glam::DVec2;

use super::Screen;

/// Samples a method needs, in closed form: counts may be fractions.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Per pass, innermost or finest first; those that are entirely off the screen count zero samples.
    pub passes: Vec<PassEstimate>,
    /// Pixels of the screen.
    pub display_pixels: f64,
}

/// Samples of one pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassEstimate {
    /// Samples each time it is drawn: places where visibility is found.
    pub samples: f64,
    /// Evaluations of shading each time it is drawn.
    pub shadings: f64,
    /// Samples that share an evaluation of shading, where most do.
    pub block: f64,
    /// Drawn in one frame of this many.
    pub every: u32,
    /// Display pixels per sample, across and down.
    pub scale: DVec2,
    /// How far from the gaze the pass reaches \[deg\]; `None` for one that fills the screen.
    pub radius_deg: Option<f64>,
}

impl PassEstimate {
    /// Each sample shaded, in every frame.
    pub(super) fn new(samples: f64, scale: DVec2) -> Self {
        Self {
            samples,
            shadings: samples,
            block: 1.0,
            every: 1,
            scale,
            radius_deg: None,
        }
    }
}

impl Estimate {
    /// One sample per pixel.
    pub(super) fn full(screen: &Screen) -> Self {
        let samples = screen.pixels();
        Self {
            passes: vec![PassEstimate::new(samples, DVec2::ONE)],
            display_pixels: samples,
        }
    }

    /// Samples when every pass is drawn.
    pub fn samples(&self) -> f64 {
        self.passes.iter().map(|p| p.samples).sum()
    }

    /// Evaluations of shading when every pass is drawn.
    pub fn shadings(&self) -> f64 {
        self.passes.iter().map(|p| p.shadings).sum()
    }

    /// Evaluations of shading per frame on average, each pass at its own cadence.
    pub fn shadings_staggered(&self) -> f64 {
        self.passes
            .iter()
            .map(|p| p.shadings / f64::from(p.every))
            .sum()
    }

    /// Whether the displayed image is put together from samples that are not its own pixels.
    pub fn is_reconstructed(&self) -> bool {
        self.passes.len() != 1 || self.passes[0].scale != DVec2::ONE
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
