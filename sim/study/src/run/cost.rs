use foveasim_models::foveation::{Method, Prepared, Request};
use foveasim_models::{
    CostProfile, EyePanel, FrameCost, FrameInput, FrameWork, GazeMode, ModelError, Nanos, Resolve,
};

use crate::Scenario;

/// Rendering time from a cost profile on each frame's own shaded samples: of the layers that are due in
/// it, cut off at the display's edge as its gaze demands. An image that needs no reconstruction pays for none.
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
    /// What a frame does.
    pub(super) fn work(&self, frame: &FrameInput) -> FrameWork {
        let mut work = FrameWork::default();
        for (panel, prepared) in &self.eyes {
            let gaze = match (self.gaze_mode, frame.gaze) {
                (GazeMode::Tracked, Some(gaze)) => panel.in_eye(gaze),
                _ => panel.ahead(),
            };
            let plan = prepared.plan(gaze).expect("recorded gaze is finite");
            work.samples_shaded += plan.shadings_in_frame(frame.id) as f64;
            if self.profile.per_visible_sample_ns > 0.0 {
                work.samples += plan.samples_in_frame(frame.id) as f64;
            }
            let due = plan.passes.iter().filter(|p| p.cadence.is_due(frame.id));
            work.passes += due.count() as f64;
            work.pixels_resolved += match plan.resolve {
                Resolve::Direct => 0.0,
                _ => f64::from(plan.display_px.x) * f64::from(plan.display_px.y),
            };
        }
        work
    }

    /// What that takes.
    pub(super) fn time(&self, work: &FrameWork) -> Nanos {
        self.profile.time(work)
    }
}

impl FrameCost for PlanCost {
    fn duration(&self, frame: &FrameInput) -> Nanos {
        self.time(&self.work(frame))
    }
}
