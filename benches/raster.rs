//! The scene that CPU rasterizers are compared on: 260,000 triangles (20 × 20 spheres and tori over a
//! height field), Phong's reflection with a sine in each colour, 1920×1080, everything done anew for
//! every frame of a moving camera. Prints one row per frame, so that runs of another renderer can be put
//! between ours:
//!
//! `cargo bench --bench raster -- --frames 20 [--both-faces] [--simd scalar] [--skip none] [--png FILE]`

#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a program whose results are what it prints"
)]

use std::f64::consts::PI;
use std::time::Instant;

mod common;

use common::Args;
use foveasim::assets::{Instance, Material, Mesh, Phong, Scene, Similarity, Sky, Sun, Vertex};
use foveasim::models::{Eye, Pose, SamplePlan, View, Viewport};
use foveasim::render::{FrameMemory, RenderOptions, Simd, Skip, render_into};
use glam::{DMat3, DQuat, DVec3, UVec2};

/// Triangles between the points of a grid of `nu` × `nv` squares.
fn grid(nu: u32, nv: u32) -> Vec<[u32; 3]> {
    let squares = (0..nu).flat_map(|i| (0..nv).map(move |j| i * (nv + 1) + j));
    squares
        .flat_map(|p| {
            let q = p + nv + 1;
            [[p, q, p + 1], [p + 1, q, q + 1]]
        })
        .collect()
}

/// A surface over a grid of two parameters from 0 to 1: point and normal.
fn surface(nu: u32, nv: u32, point: impl Fn(f64, f64) -> (DVec3, DVec3)) -> Mesh {
    let at = |i: u32, n: u32| f64::from(i) / f64::from(n);
    let vertices: Vec<Vertex> = (0..=nu)
        .flat_map(|i| (0..=nv).map(move |j| (i, j)))
        .map(|(i, j)| {
            let (position, normal) = point(at(i, nu), at(j, nv));
            Vertex {
                position,
                normal,
                uv: [0.0; 2],
            }
        })
        .collect();
    Mesh::new(&vertices, grid(nu, nv)).expect("a generated mesh")
}

fn sphere() -> Mesh {
    surface(20, 15, |u, v| {
        let (u, v) = (2.0 * PI * u, PI * v);
        let n = DVec3::new(u.cos() * v.sin(), u.sin() * v.sin(), v.cos());
        (n * 0.38, n)
    })
}

fn torus() -> Mesh {
    surface(20, 15, |u, v| {
        let (u, v) = (2.0 * PI * u, 2.0 * PI * v);
        let n = DVec3::new(u.cos() * v.cos(), u.sin() * v.cos(), v.sin());
        (DVec3::new(u.cos(), u.sin(), 0.0) * 0.30 + n * 0.13, n)
    })
}

fn height(x: f64, y: f64) -> f64 {
    0.35 * (0.9 * x).sin() * (0.7 * y).cos() + 0.15 * (2.3 * x + 1.1 * y).sin()
}

fn ground() -> Mesh {
    surface(100, 100, |u, v| {
        let (x, y) = (24.0 * u - 12.0, 24.0 * v - 12.0);
        let e = 1e-3;
        let nx = -(height(x + e, y) - height(x - e, y)) / (2.0 * e);
        let ny = -(height(x, y + e) - height(x, y - e)) / (2.0 * e);
        (DVec3::new(x, y, height(x, y)), DVec3::new(nx, ny, 1.0))
    })
}

fn scene() -> Scene {
    let mut instances = Vec::new();
    let mut place = |mesh, p| {
        instances.push(Instance {
            mesh,
            material: 0,
            world_from_object: Similarity::at(p),
            two_sided: false,
            lod: None,
        });
    };
    for i in 0..20 {
        for j in 0..20 {
            let (x, y) = ((f64::from(i) - 9.5) * 0.95, (f64::from(j) - 9.5) * 0.95);
            let mesh = ((i + j) % 2) as usize;
            place(mesh, DVec3::new(x, y, height(x, y) + 0.45));
        }
    }
    place(2, DVec3::ZERO);
    let material = Material::Phong(Phong {
        frequency: 2.0,
        ambient: 0.1,
        diffuse: 0.8,
        specular: 0.3,
        shininess_log2: 5,
    });
    let sun = Sun {
        direction: DVec3::new(0.4, -0.5, 0.8),
        radiance: [1.0; 3],
    };
    let meshes = vec![sphere(), torus(), ground()];
    Scene::new(
        meshes,
        instances,
        vec![material],
        Sky::Uniform([0.0; 3]),
        sun,
    )
    .expect("a scene")
}

/// The camera of frame `k`: a step to the side for each, about the place of the comparison's camera.
fn view(k: u32) -> View {
    let eye = DVec3::new(0.001 * f64::from(k % 16), -11.5, 7.5);
    let back = (eye - DVec3::new(0.0, -0.8, 0.0)).normalize();
    let right = DVec3::Z.cross(back).normalize();
    let rotation = DMat3::from_cols(right, back.cross(right), back);
    let size = UVec2::new(1920, 1080);
    let half_height = (55f64 / 2.0).to_radians().tan();
    let optics = Viewport::symmetric(size, half_height * 1920.0 / 1080.0).expect("a viewport");
    let pose = Pose::new(eye, DQuat::from_mat3(&rotation));
    View::still(Eye::Cyclopean, optics, pose)
}

fn main() {
    let args = Args::new();
    // `cargo test --benches` runs this with other arguments: one frame will do.
    let frames: u32 = args.value("--frames").unwrap_or(1);
    let scene = scene();
    let plan = SamplePlan::full(Eye::Cyclopean, UVec2::new(1920, 1080));
    let mut skip = match args.text("--skip") {
        Some("none") => Skip::NONE,
        _ => Skip::ALL,
    };
    skip.back_faces = !args.has("--both-faces");
    let scalar = args.text("--simd").is_some_and(|v| v == "scalar");
    let options = RenderOptions {
        simd: if scalar { Simd::Scalar } else { Simd::Auto },
        near_m: 0.5,
        skip,
        ..RenderOptions::default()
    };
    // As a program that shows frame after frame: the last ones' memory is drawn into again.
    let mut memory = FrameMemory::default();
    let draw = |k, memory: &mut FrameMemory| {
        render_into(&scene, &view(k), &plan, &options, memory).expect("a drawable plan")
    };
    for k in 0..frames.min(3) {
        let frame = draw(k, &mut memory);
        memory.give(frame.image);
    }
    println!("frame,wall_ms");
    let mut times = Vec::new();
    for k in 0..frames {
        let start = Instant::now();
        let frame = draw(k, &mut memory);
        times.push(start.elapsed().as_secs_f64() * 1e3);
        println!("{k},{:.3}", times[k as usize]);
        memory.give(std::hint::black_box(frame).image);
    }
    times.sort_by(f64::total_cmp);
    let frame = draw(0, &mut memory);
    let threads = rayon::current_num_threads();
    eprintln!(
        "{} triangles, 1920x1080, {threads} threads: median {:.2} ms, least {:.2} ms",
        scene.triangle_count(),
        times[times.len() / 2],
        times[0]
    );
    for (name, count) in frame.work.rows() {
        eprintln!("  {name}: {count}");
    }
    if let Some(file) = args.text("--png") {
        let bytes = foveasim::reports::png(&frame.image).expect("a picture");
        std::fs::write(file, bytes).expect("a writable file");
    }
}
