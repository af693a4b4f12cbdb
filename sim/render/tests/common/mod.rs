//! Scenes, views and plans that the tests share.
#![allow(dead_code, reason = "each test binary uses its own part")]

use foveasim_assets::{
    Instance, Material, Mesh, ParametricSurface, Scene, Similarity, Sky, Sun, Vertex, study_camera,
    tessellate,
};
use foveasim_models::{
    Affine, Eye, Feather, Lattice, Map, Pass, Pose, Resolve, SamplePlan, View, Viewport,
};
use glam::{DVec2, DVec3, UVec2};

pub(crate) fn sun() -> Sun {
    Sun {
        direction: DVec3::new(0.3, 1.0, 0.4),
        radiance: [1.0; 3],
    }
}

pub(crate) fn viewport(width: u32, height: u32) -> Viewport {
    Viewport::symmetric(UVec2::new(width, height), 0.6).unwrap()
}

pub(crate) fn view(width: u32, height: u32, pose: Pose) -> View {
    View::still(Eye::Cyclopean, viewport(width, height), pose)
}

pub(crate) fn study_view(width: u32, height: u32) -> View {
    view(width, height, study_camera(0.3, 1))
}

/// A mesh of loose triangles.
pub(crate) fn soup(triangles: &[[DVec3; 3]]) -> Mesh {
    let mut vertices = Vec::new();
    for t in triangles {
        let normal = (t[1] - t[0])
            .cross(t[2] - t[0])
            .try_normalize()
            .unwrap_or(DVec3::Z);
        vertices.extend(t.map(|position| Vertex {
            position,
            normal,
            uv: [0.0; 2],
        }));
    }
    let indices = (0..triangles.len() as u32)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    Mesh::new(&vertices, indices).unwrap()
}

/// Meshes at the origin, one colour, one sky.
pub(crate) fn unlit(meshes: Vec<Mesh>, colour: [f32; 3], sky: [f32; 3]) -> Scene {
    let placed = Similarity::at(DVec3::ZERO);
    let instances = (0..meshes.len())
        .map(|mesh| Instance {
            mesh,
            lod: None,
            material: 0,
            world_from_object: placed,
            two_sided: false,
        })
        .collect();
    Scene::new(
        meshes,
        instances,
        vec![Material::Unlit(colour)],
        Sky::Uniform(sky),
        sun(),
    )
    .unwrap()
}

pub(crate) fn sphere_scene(colour: [f32; 3], sky: [f32; 3]) -> Scene {
    let mut scene = unlit(
        vec![tessellate(ParametricSurface::Sphere, 24, 16)],
        colour,
        sky,
    );
    let mut instances = scene.instances().to_vec();
    instances[0].world_from_object = Similarity::at(DVec3::new(0.2, -0.1, -3.0));
    scene = Scene::new(
        scene.meshes().to_vec(),
        instances,
        scene.materials().to_vec(),
        scene.sky().clone(),
        *scene.sun(),
    )
    .unwrap();
    scene
}

/// One pass: `size` samples of `scale` pixels from `origin` on.
pub(crate) fn pass(origin: DVec2, scale: f64, size: UVec2) -> Pass {
    let mut pass = SamplePlan::full(Eye::Cyclopean, size).passes.remove(0);
    pass.lattice = Lattice::Grid(size);
    pass.map = Map::Affine(Affine {
        origin,
        scale: DVec2::splat(scale),
    });
    pass
}

/// Layers about `gaze_px`: (scale, half width in pixels) for each, the last one over the whole image.
pub(crate) fn layers(view: &View, gaze_px: DVec2, layers: &[(f64, f64)]) -> SamplePlan {
    let optics = &view.optics;
    let size = optics.size.as_dvec2();
    let mut plan = SamplePlan::full(view.eye, optics.size);
    plan.method = "layers by hand".into();
    plan.passes.clear();
    let mut edges_tan = Vec::new();
    for (k, &(scale, half)) in layers.iter().enumerate() {
        let last = k + 1 == layers.len();
        let half = if last { f64::INFINITY } else { half };
        let low = (gaze_px.floor() - half).max(DVec2::ZERO).min(size);
        let high = (gaze_px.floor() + half).min(size).max(low);
        let count = ((high - low) / scale).ceil().as_uvec2();
        plan.passes.push(pass(low, scale, count));
        if !last {
            // Off its axis a cone covers more than its tangent to either side: stay well inside.
            let edge = 0.6 * half * optics.pixel_tan().x;
            edges_tan.push([0.6 * edge, edge]);
        }
    }
    let gaze = optics.direction(gaze_px).normalize();
    plan.resolve = Resolve::Feather(Feather { gaze, edges_tan });
    plan
}

/// The study scene with one mesh for each instance, whatever the distance.
pub(crate) fn study_scene_without_lods(seed: u64) -> Scene {
    let scene = foveasim_assets::study_scene(seed);
    let instances = scene
        .instances()
        .iter()
        .map(|i| Instance { lod: None, ..*i });
    Scene::new(
        scene.meshes().to_vec(),
        instances.collect(),
        scene.materials().to_vec(),
        scene.sky().clone(),
        *scene.sun(),
    )
    .unwrap()
}
