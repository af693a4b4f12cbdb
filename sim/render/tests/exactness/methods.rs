//! What all methods have in common, bit for bit.

use std::num::NonZeroU32;

use foveasim_assets::{
    Instance, Material, ParametricSurface, Scene, Similarity, Sky, study_camera, tessellate,
};
use foveasim_models::{Cadence, Msaa, Pose, SamplePlan, View};
use foveasim_render::{
    Clamp, Frame, Interpolation, RenderOptions, Sequence, Simd, Skip, TemporalOptions, jitter,
    render, visibility_at,
};
use glam::{DQuat, DVec2, DVec3};

use crate::common::{study_view, sun, view};
use crate::{METHODS, STUDY, bits, options, plan, varied};

const ALL_ON: TemporalOptions = TemporalOptions {
    jitter: true,
    reproject: true,
    staggered: true,
    blend: 0.8,
    clamp: Clamp::Neighbourhood,
    interpolation: Interpolation::CatmullRom,
    footprint: 0.5,
};

/// Nothing else is skipped.
const BACK_FACES_ALONE: Skip = Skip {
    back_faces: true,
    ..Skip::NONE
};

/// The plan with its outer passes on alternate frames.
fn staggered(mut plan: SamplePlan) -> SamplePlan {
    for (phase, pass) in plan.passes.iter_mut().skip(1).enumerate() {
        pass.cadence = Cadence {
            every: NonZeroU32::new(2).unwrap(),
            phase: phase as u32 % 2,
        };
    }
    plan
}

/// Balls and tori of one colour before a sky of the same, at places that move with `t`.
fn one_colour(colour: [f32; 3], t: f64) -> Scene {
    let meshes = vec![
        tessellate(ParametricSurface::Sphere, 24, 16),
        tessellate(ParametricSurface::Torus { tube: 0.4 }, 24, 16),
    ];
    let instances = (0..12u32).map(|k| {
        let at = DVec3::new(f64::from(k % 4) - 1.5 + t, f64::from(k / 4) - 1.0, -3.0);
        Instance {
            mesh: k as usize % 2,
            lod: None,
            material: 0,
            world_from_object: Similarity {
                pose: Pose::new(at, DQuat::from_rotation_y(t * f64::from(k))),
                scale: 0.4,
            },
            two_sided: k == 3,
        }
    });
    let materials = vec![Material::Unlit(colour)];
    Scene::new(
        meshes,
        instances.collect(),
        materials,
        Sky::Uniform(colour),
        sun(),
    )
    .unwrap()
}

#[test]
fn one_colour_everywhere_stays_that_colour_to_the_bit() {
    // None of them is a sum of few powers of two.
    let colour = [0.3, 0.123_456_7, 0.9];
    for method in METHODS {
        for msaa in [Msaa::One, Msaa::Four] {
            for offset in [DVec2::ZERO, jitter(3), DVec2::new(-0.5, 0.5)] {
                let view = view(157, 91, Pose::IDENTITY);
                let plan = varied(plan(method, &view), msaa, offset);
                let frame = render(&one_colour(colour, 0.0), &view, &plan, &options()).unwrap();
                assert!(frame.work.samples_shaded > 0 && frame.work.samples_sky > 0);
                let same = frame.image.rgb.iter().all(|c| *c == colour);
                assert!(same, "{method} {msaa:?} {offset}");
            }
        }
        let mut sequence = Sequence::new(ALL_ON);
        for k in 0..5 {
            let t = 0.03 * k as f64;
            let view = view(157, 91, Pose::new(DVec3::X * t, DQuat::from_rotation_y(t)));
            let plan = staggered(varied(plan(method, &view), Msaa::Four, DVec2::ZERO));
            let frame = sequence.draw(&one_colour(colour, t), &view, &plan, k, &options());
            let frame = frame.unwrap();
            assert_eq!(frame.work.samples_reprojected > 0, k > 0, "{method}");
            let same = frame.image.rgb.iter().all(|c| *c == colour);
            assert!(same, "{method}, frame {k} of a sequence");
        }
    }
}

#[test]
fn shading_rates_of_one_are_the_full_image() {
    let view = study_view(222, 125);
    for msaa in [Msaa::One, Msaa::Four] {
        for offset in [DVec2::ZERO, jitter(5)] {
            let draw = |method: &str| {
                let plan = varied(plan(method, &view), msaa, offset);
                render(&STUDY, &view, &plan, &options()).unwrap()
            };
            let full = draw("full");
            for tile in [8, 16, 32] {
                let coarse = draw(&format!("vrs:tile={tile}:max=1"));
                assert!(bits(&coarse.image) == bits(&full.image), "{tile} {msaa:?}");
                assert_eq!(coarse.work.samples_shaded, full.work.samples_shaded);
            }
            // And coarser ones are another image: the test above would else say nothing.
            assert!(bits(&draw("vrs").image) != bits(&full.image));
        }
    }
}

/// Three frames of a sequence by `method`, with everything on.
fn sequence(method: &str, options: &RenderOptions) -> Vec<Frame> {
    let mut sequence = Sequence::new(ALL_ON);
    (0..3)
        .map(|k| {
            let view = view(99, 57, study_camera(0.3 + 3e-4 * k as f64, 1));
            let plan = staggered(varied(plan(method, &view), Msaa::Four, DVec2::ZERO));
            sequence.draw(&STUDY, &view, &plan, k, options).unwrap()
        })
        .collect()
}

