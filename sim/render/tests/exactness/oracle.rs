//! The renderer against an independent tracer in double precision, whose vertices are not snapped
//! (Möller and Trumbore 1997): they may differ only within ε of an edge, and within what single
//! precision loses. [`Triangle`] derives how much that is.

use foveasim_assets::{
    Encoding, Instance, Material, Mesh, Phong, Scene, SceneParts, Similarity, Sky, Sun, Texture,
    Textured, Vertex, Wrap,
};
use foveasim_models::{Pose, Role, Stream, View};
use foveasim_render::{RenderOptions, Skip, render, visibility};
use glam::{DQuat, DVec2, DVec3};

use crate::common::view;
use crate::triangle::{Bounds, NEAR_M, Triangle, U};
use crate::{full, options};

const TRIANGLES: usize = 160;

fn placed() -> Similarity {
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.7, 0.2);
    Similarity {
        pose: Pose::new(DVec3::new(0.4, -0.3, 0.9), turn),
        scale: 1.7,
    }
}

fn seen_from() -> View {
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, -0.1, 0.25, 0.05);
    view(96, 64, Pose::new(DVec3::new(0.5, 0.2, 1.5), turn))
}

/// Texture coordinates as a function of place, flat enough for one texel to be wider than a sample.
fn uv_at(p: DVec3) -> [f64; 2] {
    [
        0.5 + 0.02 * p.x - 0.01 * p.z,
        0.5 + 0.015 * p.y + 0.01 * p.z,
    ]
}

