use std::time::Duration;

use foveasim_assets::Scene;
use foveasim_models::{Image, SamplePlan};
use foveasim_quality::compare;
use foveasim_render::{Focus, Lighting, RenderOptions, Shadows, render, visibility};
use foveasim_reports::Table;

use super::place::Place;
use super::timing::timed;
use super::{Friston2019Outcome, ReproduceError};
use crate::kernel::median;

/// One way to find shadows on one scene.
#[derive(Debug, Clone, PartialEq)]
pub struct ShadowRow {
    /// The scene.
    pub scene: String,
    /// The way.
    pub way: &'static str,
    /// Texels of all maps.
    pub texels: u64,
    /// Time of a frame \[ms\].
    pub frame_ms: f64,
    /// SSIM of the fovea against a map of the most texels.
    pub ssim: f64,
}

/// Texels along each side of the maps compared: one map, and two of as many texels together.
const SIZES: [u32; 2] = [512, 362];
/// Of the map that stands for the truth.
const REFERENCE: u32 = 4096;
/// How far around what the eye looks at the second map reaches, as a share of how far away that is.
const REACH: f64 = 0.25;

/// One map, and one with a second look, of as many texels together.
pub(super) fn measure(
    places: &[Place],
    rounds: u32,
    clock: &mut dyn FnMut() -> Duration,
) -> Result<Vec<ShadowRow>, ReproduceError> {
    let mut rows = Vec::new();
    for place in places {
        let plan = SamplePlan::full(place.view.eye, place.view.optics.size);
        let lit = |shadows| RenderOptions {
            lighting: Lighting {
                shadows: Some(shadows),
                ..Lighting::default()
            },
            ..RenderOptions::default()
        };
        let one = |size| Shadows { size, focus: None };
        let truth = render(&place.world, &place.view, &plan, &lit(one(REFERENCE)))?.image;
        let judge = |image: &Image| -> Result<f64, ReproduceError> {
            Ok(compare(&place.fovea_of(image), &place.fovea_of(&truth))?
                .whole
                .ssim)
        };
        let focused = Shadows {
            size: SIZES[1],
            focus: Some(focus(place, &place.world)?),
        };
        for (way, shadows) in [("one map", one(SIZES[0])), ("foveated", focused)] {
            let (mut times, mut last) = (Vec::new(), None);
            for _ in 0..rounds {
                let (frame, ms) = timed(&place.world, &place.view, &plan, &lit(shadows), clock)?;
                times.push(ms);
                last = Some(frame);
            }
            let Some(frame) = last else { continue };
            rows.push(ShadowRow {
                scene: place.scene.to_string(),
                way,
                texels: frame.work.shadow_texels,
                frame_ms: median(times),
                ssim: judge(&frame.image)?,
            });
        }
    }
    Ok(rows)
}

/// What the eye looks at: the nearest surface at the gaze, or the middle of the scene if that is the sky.
fn focus(place: &Place, world: &Scene) -> Result<Focus, ReproduceError> {
    let size = place.view.optics.size;
    let plan = SamplePlan::full(place.view.eye, size);
    let seen = visibility(world, &place.view, &plan, 0, &RenderOptions::default())?;
    let px = place.gaze_px();
    let at = (px.y as u32).min(size.y - 1) * size.x + (px.x as u32).min(size.x - 1);
    let eye = place.view.poses[0];
    let away = seen[at as usize].map(|s| f64::from(s.depth_m));
    Ok(match away {
        Some(away) => Focus {
            centre: eye.point(place.view.optics.direction(px) * away),
            radius_m: (REACH * away).max(1e-3),
        },
        None => {
            let [low, high] = world.bounds().unwrap_or_default();
            let centre = (low + high) / 2.0;
            Focus {
                centre,
                radius_m: (REACH * eye.position.distance(centre)).max(1e-3),
            }
        }
    })
}

impl Friston2019Outcome {
    /// Fig. 12, foveated shadows.
    pub fn shadow_table(&self) -> Table {
        let mut table = Table::new(["scene", "way", "texels", "frame_ms", "ssim_fovea"]);
        for r in &self.shadows {
            table.push(vec![
                r.scene.as_str().into(),
                r.way.into(),
                r.texels.into(),
                r.frame_ms.into(),
                r.ssim.into(),
            ]);
        }
        table
    }
}
