//! Properties of whole pictures: the same for any threads, instructions and way of sampling.

mod common;

use common::{layers, pass, sphere_scene, study_scene_without_lods, study_view, view};
use std::collections::BTreeMap;

use foveasim_assets::{Instance, LodRule, study_camera, study_scene};
use foveasim_models::foveation::{Method, Request};
use foveasim_models::{
    Acuity, Eye, Feather, GazeDirection, Image, Pose, Resolve, SamplePlan, View, Viewport,
};
use foveasim_render::{
    Frame, FrameMemory, RenderError, RenderOptions, Simd, render, render_into, visibility,
};
use glam::{DVec2, DVec3, UVec2};

fn bits(image: &Image) -> Vec<u32> {
    image.rgb.iter().flatten().map(|v| v.to_bits()).collect()
}

fn assert_same(a: &Frame, b: &Frame, what: &str) {
    assert!(bits(&a.image) == bits(&b.image), "{what}");
    assert_eq!(a.work, b.work, "{what}");
}

fn with_threads(threads: usize, f: impl FnOnce() -> Frame + Send) -> Frame {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
        .install(f)
}

#[test]
fn scalar_and_vector_and_any_threads_agree_to_the_bit() {
    let scene = study_scene(1);
    let view = study_view(333, 187);
    let options = RenderOptions::default();
    let scalar = RenderOptions {
        simd: Simd::Scalar,
        ..options
    };
    let gaze = DVec2::new(140.0, 90.0);
    let full = SamplePlan::full(Eye::Cyclopean, view.optics.size);
    for plan in [
        full,
        layers(&view, gaze, &[(1.0, 30.0), (2.3, 80.0), (5.0, 0.0)]),
    ] {
        let one = with_threads(1, || render(&scene, &view, &plan, &options).unwrap());
        let again = with_threads(1, || render(&scene, &view, &plan, &options).unwrap());
        assert_same(&one, &again, "again");
        assert_same(
            &one,
            &with_threads(1, || render(&scene, &view, &plan, &scalar).unwrap()),
            "scalar",
        );
        for n in [2, 7] {
            let many = with_threads(n, || render(&scene, &view, &plan, &options).unwrap());
            assert_same(&one, &many, "threads");
        }
        assert!(
            one.image
                .rgb
                .iter()
                .flatten()
                .all(|v| v.is_finite() && *v >= 0.0)
        );
    }
}

/// Plans of every kind of resolve, looked at from `gaze`.
fn plans(view: &View, gaze: GazeDirection) -> Vec<SamplePlan> {
    let request = Request {
        eye: Eye::Cyclopean,
        viewport: view.optics,
        acuity: Acuity::default(),
        gaze,
        ahead: GazeDirection::AHEAD,
        margin_deg: 0.0,
    };
    let methods = [
        "full",
        "layers:3",
        "rates",
        "kfr:2:4",
        "radial:2",
        "radial:2:filter=gather",
        "kfr:2:4:filter=cubic:smooth",
    ];
    let plan = |method: &str| method.parse::<Method>()?.plan(&request);
    methods.map(|method| plan(method).unwrap()).into()
}

#[test]
fn memory_of_other_frames_leaves_no_trace() {
    let scene = study_scene(1);
    let options = RenderOptions::default();
    let mut memory = FrameMemory::default();
    for size in [UVec2::ZERO, UVec2::new(150, 90), UVec2::new(400, 300)] {
        memory.give(Image::filled(size, [f32::NAN; 3]));
    }
    // Each after others of the same and of other sizes, and of another gaze.
    for (width, height, azimuth) in [(150, 90, 0.0), (210, 90, 8.0), (150, 90, -12.0)] {
        let view = study_view(width, height);
        let gaze = GazeDirection::new(azimuth, 5.0);
        for plan in plans(&view, gaze) {
            let fresh = render(&scene, &view, &plan, &options).unwrap();
            let again = render_into(&scene, &view, &plan, &options, &mut memory).unwrap();
            assert_same(&fresh, &again, &plan.method);
            let mut wrong = again.image;
            wrong.rgb.fill([f32::NAN; 3]);
            memory.give(wrong);
        }
    }
}

#[test]
fn passes_are_kept_alike_in_used_memory() {
    let scene = study_scene(1);
    let view = study_view(150, 90);
    let keep = RenderOptions {
        keep_passes: true,
        ..RenderOptions::default()
    };
    let mut memory = FrameMemory::default();
    for plan in plans(&view, GazeDirection::AHEAD) {
        let fresh = render(&scene, &view, &plan, &keep).unwrap();
        for _ in 0..2 {
            let again = render_into(&scene, &view, &plan, &keep, &mut memory).unwrap();
            assert_same(&fresh, &again, &plan.method);
            for (a, b) in fresh.passes.iter().zip(&again.passes) {
                assert!(bits(a) == bits(b), "{}", plan.method);
            }
            for mut image in again.passes.into_iter().chain([again.image]) {
                image.rgb.fill([f32::NAN; 3]);
                memory.give(image);
            }
        }
    }
}

