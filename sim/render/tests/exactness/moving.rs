//! Rolling, foveated, seen through a lens, and all of it at once: the rasterizer against rays, and against itself with other threads
//! and instructions.

use foveasim_assets::{Key, Motion, Repeat, Scene, SceneParts, Similarity, Track, study_camera};
use foveasim_models::{Lens, Pose, Role, SamplePlan, ScanSkew, Stream, View, Visibility};
use foveasim_render::{Bound, RenderOptions, Simd, Skip, render, trace, visibility};
use glam::{DQuat, DVec2, DVec3, UVec2};

use crate::common::{soup, unlit, view};
use crate::{STUDY, bits, full, loose_triangles, options, plan};

/// Plans that are not, and are, foveated.
const METHODS: [&str; 5] = [
    "full",
    "radial:2",
    "radial:2.5:boundary:scale=0.8",
    "kfr:1.5:0.5",
    "lms:0.6:0.4",
];

pub(crate) fn lens(size: UVec2) -> Lens {
    let centre = DVec2::new(0.47, 0.52) * size.as_dvec2();
    let unit = f64::from(size.x) / 2.0;
    Lens::new(centre, unit, [0.22, 0.12], [1.0; 3], size).unwrap()
}

/// From `pose` on, turning by so many degrees about the vertical and moving a little.
pub(crate) fn turning(view: View, degrees: f64, moved: DVec3) -> View {
    let start = view.poses[0];
    let turn = DQuat::from_rotation_y(degrees.to_radians());
    let end = Pose::new(
        start.position + moved,
        (turn * start.orientation).normalize(),
    );
    let scan = ScanSkew::new(DVec2::new(0.1, 0.85)).unwrap();
    View::rolling(view.eye, view.optics, [start, end], scan)
}

/// How many samples show a triangle, if rasterizer and tracer agree.
fn agree(scene: &Scene, view: &View, plan: &SamplePlan, options: &RenderOptions) -> usize {
    let mut seen = 0;
    for index in 0..plan.passes.len() {
        let drawn = visibility(scene, view, plan, index, options).unwrap();
        let traced = trace(scene, view, plan, index, 0, options).unwrap();
        if let Some(k) = drawn.iter().zip(&traced).position(|(a, b)| a != b) {
            panic!(
                "{} pass {index} sample {k}: drawn {:?}, traced {:?}",
                plan.method, drawn[k], traced[k]
            );
        }
        seen += drawn.iter().flatten().count();
    }
    seen
}

/// Loose triangles whose corners each go somewhere else.
pub(crate) fn scattering(seed: u64, count: usize, reach: f64) -> Scene {
    let still = loose_triangles(seed, count);
    let mesh = still.meshes()[0].clone();
    let moving = mesh
        .moving_to(|p| {
            let bits = p.to_array().map(f64::to_bits);
            let key = bits[0] ^ bits[1].rotate_left(21) ^ bits[2].rotate_left(42);
            let random = &mut Stream::new(key, Role::Scene, 8);
            p + DVec3::from([(); 3].map(|()| random.range(-reach, reach)))
        })
        .unwrap();
    unlit(vec![moving], [1.0; 3], [0.0; 3])
}

#[test]
fn all_combinations_on_the_study_scene() {
    let still = view(120, 68, study_camera(0.3, 1));
    let rolling = turning(still, 4.0, DVec3::new(0.02, 0.0, 0.05));
    let size = still.optics.size;
    for method in METHODS {
        for view in [still, rolling] {
            for lens in [None, Some(lens(size))] {
                let view = view.seen_through(lens);
                let seen = agree(&STUDY, &view, &plan(method, &view), &options());
                assert!(seen > 1000, "{method}: {seen}");
            }
        }
    }
}

