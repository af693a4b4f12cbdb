use foveasim_models::math::log;
use foveasim_models::{Resolve, SamplePlan, Viewport};

use super::probe::Probe;
use super::zones::PassZones;

/// What the time of a frame is made of, before it is drawn: milliseconds as the probe of its scene has them, and counts of
/// its plan.
pub(super) type Terms = [f64; TERMS.len()];

/// Their names.
pub(super) const TERMS: [&str; 14] = [
    "frame",
    "passes",
    "tiles",
    "geometry_ms",
    "geometry_placed_ms",
    "visibility_ms",
    "visibility_placed_ms",
    "shading_ms",
    "samples",
    "samples_placed",
    "pixels_direct",
    "pixels_feathered",
    "pixels_mosaic",
    "pixels_inverse",
];

/// The terms of a plan of a scene.
pub(super) fn terms(
    plan: &SamplePlan,
    viewport: &Viewport,
    passes: &[PassZones],
    probe: &Probe,
) -> Terms {
    let mut terms = [0.0; TERMS.len()];
    let mut add = |name: &str, value: f64| {
        let place = TERMS.iter().position(|t| *t == name);
        terms[place.expect("a term")] += value;
    };
    let width = log(f64::from(viewport.size.x));
    add("frame", 1.0);
    for pass in passes {
        add("passes", 1.0);
        add("tiles", pass.tiles);
        let finest = pass.finest_log_px() - width;
        let geometry = probe.geometry(pass.reach, finest);
        let placed = |even: &'static str, placed: &'static str| match pass.placed {
            true => placed,
            false => even,
        };
        if pass.finds {
            add(placed("geometry_ms", "geometry_placed_ms"), geometry);
        }
        for (k, zone) in pass.zones.iter().enumerate() {
            if pass.finds {
                let each = probe.visibility(zone.log_sample_px - width);
                add(
                    placed("visibility_ms", "visibility_placed_ms"),
                    zone.samples * each,
                );
                add(placed("samples", "samples_placed"), zone.samples);
            }
            let each = probe.shading(k, zone.log_shading_px - width);
            add("shading_ms", zone.shadings * each);
        }
    }
    let pixels = f64::from(viewport.size.x) * f64::from(viewport.size.y);
    match plan.resolve {
        Resolve::Direct => add("pixels_direct", pixels),
        Resolve::Feather(_) => add("pixels_feathered", pixels),
        Resolve::Mosaic => add("pixels_mosaic", pixels),
        _ => add("pixels_inverse", pixels),
    }
    terms
}
