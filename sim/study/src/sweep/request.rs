use foveasim_models::foveation::{Method, PlanCache, Request};

use super::Sweep;

impl Sweep {
    /// What a method plans for the first eye of a group's rows; `None` for a display without whole pixels.
    ///
    /// # Panics
    /// If there is no such group.
    pub(crate) fn request(&self, group: usize, method: Method) -> Option<Request> {
        let cache = PlanCache::default();
        let situation = self.situation(group, &cache);
        let eye = &situation.display.eyes[0];
        Some(Request {
            eye: eye.eye,
            viewport: eye.viewport?,
            acuity: situation.acuity,
            gaze: situation.drawn_gaze(eye, method.aim(), self.gaze_mode),
            ahead: eye.ahead(),
            margin_deg: situation.margin_deg,
        })
    }

    /// Name and horizontal field of view \[deg\] of a group's display.
    pub(crate) fn named(&self, group: usize) -> (&str, f64) {
        let of_display = self.margins_deg.len() * self.gazes.len() * self.acuities.len();
        let display = &self.displays[group / of_display];
        (&display.name, display.fov_h_deg)
    }
}