#[test]
fn work_counts_every_sample_once() {
    let scene = study_scene_without_lods(2);
    let view = study_view(201, 133);
    let plan = layers(
        &view,
        DVec2::new(20.0, 60.0),
        &[(1.0, 25.0), (2.0, 60.0), (4.5, 0.0)],
    );
    let frame = render(&scene, &view, &plan, &RenderOptions::default()).unwrap();
    let count = plan.count();
    let mesh = |i: &Instance| &scene.meshes()[i.mesh];
    let counts = scene.instances().iter().map(|i| mesh(i).triangles().len());
    let triangles = counts.sum::<usize>() as u64;
    for (work, pass) in frame.pass_work.iter().zip(&count.passes) {
        // What the inner layer hides is not drawn.
        assert_eq!(work.samples() + work.samples_hidden, pass.samples);
        assert!(work.samples_covered >= work.samples_shaded);
        assert!(work.samples_tested >= work.samples_covered);
        assert_eq!(work.triangles, triangles);
        // Clipping may set up several triangles for one.
        let sorted = work.triangles_back_facing + work.triangles_outside;
        assert!(sorted + work.triangles_set_up >= work.triangles);
    }
    assert_eq!(
        frame.work.samples() + frame.work.samples_hidden,
        count.samples()
    );
    assert_eq!(frame.work.passes, 3);
    assert_eq!(frame.work.pixels_resolved, count.display_pixels);
}

#[test]
fn one_colour_everywhere_stays_one_colour() {
    let colour = [0.3, 0.123_456_7, 0.9];
    let scene = sphere_scene(colour, colour);
    let view = view(157, 101, Pose::IDENTITY);
    let full = SamplePlan::full(Eye::Cyclopean, view.optics.size);
    let layered = layers(
        &view,
        DVec2::new(70.5, 30.2),
        &[(1.0, 20.0), (2.7, 45.0), (6.1, 0.0)],
    );
    for plan in [full, layered] {
        let frame = render(&scene, &view, &plan, &RenderOptions::default()).unwrap();
        assert!(frame.work.samples_shaded > 0 && frame.work.samples_sky > 0);
        assert!(
            frame.image.rgb.iter().all(|c| *c == colour),
            "{}",
            plan.method
        );
    }
}

#[test]
fn layers_of_display_pixels_are_the_full_image() {
    let scene = study_scene(1);
    let view = study_view(300, 170);
    let full = SamplePlan::full(Eye::Cyclopean, view.optics.size);
    let plan = layers(
        &view,
        DVec2::new(211.0, 70.0),
        &[(1.0, 33.0), (1.0, 71.0), (1.0, 0.0)],
    );
    let options = RenderOptions::default();
    let a = render(&scene, &view, &full, &options).unwrap();
    let b = render(&scene, &view, &plan, &options).unwrap();
    // Blending rounds where a and b are equal to nothing: a + w·(b − a) = a.
    assert!(bits(&a.image) == bits(&b.image));
}

#[test]
fn the_periphery_is_blurred_and_the_fovea_is_not() {
    let scene = study_scene(1);
    let view = study_view(320, 180);
    let gaze = DVec2::new(160.0, 90.0);
    let options = RenderOptions::default();
    let full = SamplePlan::full(Eye::Cyclopean, view.optics.size);
    let full = render(&scene, &view, &full, &options).unwrap().image;
    let plan = layers(&view, gaze, &[(1.0, 40.0), (8.0, 0.0)]);
    let layered = render(&scene, &view, &plan, &options).unwrap().image;
    let mut periphery = 0.0;
    for y in 0..180 {
        for x in 0..320 {
            let r = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5).distance(gaze);
            let (a, b) = (full.at(x, y), layered.at(x, y));
            // Within the plateau of the inner weight (0.36 of its half width) nothing may change.
            if r < 14.0 {
                assert_eq!(a, b, "({x}, {y})");
            }
            periphery += (0..3).map(|c| f64::from(a[c] - b[c]).abs()).sum::<f64>();
        }
    }
    assert!(periphery > 100.0, "{periphery}");
}

#[test]
fn gaze_beyond_the_edge_leaves_the_outer_layers() {
    let scene = study_scene(1);
    let view = study_view(160, 90);
    let plan = layers(&view, DVec2::new(-500.0, 40.0), &[(1.0, 20.0), (3.0, 0.0)]);
    let frame = render(&scene, &view, &plan, &RenderOptions::default()).unwrap();
    assert_eq!(frame.pass_work[0].samples(), 0);
    assert!(frame.image.rgb.iter().flatten().all(|v| *v > 0.0));
}