#[test]
fn threads_and_instructions_do_not_matter_to_any_method() {
    let pool = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
    };
    let pools = [1, 2, 7].map(pool);
    let scalar = RenderOptions {
        simd: Simd::Scalar,
        ..options()
    };
    for method in METHODS {
        let one = pools[0].install(|| sequence(method, &options()));
        assert!(one[2].work.samples_with_edge > 0);
        let others = [(1, options()), (2, options()), (0, scalar)];
        for (pool, options) in others {
            let other = pools[pool].install(|| sequence(method, &options));
            for (k, (a, b)) in one.iter().zip(&other).enumerate() {
                let what = format!("{method}, frame {k}, pool {pool}, {:?}", options.simd);
                assert!(bits(&a.image) == bits(&b.image), "{what}");
                assert_eq!(a.work, b.work, "{what}");
            }
        }
    }
}

/// Every part of [`Skip`] by itself, but back faces: they are what outlines may show.
#[test]
fn what_is_skipped_is_not_missed() {
    let none = BACK_FACES_ALONE;
    let alone = [
        (
            "outside",
            Skip {
                outside: true,
                ..none
            },
        ),
        (
            "occluded",
            Skip {
                occluded: true,
                ..none
            },
        ),
        (
            "hidden",
            Skip {
                hidden: true,
                ..none
            },
        ),
        (
            "repeated",
            Skip {
                repeated_vertices: true,
                ..none
            },
        ),
        (
            "whole",
            Skip {
                whole_samples: true,
                ..none
            },
        ),
        ("all", Skip::ALL),
    ];
    let view = study_view(180, 101);
    for method in METHODS {
        let plan = varied(plan(method, &view), Msaa::Four, jitter(2));
        let draw = |skip| {
            let options = RenderOptions { skip, ..options() };
            render(&STUDY, &view, &plan, &options).unwrap()
        };
        let whole = draw(BACK_FACES_ALONE);
        for (name, skip) in alone {
            let frame = draw(skip);
            let other = bits(&frame.image)
                .iter()
                .zip(&bits(&whole.image))
                .filter(|(a, b)| a != b)
                .count();
            assert_eq!(other, 0, "{method} without {name}");
        }
    }
}

/// The sequence passes an option on, and changes what is hidden.
#[test]
fn what_is_skipped_is_not_missed_in_sequences() {
    for method in ["layers:3", "fdm:tile=8", "quad"] {
        let skip = |skip| sequence(method, &RenderOptions { skip, ..options() });
        let (all, none) = (skip(Skip::ALL), skip(BACK_FACES_ALONE));
        for (k, (a, b)) in all.iter().zip(&none).enumerate() {
            assert!(bits(&a.image) == bits(&b.image), "{method}, frame {k}");
        }
    }
}

/// Closed surfaces hide their own backs, except on their outlines, where snapping decides which of two
/// neighbours is nearer: it moves each by up to √2/512 of a sample, so that of a thousand samples along an
/// outline some five are that close to it.
#[test]
fn backs_of_closed_surfaces_show_on_outlines_only() {
    let (mut samples, mut outlines, mut other) = (0, 0, 0);
    for (t, scene) in [
        (0.0, one_colour([1.0; 3], 0.1)),
        (1.0, one_colour([1.0; 3], 0.4)),
    ] {
        let view = view(320, 200, Pose::new(DVec3::Z * t, DQuat::IDENTITY));
        let plan = varied(plan("full", &view), Msaa::Four, DVec2::ZERO);
        for position in 0..4 {
            let see = |skip| {
                let options = RenderOptions { skip, ..options() };
                visibility_at(&scene, &view, &plan, 0, position, &options).unwrap()
            };
            let (without, with) = (see(BACK_FACES_ALONE), see(Skip::NONE));
            let instance = |k: usize| without[k].map(|s| s.instance);
            for (k, (a, b)) in without.iter().zip(&with).enumerate().skip(1) {
                samples += 1;
                outlines += usize::from(instance(k) != instance(k - 1));
                if a != b {
                    other += 1;
                    // A hole would let something else be seen.
                    assert_eq!(instance(k), b.map(|s| s.instance), "sample {k}");
                    let depth = [a, b].map(|s| s.map_or(0.0, |s| f64::from(s.depth_m)));
                    assert!((depth[0] / depth[1] - 1.0).abs() < 0.02, "{a:?} {b:?}");
                }
            }
        }
    }
    assert!(
        samples > 500_000 && outlines > 5000,
        "{outlines} of {samples}"
    );
    assert!(other * 100 < outlines, "{other} along {outlines}");
}

/// No seam and no hole: nothing is black, and nothing is brighter or darker than what it is put
/// together of.
#[test]
fn every_pixel_is_a_mixture_of_what_was_drawn() {
    let view: View = study_view(320, 180);
    for method in METHODS {
        for msaa in [Msaa::One, Msaa::Four] {
            let options = RenderOptions {
                keep_passes: true,
                ..options()
            };
            let plan = varied(plan(method, &view), msaa, DVec2::ZERO);
            let frame = render(&STUDY, &view, &plan, &options).unwrap();
            for c in 0..3 {
                let drawn = frame.passes.iter().flat_map(|p| &p.rgb).map(|rgb| rgb[c]);
                // What is dead or hidden stays zero in the passes; nothing that is drawn is.
                let drawn: Vec<f32> = drawn.filter(|v| *v > 0.0).collect();
                let low = drawn.iter().copied().fold(f32::MAX, f32::min);
                let high = drawn.iter().copied().fold(0.0, f32::max);
                for rgb in &frame.image.rgb {
                    // Blending rounds thrice for each of two steps: 2⁻²⁴ each.
                    let v = rgb[c];
                    assert!(
                        v >= low * (1.0 - 1e-6) && v <= high * (1.0 + 1e-6),
                        "{method}"
                    );
                }
            }
        }
    }
}
