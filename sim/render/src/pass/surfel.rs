use foveasim_assets::Scene;
use foveasim_models::{SamplePlan, View, Visibility, Work};

use super::{Drawing, Scratch, tiles};
use crate::live::grid;
use crate::tile::{LANES, SampleTile};
use crate::visible::{PassObjects, geometry};
use crate::{RenderError, RenderOptions};

/// What one sample sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surfel {
    /// Index of the instance in the scene.
    pub instance: u32,
    /// Index of the mesh drawn for it.
    pub mesh: u32,
    /// Index of the triangle in that mesh.
    pub triangle: u32,
    /// Distance along the view axis \[m\].
    pub depth_m: f32,
}

/// What each sample of pass `pass` of the plan sees, row by row; `None` is sky, or not drawn. With
/// several positions of visibility per sample, what is seen at the first.
///
/// # Errors
/// As [`render`](crate::render); also if there is no such pass.
pub fn visibility(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    pass: usize,
    options: &RenderOptions,
) -> Result<Vec<Option<Surfel>>, RenderError> {
    visibility_at(scene, view, plan, pass, 0, options)
}

/// As [`visibility`], at any of the positions of visibility that samples of the pass have, from 0.
///
/// # Errors
/// As [`visibility`]; also if there is no such position.
pub fn visibility_at(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    pass: usize,
    position: usize,
    options: &RenderOptions,
) -> Result<Vec<Option<Surfel>>, RenderError> {
    check_position(scene, view, plan, pass, position, options)?;
    let size = grid(&plan.passes[pass]);
    if size.min_element() == 0 {
        return Ok(Vec::new());
    }
    let objects = PassObjects::of(scene, view, plan, pass, options);
    let geometry = geometry(scene, view, &objects.named, options);
    let drawing = Drawing::new(scene, view, plan, pass, &geometry, &objects, options, None);
    let mut surfels = vec![None; size.x as usize * size.y as usize];
    let mut scratch = Scratch::new(&drawing);
    for (x, y) in tiles(size) {
        let tile = SampleTile::of(&plan.passes[pass], x, y);
        drawing.find_visible(&tile, &mut scratch, &mut Work::default());
        for (place, first) in drawing.samples(&tile, &scratch.buffers) {
            let index = first + LANES * position;
            let slot = scratch.buffers.slot.as_flattened()[index];
            if slot != 0 {
                let t = &scratch.triangles[slot as usize - 1];
                let object = &geometry.objects[t.object as usize];
                surfels[place] = Some(Surfel {
                    instance: object.instance,
                    mesh: object.mesh,
                    triangle: t.index() as u32,
                    depth_m: 1.0 / scratch.buffers.depth.as_flattened()[index],
                });
            }
        }
    }
    Ok(surfels)
}

/// Refuses what cannot be drawn, and passes and positions that are not there.
pub(crate) fn check_position(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    pass: usize,
    position: usize,
    options: &RenderOptions,
) -> Result<(), RenderError> {
    crate::check::check(scene, view, plan, options)?;
    let why = match plan.passes.get(pass).map(|p| p.visibility) {
        Some(Visibility::Own(msaa)) if position < msaa.positions() as usize => return Ok(()),
        Some(Visibility::Own(msaa)) => {
            let count = msaa.positions();
            format!("position {position}: there are {count} per sample, counted from 0")
        }
        Some(other) => format!("cannot find visibility by {other:?}"),
        None => format!("there are {} passes, counted from 0", plan.passes.len()),
    };
    Err(RenderError::Pass {
        method: plan.method.clone(),
        pass,
        why,
    })
}
