//! Reprojection: what is seen is found where it was, and what was not seen is not.
#![allow(
    clippy::float_cmp_const,
    reason = "a colour is that colour to the bit, or a mixture"
)]

use foveasim_assets::{Material, ParametricSurface, Scene, Similarity, tessellate};
use foveasim_models::{Image, Map, Pose, SamplePlan, View};
use foveasim_render::{Clamp, Sequence, TemporalOptions, render};
use glam::{DQuat, DVec2, DVec3, UVec2};

use crate::common::{self, layers, view};
use crate::{UNCLAMPED, checkered, full, options, placed, scene, square};

/// Bilinear between sample centres; `None` if a sample is missing.
fn bilinear(image: &Image, px: DVec2) -> Option<[f64; 3]> {
    let p = px - 0.5;
    let low = p.floor();
    let f = p - low;
    if low.min_element() < 0.0 || (low + 1.0).cmpge(image.size.as_dvec2()).any() {
        return None;
    }
    let at = |dx, dy| {
        image
            .at(low.x as u32 + dx, low.y as u32 + dy)
            .map(f64::from)
    };
    let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
    Some(std::array::from_fn(|i| {
        (1.0 - f.y) * ((1.0 - f.x) * a[i] + f.x * b[i]) + f.y * ((1.0 - f.x) * c[i] + f.x * d[i])
    }))
}

/// Two frames of a checkered square that fills the view: each sample of the second must be the mean
/// of itself and of the first image where `before` says that its point was.
fn assert_found(
    eyes: [Pose; 2],
    placements: [Similarity; 2],
    plans: impl Fn(&View) -> [SamplePlan; 2],
) {
    let views = eyes.map(|eye| view(120, 80, eye));
    let scenes = placements.map(|p| scene(square(), &[(checkered(), p)], [0.0; 3]));
    let plans = plans(&views[0]);
    let mut sequence = Sequence::new(UNCLAMPED);
    let frames = [0, 1].map(|k| {
        let frame = sequence.draw(&scenes[k], &views[k], &plans[k], k as u64, &options());
        frame.unwrap()
    });
    let fresh = render(&scenes[1], &views[1], &plans[1], &options()).unwrap();
    let maps = [0, 1].map(|k| {
        let Map::Affine(map) = plans[k].passes[0].map else {
            unreachable!("the plan is affine")
        };
        map
    });
    let (new, old) = (&fresh.passes[0], &frames[0].passes[0]);
    let (mut compared, mut moved): (u32, f64) = (0, 0.0);
    for y in 0..new.size.y {
        for x in 0..new.size.x {
            let lattice = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let display = maps[1].display_from_lattice(lattice);
            let ray = views[1].poses[0].direction(views[1].optics.direction(display));
            // Where the ray meets the square's plane, on the square and back out of it.
            let plane = placements[1];
            let normal = plane.pose.direction(DVec3::Z);
            let eye = views[1].poses[0].position;
            let t = (plane.pose.position - eye).dot(normal) / ray.dot(normal);
            let on_square = plane.pose.inverse().point(eye + t * ray) / plane.scale;
            let before = placements[0].point(on_square);
            let seen = views[0].poses[0].inverse().point(before);
            let Some(px) = views[0].optics.project(seen) else {
                continue;
            };
            let place = maps[0].lattice_from_display(px);
            let Some(history) = bilinear(old, place) else {
                continue;
            };
            moved = moved.max(place.distance(lattice));
            compared += 1;
            for (c, history) in history.into_iter().enumerate() {
                let found = f64::from(frames[1].passes[0].at(x, y)[c]);
                let expected = 0.5 * (f64::from(new.at(x, y)[c]) + history);
                // A place is known to about 1e-4 of a sample in single precision, and two samples
                // differ by less than 1.
                assert!(
                    (found - expected).abs() < 1e-3,
                    "({x}, {y}): {found} {expected}"
                );
            }
        }
    }
    assert!(moved > 2.0, "nothing moved");
    assert!(
        compared > new.size.x * new.size.y / 2,
        "{compared} compared"
    );
    let work = &frames[1].work;
    assert_eq!(work.samples_reprojected, u64::from(new.size.x * new.size.y));
    // Only what lay outside the first image was not found.
    assert!(work.history_rejected <= work.samples_reprojected - u64::from(compared));
    assert_eq!((work.history_clamped, work.samples_in_place), (0, 0));
}

