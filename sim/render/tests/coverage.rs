//! Which triangle each sample sees: against brute force, along shared edges, across the near plane.

mod common;

use common::{soup, study_scene_without_lods, study_view, unlit, view};
use foveasim_assets::{Mesh, Scene, Vertex};
use foveasim_models::{Eye, Pose, Role, SamplePlan, Stream, View};
use foveasim_render::{RenderOptions, Simd, render, visibility};
use glam::{DVec2, DVec3};

fn full(view: &View) -> SamplePlan {
    SamplePlan::full(view.eye, view.optics.size)
}

/// A ray against all triangles in double precision: what it sees first, and how far the ray passes
/// from the nearest edge or the nearest rival in depth — zero where the two methods may differ.
struct Traced {
    seen: Option<(u32, u32)>,
    margin: f64,
}

/// World-space triangles that face the eye, with their names.
fn facing(scene: &Scene, eye: DVec3) -> Vec<((u32, u32), [DVec3; 3])> {
    let mut out = Vec::new();
    for (i, instance) in scene.instances().iter().enumerate() {
        let mesh = &scene.meshes()[instance.mesh];
        for (t, corners) in mesh.triangles().iter().enumerate() {
            let p = corners.map(|c| instance.world_from_object.point(mesh.position(c)));
            let n = (p[1] - p[0]).cross(p[2] - p[0]);
            if n.dot(eye - p[0]) > 0.0 {
                out.push(((i as u32, t as u32), p));
            }
        }
    }
    out
}

fn trace(
    triangles: &[((u32, u32), [DVec3; 3])],
    eye: DVec3,
    d: DVec3,
    near: f64,
    ahead: DVec3,
) -> Traced {
    let mut hits = Vec::new();
    let mut margin = f64::INFINITY;
    for (name, p) in triangles {
        let [a, b, c] = p.map(|p| p - eye);
        let n = (b - a).cross(c - a);
        // Edge functions of the ray (Möller and Trumbore's volumes), as angles from each edge's plane.
        let edges = [(a, b), (b, c), (c, a)].map(|(p, q)| {
            let m = q.cross(p);
            m.dot(d) / (m.length() * d.length()).max(1e-300)
        });
        let t = n.dot(a) / n.dot(d);
        let (low, point) = (edges.iter().copied().fold(f64::INFINITY, f64::min), d * t);
        let depth = point.dot(ahead);
        if depth.is_nan() || depth <= 0.0 {
            continue;
        }
        if low >= 0.0 && depth >= near {
            hits.push((depth, *name));
        }
        // Passing an edge closely, from either side, counts only on the edge's own stretch.
        let nearest_vertex = [a, b, c]
            .iter()
            .map(|v| v.angle_between(d))
            .fold(f64::INFINITY, f64::min);
        if low.abs() < 1.0 && (low >= 0.0 || edges.iter().filter(|e| **e < 0.0).count() == 1) {
            margin = margin.min(low.abs());
        }
        margin = margin.min(nearest_vertex);
    }
    hits.sort_by(|a, b| a.0.total_cmp(&b.0));
    if let [first, second, ..] = hits.as_slice() {
        margin = margin.min((second.0 / first.0 - 1.0).abs());
    }
    Traced {
        seen: hits.first().map(|h| h.1),
        margin,
    }
}

/// Every sample agrees with the tracer, except those within `epsilon` of an edge or of a tie.
fn agrees_with_tracer(scene: &Scene, view: &View, epsilon: f64) {
    let options = RenderOptions::default();
    let seen = visibility(scene, view, &full(view), 0, &options).unwrap();
    let pose = view.poses[0];
    let triangles = facing(scene, pose.position);
    let size = view.optics.size;
    let ahead = pose.direction(DVec3::NEG_Z);
    let (mut hits, mut close) = (0, 0);
    for y in 0..size.y {
        for x in 0..size.x {
            let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let d = pose.direction(view.optics.direction(px));
            let traced = trace(&triangles, pose.position, d, options.near_m, ahead);
            let got = seen[(y * size.x + x) as usize].map(|s| (s.instance, s.triangle));
            hits += usize::from(got.is_some());
            if got != traced.seen {
                assert!(
                    traced.margin < epsilon,
                    "({x}, {y}): {got:?}, traced {:?}, {} from the nearest edge",
                    traced.seen,
                    traced.margin
                );
                close += 1;
            }
        }
    }
    let samples = (size.x * size.y) as usize;
    assert!(
        hits * 10 > samples,
        "{hits} of {samples} samples hit anything"
    );
    assert!(
        close * 50 < samples,
        "{close} of {samples} samples are too close to an edge to judge"
    );
}

