//! Peak memory of frames at 3840×2160 with a million triangles in view: one row per way of drawing, each
//! in a process of its own, because a process's peak never falls.
//!
//! `cargo bench --bench memory`; on Linux only, where the kernel says what the peak was.

#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a bench prints what it measured"
)]

use std::process::Command;

use foveasim::assets::{Instance, Material, Mesh, Phong, Scene, Similarity, Sky, Sun, Vertex};
use foveasim::models::foveation::{Method, Request};
use foveasim::models::{
    Acuity, Eye, GazeDirection, Msaa, Pose, SamplePlan, View, Viewport, Visibility,
};
use foveasim::render::{RenderOptions, Sequence, TemporalOptions, render};
use glam::{DQuat, DVec3, UVec2};

const SIZE: UVec2 = UVec2::new(3840, 2160);
/// Squares of the ground, each two triangles: 1,008,200.
const SQUARES: u32 = 710;
/// What a frame may take [MiB].
const LIMIT_MIB: f64 = 1024.0;

/// Name, method, positions of visibility, and whether frames follow one another.
const WAYS: [(&str, &str, Msaa, bool); 5] = [
    ("full", "full", Msaa::One, false),
    ("full, MSAA 4", "full", Msaa::Four, false),
    ("layers:3", "layers:3", Msaa::One, false),
    ("layers:3, MSAA 4, sequence", "layers:3", Msaa::Four, true),
    ("full, MSAA 4, sequence", "full", Msaa::Four, true),
];

/// Waves so shallow that all of them face an eye above.
fn ground() -> Scene {
    let side = SQUARES + 1;
    let place = |k: u32| f64::from(k) / f64::from(SQUARES) - 0.5;
    let vertices: Vec<Vertex> = (0..side * side)
        .map(|k| {
            // As wide as the view from 10 m above.
            let (x, z) = (16.0 * place(k % side), 9.0 * place(k / side));
            let (dx, dz) = (0.1 * (2.0 * x).cos(), 0.1 * (3.0 * z).cos());
            Vertex {
                position: DVec3::new(x, 0.05 * (2.0 * x).sin() + 0.1 / 3.0 * (3.0 * z).sin(), z),
                normal: DVec3::new(-dx, 1.0, -dz).normalize(),
                uv: [place(k % side), place(k / side)],
            }
        })
        .collect();
    let triangles = (0..SQUARES * SQUARES)
        .flat_map(|k| {
            let a = k / SQUARES * side + k % SQUARES;
            [[a, a + side, a + 1], [a + 1, a + side, a + side + 1]]
        })
        .collect();
    let mesh = Mesh::new(&vertices, triangles).expect("a generated mesh");
    let instance = Instance {
        mesh: 0,
        lod: None,
        material: 0,
        world_from_object: Similarity::at(DVec3::ZERO),
        two_sided: false,
    };
    let material = Material::Phong(Phong {
        frequency: 2.0,
        ambient: 0.1,
        diffuse: 0.8,
        specular: 0.3,
        shininess_log2: 5,
    });
    let sun = Sun {
        direction: DVec3::new(0.3, 1.0, 0.2),
        radiance: [1.0; 3],
    };
    let sky = Sky::Uniform([0.0; 3]);
    Scene::new(vec![mesh], vec![instance], vec![material], sky, sun).expect("a scene")
}

/// Looking down at the middle of the ground, a little farther on in each frame.
fn view(frame: u64) -> View {
    let optics = Viewport::symmetric(SIZE, 0.82).expect("a viewport");
    let down = DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    let eye = DVec3::new(0.002 * frame as f64, 10.0, 0.0);
    View::still(Eye::Cyclopean, optics, Pose::new(eye, down))
}

fn plan(method: &str, msaa: Msaa) -> SamplePlan {
    let request = Request {
        eye: Eye::Cyclopean,
        viewport: view(0).optics,
        acuity: Acuity::default(),
        gaze: GazeDirection::AHEAD,
        ahead: GazeDirection::AHEAD,
        margin_deg: 0.0,
    };
    let method: Method = method.parse().expect("a method");
    let mut plan = method.plan(&request).expect("a plan");
    for pass in &mut plan.passes {
        pass.visibility = Visibility::Own(msaa);
    }
    plan
}

/// Peak resident memory of this process so far \[MiB\]: `VmHWM`, in KiB (proc(5)).
fn peak_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / 1024.0)
}

/// Draws frames one way and prints its row; whether it stayed within the limit.
fn measure((name, method, msaa, follows): (&str, &str, Msaa, bool)) -> bool {
    let scene = ground();
    let at_start = peak_mib();
    let (plan, options) = (plan(method, msaa), RenderOptions::default());
    let frame = if follows {
        let mut sequence = Sequence::new(TemporalOptions {
            staggered: true,
            ..TemporalOptions::default()
        });
        let mut draw = |k| sequence.draw(&scene, &view(k), &plan, k, &options);
        (0..3).map(&mut draw).last().expect("three frames")
    } else {
        render(&scene, &view(0), &plan, &options)
    };
    let frame = frame.expect("a drawable plan");
    let (Some(start), Some(peak)) = (at_start, peak_mib()) else {
        eprintln!("no /proc/self/status with a VmHWM line: memory can be measured on Linux only");
        return true;
    };
    let (offered, set_up) = (frame.work.triangles, frame.work.triangles_set_up);
    let threads = rayon::current_num_threads();
    println!("{name},{threads},{offered},{set_up},{start:.0},{peak:.0}");
    std::hint::black_box(frame);
    peak < LIMIT_MIB
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    if let Some(way) = args.iter().position(|a| a == "--way") {
        let index: Option<usize> = args.get(way + 1).and_then(|n| n.parse().ok());
        let way = index.and_then(|k| WAYS.get(k)).expect("a way of drawing");
        std::process::exit(i32::from(!measure(*way)));
    }
    println!("way,threads,triangles,triangles_set_up,peak_mib_of_scene,peak_mib");
    let own = std::env::current_exe().expect("the path of this program");
    let mut kept = true;
    for k in 0..WAYS.len() {
        let way = Command::new(&own).args(["--way", &k.to_string()]).status();
        kept &= way.is_ok_and(|status| status.success());
    }
    if !kept {
        eprintln!("more than {LIMIT_MIB} MiB");
        std::process::exit(1);
    }
}