#[test]
fn what_is_seen_is_found_where_it_was() {
    let both = |view: &View| [full(view), full(view)];
    let still = placed(DVec3::new(0.0, 0.0, -2.0), DQuat::from_rotation_y(0.2), 2.5);
    let eye = |x: f64, turn: f64| {
        let position = DVec3::new(x, -0.5 * x, 0.3 * x);
        Pose::new(
            position,
            DQuat::from_rotation_y(turn) * DQuat::from_rotation_x(0.4 * turn),
        )
    };
    // The eye moves; it turns; both.
    assert_found([eye(0.0, 0.0), eye(0.2, 0.0)], [still; 2], both);
    assert_found([eye(0.0, 0.1), eye(0.0, 0.02)], [still; 2], both);
    assert_found([eye(-0.1, 0.1), eye(0.2, 0.05)], [still; 2], both);
    // The square moves, turns and grows; then the eye does, too.
    let turned = DQuat::from_rotation_z(0.1) * DQuat::from_rotation_y(0.15);
    let moved = placed(DVec3::new(0.1, -0.07, -1.8), turned, 2.7);
    assert_found([eye(0.0, 0.0); 2], [still, moved], both);
    assert_found([eye(0.0, 0.0), eye(0.15, 0.05)], [moved, still], both);
    // The gaze moves, and the lattice with it.
    let gaze = |view: &View| {
        [DVec2::new(40.0, 30.0), DVec2::new(51.5, 38.0)].map(|origin| {
            let mut plan = layers(view, DVec2::new(50.0, 40.0), &[(1.3, 30.0), (2.0, 0.0)]);
            plan.passes.truncate(2);
            plan.passes[0] = common::pass(origin, 1.3, UVec2::new(40, 30));
            plan
        })
    };
    let mut sequence = Sequence::new(UNCLAMPED);
    let view = view(120, 80, eye(0.0, 0.0));
    let scene = scene(square(), &[(checkered(), still)], [0.0; 3]);
    let plans = gaze(&view);
    // What the inner layer hides in one frame would have no history in the next.
    let mut options = options();
    options.skip.hidden = false;
    let frames = [0, 1].map(|k| {
        let frame = sequence.draw(&scene, &view, &plans[k], k as u64, &options);
        frame.unwrap()
    });
    let fresh = render(&scene, &view, &plans[1], &options).unwrap();
    let shift = DVec2::new(11.5, 8.0) / 1.3;
    let mut compared = 0;
    for y in 0..30 {
        for x in 0..40 {
            let place = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) + shift;
            let Some(history) = bilinear(&frames[0].passes[0], place) else {
                continue;
            };
            compared += 1;
            for (c, history) in history.into_iter().enumerate() {
                let expected = 0.5 * (f64::from(fresh.passes[0].at(x, y)[c]) + history);
                let found = f64::from(frames[1].passes[0].at(x, y)[c]);
                assert!((found - expected).abs() < 1e-4, "({x}, {y})");
            }
        }
    }
    assert!(compared > 600);
    // The outer pass stayed where it was.
    let count = plans[1].count();
    assert_eq!(frames[1].work.samples_in_place, count.passes[1].samples);
    assert_eq!(frames[1].work.samples_reprojected, count.passes[0].samples);
}

const WALL: [f32; 3] = [0.21, 0.43, 0.65];
const BALL: [f32; 3] = [0.9, 0.1, 0.05];

/// A ball before a wall of one colour that fills the view.
fn ball_at(x: f64) -> Scene {
    let wall = placed(DVec3::new(0.0, 0.0, -6.0), DQuat::from_rotation_y(0.3), 1.0);
    let mut parts = scene(
        tessellate(ParametricSurface::Sphere, 24, 16),
        &[
            (
                Material::Unlit(BALL),
                placed(DVec3::new(x, 0.1, -3.0), DQuat::IDENTITY, 0.4),
            ),
            (Material::Unlit(WALL), Similarity { scale: 9.0, ..wall }),
        ],
        WALL,
    );
    let mut instances = parts.instances().to_vec();
    instances[1].mesh = 1;
    parts = Scene::new(
        vec![parts.meshes()[0].clone(), square()],
        instances,
        parts.materials().to_vec(),
        parts.sky().clone(),
        *parts.sun(),
    )
    .unwrap();
    parts
}

