use super::cells::Cells;
use super::estimate::{Estimate, PassEstimate};
use super::need::Need;
use super::{Method, PlanCache, Request, TileSettings};
use crate::{ModelError, SamplePlan, Shading, ShadingRate, TileRates};
use glam::{DVec2, UVec2};

/// Variable-rate shading (Direct3D 12, Vulkan `VK_KHR_fragment_shading_rate`): visibility at every
/// display pixel, shading once per block of pixels, the block's size constant within a tile.
///
/// A tile's rate is the coarsest, per axis, that keeps to the spacing the eye needs everywhere in the
/// tile, at its least eccentricity and largest pixel.
pub(super) fn plan(
    settings: &TileSettings,
    request: &Request,
    cache: Option<&PlanCache>,
) -> Result<SamplePlan, ModelError> {
    let size = request.viewport.size;
    let screen = (&request.viewport).into();
    let need = request.need(&screen, cache);
    let cells = Cells::new(&need, UVec2::splat(settings.tile()));
    let mut spacings = cells.spacings(settings.enough());
    let rates = TileRates::new(size, settings.tile(), |_| {
        let spacing = spacings.next().expect("one cell for each tile");
        rate(settings, spacing)
    })?;
    let mut plan = SamplePlan::full(request.eye, size);
    plan.method = Method::Vrs(*settings).to_string();
    plan.passes[0].shading = Shading::Coarse(rates);
    Ok(plan)
}

/// The same with fractions of blocks.
pub(super) fn estimate(settings: &TileSettings, need: &Need<'_>) -> Estimate {
    let (mut shadings, mut block) = (0.0, 1.0f64);
    Cells::new(need, UVec2::splat(settings.tile())).survey(settings.enough(), |spacing, pixels| {
        let rate = rate(settings, spacing);
        let shared = f64::from(rate.x * rate.y);
        shadings += pixels / shared;
        block = block.max(shared);
    });
    let pixels = need.screen.pixels();
    let pass = PassEstimate {
        shadings,
        block,
        ..PassEstimate::new(pixels, DVec2::ONE)
    };
    Estimate {
        passes: vec![pass],
        display_pixels: pixels,
    }
}

/// Hardware has no 1 × 4 and 4 × 1: the longer side is halved there.
fn rate(settings: &TileSettings, spacing: DVec2) -> ShadingRate {
    let (x, y) = (settings.side(spacing.x), settings.side(spacing.y));
    ShadingRate {
        x: x.min(2 * y),
        y: y.min(2 * x),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_those_of_hardware() {
        let settings = TileSettings::default();
        let of = |x, y| {
            let rate = rate(&settings, DVec2::new(x, y));
            (rate.x, rate.y)
        };
        assert_eq!(of(0.2, 1.9), (1, 1));
        assert_eq!(of(2.0, 1.0), (2, 1));
        assert_eq!(of(2.0, 4.0), (2, 4));
        assert_eq!(of(9.0, 1.5), (2, 1));
        assert_eq!(of(1.5, 9.0), (1, 2));
        assert_eq!(of(f64::INFINITY, 4.0), (4, 4));
    }
}