/// Loose triangles, some through the near plane, with a normal of its own at each corner.
fn mesh(seed: u64) -> Mesh {
    let random = &mut Stream::new(seed, Role::Scene, 5);
    let mut vertices = Vec::new();
    for _ in 0..TRIANGLES {
        let mut point = |reach: f64| DVec3::from_array([0; 3].map(|_| random.range(-reach, reach)));
        let centre = DVec3::new(0.0, 0.0, -4.0) + point(1.0) * DVec3::new(3.0, 2.0, 4.5);
        for _ in 0..3 {
            let position = placed_inverse(centre + point(1.2));
            let normal = (DVec3::new(0.2, 0.3, 1.0) + point(0.6)).normalize();
            let uv = uv_at(position);
            vertices.push(Vertex {
                position,
                normal,
                uv,
            });
        }
    }
    let names = (0..TRIANGLES as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    Mesh::new(&vertices, names.collect()).unwrap()
}

fn placed_inverse(p: DVec3) -> DVec3 {
    let Similarity { pose, scale } = placed();
    pose.inverse().point(p) / scale
}

/// The mesh, seen from both sides, made of `material`, under a sun that alone gives light.
fn scene(mesh: Mesh, material: Material, sun: DVec3) -> Scene {
    let instance = Instance {
        mesh: 0,
        lod: None,
        material: 0,
        world_from_object: placed(),
        two_sided: true,
    };
    // Black to white between two texels' middles.
    let texels = [0, 255].map(|v| [v, v, v, 255]);
    let texels = [texels[0], texels[1], texels[0], texels[1]];
    let ramp = Texture::new([2, 2], texels.to_vec(), Encoding::Linear, [Wrap::Clamp; 2]);
    Scene::build(SceneParts {
        meshes: vec![mesh],
        lods: vec![],
        instances: vec![instance],
        materials: vec![material],
        textures: vec![ramp.unwrap()],
        motions: vec![],
        sky: Sky::Uniform([0.0; 3]),
        sun: Sun {
            direction: sun,
            radiance: [1.0; 3],
        },
    })
    .unwrap()
}

/// Beyond this relative error of depth, first order is not enough.
const STEEP: f64 = 0.05;

/// What the tracer finds at a sample: the nearest triangle, and those that ε leaves open.
struct Traced {
    nearest: Option<usize>,
    open: Vec<usize>,
    /// The nearest of those that are surely hit, at their deepest within the bounds of depth [1/m].
    surely: f64,
}

fn trace(triangles: &[Triangle], view: &View, px: DVec2, d: DVec3) -> Traced {
    let mut traced = Traced {
        nearest: None,
        open: Vec::new(),
        surely: 0.0,
    };
    let mut nearest = f64::INFINITY;
    for (k, t) in triangles.iter().enumerate() {
        let hit = t.hit(d);
        if let Some((w, _)) = hit.filter(|(w, _)| *w < nearest) {
            (nearest, traced.nearest) = (w, Some(k));
        }
        if t.outline_distance(px) <= t.epsilon {
            traced.open.push(k);
        } else if let Some((w, beta)) = hit {
            let off = t.bounds(view, d, w, beta).inverse_w;
            if off * w <= STEEP {
                traced.surely = traced.surely.max(1.0 / w - off);
            } else {
                traced.open.push(k);
            }
        }
    }
    traced
}

/// Samples (display position, direction) in their order.
fn samples(view: &View) -> Vec<(DVec2, DVec3)> {
    let size = view.optics.size;
    let at = |i: u32| DVec2::new(f64::from(i % size.x) + 0.5, f64::from(i / size.x) + 0.5);
    (0..size.x * size.y)
        .map(|i| {
            let d = view.optics.direction(at(i));
            (at(i), DVec3::new(d.x, d.y, -d.z))
        })
        .collect()
}

fn tracer_options() -> RenderOptions {
    RenderOptions {
        near_m: NEAR_M,
        skip: Skip::ALL,
        ..options()
    }
}

#[test]
fn the_tracer_differs_only_within_epsilon_of_an_edge() {
    let view = seen_from();
    let (mut hits, mut differ, mut open, mut compared) = (0, 0, 0, 0);
    let mut closest: f64 = 0.0;
    for seed in 0..5 {
        let mesh = mesh(seed);
        let triangles: Vec<_> = (0..TRIANGLES)
            .map(|k| Triangle::new(&mesh, k, placed(), &view))
            .collect();
        let scene = scene(mesh, Material::Unlit([1.0; 3]), DVec3::Y);
        let seen = visibility(&scene, &view, &full(&view), 0, &tracer_options()).unwrap();
        for ((px, d), seen) in samples(&view).into_iter().zip(seen) {
            let traced = trace(&triangles, &view, px, d);
            let drawn = seen.map(|s| s.triangle as usize);
            hits += usize::from(traced.nearest.is_some());
            open += usize::from(!traced.open.is_empty());
            differ += usize::from(drawn != traced.nearest);
            let Some((surfel, k)) = seen.zip(drawn) else {
                assert!(
                    traced.surely == 0.0,
                    "{px}: nothing drawn of {:?}",
                    traced.nearest
                );
                continue;
            };
            let t = &triangles[k];
            if traced.open.contains(&k) {
                // Where depth is not to be trusted, it still is not beyond the vertices'.
                let nearest =
                    t.p.iter()
                        .map(|p| 1.0 / p.z.max(NEAR_M))
                        .fold(0.0, f64::max);
                assert!(nearest >= traced.surely * (1.0 - 1e-5), "{px}: {k}");
                continue;
            }
            let Some((w, beta)) = t.hit(d) else {
                panic!(
                    "{px}: {k} is drawn {} px from its outline, ε {}",
                    t.outline_distance(px),
                    t.epsilon
                )
            };
            let bound = t.bounds(&view, d, w, beta).inverse_w;
            let off = (1.0 / f64::from(surfel.depth_m) - 1.0 / w).abs();
            assert!(off <= bound, "{px}: 1/w is off by {off:e}, bound {bound:e}");
            assert!(
                1.0 / w + bound >= traced.surely,
                "{px}: something is nearer than {k}"
            );
            compared += 1;
            closest = closest.max(off / bound);
        }
    }
    let all = 5 * 96 * 64;
    // Outlines are some 2 ε wide and a few hundred pixels long in front of 6144 samples.
    assert!(hits * 2 > all, "{hits} of {all} samples hit anything");
    assert!(open * 20 < all, "{open} of {all} samples are open");
    assert!(
        differ <= open && differ * 200 < all,
        "{differ} of {all} samples differ"
    );
    assert!(
        compared * 10 > hits * 9,
        "{compared} of {hits} depths compared"
    );
    // A bound that is never neared proves little.
    assert!(closest > 0.01, "errors reach {closest} of their bounds");
}

/// At each sample that both see alike and surely: bounds, weights, ray and triangle.
fn for_each_sure(
    mesh: &Mesh,
    seen: &[Option<foveasim_render::Surfel>],
    view: &View,
    mut visit: impl FnMut(usize, &Triangle, usize, [f64; 2], &Bounds, DVec3),
) -> usize {
    let triangles: Vec<_> = (0..TRIANGLES)
        .map(|k| Triangle::new(mesh, k, placed(), view))
        .collect();
    let mut count = 0;
    for (index, ((px, d), seen)) in samples(view).into_iter().zip(seen).enumerate() {
        let traced = trace(&triangles, view, px, d);
        let Some(k) = seen.map(|s| s.triangle as usize) else {
            continue;
        };
        if traced.nearest != Some(k) || traced.open.contains(&k) {
            continue;
        }
        if let Some((w, beta)) = triangles[k].hit(d) {
            let bounds = triangles[k].bounds(view, d, w, beta);
            visit(index, &triangles[k], k, beta, &bounds, d * w);
            count += 1;
        }
    }
    count
}

#[test]
fn attributes_are_within_their_bounds() {
    let view = seen_from();
    let eye = view.poses[0];
    let suns = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut reached = [0.0f64; 3];
    for seed in 0..3 {
        let mesh = mesh(seed);
        let draw = |material: Material, sun| {
            let scene = scene(mesh.clone(), material, sun);
            let image = render(&scene, &view, &full(&view), &tracer_options())
                .unwrap()
                .image;
            image.rgb
        };
        let phong = |frequency, ambient, diffuse| {
            Material::Phong(Phong {
                frequency,
                ambient,
                diffuse,
                specular: 0.0,
                shininess_log2: 0,
            })
        };
        let frequency = 0.2f32;
        let place = draw(phong(frequency, 1.0, 0.0), DVec3::Y);
        // ½·2·n·l, where that is not negative; and the same from the other side.
        let lit = suns.map(|sun| {
            [
                draw(phong(0.0, 0.0, 2.0), sun),
                draw(phong(0.0, 0.0, 2.0), -sun),
            ]
        });
        let glowing = Material::Textured(Textured {
            base_colour: [0.0; 3],
            emissive: [1.0; 3],
            emissive_texture: Some(0),
            ..Textured::default()
        });
        let mut without_light = scene(mesh.clone(), glowing, DVec3::Y);
        without_light = Scene::build(SceneParts {
            meshes: without_light.meshes().to_vec(),
            lods: vec![],
            instances: without_light.instances().to_vec(),
            materials: without_light.materials().to_vec(),
            textures: without_light.textures().to_vec(),
            motions: vec![],
            sky: Sky::Uniform([0.0; 3]),
            sun: Sun {
                direction: DVec3::Y,
                radiance: [0.0; 3],
            },
        })
        .unwrap();
        let seen = visibility(&without_light, &view, &full(&view), 0, &tracer_options()).unwrap();
        let ramp = render(&without_light, &view, &full(&view), &tracer_options());
        let ramp = ramp.unwrap().image.rgb;
        let count = for_each_sure(&mesh, &seen, &view, |index, t, k, beta, bounds, at| {
            let w = at.z;
            let mut check = |what: usize, got: f64, want: f64, bound: f64| {
                let off = (got - want).abs();
                assert!(
                    off <= bound,
                    "{} sample {index}: {got}, exactly {want}: off by {off:e}, bound {bound:e}",
                    ["place", "normal", "uv"][what]
                );
                reached[what] = reached[what].max(off / bound);
            };
            // The place: eye + direction·w, five products and as many sums, and the sine's own 5e-7.
            let point = eye.point(DVec3::new(at.x, at.y, -at.z));
            let along = at.length() * (bounds.inverse_w * w + 4.0 * U);
            let sums = 16.0 * U * (eye.position.abs().max_element() + at.abs().element_sum());
            for c in 0..3 {
                let phase = f64::from(frequency) * point[c];
                let phase_off = f64::from(frequency) * (along + sums) + 2.0 * U * phase.abs();
                let want = 0.5 + 0.5 * phase.sin();
                check(
                    0,
                    f64::from(place[index][c]),
                    want,
                    0.5 * phase_off + 2.5e-7 + 2.0 * U,
                );
            }
            // The normal: interpolated, made a unit vector, turned towards the eye.
            let corners = mesh.triangles()[k].map(|i| i as usize);
            let turn = placed().pose.orientation;
            let normals = corners.map(|i| {
                turn * DVec3::from_array([0, 1, 2].map(|c| f64::from(mesh.normals()[c][i])))
            });
            let blended = normals[0]
                + (normals[1] - normals[0]) * beta[0]
                + (normals[2] - normals[0]) * beta[1];
            let blended_off = bounds.weights[0] * (normals[1] - normals[0]).length()
                + bounds.weights[1] * (normals[2] - normals[0]).length()
                + 12.0 * U;
            let unit = blended.normalize();
            let unit_off = 1.1 * blended_off / blended.length() + 8.0 * U;
            let toward = -(eye.orientation * DVec3::new(at.x, at.y, -at.z)).normalize();
            if unit.dot(toward).abs() > 2.0 * unit_off + 1e-5 {
                // Drawn from behind, the normal is that of the other side, before it is turned.
                let facing = unit * unit.dot(toward).signum();
                for c in 0..3 {
                    let [front, back] = &lit[c];
                    let got = f64::from(front[index][0]) - f64::from(back[index][0]);
                    check(1, got, facing[c], unit_off + 4.0 * U);
                }
            }
            // The coordinate along the ramp, on which white and black are half a unit apart.
            let us = corners.map(|i| f64::from(mesh.uvs()[0][i]));
            let u = us[0] + (us[1] - us[0]) * beta[0] + (us[2] - us[0]) * beta[1];
            let u_off = bounds.weights[0] * (us[1] - us[0]).abs()
                + bounds.weights[1] * (us[2] - us[0]).abs()
                + 4.0 * U;
            check(
                2,
                f64::from(ramp[index][0]),
                2.0 * u - 0.5,
                2.0 * u_off + 8.0 * U,
            );
            assert!(t.epsilon < 0.1);
        });
        assert!(count > 2000, "{count} samples");
    }
    assert!(
        reached.iter().all(|r| *r > 0.01),
        "errors reach {reached:?} of their bounds"
    );
}