/// Loose triangles that turn about the vertical, three times a second.
fn turning_soup() -> Scene {
    let still = loose_triangles(5, 300);
    let key = |seconds: f64, turn: f64| Key {
        seconds,
        placement: Similarity {
            pose: Pose::new(DVec3::ZERO, DQuat::from_rotation_y(turn)),
            scale: 1.0,
        },
    };
    let track = Track::new(vec![key(0.0, 0.0), key(0.1, 2.0)], Repeat::Every(0.1)).unwrap();
    Scene::build(SceneParts {
        meshes: still.meshes().to_vec(),
        lods: Vec::new(),
        instances: still.instances().to_vec(),
        materials: still.materials().to_vec(),
        textures: Vec::new(),
        motions: vec![Motion {
            instance: 0,
            chain: vec![track],
        }],
        sky: still.sky().clone(),
        sun: *still.sun(),
    })
    .unwrap()
}

#[test]
fn moving_instances_and_other_bounds() {
    let scene = turning_soup().over([0.3, 0.311]);
    assert!(scene.is_moving());
    let still = view(120, 68, Pose::IDENTITY);
    let scan = ScanSkew::new(DVec2::new(0.0, -0.9)).unwrap();
    let rolling = View::rolling(still.eye, still.optics, still.poses, scan);
    let planned = plan("radial:2", &rolling);
    let seen = agree(&scene, &rolling, &planned, &options());
    assert!(seen > 1000, "{seen}");
    let still = view(120, 68, study_camera(0.3, 1));
    let plan = plan("radial:2", &still);
    // Also of still views.
    let options = RenderOptions {
        bound: Some(Bound::Conservative),
        ..options()
    };
    assert!(agree(&STUDY, &still, &plan, &options) > 1000);
}

/// A million with `FOVEASIM_THOROUGH=1`.
#[test]
fn random_moving_triangles() {
    let thorough = std::env::var_os("FOVEASIM_THOROUGH").is_some();
    let (scenes, count) = if thorough { (1000, 1000) } else { (8, 400) };
    let mut seen = 0;
    for seed in 0..scenes {
        let scene = scattering(seed, count, [0.3, 3.0, 0.0][seed as usize % 3]);
        let (width, height) = [(96, 54), (33, 101)][seed as usize % 2];
        let still = view(width, height, Pose::IDENTITY);
        let rolling = turning(still, 5.0, DVec3::new(0.1, -0.1, 0.3));
        let view =
            [rolling, rolling.seen_through(Some(lens(still.optics.size)))][(seed / 2) as usize % 2];
        let method = ["radial:2", "full", "radial:4:scale=0.7"][(seed / 4) as usize % 3];
        let options = RenderOptions {
            simd: if seed == 0 { Simd::Scalar } else { Simd::Auto },
            skip: match seed % 3 {
                0 => Skip::ALL,
                1 => Skip::NONE,
                _ => Skip {
                    back_faces: false,
                    ..Skip::ALL
                },
            },
            ..options()
        };
        seen += agree(&scene, &view, &plan(method, &view), &options);
    }
    assert!(seen > 10_000, "{seen}");
}

#[test]
fn hard_cases_are_finite_and_agree() {
    let still = view(
        90,
        50,
        Pose::new(DVec3::new(0.0, 0.0, 2.0), DQuat::IDENTITY),
    );
    // 500° in a second, 11 ms a scan; and a scan of half a second.
    let fast = turning(still, 5.5, DVec3::ZERO);
    let faster = turning(still, 250.0, DVec3::ZERO);
    let sliver = [
        DVec3::new(-1.0, 0.3, -1.0),
        DVec3::new(1.0, 0.31, -1.0),
        DVec3::new(0.0, 0.305 + 3e-8, -1.0),
    ];
    let huge = [
        DVec3::new(-1e4, -40.0, -90.0),
        DVec3::new(1e4, -40.0, -90.0),
        DVec3::new(0.0, 9e3, -90.0),
    ];
    let near = [
        DVec3::new(-0.2, -0.2, 1.9),
        DVec3::new(0.3, -0.2, 1.97),
        DVec3::new(0.0, 0.3, 1.0),
    ];
    let mesh = soup(&[sliver, huge, near]);
    let through = mesh.moving_to(|p| p + DVec3::new(0.0, 0.0, 1.5)).unwrap();
    let mut scene = unlit(vec![through], [0.5; 3], [0.1; 3]);
    let mut parts = scene.instances().to_vec();
    parts[0].two_sided = true;
    scene = Scene::new(
        scene.meshes().to_vec(),
        parts,
        scene.materials().to_vec(),
        scene.sky().clone(),
        *scene.sun(),
    )
    .unwrap();
    let size = still.optics.size.as_dvec2();
    for view in [still, fast, faster] {
        for gaze in [DVec2::ZERO, size, size * 0.5, size * 3.0, size * -1.0] {
            for text in ["radial:2", "radial:16:scale=0.5", "radial:3:boundary"] {
                let method: foveasim_models::foveation::Method = text.parse().unwrap();
                let request = foveasim_models::foveation::Request {
                    eye: view.eye,
                    viewport: view.optics,
                    acuity: foveasim_models::Acuity::default(),
                    gaze: view.optics.gaze_at(gaze),
                    ahead: foveasim_models::GazeDirection::AHEAD,
                    margin_deg: 0.0,
                };
                let plan = method.plan(&request).unwrap();
                for lens in [None, Some(lens(view.optics.size))] {
                    let view = view.seen_through(lens);
                    agree(&scene, &view, &plan, &options());
                    let frame = render(&scene, &view, &plan, &options()).unwrap();
                    assert!(frame.image.rgb.iter().flatten().all(|c| c.is_finite()));
                }
            }
        }
    }
}

