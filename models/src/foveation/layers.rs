use super::design::OUTER_EVERY;
use super::{Blending, Coverage, LayerDesign, LayersSettings, Method, Request, Screen, lattice};
use crate::math::tan_deg;
use crate::{
    Cadence, Feather, Lattice, Map, Msaa, Pass, Region, Resolve, SamplePlan, Shading, Visibility,
};
use glam::DVec2;

/// Eccentricity layers (Guenter 2012, §4) as a drawable plan.
///
/// Radii and scales are those of `design`, which is for this image; rectangles are exact
/// (see [`Coverage::Exact`]) and clipped to the screen, and a layer that is entirely off it is left
/// out. The inner layer is drawn every frame on the display's own grid; the others every second
/// frame, taking turns. Each layer keeps full weight up to 0.6·e_i and blends out to e_i.
///
/// The outer layers' scales are rounded down a little where that makes whole samples fit the screen.
pub(super) fn plan(
    settings: &LayersSettings,
    design: &LayerDesign,
    request: &Request,
) -> SamplePlan {
    let viewport = &request.viewport;
    let method = Method::Layers(*settings).to_string();
    if design.layers().len() == 1 {
        return SamplePlan {
            method,
            ..SamplePlan::full(request.eye, viewport.size)
        };
    }
    let gaze = request.gaze.vector();
    let screen = Screen::from(viewport);
    let mut passes = Vec::with_capacity(design.layers().len());
    let mut edges_tan = Vec::with_capacity(design.layers().len() - 1);
    for (i, layer) in design.layers().iter().enumerate() {
        let grid = match layer.eccentricity_deg {
            None => lattice::whole(viewport, layer.scale),
            Some(e) => {
                let area = Coverage::Exact
                    .rectangle(gaze, e)
                    .and_then(|r| r.clipped(&screen));
                let Some(area) = area else { continue };
                edges_tan.push([tan_deg(Blending::FULL_WEIGHT_TO * e), tan_deg(e)]);
                lattice::covering(viewport, area, layer.scale)
            }
        };
        passes.push(pass(request, i, grid));
    }
    SamplePlan {
        method,
        display_px: viewport.size,
        passes,
        resolve: Resolve::Feather(Feather { gaze, edges_tan }),
    }
}

fn pass(request: &Request, layer: usize, (lattice, map): (Lattice, Map)) -> Pass {
    let cadence = match u32::try_from(layer) {
        Ok(i @ 1..) => Cadence {
            every: OUTER_EVERY,
            phase: (i - 1) % OUTER_EVERY.get(),
        },
        _ => Cadence::EVERY_FRAME,
    };
    Pass {
        eye: request.eye,
        lattice,
        map,
        region: Region::All,
        offset: DVec2::ZERO,
        visibility: Visibility::Own(Msaa::One),
        shading: Shading::PerSample,
        cadence,
    }
}
