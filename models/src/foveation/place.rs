use glam::{DMat2, DVec2, DVec3};

use super::Request;
use crate::gaze::angle_deg;
use crate::math::{hypot, to_deg};
use crate::{LogPolar, Map, Pass, Resolve, SamplePlan, Shading, Spacing};

/// A place of an image as the eye of a [`Request`] sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Its angle from the gaze \[deg\].
    pub eccentricity_deg: f64,
    /// What the eye can tell there, half a cycle: ω(max(0, e − δ))/2 \[deg\].
    pub acuity_deg: f64,
    /// The larger of the display's steps along x and y there \[deg\].
    pub pixel_deg: f64,
    /// How far a pixel along x, and one along y, turns the ray along the radius from the gaze \[deg\].
    radial: DVec2,
    /// The same across it.
    tangential: DVec2,
}

impl Request {
    /// The place at pixel position `px`.
    pub fn place(&self, px: DVec2) -> Place {
        let (gaze, ray) = (self.gaze.vector(), self.viewport.direction(px));
        let out = ray.normalize();
        let across = gaze.cross(out).try_normalize().unwrap_or(DVec3::Y);
        let along = across.cross(out);
        // A step turns the ray by its part across the ray over the ray's length.
        let pixel = self.viewport.pixel_tan() * to_deg(1.0) / ray.length();
        let [radial, tangential] = [along, across].map(|axis| DVec2::new(axis.x, -axis.y) * pixel);
        let eccentricity_deg = angle_deg(ray, gaze);
        let mut place = Place {
            eccentricity_deg,
            acuity_deg: self.acuity.mar_deg(eccentricity_deg - self.margin_deg) / 2.0,
            pixel_deg: 0.0,
            radial,
            tangential,
        };
        place.pixel_deg = place.longest(DMat2::IDENTITY);
        place
    }
}

impl Place {
    /// What is asked of samples there \[deg\]: no farther apart than the eye can tell, or than the display's
    /// pixels are where those are coarser.
    pub fn limit_deg(&self) -> f64 {
        self.acuity_deg.max(self.pixel_deg)
    }

    /// The angle of a step on the display \[deg\].
    pub fn angle_deg(&self, step_px: DVec2) -> f64 {
        hypot(self.radial.dot(step_px), self.tangential.dot(step_px))
    }

    /// The longer of two steps \[deg\]. It bounds the spacing of samples along every direction: that along
    /// the radius and that across it, and all between.
    pub fn longest(&self, steps_px: DMat2) -> f64 {
        let [a, b] = [steps_px.x_axis, steps_px.y_axis].map(|step| self.angle_deg(step));
        a.max(b)
    }

    /// Spacing along the radius and across it \[deg\].
    pub fn spacing_deg(&self, steps_px: DMat2) -> Spacing {
        let reach = |axis: DVec2| {
            let [a, b] = [steps_px.x_axis, steps_px.y_axis].map(|step| axis.dot(step).abs());
            a.max(b)
        };
        Spacing {
            radial: reach(self.radial),
            tangential: reach(self.tangential),
        }
    }
}

impl SamplePlan {
    /// Display pixels from one evaluation of shading to the next, along both axes of the lattice that shows
    /// at pixel position `px` of the image that `request` asks for: of the coarsest pass where several
    /// blend.
    ///
    /// # Panics
    /// If the plan shows nothing there.
    pub fn shading_steps(&self, request: &Request, px: DVec2) -> DMat2 {
        let shown = match &self.resolve {
            Resolve::Inverse(_) => self.passes.last(),
            Resolve::Direct | Resolve::Mosaic => {
                let mut passes = self.passes.iter();
                passes.find(|pass| pass.holds(px))
            }
            Resolve::Feather(feather) => {
                let ray = request.viewport.direction(px);
                let along = ray.dot(feather.gaze);
                let tan = ray.cross(feather.gaze).length() / along;
                // A pass mixes in from where the one inside it begins to fade.
                let mixes = |edge: &&[f64; 2]| along <= 0.0 || tan > edge[0];
                self.passes
                    .get(feather.edges_tan.iter().take_while(mixes).count())
            }
        };
        shown.expect("every pixel has a sample").shading_steps(px)
    }
}

impl Pass {
    /// Whether a live sample's cell holds a pixel position.
    fn holds(&self, px: DVec2) -> bool {
        let crate::Lattice::Grid(size) = self.lattice;
        let at = self.map.lattice_from_display(px).floor();
        let within = at.cmpge(DVec2::ZERO).all() && at.cmplt(size.as_dvec2()).all();
        within && self.region.is_live(at.as_uvec2())
    }