#[test]
fn the_same_bits_for_any_threads_and_instructions() {
    let scene = STUDY.over([3.0, 3.011]);
    let rolling = turning(view(120, 68, study_camera(0.3, 1)), 4.0, DVec3::X * 0.02);
    let view = rolling.seen_through(Some(lens(rolling.optics.size)));
    let plan = plan("radial:2:boundary", &view);
    let draw = |threads: usize, simd: Simd| {
        let options = RenderOptions { simd, ..options() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let frame = pool
            .build()
            .unwrap()
            .install(|| render(&scene, &view, &plan, &options).unwrap());
        (bits(&frame.image), frame.work)
    };
    let one = draw(1, Simd::Auto);
    assert_eq!(one, draw(3, Simd::Auto));
    assert_eq!(one, draw(2, Simd::Scalar));
}

#[test]
fn what_does_not_magnify_or_move_costs_nothing() {
    let still = view(120, 68, study_camera(0.3, 1));
    let (one, whole) = (plan("radial:1", &still), full(&still));
    let a = render(&STUDY, &still, &one, &options()).unwrap();
    let b = render(&STUDY, &still, &whole, &options()).unwrap();
    assert_eq!(bits(&a.image), bits(&b.image));
    assert_eq!(a.work, b.work);
    // A rolling display of which nothing moves is a still one.
    let scan = ScanSkew::new(DVec2::Y).unwrap();
    let rolling = View::rolling(still.eye, still.optics, still.poses, scan);
    let c = render(&STUDY, &rolling, &one, &options()).unwrap();
    assert_eq!((bits(&c.image), c.work), (bits(&b.image), b.work));
}

#[test]
fn what_cannot_be_rolled_is_refused() {
    let still = view(120, 68, Pose::IDENTITY);
    let scene = scattering(0, 10, 0.1);
    let rolling = turning(still, 5.0, DVec3::ZERO);
    let fails = |view: &View, plan: &SamplePlan| {
        let drawn = render(&scene, view, plan, &options()).map(|frame| frame.work);
        drawn.unwrap_err().to_string()
    };
    let mut four = full(&still);
    four.passes[0].visibility = Visibility::Own(foveasim_models::Msaa::Four);
    assert!(fails(&rolling, &four).contains("one position of visibility"));
    assert!(fails(&rolling, &plan("kfr:2:4:published", &still)).contains("share visibility"));
    assert!(fails(&rolling, &plan("vrs", &still)).contains("shaded by itself"));
    let through = still.seen_through(Some(lens(still.optics.size)));
    assert!(fails(&through, &plan("layers:3", &still)).contains("lens"));
    let mut lost = rolling;
    lost.poses[1].position.x = f64::NAN;
    assert!(fails(&lost, &full(&still)).contains("eye position"));
}