#[test]
fn what_is_off_screen_is_not_drawn() {
    let scene = sphere_scene([1.0; 3], [0.0; 3]);
    let away = Pose::new(
        DVec3::ZERO,
        glam::DQuat::from_rotation_y(std::f64::consts::PI),
    );
    let view = view(64, 64, away);
    let plan = SamplePlan::full(Eye::Cyclopean, view.optics.size);
    let work = render(&scene, &view, &plan, &RenderOptions::default())
        .unwrap()
        .work;
    assert_eq!(
        (work.vertices, work.triangles_set_up, work.samples_tested),
        (0, 0, 0)
    );
    assert_eq!(work.triangles_outside, work.triangles);
}

#[test]
fn passes_are_kept_only_when_asked_for() {
    let scene = study_scene(1);
    let view = study_view(96, 64);
    let options = RenderOptions::default();
    let keep = RenderOptions {
        keep_passes: true,
        ..options
    };
    let full = SamplePlan::full(Eye::Cyclopean, view.optics.size);
    let layered = layers(&view, DVec2::new(40.0, 30.0), &[(1.0, 16.0), (3.0, 0.0)]);
    for plan in [full, layered] {
        let plain = render(&scene, &view, &plan, &options).unwrap();
        assert!(plain.passes.is_empty(), "{}", plan.method);
        let kept = render(&scene, &view, &plan, &keep).unwrap();
        assert_same(&plain, &kept, &plan.method);
        assert_eq!(kept.passes.len(), plan.passes.len());
        for (image, pass) in kept.passes.iter().zip(&plan.passes) {
            assert_eq!(image.rgb.len() as u64, pass.lattice.samples());
        }
        if plan.resolve == Resolve::Direct {
            assert!(bits(&kept.passes[0]) == bits(&kept.image));
        }
    }
}

/// Extreme but allowed: no arithmetic may overflow (these builds check), nor a pixel be NaN.
#[test]
fn optics_at_the_ends_of_their_ranges_can_be_drawn() {
    let scene = study_scene(1);
    let size = UVec2::new(40, 24);
    let at = |tan| {
        let optics = Viewport::new(size, tan).unwrap();
        View::still(Eye::Cyclopean, optics, study_camera(0.3, 1))
    };
    let view_and_maps = [
        (at([-1e3, 1e3, 1e3, -1e3]), DVec2::ZERO, 1.0),
        (
            at([-2.001e-6, 2.001e-6, 1.201e-6, -1.201e-6]),
            DVec2::ZERO,
            1.0,
        ),
        (at([0.6, 0.6004, -0.6, -0.600_24]), DVec2::ZERO, 1.0),
        (at([-1.0, 1.0, 0.6, -0.6]), DVec2::new(65.0, -65.0), 1e-3),
        (at([-1.0, 1.0, 0.6, -0.6]), DVec2::splat(65_536.0), 1.0),
        (at([-1.0, 1.0, 0.6, -0.6]), DVec2::splat(-65_536.0), 1e4),
    ];
    for (view, origin, scale) in view_and_maps {
        let mut plan = SamplePlan::full(Eye::Cyclopean, size);
        plan.passes = vec![pass(origin, scale, size)];
        plan.resolve = Resolve::Feather(Feather {
            gaze: DVec3::NEG_Z,
            edges_tan: Vec::new(),
        });
        for simd in [Simd::Auto, Simd::Scalar] {
            let options = RenderOptions {
                simd,
                ..RenderOptions::default()
            };
            let frame = render(&scene, &view, &plan, &options).unwrap();
            assert!(frame.image.rgb.iter().flatten().all(|v| v.is_finite()));
        }
    }
}

