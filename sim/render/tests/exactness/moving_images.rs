//! What moving triangles show, against still images, a tracer in double precision, and where the plan says that samples look.

use foveasim_assets::study_camera;
use foveasim_models::{Pose, ScanSkew, View};
use foveasim_render::{Bound, RenderOptions, Skip, render, sample_looks, visibility};
use glam::{DVec2, DVec3, UVec2};

use crate::common::view;
use crate::moving::{lens, scattering, turning};
use crate::{STUDY, full, loose_triangles, options, plan};

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
#[expect(clippy::print_stderr, reason = "it says what it counted")]
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
