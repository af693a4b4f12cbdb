use foveasim_assets::Scene;
use foveasim_models::{SamplePlan, Shading, View, Visibility, Work};

use crate::RenderOptions;
use crate::pass::{PassSamples, draw, find_shared};
use crate::shared::SharedVisibility;
use crate::visible::PassObjects;

/// What was drawn of a plan.
#[derive(Debug)]
pub(crate) struct Drawn {
    /// Samples and work of each pass that was due.
    pub(crate) passes: Vec<Option<(PassSamples, Work)>>,
    /// Work that passes share.
    pub(crate) shared: Work,
}

/// Draws the passes of a plan that are `due`, with vertices transformed once for all of them; `spare` is
/// memory for the first.
pub(crate) fn draw_passes(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    due: &[bool],
    options: &RenderOptions,
    keep_geometry: bool,
    mut spare: Vec<[f32; 3]>,
) -> Drawn {
    let mut objects: Vec<Option<PassObjects>> = Vec::with_capacity(due.len());
    for (k, due) in due.iter().enumerate() {
        let of_pass = due.then(|| match plan.passes[k].visibility {
            // Checked: an earlier pass, in the same frames.
            Visibility::Shared(other) => {
                let found = objects[other].as_ref();
                found.map(|found| found.seen_by(plan, k))
            }
            _ => Some(PassObjects::of(scene, view, plan, k, options)),
        });
        objects.push(of_pass.flatten());
    }
    let shared = options
        .skip
        .repeated_vertices
        .then(|| PassObjects::shared(objects.iter().flatten(), scene, view, options));
    let mut found: Vec<Option<SharedVisibility>> = (0..due.len()).map(|_| None).collect();
    let passes = objects.iter().enumerate().map(|(k, objects)| {
        let objects = objects.as_ref()?;
        let own;
        let geometry = match &shared {
            Some(geometry) => geometry,
            None => {
                own = objects.geometry(scene, view, options);
                &own
            }
        };
        let (samples, mut work) = if plan.passes[k].shading == Shading::Nowhere {
            let (visibility, work) = find_shared(scene, view, plan, k, geometry, objects, options);
            found[k] = Some(visibility);
            (PassSamples::NONE, work)
        } else {
            let shared = match plan.passes[k].visibility {
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
                shared,
                std::mem::take(&mut spare),
            )
        };
        if shared.is_none() {
            work += geometry.work;
        }
        Some((samples, work))
    });
    Drawn {
        passes: passes.collect(),
        shared: shared.as_ref().map_or(Work::default(), |g| g.work),
    }
}
