use foveasim_models::SamplePlan;
use foveasim_models::foveation::{Method, Request};
use foveasim_reports::Cell;

use super::SpacingOutcome;
use super::curve::{SpacingCurve, Worst};

/// One method: its samples, and how far apart they lie.
#[derive(Debug, Clone, PartialEq)]
pub struct SpacingRow {
    /// What it is called in tables and plots: its settings, or how they were found.
    pub label: String,
    /// With its settings.
    pub method: Method,
    /// Samples that its plan draws, for the gaze that takes most.
    pub samples: u64,
    /// Evaluations of shading, likewise.
    pub shadings: u64,
    /// Its longest step over what is asked there, at worst: up to 1 it keeps to the line everywhere.
    pub over_limit: f64,
    /// How far from the gaze that is \[deg\].
    pub worst_at_deg: f64,
    /// Spacing over eccentricity.
    pub curve: SpacingCurve,
}

pub(super) const COLUMNS: [&str; 9] = [
    "name",
    "method",
    "samples",
    "shadings",
    "shading_ratio",
    "over_ideal",
    "spacing_over_limit",
    "worst_at_deg",
    "meets_line",
];

impl SpacingRow {
    pub(super) fn new(
        label: String,
        method: Method,
        requests: &[Request],
        plans: &[SamplePlan],
    ) -> Self {
        let (curve, Worst { over_limit, at_deg }) = SpacingCurve::of_plans(requests, plans);
        let counts = || plans.iter().map(SamplePlan::count);
        Self {
            label,
            method,
            samples: counts().map(|c| c.samples()).max().unwrap_or(0),
            shadings: counts().map(|c| c.shadings()).max().unwrap_or(0),
            over_limit,
            worst_at_deg: at_deg,
            curve,
        }
    }

    /// Whether samples are nowhere farther apart than is asked, to a thousandth: tiles and layers take a
    /// pixel to be as large as its tangent.
    pub fn meets_line(&self) -> bool {
        self.over_limit <= 1.001
    }

    pub(super) fn cells(&self, of: &SpacingOutcome) -> Vec<Cell> {
        vec![
            self.label.as_str().into(),
            self.method.to_string().into(),
            self.samples.into(),
            self.shadings.into(),
            (of.display_pixels as f64 / self.shadings as f64).into(),
            (self.shadings as f64 / of.ideal_samples).into(),
            self.over_limit.into(),
            self.worst_at_deg.into(),
            if self.meets_line() { "yes" } else { "no" }.into(),
        ]
    }
}
