//! Frames that follow one another: what they keep, find again and forget.

#[path = "../common/mod.rs"]
mod common;
mod motion;

use std::num::NonZeroU32;

use common::{layers, soup, study_view, sun, view};
use foveasim_assets::{
    Instance, Material, Mesh, ParametricSurface, Pattern, Scene, Similarity, Sky, Surface, Vertex,
    study_camera, study_scene, tessellate,
};
use foveasim_models::{Affine, Cadence, Eye, Image, Map, Pose, SamplePlan, Stream, View, Viewport};
use foveasim_render::{
    Clamp, Frame, Interpolation, RenderError, RenderOptions, Sequence, Simd, TemporalOptions,
    render,
};
use glam::{DQuat, DVec2, DVec3};

const UNCLAMPED: TemporalOptions = TemporalOptions {
    jitter: false,
    reproject: true,
    staggered: false,
    blend: 0.9,
    clamp: Clamp::Off,
    interpolation: Interpolation::Bilinear,
    footprint: 1.0,
};

fn options() -> RenderOptions {
    RenderOptions {
        keep_passes: true,
        ..RenderOptions::default()
    }
}

fn bits(image: &Image) -> Vec<u32> {
    image.rgb.iter().flatten().map(|v| v.to_bits()).collect()
}

fn full(view: &View) -> SamplePlan {
    SamplePlan::full(view.eye, view.optics.size)
}

/// Three layers about `gaze_px`, the outer two every other frame in turn.
fn staggered_layers(view: &View, gaze_px: DVec2) -> SamplePlan {
    let mut plan = layers(view, gaze_px, &[(1.0, 20.0), (2.3, 45.0), (5.0, 0.0)]);
    for (phase, pass) in plan.passes[1..].iter_mut().enumerate() {
        pass.cadence = Cadence {
            every: NonZeroU32::new(2).unwrap(),
            phase: phase as u32,
        };
    }
    plan
}

