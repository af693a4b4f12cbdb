use foveasim_assets::{Detail, LodRule, Scene};
use foveasim_models::math::sqrt;
use foveasim_models::{Affine, Map, Pass, Pose, Resolve, SamplePlan, View, Viewport, Work};
use glam::{DVec2, DVec3};

use crate::RenderOptions;
use crate::live::live_box;
use crate::moving::Warp;
use crate::pass::projection;
use crate::placement::Placement;
use crate::project::{Optics, Projection};
use crate::raster::{Bounds, ViewGeometry, bounds, bounds_at};
use crate::tile::sampled;

/// The instances that may be visible in a pass, each with the mesh drawn for it: nearest first, so that
/// what hides comes before what is hidden.
#[derive(Debug)]
pub(crate) struct PassObjects {
    /// Instance and mesh.
    pub(crate) named: Vec<(u32, u32)>,
    /// Triangles that were left out.
    pub(crate) work: Work,
    /// Where the samples of the pass lie, if not evenly.
    pub(crate) placement: Option<Placement>,
}

/// A pass of one view, as far as the choice of its objects depends on it.
struct Sight<'a> {
    view: &'a View,
    eye_from_world: Pose,
    projection: Projection,
    /// Onto what is drawn of it; `None` if nothing is.
    drawn: Option<Projection>,
    placement: Option<Placement>,
    /// What is seen at most of a bent display, and from where at a scan's end.
    widest: Option<(Projection, Pose)>,
    outermost: bool,
}

impl<'a> Sight<'a> {
    fn new(
        scene: &Scene,
        view: &'a View,
        plan: &SamplePlan,
        pass: usize,
        options: &RenderOptions,
    ) -> Self {
        let warp = Warp::of(scene, view, options);
        let of_pass = &plan.passes[pass];
        let projection = projection(view, of_pass, options);
        Self {
            view,
            drawn: drawn(view, of_pass, &projection, options),
            widest: warp.map(|warp| {
                let widest = warp.widest(view, options.near_m);
                (widest, view.poses[1].inverse())
            }),
            eye_from_world: view.poses[0].inverse(),
            projection,
            placement: Placement::of(plan, pass, warp),
            // The outermost of several layers has a curve of its own; parts of a mosaic are no layers.
            outermost: matches!(plan.resolve, Resolve::Feather(_))
                && pass > 0
                && pass + 1 == plan.passes.len(),
        }
    }

    /// The least width of a sample that may show anything of instance `index`, as a tangent.
    fn sample_tan(&self, scene: &Scene, index: usize, eye: DVec3) -> f64 {
        let step = self.projection.tangent_step().abs().min_element();
        let Some(placement) = &self.placement else {
            return step;
        };
        let finest = Detail {
            rule: LodRule::Finest,
            outermost: self.outermost,
            sample_tan: step,
            error_samples: Detail::ERROR_SAMPLES,
        };
        let finest = scene.mesh_for(index, eye, finest);
        let at = bounds(scene, index, finest, self.eye_from_world);
        step * least_step(&self.view.optics, placement, &at)
    }
}

