use std::time::Duration;

use foveasim_assets::Scene;
use foveasim_models::SamplePlan;
use foveasim_render::{Frame, RenderOptions, render};

use super::ReproduceError;
use super::place::Place;

/// Milliseconds of a frame, and of the same frame with one colour everywhere: visibility and reconstruction alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FrameTime {
    pub(super) frame: f64,
    pub(super) bare: f64,
}

impl FrameTime {
    pub(super) fn shading(self) -> f64 {
        self.frame - self.bare
    }
}

/// Draws a plan of a place, and says how long it took.
pub(super) fn timed(
    place: &Place,
    scene: &Scene,
    plan: &SamplePlan,
    options: &RenderOptions,
    clock: &mut dyn FnMut() -> Duration,
) -> Result<(Frame, f64), ReproduceError> {
    let began = clock();
    let frame = render(scene, &place.view, plan, options)?;
    Ok((frame, (clock().saturating_sub(began)).as_secs_f64() * 1e3))
}

/// Draws a plan with and without anything to shade.
pub(super) fn pair(
    place: &Place,
    plan: &SamplePlan,
    options: &RenderOptions,
    clock: &mut dyn FnMut() -> Duration,
) -> Result<(Frame, FrameTime), ReproduceError> {
    let (frame, whole) = timed(place, &place.world, plan, options, clock)?;
    let (_, bare) = timed(place, &place.bare, plan, options, clock)?;
    Ok((frame, FrameTime { frame: whole, bare }))
}
