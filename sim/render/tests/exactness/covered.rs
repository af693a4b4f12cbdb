//! Coverage against edge tests in whole numbers of any size.

use foveasim_assets::{Mesh, Vertex};
use foveasim_models::{Eye, Msaa, Pose, Role, Stream, View, Viewport};
use foveasim_render::{RenderOptions, Simd, Skip, render, visibility_at};
use glam::{DVec2, DVec3, UVec2};

use crate::common::{soup, unlit};
use crate::{full, options, varied};

/// Positions per sample of the test's own grid: four times finer than the rasterizer's.
const FINE: i64 = 1024;
/// The four positions of visibility, in sixteenths of a sample from its middle.
const FOUR: [[i64; 2]; 4] = [[-2, -6], [6, -2], [-6, 2], [2, 6]];
const SIZE: u32 = 128;

/// A view in which every number is exact: a point px pixels from the left and at depth w = n/32 is at
/// x = (px − 64)/64 · w, n times a multiple of 2⁻²¹ and below 8: both x and, later, x/w fit 24 bits.
fn exact_view() -> View {
    let optics = Viewport::new(UVec2::splat(SIZE), [-1.0, 1.0, 1.0, -1.0]).unwrap();
    View::still(Eye::Cyclopean, optics, Pose::IDENTITY)
}

/// A point at a fine position and depth w.
fn point([x, y]: [i64; 2], w: f64) -> DVec3 {
    let tangent = |p: i64| p as f64 / (FINE * i64::from(SIZE / 2)) as f64 - 1.0;
    let p = DVec3::new(tangent(x) * w, -tangent(y) * w, -w);
    assert!(
        (0..3).all(|k| f64::from(p[k] as f32) == p[k]),
        "{p} is not exact"
    );
    p
}

/// What the rasterizer makes of a fine position: rounded to 1/256 of a sample, halves up.
fn snapped(p: [i64; 2]) -> [i128; 2] {
    let unit = FINE / 256;
    p.map(|p| i128::from((p + unit / 2).div_euclid(unit)))
}

/// Whether the triangle covers a position \[1/256 samples\]: the definition of the top-left rule, in
/// barycentric coordinates as fractions of its area.
fn covers(corners: [[i128; 2]; 3], at: [i128; 2]) -> bool {
    let cross = |a: [i128; 2], b: [i128; 2], c: [i128; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let [mut a, mut b, c] = corners;
    // With y down, a positive area runs clockwise.
    match cross(a, b, c).signum() {
        0 => return false,
        -1 => std::mem::swap(&mut a, &mut b),
        _ => {}
    }
    [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
        let weight = cross(from, to, at);
        let is_left = to[1] < from[1];
        let is_top = to[1] == from[1] && to[0] > from[0];
        weight > 0 || (weight == 0 && (is_left || is_top))
    })
}

/// Where visibility is found [1/256 samples].
fn position(sample: [u32; 2], msaa: Msaa, position: usize) -> [i128; 2] {
    let offset = match msaa {
        Msaa::One => [0, 0],
        Msaa::Four => FOUR[position],
    };
    [0, 1].map(|k| i128::from(sample[k]) * 256 + 128 + i128::from(offset[k]) * 16)
}

/// Random triangles, each flat to the view at a depth of its own, nearest first in no order.
fn random_triangles(seed: u64, count: u32) -> Vec<([[i64; 2]; 3], f64)> {
    let random = &mut Stream::new(seed, Role::Scene, 2);
    let side = i64::from(SIZE) * FINE;
    // Depths that keep products exact: 1 to 2 in steps of 1/32.
    (0..count)
        .map(|k| {
            let reach = [FINE / 2, 3 * FINE, 20 * FINE, side][random.below(4) as usize];
            // Some on sample positions or the rasterizer's grid, some anywhere.
            let grid = [FINE / 2, FINE / 256, 2, 1][random.below(4) as usize];
            let mut at = |low: i64, high: i64| {
                let p = low + random.below((high - low) as u64) as i64;
                p.div_euclid(grid) * grid
            };
            let centre = [at(0, side), at(0, side)];
            let corners = [(); 3].map(|()| centre.map(|c| at(c - reach, c + reach)));
            (corners, 1.0 + f64::from(k % 32) / 32.0)
        })
        .collect()
}

