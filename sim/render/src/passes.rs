use foveasim_assets::Scene;
use foveasim_models::{SamplePlan, Shading, View, Visibility, Work};

use crate::pass::{PassSamples, draw, find_shared};
use crate::raster::ViewGeometry;
use crate::shadow::Illumination;
use crate::shared::SharedVisibility;
use crate::visible::{PassObjects, geometry};
use crate::{FrameMemory, RenderOptions};

/// What was drawn of a plan.
#[derive(Debug)]
pub(crate) struct Drawn {
    /// Samples and work of each pass that was due.
    pub(crate) passes: Vec<Option<(PassSamples, Work)>>,
    /// Work that passes share.
    pub(crate) shared: Work,
}

/// Transforms the vertices of instances and meshes.
type Transform<'a> = dyn Fn(&[(u32, u32)]) -> ViewGeometry + 'a;

/// Draws the passes of a plan that are `due`, with vertices transformed once for all of them.
pub(crate) fn draw_passes(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    due: &[bool],
    options: &RenderOptions,
    keep_geometry: bool,
    memory: &mut FrameMemory,
) -> Drawn {
    let objects = objects_of(plan, due, |k| {
        PassObjects::of(scene, view, plan, k, options)
    });
    let geometry = |named: &[(u32, u32)]| geometry(scene, view, named, options);
    draw_objects(
        scene,
        view,
        plan,
        &objects,
        &geometry,
        options,
        keep_geometry,
        memory,
    )
}

/// The objects of each pass that is due; `find` finds those of a pass that finds its own visibility.
pub(crate) fn objects_of(
    plan: &SamplePlan,
    due: &[bool],
    mut find: impl FnMut(usize) -> PassObjects,
) -> Vec<Option<PassObjects>> {
    let mut objects: Vec<Option<PassObjects>> = Vec::with_capacity(due.len());
    for (k, due) in due.iter().enumerate() {
        let of_pass = due.then(|| match plan.passes[k].visibility {
            // Checked: an earlier pass, in the same frames.
            Visibility::Shared(other) => {
                let found = objects[other].as_ref();
                found.map(|found| found.seen_by(plan, k))
            }
            _ => Some(find(k)),
        });
        objects.push(of_pass.flatten());
    }
    objects
}

/// Draws the passes of a plan that have objects. `geometry` transforms the vertices of instances and
/// meshes: of all at once, unless each pass is to repeat that.
pub(crate) fn draw_objects(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    objects: &[Option<PassObjects>],
    geometry: &Transform<'_>,
    options: &RenderOptions,
    keep_geometry: bool,
    memory: &mut FrameMemory,
) -> Drawn {
    let shared = options
        .skip
        .repeated_vertices
        .then(|| geometry(&PassObjects::all(objects.iter().flatten())));
    let mut found: Vec<Option<SharedVisibility>> = objects.iter().map(|_| None).collect();
    let illumination = Illumination::new(scene, view, options);
    let passes = objects.iter().enumerate().map(|(k, objects)| {
        let objects = objects.as_ref()?;
        let own;
        let geometry = match &shared {
            Some(geometry) => geometry,
            None => {
                own = geometry(&objects.named);
                &own
            }
        };
        let (samples, mut work) = if plan.passes[k].shading == Shading::Nowhere {
            let (visibility, work) = find_shared(scene, view, plan, k, geometry, objects, options);
            found[k] = Some(visibility);
            (PassSamples::NONE, work)
        } else {
            let seen = match plan.passes[k].visibility {
                Visibility::Shared(other) => found[other].as_ref(),
                _ => None,
            };
            draw(
                scene,
                view,
                plan,
                k,
                geometry,
                objects,
                options,
                keep_geometry,
                seen,
                &illumination,
                memory,
            )
        };
        if shared.is_none() {
            work += geometry.work;
        }
        Some((samples, work))
    });
    let passes = passes.collect();
    let mut work = illumination.work;
    if let Some(geometry) = &shared {
        work += geometry.work;
    }
    Drawn {
        passes,
        shared: work,
    }
}
