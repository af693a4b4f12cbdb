use std::time::Duration;

use foveasim_assets::Scene;
use foveasim_models::{SamplePlan, View};
use foveasim_render::{Frame, RenderOptions, render};

use super::ReproduceError;

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

/// Draws a plan, and says how long it took.
pub(super) fn timed(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    options: &RenderOptions,
    clock: &mut dyn FnMut() -> Duration,
) -> Result<(Frame, f64), ReproduceError> {
    let began = clock();
    let frame = render(scene, view, plan, options)?;
    Ok((frame, (clock().saturating_sub(began)).as_secs_f64() * 1e3))
}

/// Draws a plan with and without anything to shade: scenes are the world, and the same in one colour.
pub(super) fn pair(
    [world, bare]: [&Scene; 2],
    view: &View,
    plan: &SamplePlan,
    options: &RenderOptions,
    clock: &mut dyn FnMut() -> Duration,
) -> Result<(Frame, FrameTime), ReproduceError> {
    let (frame, whole) = timed(world, view, plan, options, clock)?;
    let (_, bare) = timed(bare, view, plan, options, clock)?;
    Ok((frame, FrameTime { frame: whole, bare }))
}