#[test]
fn random_triangles_are_covered_as_rational_arithmetic_has_it() {
    let view = exact_view();
    let mut decided = 0u64;
    for seed in 0..12 {
        let triangles = random_triangles(seed, 32);
        let corners: Vec<_> = triangles
            .iter()
            .map(|(corners, w)| corners.map(|p| point(p, *w)))
            .collect();
        let scene = unlit(vec![soup(&corners)], [1.0; 3], [0.0; 3]);
        let snapped: Vec<_> = triangles.iter().map(|t| t.0.map(snapped)).collect();
        for msaa in [Msaa::One, Msaa::Four] {
            let plan = varied(full(&view), msaa, DVec2::ZERO);
            let mut covered = 0;
            let nearest: Vec<Vec<Option<usize>>> = (0..msaa.positions() as usize)
                .map(|p| {
                    let samples = (0..SIZE * SIZE).map(|i| [i % SIZE, i / SIZE]);
                    let nearest = samples.map(|sample| {
                        let at = position(sample, msaa, p);
                        let inside = (0..triangles.len()).filter(|&k| covers(snapped[k], at));
                        let inside: Vec<_> = inside.collect();
                        covered += inside.len() as u64;
                        decided += triangles.len() as u64;
                        // No two have the same depth.
                        let depth = |k: usize| triangles[k].1;
                        inside
                            .into_iter()
                            .min_by(|&a, &b| depth(a).total_cmp(&depth(b)))
                    });
                    nearest.collect()
                })
                .collect();
            for simd in [Simd::Auto, Simd::Scalar] {
                let options = RenderOptions {
                    simd,
                    skip: Skip::NONE,
                    ..options()
                };
                for (p, nearest) in nearest.iter().enumerate() {
                    let seen = visibility_at(&scene, &view, &plan, 0, p, &options).unwrap();
                    for (k, (seen, nearest)) in seen.iter().zip(nearest).enumerate() {
                        let seen = seen.map(|s| s.triangle as usize);
                        assert_eq!(seen, *nearest, "seed {seed} {msaa:?} sample {k} {p}");
                    }
                }
                // Hidden ones count, too.
                let work = render(&scene, &view, &plan, &options).unwrap().work;
                assert_eq!(work.samples_covered, covered, "seed {seed} {msaa:?}");
            }
        }
    }
    assert!(decided > 30_000_000, "{decided}");
}

/// Samples along each side of the image that shared edges are drawn to.
const WIDE: u32 = 768;

fn wide_view() -> View {
    let optics = Viewport::new(UVec2::splat(WIDE), [-1.0, 1.0, 1.0, -1.0]).unwrap();
    View::still(Eye::Cyclopean, optics, Pose::IDENTITY)
}

/// A vertex at a pixel position, in or beyond the image.
fn vertex(px: DVec2) -> Vertex {
    // On a slope, so that depth varies and attributes are perspective.
    let w = 2.0 + 0.5 * px.x / f64::from(WIDE);
    Vertex {
        position: wide_view().optics.direction(px) * w,
        normal: DVec3::Z,
        uv: [0.0; 2],
    }
}

/// A jittered grid of `across` × `down` squares over more than the image, each cut along a random
/// diagonal; moved by less than a quarter of a square, none folds over. Without jitter, vertices are on sample positions or half-way between.
fn triangulation(random: &mut Stream, across: u32, down: u32, jitter: f64) -> Mesh {
    let cells = DVec2::new(across.into(), down.into());
    let step = f64::from(WIDE + 8) / cells;
    let mut vertices = Vec::new();
    for j in 0..=down {
        for i in 0..=across {
            let at = DVec2::new(i.into(), j.into());
            let moved = DVec2::new(random.range(-0.24, 0.24), random.range(-0.24, 0.24));
            let px = (at + moved * jitter) * step - 4.0;
            let rounded = (px * 2.0).round() / 2.0;
            let px = if jitter == 0.0 { rounded } else { px };
            // The border stays out of the image.
            let out = at.cmpeq(DVec2::ZERO) | at.cmpeq(cells);
            vertices.push(vertex(DVec2::select(out, at * step - 4.0, px)));
        }
    }
    let mut triangles = Vec::new();
    for j in 0..down {
        for i in 0..across {
            let a = j * (across + 1) + i;
            let (b, c, d) = (a + 1, a + across + 1, a + across + 2);
            if random.uniform() < 0.5 {
                triangles.extend([[a, b, d], [a, d, c]]);
            } else {
                triangles.extend([[a, b, c], [b, d, c]]);
            }
        }
    }
    Mesh::new(&vertices, triangles).unwrap()
}

