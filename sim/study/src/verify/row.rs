use foveasim_models::foveation::Method;

/// A cell that was drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct VerifyRow {
    /// The scene.
    pub scene: String,
    /// The display.
    pub display: String,
    /// Its horizontal field of view \[deg\].
    pub fov_deg: f64,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Which group of the sweep's rows it is of.
    pub group: usize,
    /// The method.
    pub method: Method,
    /// Samples of its plan.
    pub samples: u64,
    /// Evaluations of shading of its plan.
    pub shadings: u64,
    /// Why it is not among those that are fitted; `None` if it is.
    pub held_out: Option<HeldOutFor>,
    /// Processor time of the frame \[ms\].
    pub measured_ms: f64,
    /// By how much the same frame again differs, as a share.
    pub noise: f64,
    /// What was predicted \[ms\].
    pub predicted_ms: f64,
    /// Where nine in ten such frames lie \[ms\].
    pub interval_ms: [f64; 2],
    /// What the rule says that time goes with evaluations of shading \[ms\].
    pub naive_ms: f64,
    /// What the prediction rests on, in the order of the outcome's coefficients.
    pub terms: Vec<f64>,
}

/// Why a cell is held out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum HeldOutFor {
    /// Its scene is.
    Scene,
    /// Its method is.
    Method,
    /// Its image is of the largest size.
    Size,
    /// So that no more than half are fitted.
    Share,
}

impl HeldOutFor {
    /// For tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Method => "method",
            Self::Size => "size",
            Self::Share => "share",
        }
    }
}

impl VerifyRow {
    /// Predicted over measured, less one.
    pub fn error(&self) -> f64 {
        self.predicted_ms / self.measured_ms - 1.0
    }

    /// The same of the naive rule.
    pub fn naive_error(&self) -> f64 {
        self.naive_ms / self.measured_ms - 1.0
    }

    /// Whether the measured time is within the interval.
    pub fn is_covered(&self) -> bool {
        (self.interval_ms[0]..=self.interval_ms[1]).contains(&self.measured_ms)
    }
}