#[test]
fn random_triangles_match_the_tracer() {
    for seed in 0..4 {
        let random = &mut Stream::new(seed, Role::Scene, 0);
        let mut triangles = Vec::new();
        for _ in 0..150 {
            // Some reach behind the eye.
            let z = random.range(-9.0, 0.5);
            let centre = DVec3::new(random.range(-4.0, 4.0), random.range(-3.0, 3.0), z);
            triangles.push([(); 3].map(|()| {
                centre
                    + DVec3::new(
                        random.range(-1.5, 1.5),
                        random.range(-1.5, 1.5),
                        random.range(-1.5, 1.5),
                    )
            }));
        }
        let scene = unlit(vec![soup(&triangles)], [1.0; 3], [0.0; 3]);
        let view = view(96, 64, Pose::IDENTITY);
        // A vertex snaps by up to 1/512 px on each axis (0.0028 px in all, 0.0125 px·tan here); depth
        // is interpolated from the snapped corner in f32. 1/100 px covers both.
        agrees_with_tracer(&scene, &view, 0.01 * view.optics.pixel_tan().x);
    }
}

#[test]
fn the_study_scene_matches_the_tracer() {
    let view = study_view(32, 18);
    agrees_with_tracer(
        &study_scene_without_lods(1),
        &view,
        0.01 * view.optics.pixel_tan().x,
    );
}

/// A fan-free random triangulation of a rectangle bigger than the view: a jittered grid, each square
/// split along a random diagonal.
fn triangulation(seed: u64, cells: u32, wobble: f64) -> Mesh {
    let random = &mut Stream::new(seed, Role::Scene, 1);
    let mut vertices = Vec::new();
    for j in 0..=cells {
        for i in 0..=cells {
            let place = |k: u32| (f64::from(k) / f64::from(cells) - 0.5) * 8.0;
            let step = 8.0 / f64::from(cells);
            let jitter = |random: &mut Stream| random.range(-0.3, 0.3) * step * wobble;
            let position = DVec3::new(
                place(i) + jitter(random),
                place(j) + jitter(random),
                // Too shallow to fold: seen from the eye, no triangle hides another.
                -2.0 + random.range(-0.1, 0.1) * step * wobble,
            );
            vertices.push(Vertex {
                position,
                normal: DVec3::Z,
                uv: [0.0; 2],
            });
        }
    }
    let mut triangles = Vec::new();
    for j in 0..cells {
        for i in 0..cells {
            let a = j * (cells + 1) + i;
            let (b, c, d) = (a + 1, a + cells + 1, a + cells + 2);
            if random.uniform() < 0.5 {
                triangles.extend([[a, b, d], [a, d, c]]);
            } else {
                triangles.extend([[a, b, c], [b, d, c]]);
            }
        }
    }
    Mesh::new(&vertices, triangles).unwrap()
}

#[test]
fn shared_edges_cover_each_sample_exactly_once() {
    // Where one flat-enough layer of triangles covers the view, each sample lies in exactly one.
    // Without wobble every vertex falls on a sample position or half-way: edges run through samples.
    for (cells, wobble) in [(7, 1.0), (40, 1.0), (150, 1.0), (64, 0.0), (20, 0.0)] {
        for seed in 0..5 {
            let scene = unlit(vec![triangulation(seed, cells, wobble)], [1.0; 3], [0.0; 3]);
            let view = view(256, 192, Pose::IDENTITY);
            for simd in [Simd::Auto, Simd::Scalar] {
                let options = RenderOptions {
                    simd,
                    ..RenderOptions::default()
                };
                let work = render(&scene, &view, &full(&view), &options).unwrap().work;
                assert_eq!(
                    work.samples_covered,
                    256 * 192,
                    "{cells} cells, seed {seed}"
                );
                assert_eq!(work.samples_sky, 0);
            }
        }
    }
}