/// Triangles about one vertex somewhere in the image: all the edges of `spokes` points on a circle
/// around all of it.
fn fan(random: &mut Stream, spokes: u32) -> Mesh {
    let wide = f64::from(WIDE);
    let hub = DVec2::new(random.range(0.2, 0.8), random.range(0.2, 0.8)) * wide;
    let mut vertices = vec![vertex(hub)];
    vertices.extend((0..spokes).map(|k| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(spokes);
        // Also where the hub is aside, the chords of the circle stay out of the image.
        vertex(DVec2::splat(wide / 2.0) + DVec2::from_angle(angle) * wide * 0.8)
    }));
    let triangles = (0..spokes).map(|k| [0, 1 + k, 1 + (k + 1) % spokes]);
    Mesh::new(&vertices, triangles.collect()).unwrap()
}

/// A strip of slivers across the image, as many as there are sub-samples in places.
fn strip(random: &mut Stream, count: u32) -> Mesh {
    let wide = f64::from(WIDE);
    let step = (wide + 2.0) / f64::from(count);
    let mut vertices = Vec::new();
    for k in 0..=count {
        for y in [-1.0, wide + 1.0] {
            let is_end = k == 0 || k == count;
            let moved = if is_end {
                0.0
            } else {
                random.range(-0.45, 0.45)
            };
            vertices.push(vertex(DVec2::new((f64::from(k) + moved) * step - 1.0, y)));
        }
    }
    let squares = (0..count).map(|k| 2 * k);
    let triangles = squares.flat_map(|a| [[a, a + 1, a + 2], [a + 1, a + 3, a + 2]]);
    Mesh::new(&vertices, triangles.collect()).unwrap()
}

/// Edges that two triangles of the mesh share.
fn shared_edges(mesh: &Mesh) -> u64 {
    let mut edges: Vec<[u32; 2]> = mesh
        .triangles()
        .iter()
        .flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges
        .chunk_by(|a, b| a == b)
        .filter(|same| same.len() == 2)
        .count() as u64
}

#[test]
fn samples_along_a_million_shared_edges_are_covered_exactly_once() {
    let random = &mut Stream::new(5, Role::Scene, 3);
    let mut meshes = vec![fan(random, 50_000), strip(random, 50_000)];
    for (cells, jitter) in [(380, 1.0), (384, 0.0), (97, 1.0), (260, 0.9), (240, 1.0)] {
        meshes.push(triangulation(random, cells, cells - 1, jitter));
    }
    let view = wide_view();
    let pixels = u64::from(WIDE) * u64::from(WIDE);
    let (mut edges, mut mesh_edges) = (0, Vec::new());
    for (k, mesh) in meshes.into_iter().enumerate() {
        mesh_edges.push(shared_edges(&mesh));
        edges += mesh_edges[k];
        let scene = unlit(vec![mesh], [1.0; 3], [0.0; 3]);
        for (msaa, simd) in [(Msaa::One, Simd::Scalar), (Msaa::Four, Simd::Auto)] {
            let plan = varied(full(&view), msaa, DVec2::ZERO);
            let options = RenderOptions {
                simd,
                skip: Skip::NONE,
                ..options()
            };
            let work = render(&scene, &view, &plan, &options).unwrap().work;
            // Without a gap each position is covered at least once: as many as there are, and never twice.
            assert_eq!(work.samples_sky, 0, "mesh {k} {msaa:?}: gaps");
            let positions = pixels * u64::from(msaa.positions());
            assert_eq!(work.samples_covered, positions, "mesh {k} {msaa:?}");
        }
    }
    assert!(edges >= 1_000_000, "{edges} of {mesh_edges:?}");
}