/// A square of side 2 about the origin, seen from +z.
fn square() -> Mesh {
    let corner = |x: f64, y: f64| Vertex {
        position: DVec3::new(x, y, 0.0),
        normal: DVec3::Z,
        uv: [0.5 + 0.5 * x, 0.5 + 0.5 * y],
    };
    let corners = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    Mesh::new(&corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap()
}

fn placed(position: DVec3, turn: DQuat, scale: f64) -> Similarity {
    let pose = Pose::new(position, turn);
    Similarity { pose, scale }
}

fn scene(mesh: Mesh, parts: &[(Material, Similarity)], sky: [f32; 3]) -> Scene {
    let instances = parts.iter().enumerate().map(|(material, part)| Instance {
        lod: None,
        mesh: 0,
        material,
        world_from_object: part.1,
        two_sided: false,
    });
    Scene::new(
        vec![mesh],
        instances.collect(),
        parts.iter().map(|p| p.0.clone()).collect(),
        Sky::Uniform(sky),
        sun(),
    )
    .unwrap()
}

fn checkered() -> Material {
    Material::Surface(Surface {
        albedo: [[0.9, 0.5, 0.1], [0.05, 0.2, 0.6]],
        pattern: Pattern::Checker,
        frequency: 12.0,
        roughness: 1.0,
        f0: 0.0,
        environment: 0.0,
        seed: 1,
    })
}

/// Thin triangles of many colours, far and near, that one sample per pixel cannot show.
fn thicket() -> Scene {
    let mut random = Stream::new(3, foveasim_models::Role::Scene, 0);
    let mut point = |spread: f64| DVec3::from_array([0; 3].map(|_| random.range(-spread, spread)));
    let mut meshes = Vec::new();
    for _ in 0..12 {
        let triangles: Vec<_> = (0..30)
            .map(|_| {
                let a = point(1.6) - DVec3::Z * 3.5;
                let (b, c) = (a + point(1.2), a + point(0.06));
                [a, b, c]
            })
            .collect();
        meshes.push(soup(&triangles));
    }
    let materials: Vec<_> = (0..12)
        .map(|_| Material::Unlit((point(0.5) + 0.5).to_array().map(|c| c as f32)))
        .collect();
    let instances = (0..12).map(|k| Instance {
        lod: None,
        mesh: k,
        material: k,
        world_from_object: Similarity::at(DVec3::ZERO),
        two_sided: false,
    });
    let sky = Sky::Uniform([0.02, 0.05, 0.1]);
    Scene::new(meshes, instances.collect(), materials, sky, sun()).unwrap()
}

/// The mean of 8 × 8 samples for each pixel.
fn supersampled(scene: &Scene, view: &View) -> Image {
    let size = view.optics.size;
    let mut fine = *view;
    fine.optics = Viewport::new(size * 8, view.optics.tan).unwrap();
    let fine = render(scene, &fine, &full(&fine), &RenderOptions::default()).unwrap();
    let mut image = Image::filled(size, [0.0; 3]);
    for (index, colour) in fine.image.rgb.iter().enumerate() {
        let (x, y) = (
            index as u32 % (size.x * 8) / 8,
            index as u32 / (size.x * 8) / 8,
        );
        let out = &mut image.rgb[(y * size.x + x) as usize];
        for c in 0..3 {
            out[c] += colour[c] / 64.0;
        }
    }
    image
}

fn mean_square(a: &Image, b: &Image) -> f64 {
    let pairs = a.rgb.iter().flatten().zip(b.rgb.iter().flatten());
    let sum: f64 = pairs
        .map(|(a, b)| f64::from(a - b) * f64::from(a - b))
        .sum();
    sum / (3 * a.rgb.len()) as f64
}

#[test]
fn a_still_camera_converges_to_the_mean_of_each_cell() {
    let (scene, view) = (thicket(), view(96, 64, Pose::IDENTITY));
    let reference = supersampled(&scene, &view);
    let error = |options: TemporalOptions, frames: u64| {
        let mut sequence = Sequence::new(options);
        let mut last = None;
        for frame in 0..frames {
            let drawn = sequence.draw(&scene, &view, &full(&view), frame, &self::options());
            last = Some(drawn.unwrap());
        }
        mean_square(&last.unwrap().image, &reference)
    };
    let default = TemporalOptions::default();
    let [one, sixteen, many] = [1, 16, 80].map(|frames| error(default, frames));
    let unjittered = TemporalOptions {
        jitter: false,
        ..default
    };
    let centre = error(TemporalOptions::OFF, 1);
    // Sixteen independent samples would leave a sixteenth of the variance; well spread ones leave less.
    assert!(sixteen < one / 30.0, "{one} {sixteen}");
    assert!(many < one / 30.0, "{one} {many}");
    // It is the jitter that does it: the same sample again and again stays what it is.
    assert_eq!(error(unjittered, 16), centre);
}

/// Mean squared error, over eight frames of a slow flight through the thicket, of what is drawn with
/// `options` after sixteen others.
fn error_in_flight(options: TemporalOptions) -> f64 {
    let scene = thicket();
    let mut sequence = Sequence::new(options);
    let mut sum = 0.0;
    for frame in 0..24 {
        // About half a sample to the side, and as much nearer, at the middle of the thicket.
        let t = frame as f64 * 0.015;
        let view = view(
            96,
            64,
            Pose::new(DVec3::new(t, 0.4 * t, -t), DQuat::IDENTITY),
        );
        let drawn = sequence.draw(&scene, &view, &full(&view), frame, &self::options());
        let image = drawn.unwrap().image;
        if frame >= 16 {
            sum += mean_square(&image, &supersampled(&scene, &view)) / 8.0;
        }
    }
    sum
}

#[test]
fn a_camera_in_flight_sees_less_aliasing_with_history() {
    let default = TemporalOptions::default();
    let all = error_in_flight(default);
    let none = error_in_flight(TemporalOptions::OFF);
    let bilinear = error_in_flight(TemporalOptions {
        interpolation: Interpolation::Bilinear,
        ..default
    });
    let jittered = error_in_flight(TemporalOptions {
        reproject: false,
        ..default
    });
    assert!(all < 0.7 * none, "{all} {none}");
    assert!(all < bilinear, "{all} {bilinear}");
    assert!(all < 0.7 * jittered, "{all} {jittered}");
}

#[test]
fn a_cut_forgets_everything() {
    let scene = study_scene(1);
    let moments = [0.3, 0.3005, 0.301].map(|t| view(96, 54, study_camera(t, 1)));
    let gaze = DVec2::new(50.0, 20.0);
    let all = TemporalOptions {
        staggered: true,
        ..TemporalOptions::default()
    };
    let draw = |sequence: &mut Sequence, k: usize| {
        let plan = staggered_layers(&moments[k], gaze);
        let frame = sequence.draw(&scene, &moments[k], &plan, k as u64, &options());
        frame.unwrap()
    };
    let alone = draw(&mut Sequence::new(all), 2);
    assert_eq!((alone.work.passes, alone.work.passes_not_due), (3, 0));
    let mut sequence = Sequence::new(all);
    for k in 0..2 {
        draw(&mut sequence, k);
    }
    sequence.cut();
    assert_eq!(draw(&mut sequence, 2), alone);
    // Without it, the frame would be another.
    let mut sequence = Sequence::new(all);
    for k in 0..2 {
        draw(&mut sequence, k);
    }
    let following = draw(&mut sequence, 2);
    assert!(following.work.samples_reprojected > 0 && following.work.passes_not_due == 1);
    assert_ne!(following.image, alone.image);

    // Other scenes, plans and sizes cut by themselves.
    let other = study_scene(2);
    let fewer = layers(&moments[2], gaze, &[(1.0, 20.0), (4.0, 0.0)]);
    let smaller = view(80, 54, study_camera(0.301, 1));
    let cases = [
        (&scene, moments[2], full(&moments[2])),
        (&scene, moments[2], fewer),
        (&scene, smaller, staggered_layers(&smaller, gaze)),
        (&other, moments[2], staggered_layers(&moments[2], gaze)),
    ];
    for (scene, view, plan) in cases {
        let mut sequence = Sequence::new(all);
        draw(&mut sequence, 1);
        let cut = sequence.draw(scene, &view, &plan, 2, &options()).unwrap();
        let alone = Sequence::new(all).draw(scene, &view, &plan, 2, &options());
        assert_eq!(cut, alone.unwrap());
    }
}

#[test]
fn one_colour_everywhere_stays_one_colour() {
    let colour = [0.3, 0.123_456_7, 0.9];
    let mut sequence = Sequence::new(TemporalOptions {
        staggered: true,
        ..TemporalOptions::default()
    });
    let mut reprojected = 0;
    for frame in 0..24 {
        let t = f64::from(frame.min(20)) / 50.0;
        let eye = Pose::new(DVec3::new(t, 0.2 * t, -t), DQuat::from_rotation_y(0.7 * t));
        let view = view(111, 73, eye);
        let ball = placed(
            DVec3::new(0.2 - t, 0.0, -3.0),
            DQuat::from_rotation_x(t),
            1.0 + t,
        );
        let mesh = tessellate(ParametricSurface::Sphere, 24, 16);
        let scene = scene(mesh, &[(Material::Unlit(colour), ball)], colour);
        let plan = staggered_layers(&view, DVec2::new(40.0 + 20.0 * t, 30.0));
        let frame = sequence.draw(&scene, &view, &plan, frame as u64, &options());
        let frame = frame.unwrap();
        assert!(frame.image.rgb.iter().all(|c| *c == colour));
        reprojected += frame.work.samples_reprojected;
    }
    assert!(reprojected > 40_000, "{reprojected}");
}

#[test]
fn threads_and_instructions_do_not_matter() {
    let scene = study_scene(1);
    let run = |simd: Simd, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| {
            let mut sequence = Sequence::new(TemporalOptions {
                staggered: true,
                ..TemporalOptions::default()
            });
            let draw = |k: u64| {
                let view = view(133, 75, study_camera(0.3 + k as f64 * 4e-4, 1));
                let plan = staggered_layers(&view, DVec2::new(60.0 + 3.0 * k as f64, 30.0));
                let options = RenderOptions { simd, ..options() };
                sequence.draw(&scene, &view, &plan, k, &options).unwrap()
            };
            (0..5).map(draw).collect::<Vec<Frame>>()
        })
    };
    let one = run(Simd::Auto, 1);
    assert!(one[4].work.history_clamped > 0 && one[4].work.history_rejected > 0);
    for (simd, threads) in [(Simd::Auto, 2), (Simd::Auto, 7), (Simd::Scalar, 1)] {
        for (a, b) in one.iter().zip(run(simd, threads)) {
            assert_eq!(bits(&a.image), bits(&b.image), "{simd:?} {threads}");
            assert_eq!(a, &b);
        }
    }
}

