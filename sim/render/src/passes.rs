use foveasim_assets::Scene;
use foveasim_models::{SamplePlan, View, Work};

use crate::RenderOptions;
use crate::pass::{PassMemory, PassSamples, draw};
use crate::visible::PassObjects;

/// What was drawn of a plan.
#[derive(Debug)]
pub(crate) struct Drawn {
    /// Samples and work of each pass that was due.
    pub(crate) passes: Vec<Option<(PassSamples, Work)>>,
    /// Work that passes share.
    pub(crate) shared: Work,
}

/// Draws the passes of a plan that are `due`, with vertices transformed once for all of them; `memory`
/// is what the first ones can use.
pub(crate) fn draw_passes(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    due: &[bool],
    options: &RenderOptions,
    keep_geometry: bool,
    memory: Vec<PassMemory>,
) -> Drawn {
    let objects: Vec<_> = due
        .iter()
        .enumerate()
        .map(|(k, due)| due.then(|| PassObjects::of(scene, view, plan, k, options)))
        .collect();
    let shared = options
        .skip
        .repeated_vertices
        .then(|| PassObjects::shared(objects.iter().flatten(), scene, view, options));
    let mut memory = memory.into_iter();
    let passes = objects.iter().enumerate().map(|(k, objects)| {
        let memory = memory.next().unwrap_or_default();
        let objects = objects.as_ref()?;
        let own;
        let geometry = match &shared {
            Some(geometry) => geometry,
            None => {
                own = objects.geometry(scene, view, options);
                &own
            }
        };
        let (samples, mut work) = draw(
            scene,
            view,
            plan,
            k,
            geometry,
            objects,
            options,
            keep_geometry,
            memory,
        );
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