#[test]
fn a_floor_through_the_near_plane_has_no_holes() {
    // The floor runs from far behind the eye to far ahead in a few huge triangles.
    for (size, cells) in [(50.0, 1), (2000.0, 1), (1e5, 3), (50.0, 13)] {
        let mut vertices = Vec::new();
        for j in 0..=cells {
            for i in 0..=cells {
                let place = |k: u32| (f64::from(k) / f64::from(cells) - 0.5) * size;
                let position = DVec3::new(place(i) + 0.01 * size, -1.0, place(j));
                vertices.push(Vertex {
                    position,
                    normal: DVec3::Y,
                    uv: [0.0; 2],
                });
            }
        }
        let mut triangles = Vec::new();
        for j in 0..cells {
            for i in 0..cells {
                let a = j * (cells + 1) + i;
                triangles.extend([
                    [a, a + cells + 1, a + 1],
                    [a + 1, a + cells + 1, a + cells + 2],
                ]);
            }
        }
        let mesh = Mesh::new(&vertices, triangles).unwrap();
        let scene = unlit(vec![mesh], [1.0; 3], [0.0; 3]);
        // Looking down, so that the floor fills the view.
        let down = Pose::new(DVec3::ZERO, glam::DQuat::from_rotation_x(-0.9));
        let view = view(200, 150, down);
        let frame = render(&scene, &view, &full(&view), &RenderOptions::default()).unwrap();
        assert_eq!(frame.work.samples_sky, 0, "{size} m");
        assert_eq!(frame.work.samples_covered, 200 * 150, "{size} m");
    }
}

#[test]
fn of_equal_depths_the_first_triangle_wins() {
    let t = [
        DVec3::new(-9.0, -9.0, -2.0),
        DVec3::new(9.0, -9.0, -2.0),
        DVec3::new(0.0, 9.0, -2.0),
    ];
    let scene = unlit(vec![soup(&[t, t, t])], [1.0; 3], [0.0; 3]);
    let view = view(64, 64, Pose::IDENTITY);
    let seen = visibility(&scene, &view, &full(&view), 0, &RenderOptions::default()).unwrap();
    assert!(seen.iter().flatten().count() > 1000);
    assert!(seen.iter().flatten().all(|s| s.triangle == 0));
}

#[test]
fn degenerate_triangles_draw_nothing() {
    let p = DVec3::new(0.1, 0.2, -2.0);
    let line = [p, p + DVec3::X, p + DVec3::X * 2.0];
    let speck = [p, p + DVec3::X * 1e-9, p + DVec3::Y * 1e-9];
    let edge_on = [
        DVec3::new(0.0, 0.0, -1.0),
        DVec3::new(0.0, 0.0, -5.0),
        DVec3::new(0.0, 1e-12, -3.0),
    ];
    let at_eye = [DVec3::ZERO, DVec3::ZERO, DVec3::ZERO];
    let scene = unlit(
        vec![soup(&[[p; 3], line, speck, edge_on, at_eye])],
        [1.0; 3],
        [0.0; 3],
    );
    let view = view(64, 48, Pose::IDENTITY);
    let frame = render(&scene, &view, &full(&view), &RenderOptions::default()).unwrap();
    assert_eq!(frame.work.samples_shaded, 0);
    assert!(frame.image.rgb.iter().flatten().all(|v| *v == 0.0));
}

#[test]
fn back_faces_are_counted_and_hidden() {
    let front = [
        DVec3::new(-1.0, -1.0, -2.0),
        DVec3::new(1.0, -1.0, -2.0),
        DVec3::new(0.0, 1.0, -2.0),
    ];
    let back = [front[0], front[2], front[1]];
    for (triangle, hidden) in [(front, 0), (back, 1)] {
        let scene = unlit(vec![soup(&[triangle])], [1.0; 3], [0.0; 3]);
        let view = view(32, 32, Pose::IDENTITY);
        let work = render(&scene, &view, &full(&view), &RenderOptions::default())
            .unwrap()
            .work;
        assert_eq!(work.triangles_back_facing, hidden);
        assert_eq!(work.samples_shaded > 0, hidden == 0);
        assert_eq!(view.eye, Eye::Cyclopean);
    }
}