#[test]
fn passes_that_are_not_due_are_shown_where_they_were_drawn() {
    let scene = study_scene(1);
    let view = study_view(160, 90);
    let gazes = [60.0, 70.0, 82.0, 90.0].map(|x| DVec2::new(x, 45.0));
    let plans = gazes.map(|g| staggered_layers(&view, g));
    let mut sequence = Sequence::new(TemporalOptions {
        staggered: true,
        ..TemporalOptions::OFF
    });
    let mut drawn_in = [0; 3];
    let mut last: Option<Frame> = None;
    for k in 0..4 {
        let frame = sequence.draw(&scene, &view, &plans[k], k as u64, &options());
        let frame = frame.unwrap();
        let mut not_due = 0;
        for (pass, drawn_in) in drawn_in.iter_mut().enumerate() {
            let work = &frame.pass_work[pass];
            if k == 0 || plans[k].passes[pass].cadence.is_due(k as u64) {
                *drawn_in = k;
                assert_eq!((work.passes, work.passes_not_due), (1, 0));
            } else {
                assert_eq!(
                    (work.passes, work.passes_not_due, work.samples()),
                    (0, 1, 0)
                );
                let last = last.as_ref().unwrap();
                assert_eq!(bits(&frame.passes[pass]), bits(&last.passes[pass]));
                not_due += 1;
            }
        }
        assert_eq!(not_due, u64::from(k > 0));
        assert_eq!(frame.work.passes_not_due, not_due);
        // The same picture as a plan of the passes of different ages, blended by the present gaze.
        let mut mixed = plans[k].clone();
        for (pass, k) in drawn_in.into_iter().enumerate() {
            mixed.passes[pass] = plans[k].passes[pass].clone();
        }
        let mixed = render(&scene, &view, &mixed, &options()).unwrap();
        assert_eq!(bits(&frame.image), bits(&mixed.image), "frame {k}");
        last = Some(frame);
    }
}

