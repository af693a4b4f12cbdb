use foveasim_assets::{Scene, Similarity};
use foveasim_models::{SamplePlan, View};
use foveasim_render::{RenderError, RenderOptions, Surfel, visibility};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// By what part 1/w of a point may lie beyond that of the pixels around it and still be theirs.
const DEPTH_TOLERANCE: f64 = 0.01;

/// The points of a scene that the pixels of one frame show, to be found again in others: they stay on
/// their instances, however these and the eye move.
#[derive(Debug, Clone)]
pub struct Tracks {
    points: Vec<Point>,
    options: RenderOptions,
}

#[derive(Debug, Clone, Copy)]
enum Point {
    /// On an instance, in its own frame.
    On(u32, DVec3),
    /// In the sky: a direction in the world.
    Sky(DVec3),
}

impl Tracks {
    /// What the middles of the pixels of `view` see, row by row.
    ///
    /// # Errors
    /// If the renderer refuses the view.
    pub fn new(scene: &Scene, view: &View, options: &RenderOptions) -> Result<Self, RenderError> {
        let width = view.optics.size.x.max(1) as usize;
        let point = |(index, seen): (usize, &Option<Surfel>)| {
            let (x, y) = (index % width, index / width);
            let px = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let ray = view.optics.direction(px);
            match seen {
                Some(surfel) => {
                    let depth = f64::from(surfel.depth_m);
                    let world = view.poses[0].point(ray * (depth / -ray.z));
                    let instance = &scene.instances()[surfel.instance as usize];
                    let on_it = object_from_world(&instance.world_from_object, world);
                    Point::On(surfel.instance, on_it)
                }
                None => Point::Sky(view.poses[0].direction(ray)),
            }
        };
        let seen = surfels(scene, view, options)?;
        Ok(Self {
            points: seen.par_iter().enumerate().map(point).collect(),
            options: *options,
        })
    }

    /// Where each point is in `view` of the scene as it then is \[px\]; `None` if it is hidden or out
    /// of sight. A point counts as seen if its depth is between those of the four pixels around it:
    /// beside an outline both what is in front and what is behind are.
    ///
    /// # Errors
    /// If the renderer refuses the view.
    pub fn places(&self, scene: &Scene, view: &View) -> Result<Vec<Option<DVec2>>, RenderError> {
        let seen = surfels(scene, view, &self.options)?;
        let size = view.optics.size;
        let width = size.x as usize;
        let inverse_w = |x: usize, y: usize| {
            seen[y * width + x].map_or(0.0, |surfel| 1.0 / f64::from(surfel.depth_m))
        };
        let place = |point: &Point| {
            let (from_eye, at) = match *point {
                Point::On(instance, at) => {
                    let instance = scene.instances().get(instance as usize)?;
                    let world = instance.world_from_object.point(at);
                    let from_eye = view.poses[0].inverse().point(world);
                    (from_eye, -1.0 / from_eye.z)
                }
                Point::Sky(direction) => (view.poses[0].inverse().direction(direction), 0.0),
            };
            let px = view.optics.project(from_eye)?;
            let low = (px - 0.5).floor();
            let last = size.as_dvec2() - 2.0;
            if !(low.cmpge(DVec2::ZERO).all() && low.cmple(last).all()) {
                return None;
            }
            let (x, y) = (low.x as usize, low.y as usize);
            let around = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| inverse_w(x + dx, y + dy));
            let least = around.into_iter().fold(f64::INFINITY, f64::min);
            let greatest = around.into_iter().fold(0.0, f64::max);
            let seen =
                at >= least * (1.0 - DEPTH_TOLERANCE) && at <= greatest * (1.0 + DEPTH_TOLERANCE);
            seen.then_some(px)
        };
        Ok(self.points.par_iter().map(place).collect())
    }
}

/// What the middle of each pixel sees.
fn surfels(
    scene: &Scene,
    view: &View,
    options: &RenderOptions,
) -> Result<Vec<Option<Surfel>>, RenderError> {
    let plan = SamplePlan::full(view.eye, view.optics.size);
    visibility(scene, view, &plan, 0, options)
}

fn object_from_world(placed: &Similarity, world: DVec3) -> DVec3 {
    placed.pose.inverse().point(world) / placed.scale
}

#[cfg(test)]
mod tests {
    use foveasim_assets::{study_camera, study_scene};
    use foveasim_models::{Eye, Viewport};
    use glam::UVec2;

    use super::*;

    fn view(t: f64) -> View {
        let optics = Viewport::symmetric(UVec2::new(96, 54), 0.43).unwrap();
        View::still(Eye::Cyclopean, optics, study_camera(t, 1))
    }

    #[test]
    fn points_are_where_they_were_and_move_with_the_view() {
        let scene = study_scene(1);
        let options = RenderOptions::default();
        let tracks = Tracks::new(&scene, &view(0.3), &options).unwrap();
        let here = tracks.places(&scene, &view(0.3)).unwrap();
        let mut found = 0;
        for (k, place) in here.iter().enumerate() {
            let middle = DVec2::new((k % 96) as f64 + 0.5, (k / 96) as f64 + 0.5);
            if let Some(px) = place {
                // Depth is single precision, but moves a point along its own ray.
                assert!(px.distance(middle) < 1e-6, "{px} {middle}");
                found += 1;
            }
        }
        // All but those at the edges, whose pixels around are not all there, and some beside outlines.
        assert!(found > 95 * 53 * 97 / 100, "{found}");

        // Later most of them are seen, elsewhere, and at the depth that is seen there.
        let later = view(0.302);
        let there = tracks.places(&scene, &later).unwrap();
        let moved = here
            .iter()
            .zip(&there)
            .filter_map(|(a, b)| Some((*a)?.distance((*b)?)));
        let moved: Vec<f64> = moved.collect();
        assert!(moved.len() > found * 8 / 10, "{} of {found}", moved.len());
        assert!(moved.iter().sum::<f64>() / moved.len() as f64 > 0.2);
        // From the other end of the flight, hardly any.
        let far = tracks.places(&scene, &view(0.95)).unwrap();
        let ground = |k: &usize| matches!(tracks.points[*k], Point::On(..)) && far[*k].is_some();
        let seen = (0..far.len()).filter(ground).count();
        assert!(seen < found / 10, "{seen}");
    }
}
