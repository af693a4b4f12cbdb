use foveasim_models::foveation::{Method, Prepared, Request};
use foveasim_models::{
    CostProfile, EyePanel, FrameCost, FrameInput, GazeMode, ModelError, Nanos, Resolve,
};

use crate::Scenario;

/// Rendering time from a cost profile on each frame's own shaded samples: of the layers that are due in
/// it, cut off at the display's edge as its gaze demands. Visibility that is finer than shading is not
/// charged, and an image that needs no reconstruction pays for none.
#[derive(Debug, Clone)]
pub struct PlanCost {
    profile: CostProfile,
    gaze_mode: GazeMode,
    eyes: Vec<(EyePanel, Prepared)>,
}

impl PlanCost {
    /// The cost of `method` in a scenario.
    ///
    /// # Errors
    /// If the method cannot be planned on the display.
    pub fn new(scenario: &Scenario, method: &Method) -> Result<Self, ModelError> {
        let prepare = |panel: &EyePanel| {
            let request = Request {
                acuity: scenario.acuity,
                margin_deg: scenario.spec.margin_deg,
                ..Request::ahead(panel)
            };
            Ok((panel.clone(), method.prepare(&request)?))
        };
        Ok(Self {
            profile: scenario.cost.clone(),
            gaze_mode: scenario.gaze_mode,
            eyes: scenario
                .display
                .eyes
                .iter()
                .map(prepare)
                .collect::<Result<_, ModelError>>()?,
        })
    }
}

impl PlanCost {
    /// Samples shaded in a frame, and display pixels that are reconstructed.
    pub(super) fn counts(&self, frame: &FrameInput) -> (u64, u64) {
        let (mut samples, mut pixels) = (0, 0);
        for (panel, prepared) in &self.eyes {
            let gaze = match (self.gaze_mode, frame.gaze) {
                (GazeMode::Tracked, Some(gaze)) => panel.in_eye(gaze),
                _ => panel.ahead(),
            };
            let plan = prepared.plan(gaze).expect("recorded gaze is finite");
            samples += plan.shadings_in_frame(frame.id);
            pixels += match plan.resolve {
                Resolve::Direct => 0,
                _ => u64::from(plan.display_px.x) * u64::from(plan.display_px.y),
            };
        }
        (samples, pixels)
    }

    /// What so many take.
    pub(super) fn time(&self, samples: u64, pixels: u64) -> Nanos {
        self.profile.time(samples as f64, pixels as f64)
    }
}

impl FrameCost for PlanCost {
    fn duration(&self, frame: &FrameInput) -> Nanos {
        let (samples, pixels) = self.counts(frame);
        self.time(samples, pixels)
    }
}
