use foveasim_assets::{STUDY_FRAMES, study_camera};
use foveasim_models::foveation::{Method, Request};
use foveasim_models::{Acuity, Eye, EyePanel, ModelError, Pose, SamplePlan, View, Viewport};
use glam::{DQuat, DVec3, UVec2};

/// Distance between the eyes \[m\].
const INTERPUPILLARY_M: f64 = 0.063;
/// Tangent of half the field of view, horizontally.
const HALF_WIDTH_TAN: f64 = 1.0;
/// Where the eyes look, moment after moment: points of the head's frame \[m\].
const LOOKED_AT: [DVec3; 4] = [
    DVec3::new(0.0, 0.0, -3.0),
    DVec3::new(-0.6, 0.2, -4.0),
    DVec3::new(0.5, -0.4, -2.5),
    DVec3::new(0.2, 0.5, -6.0),
];

/// A headset with two parallel images of 90° across, somewhere on the study's flight.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pair {
    panels: [EyePanel; 2],
    pub(super) head: Pose,
    pub(super) views: [View; 2],
    looked_at: DVec3,
}

impl Pair {
    /// At moment `index` of `count`, with images of `size` pixels for each eye.
    pub(super) fn new(size: UVec2, index: u32, count: u32, seed: u64) -> Result<Self, ModelError> {
        let viewport = Viewport::symmetric(size, HALF_WIDTH_TAN)?;
        let panel = |eye, side: f64| EyePanel {
            eye,
            viewport,
            panel_px: size.to_array(),
            head_from_eye: Pose::new(DVec3::X * (side * INTERPUPILLARY_M / 2.0), DQuat::IDENTITY),
            hidden_area_fraction: 0.0,
            lens: None,
        };
        let panels = [panel(Eye::Left, -1.0), panel(Eye::Right, 1.0)];
        let frame = u64::from(STUDY_FRAMES) * (2 * u64::from(index) + 1) / (2 * u64::from(count));
        let head = study_camera(frame as f64 / f64::from(STUDY_FRAMES), seed);
        Ok(Self {
            views: [0, 1].map(|k| panels[k].view(head)),
            panels,
            head,
            looked_at: LOOKED_AT[index as usize % LOOKED_AT.len()],
        })
    }

    /// What a method plans one eye's image for.
    pub(super) fn request(&self, eye: usize, acuity: Acuity) -> Request {
        Request {
            gaze: self.panels[eye].looking_at(self.looked_at),
            acuity,
            ..Request::ahead(&self.panels[eye])
        }
    }

    /// Both eyes' plans.
    pub(super) fn plans(
        &self,
        method: &Method,
        acuity: Acuity,
    ) -> Result<[SamplePlan; 2], ModelError> {
        let plan = |eye| method.plan(&self.request(eye, acuity));
        Ok([plan(0)?, plan(1)?])
    }
}
