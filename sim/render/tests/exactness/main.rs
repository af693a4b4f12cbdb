//! What is exact: coverage against rational arithmetic, the rasterizer against rays, methods against
//! each other, any threads and instructions against one thread and one lane.

#[path = "../common/mod.rs"]
mod common;
mod covered;
mod methods;
mod moving;
mod moving_bounds;
mod moving_images;
mod oracle;
mod traced;
mod triangle;

use std::sync::LazyLock;

use common::{soup, unlit};
use foveasim_assets::{Scene, study_scene};
use foveasim_models::foveation::{Method, Request};
use foveasim_models::{
    Acuity, Eye, GazeDirection, Image, Msaa, Role, SamplePlan, Stream, View, Visibility,
};
use foveasim_render::RenderOptions;
use glam::{DVec2, DVec3};

/// The study scene; its sky takes a while to make.
static STUDY: LazyLock<Scene> = LazyLock::new(|| study_scene(1));

/// Every method, with settings that change what is drawn.
const METHODS: [&str; 18] = [
    "full",
    "layers:2",
    "layers:3",
    "layers:4",
    "layers:3:strict",
    "layers:3:fixed=5",
    "vrs:tile=8",
    "vrs",
    "vrs:tile=32:max=2",
    "vrs:fixed=5",
    "fdm:tile=8",
    "fdm",
    "fdm:tile=32:fixed=5",
    "rates",
    "rates:bands=9:fixed=5",
    "quad",
    "quad:auto",
    "quad:focus=0.6:peripheral=0.7",
];

fn options() -> RenderOptions {
    RenderOptions::default()
}

/// A plan of `method` for a viewer of low acuity, so that small images are foveated as large ones are.
fn plan(method: &str, view: &View) -> SamplePlan {
    let method: Method = method.parse().unwrap();
    let request = Request {
        eye: view.eye,
        viewport: view.optics,
        acuity: Acuity::with_foveal(0.08, 0.3).unwrap(),
        gaze: GazeDirection::new(6.0, -3.0),
        ahead: GazeDirection::AHEAD,
        margin_deg: 0.5,
    };
    method.plan(&request).unwrap()
}

fn full(view: &View) -> SamplePlan {
    SamplePlan::full(Eye::Cyclopean, view.optics.size)
}

/// The plan with four positions of visibility per sample, or one, and its samples moved.
fn varied(mut plan: SamplePlan, msaa: Msaa, offset: DVec2) -> SamplePlan {
    for pass in &mut plan.passes {
        pass.visibility = Visibility::Own(msaa);
        pass.offset = offset;
    }
    plan
}

fn bits(image: &Image) -> Vec<u32> {
    image.rgb.iter().flatten().map(|v| v.to_bits()).collect()
}

/// Loose triangles of all sizes, some behind the eye, some through the near plane, some huge.
fn loose_triangles(seed: u64, count: usize) -> Scene {
    let random = &mut Stream::new(seed, Role::Scene, 7);
    let triangles: Vec<_> = (0..count)
        .map(|_| {
            let size = [0.05, 0.6, 2.5, 400.0][random.below(4) as usize];
            let mut point = |x: f64, z: f64| {
                DVec3::new(
                    random.range(-x, x),
                    random.range(-x, x),
                    random.range(-z, z),
                )
            };
            let centre = point(3.0, 4.6) - DVec3::Z * 4.0;
            [(); 3].map(|()| centre + point(size, size))
        })
        .collect();
    unlit(vec![soup(&triangles)], [1.0; 3], [0.0; 3])
}
