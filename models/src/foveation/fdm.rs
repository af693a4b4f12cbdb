use glam::{DVec2, UVec2};

use super::cells::Cells;
use super::estimate::Estimate;
use super::mosaic::{self, Density, Tally};
use super::need::Need;
use super::{Method, PlanCache, Request, TileSettings};
use crate::SamplePlan;

/// Fragment density maps (Vulkan `VK_EXT_fragment_density_map`): each tile of the display is rasterised
/// and shaded at a rate of its own.
///
/// A tile's rate is found as in variable-rate shading, but visibility is as coarse as shading, and 1 × 4
/// and 4 × 1 are allowed.
pub(super) fn plan(
    settings: &TileSettings,
    request: &Request,
    cache: Option<&PlanCache>,
) -> SamplePlan {
    let screen = (&request.viewport).into();
    let need = request.need(&screen, cache);
    let cell = UVec2::splat(settings.tile());
    let spacings = Cells::new(&need, cell);
    let densities: Vec<Density> = spacings
        .spacings(settings.enough())
        .map(|s| density(settings, s))
        .collect();
    mosaic::plan(
        Method::Fdm(*settings).to_string(),
        request,
        cell,
        &densities,
    )
}

/// The same with fractions of samples.
pub(super) fn estimate(settings: &TileSettings, need: &Need<'_>) -> Estimate {
    let mut tally = Tally::default();
    Cells::new(need, UVec2::splat(settings.tile())).survey(settings.enough(), |spacing, pixels| {
        tally.add(density(settings, spacing), pixels)
    });
    tally.estimate()
}

fn density(settings: &TileSettings, spacing: DVec2) -> Density {
    Density {
        x: 4 / settings.side(spacing.x),
        y: 4 / settings.side(spacing.y),
    }
}