#[test]
fn a_sequence_with_nothing_on_is_the_frames_themselves() {
    let scene = study_scene(1);
    let mut sequence = Sequence::new(TemporalOptions::OFF);
    for frame in 0..2 {
        let view = view(96, 54, study_camera(0.2 + 0.001 * frame as f64, 1));
        for plan in [full(&view), staggered_layers(&view, DVec2::new(30.0, 30.0))] {
            let alone = render(&scene, &view, &plan, &options()).unwrap();
            let drawn = sequence.draw(&scene, &view, &plan, frame, &options());
            assert_eq!(drawn.unwrap(), alone);
        }
    }
}

#[test]
fn an_offset_moves_the_samples_and_nothing_else() {
    let (scene, view) = (thicket(), view(64, 48, Pose::IDENTITY));
    let mut plan = layers(&view, DVec2::new(30.0, 24.0), &[(1.0, 12.0), (4.0, 0.0)]);
    let offset = DVec2::new(0.25, -0.375);
    for pass in &mut plan.passes {
        pass.offset = offset;
    }
    let moved = render(&scene, &view, &plan, &options()).unwrap();
    for pass in &mut plan.passes {
        let Map::Affine(map) = pass.map else {
            unreachable!("the plan is affine")
        };
        pass.map = Map::Affine(Affine {
            origin: map.origin + map.scale * offset,
            ..map
        });
        pass.offset = DVec2::ZERO;
    }
    let shifted = render(&scene, &view, &plan, &options()).unwrap();
    assert_eq!(moved.passes, shifted.passes);
    // Samples stand for their cells: reconstruction leaves them where the cells are.
    assert_ne!(moved.image, shifted.image);
}

#[test]
fn wrong_numbers_are_refused_and_change_nothing() {
    let (scene, view) = (thicket(), view(32, 24, Pose::IDENTITY));
    for blend in [1.0, -0.1, f32::NAN] {
        let mut sequence = Sequence::new(TemporalOptions {
            blend,
            ..TemporalOptions::default()
        });
        let error = sequence.draw(&scene, &view, &full(&view), 0, &options());
        let text = error.unwrap_err().to_string();
        assert!(
            text.contains("blend") && text.contains("0 to 0.99"),
            "{text}"
        );
    }
    let mut plan = full(&view);
    plan.passes[0].offset = DVec2::new(0.6, 0.0);
    let mut sequence = Sequence::new(UNCLAMPED);
    sequence
        .draw(&scene, &view, &full(&view), 0, &options())
        .unwrap();
    let error = sequence
        .draw(&scene, &view, &plan, 1, &options())
        .unwrap_err();
    assert!(
        matches!(error, RenderError::Pass { pass: 0, .. }),
        "{error}"
    );
    let frame = sequence.draw(&scene, &view, &full(&view), 1, &options());
    assert_eq!(frame.unwrap().work.samples_in_place, 32 * 24);
    let mut other_eye = full(&view);
    other_eye.passes[0].eye = Eye::Left;
    assert!(
        sequence
            .draw(&scene, &view, &other_eye, 2, &options())
            .is_err()
    );
}
