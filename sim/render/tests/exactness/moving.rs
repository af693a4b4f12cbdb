//! Rolling, foveated, seen through a lens, and all of it at once: the rasterizer against rays, a tracer in double
//! precision, still images, and itself with other threads and instructions.

use foveasim_assets::{Key, Motion, Repeat, Scene, SceneParts, Similarity, Track, study_camera};
use foveasim_models::{Lens, Pose, Role, SamplePlan, ScanSkew, Stream, View, Visibility};
use foveasim_render::{
    Bound, BoundCounts, RenderOptions, Simd, Skip, bound_counts, render, sample_looks, trace,
    visibility,
};
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

fn lens(size: UVec2) -> Lens {
    let centre = DVec2::new(0.47, 0.52) * size.as_dvec2();
    let unit = f64::from(size.x) / 2.0;
    Lens::new(centre, unit, [0.22, 0.12], [1.0; 3], size).unwrap()
}

/// From `pose` on, turning by so many degrees about the vertical and moving a little.
fn turning(view: View, degrees: f64, moved: DVec3) -> View {
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
fn scattering(seed: u64, count: usize, reach: f64) -> Scene {
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

/// While the eye only shifts, vertices move as straight as it does: each row is the row of a still view from where the eye is then,
/// but for snapping and rounding.
#[test]
fn rows_are_those_of_still_views_at_their_time() {
    let still = view(160, 90, study_camera(0.3, 1));
    let moved = DVec3::new(0.3, 0.05, -0.2);
    let end = Pose::new(still.poses[0].position + moved, still.poses[0].orientation);
    let scan = ScanSkew::new(DVec2::Y).unwrap();
    let rolling = View::rolling(still.eye, still.optics, [still.poses[0], end], scan);
    // The finest meshes of both.
    let options = RenderOptions {
        lod: foveasim_assets::LodRule::Finest,
        ..options()
    };
    let image = render(&STUDY, &rolling, &full(&still), &options)
        .unwrap()
        .image;
    let (mut off, mut all) = (0, 0);
    for y in (0..90).step_by(11) {
        let t = (f64::from(y) + 0.5) / 90.0;
        let pose = Pose::new(
            still.poses[0].position + moved * t,
            still.poses[0].orientation,
        );
        let then = View::still(still.eye, still.optics, pose);
        let wanted = render(&STUDY, &then, &full(&still), &options)
            .unwrap()
            .image;
        let row = (y * 160) as usize..(y * 160 + 160) as usize;
        for (a, b) in image.rgb[row.clone()].iter().zip(&wanted.rgb[row]) {
            let differs = (0..3).any(|k| (a[k] - b[k]).abs() > 0.01 + 0.02 * b[k]);
            off += usize::from(differs);
            all += 1;
        }
    }
    assert!(off * 100 < all * 2, "{off} of {all}");
}

/// Seen by lens and magnification, a still scene is what snapped triangles show, but along edges.
#[test]
fn still_passes_are_alike_by_either_rasterizer() {
    let still = view(160, 90, study_camera(0.3, 1));
    let asked = RenderOptions {
        bound: Some(Bound::Conservative),
        ..options()
    };
    for method in ["full", "radial:2"] {
        let plan = plan(method, &still);
        let a = visibility(&STUDY, &still, &plan, 0, &options()).unwrap();
        let b = visibility(&STUDY, &still, &plan, 0, &asked).unwrap();
        let name = |s: &Option<foveasim_render::Surfel>| s.map(|s| (s.instance, s.triangle));
        let differ = a.iter().zip(&b).filter(|(a, b)| name(a) != name(b)).count();
        assert!(
            differ * 100 < a.len() * 2,
            "{method}: {differ} of {}",
            a.len()
        );
        let images = [options(), asked]
            .map(|options| render(&STUDY, &still, &plan, &options).unwrap().image);
        let far = images[0].rgb.iter().zip(&images[1].rgb);
        let off = far
            .filter(|(a, b)| (0..3).any(|k| (a[k] - b[k]).abs() > 0.01 + 0.03 * b[k]))
            .count();
        assert!(off * 100 < a.len() * 2, "{method}: {off} of {}", a.len());
    }
}

/// A sample's hit of a triangle with `corners` in eye space (x, y, w), by solving for the point in double precision: its w, and
/// the least barycentric weight.
fn hit(corners: [DVec3; 3], direction: DVec2) -> Option<(f64, f64)> {
    let [a, b, c] = corners;
    let matrix = glam::DMat3::from_cols(a, b, c);
    let weights = matrix.inverse() * direction.extend(1.0);
    let sum = weights.element_sum();
    let share = weights / sum;
    (weights.is_finite() && sum > 0.0).then(|| (1.0 / sum, share.min_element()))
}

/// An independent tracer in double precision, one that knows nothing of forms and planes, differs only beside edges.
#[test]
fn an_independent_tracer_differs_only_beside_edges() {
    let (mut beside, mut samples) = (0, 0);
    for seed in 0..3 {
        let scene = scattering(seed, 150, 0.3);
        let still = view(64, 36, Pose::IDENTITY);
        let rolling = turning(still, 5.0, DVec3::new(0.02, 0.01, 0.05));
        let view = rolling.seen_through((seed > 0).then(|| lens(still.optics.size)));
        let plan = plan("radial:2", &view);
        let options = RenderOptions {
            skip: Skip::NONE,
            near_m: 0.05,
            ..options()
        };
        let drawn = visibility(&scene, &view, &plan, 0, &options).unwrap();
        let looks = sample_looks(&scene, &view, &plan, 0, &options).unwrap();
        let mesh = &scene.meshes()[0];
        let ends = mesh.end_positions().unwrap();
        let eye = view.poses.map(|p| p.inverse());
        let corner = |i: u32, t: f64| {
            let start = eye[0].point(mesh.position(i));
            let at = |k: usize| f64::from(ends[k][i as usize]);
            let end = eye[1].point(DVec3::new(at(0), at(1), at(2)));
            let p = start + (end - start) * t;
            DVec3::new(p.x, p.y, -p.z)
        };
        for (sample, (found, looks)) in drawn.iter().zip(&looks).enumerate() {
            let Some([u, v, t]) = looks.map(|l| l.map(f64::from)) else {
                assert_eq!(*found, None);
                continue;
            };
            samples += 1;
            let ray = view.optics.direction(DVec2::new(u, v));
            let direction = DVec2::new(ray.x, ray.y);
            let mut nearest: Option<(f64, u32)> = None;
            let mut close = false;
            for (index, names) in mesh.triangles().iter().enumerate() {
                let corners = names.map(|i| corner(i, t));
                let Some((w, least)) = hit(corners, direction) else {
                    continue;
                };
                // Weights of slivers are far apart where places are close.
                let size = corners[0]
                    .distance(corners[1])
                    .min(corners[0].distance(corners[2]));
                let slack = 1e-3_f64.max(1e-3 * w / size);
                if w < options.near_m * (1.0 - 1e-5) {
                    continue;
                }
                close |= least.abs() < slack || (w - options.near_m).abs() < 1e-4;
                if least >= 0.0 && w >= options.near_m {
                    if let Some((other, _)) = nearest {
                        close |= (w - other).abs() < 1e-3 * w;
                    }
                    if nearest.is_none_or(|(other, _)| w < other) {
                        nearest = Some((w, index as u32));
                    }
                }
            }
            let wanted = nearest.map(|n| n.1);
            if found.map(|s| s.triangle) != wanted {
                assert!(close, "sample {sample}: {found:?}, {nearest:?}");
                beside += 1;
            } else if let (Some(s), Some((w, _))) = (found, nearest) {
                let off = (f64::from(s.depth_m) / w - 1.0).abs();
                assert!(off < 2e-3 || close, "sample {sample}: {off}");
            }
        }
    }
    eprintln!("{beside} of {samples} samples differ, all beside an edge");
    assert!(beside * 50 < samples, "{beside} of {samples}");
}

/// No covered sample is left out, hidden ones included: triangle by triangle what is found without any bound. A million with
/// `FOVEASIM_THOROUGH=1`.
#[test]
fn the_bound_misses_nothing() {
    let thorough = std::env::var_os("FOVEASIM_THOROUGH").is_some();
    let (scenes, count) = if thorough { (2000, 500) } else { (8, 300) };
    let (mut triangles, mut covered, mut tested) = (0, 0, [0; 2]);
    for seed in 0..scenes {
        let scene = scattering(1000 + seed, count, [0.3, 3.0, 0.05][seed as usize % 3]);
        let still = view(80, 45, Pose::IDENTITY);
        let rolling = turning(still, 6.0, DVec3::new(0.1, -0.1, 0.3));
        let through = rolling.seen_through(Some(lens(still.optics.size)));
        let view = [rolling, through, still][(seed / 3) as usize % 3];
        let method = ["radial:2", "full", "radial:4:scale=0.7"][seed as usize % 3];
        let plan = plan(method, &view);
        let [all, ours] = [Bound::Everything, Bound::Conservative]
            .map(|bound| bound_counts(&scene, &view, &plan, 0, bound, &options()).unwrap());
        assert_eq!(all.covered, ours.covered, "{seed}");
        let hit = |counts: &BoundCounts| -> Vec<(u32, u64)> {
            let triangles = counts.triangles.iter().filter(|t| t.covered > 0);
            triangles.map(|t| (t.triangle, t.covered)).collect()
        };
        assert_eq!(hit(&all), hit(&ours), "{seed}");
        triangles += count;
        covered += ours.work.samples_covered;
        tested = [
            tested[0] + all.work.samples_tested,
            tested[1] + ours.work.samples_tested,
        ];
    }
    eprintln!("{triangles} triangles, {covered} samples covered, {tested:?} tested: none missed");
    assert!(covered > 10_000);
}

/// Where samples look is where the map, lens and scan have them in double precision, to rounding.
#[test]
fn samples_look_where_the_plan_says() {
    let still = view(640, 360, Pose::IDENTITY);
    let scene = loose_triangles(1, 3);
    for method in [
        "full",
        "radial:2",
        "radial:3.3:boundary:scale=0.6",
        "kfr:2:0.5",
        "lms:1:0.5",
    ] {
        for through in [None, Some(lens(still.optics.size))] {
            let view = turning(still, 5.0, DVec3::ZERO).seen_through(through);
            let plan = plan(method, &view);
            let looks = sample_looks(&scene, &view, &plan, 0, &options()).unwrap();
            let sampling = view.sampling(plan.passes[0].map);
            let (mut off, mut late) = (0.0f64, 0.0f64);
            let foveasim_models::Lattice::Grid(grid) = plan.passes[0].lattice else {
                unreachable!("a grid")
            };
            for (index, looks) in looks.iter().enumerate().step_by(7) {
                let Some([u, v, t]) = looks.map(|l| l.map(f64::from)) else {
                    continue;
                };
                let index = index as u32;
                let at = UVec2::new(index % grid.x, index / grid.x).as_dvec2() + 0.5;
                let wanted = sampling.at_clamped(at);
                off = off.max((wanted.ray - DVec2::new(u, v)).abs().max_element());
                late = late.max((wanted.time - t).abs());
            }
            assert!(off < 0.003 && late < 2e-6, "{method}: {off} px, {late}");
        }
    }
}

/// Published bounds find no more than ours does; how much they miss, and what each tests.
#[test]
fn published_bounds_miss_and_ours_does_not() {
    let still = view(120, 68, study_camera(0.3, 1));
    let view = turning(still, 5.0, DVec3::new(0.02, 0.0, 0.05));
    let plan = plan("radial:2", &view);
    let bounds = [
        Bound::Box,
        Bound::Simple,
        Bound::Adaptive,
        Bound::Conservative,
    ];
    let counts = bounds.map(|bound| {
        let found = bound_counts(&STUDY, &view, &plan, 0, bound, &options()).unwrap();
        let of_triangles: u64 = found.triangles.iter().map(|t| t.covered).sum();
        assert_eq!(of_triangles, found.work.samples_covered);
        let of_samples: u64 = found.covered.iter().map(|c| u64::from(*c)).sum();
        assert_eq!(of_samples, found.work.samples_covered);
        found
    });
    let [boxed, simple, adaptive, ours] = counts.map(|c| {
        eprintln!(
            "tested {} covered {} efficiency {:.3}",
            c.work.samples_tested,
            c.work.samples_covered,
            c.efficiency()
        );
        c.work.samples_covered
    });
    assert!(boxed <= ours && simple < ours && adaptive <= ours);
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
