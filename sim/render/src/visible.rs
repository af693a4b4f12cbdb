use foveasim_assets::{Detail, LodRule, Scene};
use foveasim_models::{Resolve, SamplePlan, View, Viewport, Work};
use glam::DVec2;

use foveasim_models::math::sqrt;

use crate::RenderOptions;
use crate::pass::projection;
use crate::placement::Placement;
use crate::project::Optics;
use crate::raster::{Bounds, ViewGeometry, bounds};

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

impl PassObjects {
    pub(crate) fn of(
        scene: &Scene,
        view: &View,
        plan: &SamplePlan,
        pass: usize,
        options: &RenderOptions,
    ) -> Self {
        let eye_from_world = view.poses[0].inverse();
        let placement = Placement::of(plan, pass);
        let projection = projection(view, &plan.passes[pass], options);
        let detail = Detail {
            rule: options.lod,
            // The outermost of several layers has a curve of its own; parts of a mosaic are no layers.
            outermost: matches!(plan.resolve, Resolve::Feather(_))
                && pass > 0
                && pass + 1 == plan.passes.len(),
            sample_tan: projection.tangent_step().abs().min_element(),
        };
        let mut found = Vec::new();
        let mut work = Work::default();
        for index in 0..scene.instances().len() {
            let mut detail = detail;
            if let Some(placement) = &placement {
                let finest = Detail {
                    rule: LodRule::Finest,
                    ..detail
                };
                let finest = scene.mesh_for(index, view.poses[0].position, finest);
                let at = bounds(scene, index, finest, eye_from_world);
                detail.sample_tan *= least_step(&view.optics, placement, &at);
            }
            let mesh = scene.mesh_for(index, view.poses[0].position, detail);
            let at = bounds(scene, index, mesh, eye_from_world);
            if options.skip.outside && projection.misses_sphere(at.centre, at.radius) {
                let triangles = scene.meshes()[mesh].triangles().len() as u64;
                work.triangles += triangles;
                work.triangles_outside += triangles;
                continue;
            }
            found.push((at.centre.length() - at.radius, (index as u32, mesh as u32)));
        }
        // Stable: of equal distances, the first in the scene.
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let named = found.into_iter().map(|(_, name)| name).collect();
        Self {
            named,
            work,
            placement,
        }
    }

    /// What a pass sees that shares the visibility of another one, whose objects are `self`.
    pub(crate) fn seen_by(&self, plan: &SamplePlan, pass: usize) -> Self {
        Self {
            named: self.named.clone(),
            work: Work::default(),
            placement: Placement::of(plan, pass),
        }
    }

    /// The geometry of this pass alone.
    pub(crate) fn geometry(
        &self,
        scene: &Scene,
        view: &View,
        options: &RenderOptions,
    ) -> ViewGeometry {
        geometry(scene, view, &self.named, options)
    }

    /// The geometry that several passes share.
    pub(crate) fn shared<'a>(
        passes: impl Iterator<Item = &'a Self>,
        scene: &Scene,
        view: &View,
        options: &RenderOptions,
    ) -> ViewGeometry {
        let mut named: Vec<_> = passes.flat_map(|p| p.named.iter().copied()).collect();
        named.sort_unstable();
        named.dedup();
        geometry(scene, view, &named, options)
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

fn geometry(
    scene: &Scene,
    view: &View,
    named: &[(u32, u32)],
    options: &RenderOptions,
) -> ViewGeometry {
    let optics = Optics::new(&view.optics);
    ViewGeometry::new(scene, view.poses[0], &optics, named, options.simd)
}