    fn shading_steps(&self, px: DVec2) -> DMat2 {
        let at = self.map.lattice_from_display(px);
        match (&self.shading, &self.map) {
            (Shading::Coarse(rates), map) => {
                let rate = rates.rate(at.floor().max(DVec2::ZERO).as_uvec2());
                let steps = map.steps(at);
                DMat2::from_cols(
                    steps.x_axis * f64::from(rate.x),
                    steps.y_axis * f64::from(rate.y),
                )
            }
            (_, Map::LogPolar(map)) => cell(map, at),
            (_, map) => map.steps(at),
        }
    }
}

/// The sides of a sample's cell about lattice position `at`.
fn cell(map: &LogPolar, at: DVec2) -> DMat2 {
    let [outwards, around] = map.cell_lengths(at.x);
    let direction = map.direction(at.y);
    DMat2::from_cols(outwards * direction, around * direction.perp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foveation::Method;
    use crate::{Acuity, Eye, GazeDirection, Viewport};
    use glam::UVec2;

    fn request(gaze: GazeDirection) -> Request {
        Request {
            eye: Eye::Cyclopean,
            viewport: Viewport::new(UVec2::new(400, 300), [-0.7, 1.1, 0.9, -0.6]).unwrap(),
            acuity: Acuity::default(),
            gaze,
            ahead: GazeDirection::AHEAD,
            margin_deg: 2.0,
        }
    }

    #[test]
    fn steps_turn_the_ray_as_differences_do() {
        let request = request(GazeDirection::new(12.0, -7.0));
        let (px, h) = (DVec2::new(310.0, 41.0), 1e-4);
        let place = request.place(px);
        for step in [DVec2::X, DVec2::Y, DVec2::new(-2.0, 1.0)] {
            let at = |s: f64| request.viewport.direction(px + step * s);
            let turned = angle_deg(at(h), at(-h)) / (2.0 * h);
            assert!((place.angle_deg(step) / turned - 1.0).abs() < 1e-6);
            // Along the radius it is the change of eccentricity.
            let e = |s: f64| request.place(px + step * s).eccentricity_deg;
            let change = ((e(h) - e(-h)) / (2.0 * h)).abs();
            let along = place
                .spacing_deg(DMat2::from_cols(step, DVec2::ZERO))
                .radial;
            assert!((along / change - 1.0).abs() < 1e-5, "{along} {change}");
        }
        assert!(place.acuity_deg < request.acuity.mar_deg(place.eccentricity_deg) / 2.0);
        assert!(request.place(request.viewport.centre_px()).pixel_deg > 0.1);
    }

    #[test]
    fn plans_say_how_coarse_they_are() {
        let request = request(GazeDirection::AHEAD);
        let steps = |method: &str, x: f64, y: f64| {
            let method: Method = method.parse().unwrap();
            let plan = method.plan(&request).unwrap();
            plan.shading_steps(&request, DVec2::new(x, y))
                .to_cols_array()
        };
        assert_eq!(steps("full", 3.5, 3.5), [1.0, 0.0, 0.0, 1.0]);
        // Pixels are smaller along the radius, which is nearer x here.
        assert_eq!(steps("vrs", 398.5, 298.5), [4.0, 0.0, 0.0, 2.0]);
        assert_eq!(steps("lms:0:0", 8.5, 9.5), [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(steps("quad", 399.5, 0.5), [2.0, 0.0, 0.0, 2.0]);
        let sharp = Request {
            viewport: Viewport::symmetric(UVec2::new(1600, 1200), 0.6).unwrap(),
            ..request.clone()
        };
        let layers = "layers:3".parse::<Method>().unwrap().plan(&sharp).unwrap();
        let steps_at = |px| layers.shading_steps(&sharp, px);
        assert_eq!(steps_at(DVec2::new(800.5, 600.5)), DMat2::IDENTITY);
        assert!(steps_at(DVec2::splat(0.5)).x_axis.x > 2.0);
        let at = request.viewport.project(DVec3::NEG_Z).unwrap() + DVec2::new(0.0, 100.0);
        let [ox, oy, ax, ay] = steps("kfr:2:1", at.x, at.y);
        assert!(ox.abs() < 1e-9 && oy > 1.0 && ax < -1.0 && ay.abs() < 1e-9);
    }
}
