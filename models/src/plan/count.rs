/// Samples of one pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PassCount {
    /// Samples each time it is drawn: live ones for which visibility is found.
    pub samples: u64,
    /// At most how often shading is evaluated each time, if no sample shows two triangles: once for
    /// each sample, or for each block of coarse shading that has a live sample.
    pub shadings: u64,
    /// One frame in this many.
    pub every: u32,
}

/// Exact sample counts of a plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanCount {
    /// Per pass, in the plan's order.
    pub passes: Vec<PassCount>,
    /// Pixels of the image the plan is for.
    pub display_pixels: u64,
}

impl PlanCount {
    /// Samples when every pass is drawn.
    pub fn samples(&self) -> u64 {
        self.passes.iter().map(|p| p.samples).sum()
    }

    /// Evaluations of shading when every pass is drawn (see [`PassCount::shadings`]).
    pub fn shadings(&self) -> u64 {
        self.passes.iter().map(|p| p.shadings).sum()
    }

    /// Samples per frame on average, each pass at its own cadence.
    pub fn samples_staggered(&self) -> f64 {
        self.passes
            .iter()
            .map(|p| p.samples as f64 / f64::from(p.every))
            .sum()
    }

    /// Display pixels per sample: how many times fewer samples than full resolution.
    pub fn ratio(&self) -> f64 {
        self.display_pixels as f64 / self.samples() as f64
    }

    /// Display pixels per sample drawn, each pass at its own cadence.
    pub fn ratio_staggered(&self) -> f64 {
        self.display_pixels as f64 / self.samples_staggered()
    }

    /// Display pixels per evaluation of shading: how many times fewer than at full resolution.
    pub fn shading_ratio(&self) -> f64 {
        self.display_pixels as f64 / self.shadings() as f64
    }
}