#[test]
fn what_comes_into_sight_shows_no_ghost() {
    let view = view(120, 80, Pose::IDENTITY);
    let fresh = |x: f64| {
        let plan = full(&view);
        render(&ball_at(x), &view, &plan, &options()).unwrap().image
    };
    let run = |clamp: Clamp| {
        let mut sequence = Sequence::new(TemporalOptions { clamp, ..UNCLAMPED });
        let mut frames = Vec::new();
        for (frame, x) in [-0.9, -0.9, 0.4].into_iter().enumerate() {
            let plan = full(&view);
            let frame = sequence.draw(&ball_at(x), &view, &plan, frame as u64, &options());
            frames.push(frame.unwrap());
        }
        frames.pop().unwrap()
    };
    let (before, now) = (fresh(-0.9), fresh(0.4));
    let uncovered = before.rgb.iter().zip(&now.rgb);
    let uncovered = uncovered
        .filter(|(b, n)| **b == BALL && **n == WALL)
        .count();
    assert!(uncovered > 300, "{uncovered} samples came into sight");

    let clamped = run(Clamp::Neighbourhood);
    // The ball's own outline is blended with what it was before; nothing else may show a trace.
    for y in 1..79 {
        for x in 1..119 {
            if !is_mixed(&now, x, y) {
                assert_eq!(clamped.image.at(x, y), now.at(x, y), "({x}, {y})");
            }
        }
    }
    assert!(clamped.work.history_rejected >= uncovered as u64 / 2);

    // Without the clamp the test alone must do: what is left lies on the old outline, where the
    // history showed both, or beside the new one, which took its blended samples along.
    let unclamped = run(Clamp::Off);
    let (mut outline, mut ghosts) = (0, 0);
    for y in 1..79 {
        for x in 1..119 {
            let on_outline = is_mixed(&before, x, y);
            outline += u32::from(on_outline);
            let ghost = now.at(x, y) == WALL && unclamped.image.at(x, y) != WALL;
            if ghost && !is_mixed(&now, x, y) {
                ghosts += 1;
                assert!(on_outline, "ghost at ({x}, {y})");
            }
        }
    }
    assert!(ghosts <= outline);
}

/// Whether the 3×3 samples about one show both ball and wall.
fn is_mixed(image: &Image, x: u32, y: u32) -> bool {
    let mut around = (0..9).map(|k| image.at(x + k % 3 - 1, y + k / 3 - 1));
    let first = image.at(x, y);
    around.any(|c| c != first)
}

#[test]
fn an_outline_that_moves_slowly_leaves_no_trail() {
    // Half a sample to the right in each frame: what comes into sight was next to the outline before.
    let view = view(120, 80, Pose::IDENTITY);
    let step = 0.5 * 3.0 * view.optics.pixel_tan().x;
    for clamp in [Clamp::Neighbourhood, Clamp::Off] {
        let mut sequence = Sequence::new(TemporalOptions {
            clamp,
            ..TemporalOptions::default()
        });
        let draw = |k: u32| {
            let ball = ball_at(-0.5 + f64::from(k) * step);
            let plan = full(&view);
            let frame = sequence.draw(&ball, &view, &plan, u64::from(k), &options());
            frame.unwrap().image
        };
        let last = (0..24).map(draw).last().unwrap();
        let now = render(
            &ball_at(-0.5 + 23.0 * step),
            &view,
            &full(&view),
            &options(),
        );
        let now = now.unwrap().image;
        let mut trail = 0.0f32;
        for y in 3..77 {
            for x in 3..117 {
                let near = (0..49).any(|k| now.at(x + k % 7 - 3, y + k / 7 - 3) == BALL);
                if !near {
                    for (shown, wall) in last.at(x, y).into_iter().zip(WALL) {
                        trail = trail.max((shown - wall).abs());
                    }
                }
            }
        }
        // The clamp takes away what remains of the outer samples that Catmull-Rom weighs, each by at most
        // 0.074; without it, that is a part of 0.7, the greatest difference between ball and wall.
        let most = match clamp {
            Clamp::Neighbourhood => 0.0,
            _ => 0.74 * 0.7 / 10.0,
        };
        assert!(trail <= most, "{clamp:?}: {trail}");
    }
}

#[test]
fn motion_of_an_object_is_followed() {
    // The wall is checkered and turns with the ball's motion: only instances that moved take a warp of
    // their own, and a ball that moves by whole samples finds its own colours again.
    let view = view(120, 80, Pose::IDENTITY);
    let mut sequence = Sequence::new(UNCLAMPED);
    let draw = |sequence: &mut Sequence, x: f64, frame| {
        let plan = full(&view);
        sequence
            .draw(&ball_at(x), &view, &plan, frame, &options())
            .unwrap()
    };
    let first = draw(&mut sequence, -0.3, 0);
    assert_eq!(first.work.samples_reprojected, 0);
    let frame = draw(&mut sequence, 0.0, 1);
    let ball = frame.image.rgb.iter().filter(|c| **c == BALL).count();
    let drawn = render(&ball_at(0.0), &view, &full(&view), &options()).unwrap();
    let all = drawn.image.rgb.iter().filter(|c| **c == BALL).count();
    // All but the outline, where the earlier samples lay differently.
    assert!(ball > all * 9 / 10, "{ball} of {all}");
    // Rejected is about what the ball uncovered, not the ball itself.
    let uncovered = first.image.rgb.iter().zip(&drawn.image.rgb);
    let uncovered = uncovered
        .filter(|(b, n)| **b == BALL && **n == WALL)
        .count() as u64;
    assert!(frame.work.history_rejected <= uncovered + 60, "{uncovered}");
    // At rest again, everything stays in its place.
    let rest = draw(&mut sequence, 0.0, 2);
    assert_eq!(rest.work.samples_in_place, 120 * 80);
    assert_eq!(rest.work.samples_reprojected, 0);
}