#[test]
fn optics_beyond_what_arithmetic_can_hold_are_refused() {
    let scene = study_scene(1);
    let size = UVec2::new(64, 32);
    let plan = SamplePlan::full(Eye::Cyclopean, size);
    let narrow = 1e-40_f64.to_radians() / 2.0;
    for (name, tan) in [
        ("pixel size", [-narrow, narrow, narrow / 2.0, -narrow / 2.0]),
        ("pixel size", [-3e-6, 3e-6, 1e-6, -1e-6]),
        ("pixel size", [1.0, -1.0, 0.5, -0.5]),
        ("pixel size", [-1.0, 1.0, 0.0, 0.0]),
        ("image edges", [-1001.0, 1.0, 0.5, -0.5]),
        ("image edges", [-1.0, f64::INFINITY, 0.5, -0.5]),
        ("image edges", [-1.0, 1.0, f64::NAN, -0.5]),
        (
            "distance of the image from the view axis",
            [-1.0, -0.9999, 0.5, -0.5],
        ),
    ] {
        let optics = Viewport { size, tan };
        let view = View::still(Eye::Cyclopean, optics, study_camera(0.3, 1));
        let error = render(&scene, &view, &plan, &RenderOptions::default()).unwrap_err();
        assert!(
            matches!(error, RenderError::OutOfRange { field, .. } if field == name),
            "{tan:?}: {error}"
        );
    }
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let scene = sphere_scene([1.0; 3], [0.0; 3]);
    let still = view(64, 32, Pose::IDENTITY);
    let good = SamplePlan::full(Eye::Cyclopean, still.optics.size);
    let options = RenderOptions::default();
    let fails = |view: &View, plan: &SamplePlan, options: &RenderOptions| {
        render(&scene, view, plan, options).unwrap_err()
    };

    let mut moving = still;
    moving.poses[1].position.x = 0.1;
    assert_eq!(fails(&moving, &good, &options), RenderError::MovingView);
    let mut lost = still;
    lost.poses = [Pose::new(DVec3::new(f64::NAN, 0.0, 0.0), glam::DQuat::IDENTITY); 2];
    fails(&lost, &good, &options);
    for near_m in [f64::NAN, 0.0, -1.0] {
        fails(&still, &good, &RenderOptions { near_m, ..options });
    }
    let other = SamplePlan::full(Eye::Cyclopean, UVec2::new(32, 64));
    assert!(matches!(
        fails(&still, &other, &options),
        RenderError::OtherSize { .. }
    ));
    let left = SamplePlan::full(Eye::Left, still.optics.size);
    assert!(matches!(
        fails(&still, &left, &options),
        RenderError::Pass { pass: 0, .. }
    ));

    let bad_pass = |edit: &dyn Fn(&mut foveasim_models::Pass)| {
        let mut plan = layers(&still, DVec2::splat(16.0), &[(1.0, 8.0), (2.0, 0.0)]);
        edit(&mut plan.passes[1]);
        assert!(matches!(
            fails(&still, &plan, &options),
            RenderError::Pass { pass: 1, .. }
        ));
    };
    for scale in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        bad_pass(&|p| *p = pass(DVec2::ZERO, scale, UVec2::ONE));
    }
    bad_pass(&|p| *p = pass(DVec2::splat(f64::NAN), 1.0, UVec2::ONE));
    bad_pass(&|p| *p = pass(DVec2::ZERO, 1.0, UVec2::new(70_000, 1)));
    // In samples, the origin must fit the integers of snapping.
    bad_pass(&|p| *p = pass(DVec2::splat(-65_536.0), 1e-3, UVec2::ONE));
    bad_pass(&|p| *p = pass(DVec2::new(0.0, 65.6), 1e-3, UVec2::ONE));

    let mut plan = good.clone();
    plan.passes.clear();
    assert!(matches!(
        fails(&still, &plan, &options),
        RenderError::Resolve { .. }
    ));
    let mut plan = layers(&still, DVec2::splat(16.0), &[(1.0, 8.0), (2.0, 0.0)]);
    let Resolve::Feather(feather) = &mut plan.resolve else {
        unreachable!()
    };
    feather.edges_tan[0] = [0.5, 0.2];
    assert!(matches!(
        fails(&still, &plan, &options),
        RenderError::Resolve { .. }
    ));
}

/// Only the outermost of several layers has a curve of its own (Guenter 2012, §6).
#[test]
fn parts_of_a_mosaic_have_the_detail_of_the_full_image() {
    let scene = study_scene(1);
    let view = study_view(160, 90);
    let options = RenderOptions {
        lod: LodRule::Distance,
        ..RenderOptions::default()
    };
    let request = Request {
        eye: view.eye,
        viewport: view.optics,
        acuity: Acuity::default(),
        gaze: GazeDirection::AHEAD,
        ahead: GazeDirection::AHEAD,
        margin_deg: 0.0,
    };
    let meshes = |plan: &SamplePlan, pass| {
        let seen = visibility(&scene, &view, plan, pass, &options).unwrap();
        let names = seen.into_iter().flatten().map(|s| (s.instance, s.mesh));
        names.collect::<BTreeMap<_, _>>()
    };
    let full = meshes(&SamplePlan::full(view.eye, view.optics.size), 0);
    let mosaic = "quad".parse::<Method>().unwrap().plan(&request).unwrap();
    let last = meshes(&mosaic, mosaic.passes.len() - 1);
    let shared = last.iter().filter(|(i, _)| full.contains_key(i));
    assert!(shared.clone().count() > 50);
    for (instance, mesh) in shared {
        assert_eq!(full[instance], *mesh, "instance {instance}");
    }
}
