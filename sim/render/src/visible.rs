use foveasim_assets::{Detail, Scene};
use foveasim_models::{Resolve, SamplePlan, View, Work};

use crate::RenderOptions;
use crate::pass::projection;
use crate::project::Optics;
use crate::raster::{ViewGeometry, bounds};

/// The instances that may be visible in a pass, each with the mesh drawn for it: nearest first, so that
/// what hides comes before what is hidden.
#[derive(Debug)]
pub(crate) struct PassObjects {
    /// Instance and mesh.
    pub(crate) named: Vec<(u32, u32)>,
    /// Triangles that were left out.
    pub(crate) work: Work,
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
        Self { named, work }
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

fn geometry(
    scene: &Scene,
    view: &View,
    named: &[(u32, u32)],
    options: &RenderOptions,
) -> ViewGeometry {
    let optics = Optics::new(&view.optics);
    ViewGeometry::new(scene, view.poses[0], &optics, named, options.simd)
}