/// The instances that may be visible in any of the passes `shown`, each with the mesh for all `passes`, which
/// are seen from `eye` or so; and the triangles left out.
fn choose(
    scene: &Scene,
    passes: &[Sight<'_>],
    shown: &[Sight<'_>],
    eye: DVec3,
    options: &RenderOptions,
) -> (Vec<(u32, u32)>, Work) {
    let mut found = Vec::new();
    let mut work = Work::default();
    for index in 0..scene.instances().len() {
        let widths = passes.iter().map(|p| p.sample_tan(scene, index, eye));
        let detail = Detail {
            rule: options.lod,
            outermost: passes.iter().all(|p| p.outermost),
            sample_tan: widths.fold(f64::INFINITY, f64::min),
            error_samples: options.lod_error,
        };
        let mesh = scene.mesh_for(index, eye, detail);
        let mut missed = u8::MAX;
        let mut nearest = f64::INFINITY;
        for pass in shown {
            let at = bounds(scene, index, mesh, pass.eye_from_world);
            match &pass.widest {
                None => {
                    let drawn = pass.drawn.as_ref();
                    missed &=
                        drawn.map_or(u8::MAX, |drawn| drawn.sides_missed(at.centre, at.radius));
                }
                // Beyond a side at the start and at the end is beyond it in between, where corners move straight.
                Some((widest, end)) => {
                    let placed = scene.world_from_object_at_end(index);
                    let last = bounds_at(scene, placed, mesh, *end);
                    missed &= widest.sides_missed(at.centre, at.radius);
                    missed &= widest.sides_missed(last.centre, last.radius);
                }
            }
            nearest = nearest.min(at.centre.length() - at.radius);
        }
        // Beyond the same side of all of them: outside of what holds them all.
        if options.skip.outside && missed != 0 {
            let triangles = scene.meshes()[mesh].triangles().len() as u64;
            work.triangles += triangles;
            work.triangles_outside += triangles;
            continue;
        }
        found.push((nearest, (index as u32, mesh as u32)));
    }
    // Stable: of equal distances, the first in the scene.
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    (found.into_iter().map(|(_, name)| name).collect(), work)
}

impl PassObjects {
    pub(crate) fn of(
        scene: &Scene,
        view: &View,
        plan: &SamplePlan,
        pass: usize,
        options: &RenderOptions,
    ) -> Self {
        let sight = [Sight::new(scene, view, plan, pass, options)];
        let (named, work) = choose(scene, &sight, &sight, view.poses[0].position, options);
        let [Sight { placement, .. }] = sight;
        Self {
            named,
            work,
            placement,
        }
    }

    /// Of two eyes about `head`, which see each object at the same detail: the finer that either needs. With
    /// `together`, one list holds what either may see, and the work of making it stands with the first;
    /// else each eye has its own.
    pub(crate) fn of_eyes(
        scene: &Scene,
        views: [&View; 2],
        plans: [&SamplePlan; 2],
        pass: usize,
        head: DVec3,
        options: &RenderOptions,
        together: bool,
    ) -> [Self; 2] {
        let sights = [0, 1].map(|k| Sight::new(scene, views[k], plans[k], pass, options));
        let (first, second) = if together {
            let (named, work) = choose(scene, &sights, &sights, head, options);
            ((named.clone(), work), (named, Work::default()))
        } else {
            let alone = |k: usize| choose(scene, &sights, &sights[k..=k], head, options);
            (alone(0), alone(1))
        };
        let [left, right] = sights.map(|sight| sight.placement);
        let objects = |(named, work), placement| Self {
            named,
            work,
            placement,
        };
        [objects(first, left), objects(second, right)]
    }

    /// What a pass sees that shares the visibility of another one, whose objects are `self`.
    pub(crate) fn seen_by(&self, plan: &SamplePlan, pass: usize) -> Self {
        Self {
            named: self.named.clone(),
            work: Work::default(),
            // Refused of bent views: who shares visibility looks it up in an even pass.
            placement: Placement::of(plan, pass, None),
        }
    }

    /// All that several passes see, each once.
    pub(crate) fn all<'a>(passes: impl Iterator<Item = &'a Self>) -> Vec<(u32, u32)> {
        let mut named: Vec<_> = passes.flat_map(|p| p.named.iter().copied()).collect();
        named.sort_unstable();
        named.dedup();
        named
    }

    /// Where the objects of this pass are in `geometry`, which holds all of them.
    pub(crate) fn in_geometry(&self, geometry: &ViewGeometry) -> Vec<u32> {
        let mut order: Vec<u32> = (0..geometry.objects.len() as u32).collect();
        let name = |k: u32| {
            let object = &geometry.objects[k as usize];
            (object.instance, object.mesh)
        };
        order.sort_unstable_by_key(|&k| name(k));
        let find = |wanted: &(u32, u32)| order.binary_search_by_key(wanted, |&k| name(k)).ok();
        self.named
            .iter()
            .filter_map(|wanted| find(wanted).map(|place| order[place]))
            .collect()
    }
}

/// The projection onto what is drawn of a pass, whose own is `projection`.
fn drawn(
    view: &View,
    pass: &Pass,
    projection: &Projection,
    options: &RenderOptions,
) -> Option<Projection> {
    let Map::Affine(map) = sampled(pass) else {
        return Some(*projection);
    };
    let [first, end] = live_box(pass, projection.size, options);
    if first.cmpge(end).any() {
        return None;
    }
    let map = Affine {
        origin: map.display_from_lattice(first.as_dvec2()),
        ..map
    };
    let size = end - first;
    Some(Projection::new(&view.optics, &map, size, options.near_m))
}

/// The least step between samples \[px\] where anything within these bounds may be seen: a point of
/// them at offset d from the centre c has tangents that differ by |d_x·c_w − c_x·d_w| / (c_w·(c_w + d_w)),
/// at most r·√(1 + t²)/(c_w − r) for tangent t of the centre.
fn least_step(optics: &Viewport, placement: &Placement, at: &Bounds) -> f64 {
    let room = at.centre.z - at.radius;
    if room <= 0.0 {
        return 1.0;
    }
    let step = optics.pixel_tan();
    let tangent = at.centre.truncate() / at.centre.z;
    let px = optics.axis_px() + DVec2::new(tangent.x / step.x, -tangent.y / step.y);
    let reach = |t: f64, step: f64| at.radius / room * sqrt(1.0 + t * t) / step;
    let (across, down) = (reach(tangent.x, step.x), reach(tangent.y, step.y));
    placement.least_step(px, sqrt(across * across + down * down))
}

/// The geometry of these instances and meshes for one view.
pub(crate) fn geometry(
    scene: &Scene,
    view: &View,
    named: &[(u32, u32)],
    options: &RenderOptions,
) -> ViewGeometry {
    let optics = Optics::new(&view.optics);
    let geometry = ViewGeometry::new(scene, view.poses[0], &optics, named, options.simd);
    match Warp::of(scene, view, options).and_then(|warp| warp.scan) {
        Some(_) => geometry.until(scene, view.poses[1], &optics, named, options.simd),
        None => geometry,
    }
}
