use super::{LayerDesign, Method, PlanCache, Request, Screen, fdm, kfr, layers, request, vrs};
use crate::{GazeDirection, ModelError, SamplePlan};

/// A method fitted to one image, acuity and margin. What does not depend on the gaze is done once, so
/// that a plan for another gaze, as every frame of a replay needs one, costs little.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    method: Method,
    request: Request,
    /// The radii, for layers.
    design: Option<LayerDesign>,
}

impl Method {
    /// Does what does not depend on the gaze of `request`.
    ///
    /// # Errors
    /// If a direction is not finite or the margin is not from 0 to 90 degrees.
    pub fn prepare(&self, request: &Request) -> Result<Prepared, ModelError> {
        self.prepare_from(None, request)
    }

    /// As [`Method::prepare`], with what a cache has kept.
    pub(super) fn prepare_from(
        &self,
        cache: Option<&PlanCache>,
        request: &Request,
    ) -> Result<Prepared, ModelError> {
        request.check()?;
        let design = match self {
            Self::Layers(settings) => {
                let screen = Screen::from(&request.viewport);
                let margin_deg = settings.aim.margin_deg(request.margin_deg);
                Some(match cache {
                    Some(cache) => cache.design(settings, &screen, request.acuity, margin_deg)?,
                    None => settings.design(&screen, request.acuity, margin_deg)?,
                })
            }
            _ => None,
        };
        Ok(Prepared {
            method: *self,
            request: request.clone(),
            design,
        })
    }

    /// Which samples are drawn for one image: [`Method::prepare`] and [`Prepared::plan`] in one.
    ///
    /// # Errors
    /// If the gaze is not finite or the margin is not from 0 to 90 degrees.
    pub fn plan(&self, request: &Request) -> Result<SamplePlan, ModelError> {
        self.prepare(request)?.plan(request.gaze)
    }
}

impl Prepared {
    /// Which samples are drawn for one image with this gaze (eye frame).
    ///
    /// # Errors
    /// If the gaze is not finite.
    pub fn plan(&self, gaze: GazeDirection) -> Result<SamplePlan, ModelError> {
        self.plan_from(None, gaze)
    }

    /// As [`Prepared::plan`], with what a cache has kept.
    pub(super) fn plan_from(
        &self,
        cache: Option<&PlanCache>,
        gaze: GazeDirection,
    ) -> Result<SamplePlan, ModelError> {
        request::check(gaze, self.request.margin_deg)?;
        // From here on nothing but where the method is aimed, and how far from there the eye may be.
        let aim = self.method.aim();
        let request = Request {
            gaze: aim.gaze(gaze, self.request.ahead),
            margin_deg: aim.margin_deg(self.request.margin_deg),
            ..self.request.clone()
        };
        Ok(match (&self.method, &self.design) {
            (Method::Layers(settings), Some(design)) => layers::plan(settings, design, &request),
            (Method::Vrs(settings), _) => vrs::plan(settings, &request, cache)?,
            (Method::Fdm(settings), _) => fdm::plan(settings, &request, cache),
            (Method::Rates(settings), _) => settings.plan(&request, cache),
            (Method::Quad(settings), _) => settings.plan(&request),
            (Method::Kfr(settings), _) => kfr::plan(self.method.to_string(), settings, &request)?,
            (Method::Efr(settings), _) => {
                let own = settings.of_eye(request.eye);
                kfr::plan(self.method.to_string(), &own, &request)?
            }
            (Method::Lms(settings), _) => settings.plan(&request)?,
            (Method::Radial(settings), _) => settings.plan(&request)?,
            _ => SamplePlan::full(request.eye, request.viewport.size),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::presets;

    #[test]
    fn one_preparation_serves_every_gaze() {
        let display = presets::display("quest-pro").unwrap();
        let ahead = Request::ahead(display.primary());
        for text in [
            "full",
            "layers:1",
            "layers:3",
            "layers:4:strict",
            "layers:3:fixed",
            "vrs",
            "fdm:tile=32:fixed=5",
            "rates",
            "quad",
            "quad:auto:fixed",
            "kfr:2:4:smooth",
            "kfr:2:0.25:published:fixed",
            "efr:2:3",
            "lms:0.5:1",
            "radial:2",
            "radial:1:scale=0.5:fixed",
        ] {
            let method: Method = text.parse().unwrap();
            let prepared = method.prepare(&ahead).unwrap();
            for (azimuth, elevation) in [(0.0, 0.0), (-30.0, 12.0), (80.0, 0.0), (170.0, -20.0)] {
                let gaze = GazeDirection::new(azimuth, elevation);
                let request = Request {
                    gaze,
                    ..ahead.clone()
                };
                assert_eq!(
                    prepared.plan(gaze),
                    method.plan(&request),
                    "{text} {gaze:?}"
                );
            }
            assert!(prepared.plan(GazeDirection::new(f64::NAN, 0.0)).is_err());
        }
    }
}
