//! An environment map against the sky that it is an image of.

mod common;

use common::{sun, view};
use foveasim_assets::{AnalyticSky, EnvironmentMap, Scene, Sky};
use foveasim_models::{Eye, Pose, SamplePlan};
use foveasim_render::{RenderOptions, render};
use glam::{DQuat, DVec3};

/// The image of a sky against the sky itself, at samples of the map's own size and far above: there
/// both are means over much the same angle.
#[test]
fn the_environment_map_shows_the_sky_it_was_made_of() {
    let analytic = AnalyticSky {
        seed: 7,
        zenith: [0.10, 0.24, 0.60],
        horizon: [0.55, 0.68, 0.86],
        mountains: [0.16, 0.20, 0.26],
        cloud_cover: 0.45,
        visibility_m: 420.0,
    };
    let map = EnvironmentMap::of_sky(&analytic, &sun(), 512);
    let scene = |sky| Scene::new(vec![], vec![], vec![], sky, sun()).unwrap();
    let scenes = [Sky::Analytic(analytic), Sky::Map(map)].map(scene);
    // Along the horizon, halfway up, straight up, and down.
    for (pitch, largest) in [(0.1, 0.02), (0.8, 0.01), (1.5, 0.01), (-1.2, 0.003)] {
        for (width, blur) in [(300, 1.0), (30, 3.0)] {
            let pose = Pose::new(DVec3::ZERO, DQuat::from_axis_angle(DVec3::X, pitch));
            let view = view(width, width * 2 / 3, pose);
            let plan = SamplePlan::full(Eye::Cyclopean, view.optics.size);
            let [a, b] = scenes.each_ref().map(|scene| {
                render(scene, &view, &plan, &RenderOptions::default())
                    .unwrap()
                    .image
            });
            let pairs = a.rgb.iter().flatten().zip(b.rgb.iter().flatten());
            let off: f64 = pairs.map(|(a, b)| f64::from((a - b).abs())).sum();
            let off = off / (3 * a.rgb.len()) as f64;
            assert!(off < blur * largest, "pitch {pitch}, {width} px: {off}");
        }
    }
}
