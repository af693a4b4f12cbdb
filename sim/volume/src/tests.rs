//! What the caster promises, on small volumes.

use foveasim_assets::{GeneratedVolume, TransferFunction, TransferPoint, Volume};
use foveasim_models::{Eye, Image, SamplePlan, View, Viewport};
use glam::{DAffine3, DVec2, DVec3, UVec2};

use crate::{CastError, CastOptions, Caster, Instructions, Light, Phong, Ray, Storage, orbit};

fn volume(kind: GeneratedVolume) -> Volume {
    // Not orthogonal, not equal: whatever a header may say.
    let turn = DAffine3::from_cols(
        DVec3::new(1.0, 0.2, 0.0),
        DVec3::new(-0.1, 0.8, 0.3),
        DVec3::new(0.0, -0.2, 1.3),
        DVec3::new(5.0, -3.0, 100.0),
    );
    let volume = kind.build(28, 2).unwrap();
    volume.placed(turn).unwrap()
}

fn view(volume: &Volume, azimuth: f64, times: f64) -> View {
    let optics = Viewport::symmetric(UVec2::new(42, 30), 0.4).unwrap();
    let eye = orbit(volume.bounds(), &optics, azimuth, 25.0, times).unwrap();
    View::still(Eye::Cyclopean, optics, eye)
}

fn bits(image: &Image) -> Vec<[u32; 3]> {
    image.rgb.iter().map(|p| p.map(f32::to_bits)).collect()
}

fn draw(volume: &Volume, view: &View, options: CastOptions) -> crate::VolumeFrame {
    let transfer = TransferFunction::of_volume(volume);
    let caster = Caster::new(volume, &transfer, &options).unwrap();
    caster.full(view).unwrap()
}

/// Skipping, storage, instructions and threads change no bit, from outside and inside, whatever the volume.
#[test]
fn what_is_left_out_changes_no_bit() {
    for kind in GeneratedVolume::ALL {
        let volume = volume(kind);
        for (azimuth, times, seed) in [(35.0, 1.0, None), (200.0, 0.1, Some(3))] {
            let view = view(&volume, azimuth, times);
            let own = CastOptions {
                jitter: seed,
                ..CastOptions::default()
            };
            let drawn = draw(&volume, &view, own);
            assert!(drawn.work.steps_seen > 500, "{kind}: {:?}", drawn.work);
            let others = [
                CastOptions {
                    skip_empty: false,
                    ..own
                },
                CastOptions {
                    storage: Storage::Values,
                    ..own
                },
                CastOptions {
                    instructions: Instructions::Scalar,
                    ..own
                },
                CastOptions {
                    storage: Storage::Values,
                    skip_empty: false,
                    instructions: Instructions::Scalar,
                    ..own
                },
            ];
            for options in others {
                let other = draw(&volume, &view, options);
                assert_eq!(bits(&drawn.image), bits(&other.image), "{kind} {options:?}");
                assert_eq!(drawn.work.steps_seen, other.work.steps_seen, "{kind}");
                let all = |w: crate::CastWork| w.steps + w.steps_skipped;
                if options.skip_empty {
                    assert_eq!(drawn.work, other.work, "{kind}");
                } else {
                    assert_eq!(all(drawn.work), all(other.work), "{kind}");
                }
            }
            let one = rayon::ThreadPoolBuilder::new()
                .num_threads(1)
                .build()
                .unwrap();
            let alone = one.install(|| draw(&volume, &view, own));
            assert_eq!(alone, drawn);
        }
    }
}

/// A ray that ends early is off by less than its threshold in every channel, whatever is behind.
#[test]
fn ended_rays_are_within_their_threshold() {
    for kind in [
        GeneratedVolume::Porous,
        GeneratedVolume::Shells,
        GeneratedVolume::Jet,
    ] {
        let volume = volume(kind);
        let view = view(&volume, 10.0, 0.7);
        for background in [[0.0; 3], [1.0; 3]] {
            let never = CastOptions {
                terminate: 0.0,
                background,
                ..CastOptions::default()
            };
            let whole = draw(&volume, &view, never);
            assert_eq!(whole.work.rays_ended_early, 0);
            let mut ended = 0;
            for terminate in [1.0 / 255.0, 0.1] {
                let early = draw(&volume, &view, CastOptions { terminate, ..never });
                ended += early.work.rays_ended_early;
                for (a, b) in early.image.rgb.iter().zip(&whole.image.rgb) {
                    let off = (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
                    assert!(off < terminate, "{kind}: {off} {terminate}");
                }
            }
            assert!(ended > 0, "{kind}");
        }
    }
}

/// A volume of one value against the closed form: opacity does not depend on the step.
#[test]
fn steps_of_any_length_hold_back_as_much() {
    let cube = GeneratedVolume::MarschnerLobb.build(33, 0).unwrap();
    // One colour whatever the value.
    let transfer = TransferFunction::new(vec![TransferPoint {
        value: 0.0,
        colour: [0.5, 0.25, 1.0],
        opacity: 0.05,
    }])
    .unwrap();
    let options = CastOptions {
        phong: None,
        terminate: 0.0,
        ..CastOptions::default()
    };
    let caster = Caster::new(&cube, &transfer, &options).unwrap();
    let optics = Viewport::symmetric(UVec2::splat(8), 0.01).unwrap();
    let eye = orbit(cube.bounds(), &optics, 0.0, 0.0, 1.0).unwrap();
    let view = View::still(Eye::Cyclopean, optics, eye);
    for step in [0.0625, 0.5, 1.0, 2.0, 3.7] {
        let mut seen = [[0.0; 4]];
        let ray = Ray {
            px: DVec2::splat(4.0),
            step,
        };
        let work = caster.cast(&view, |_| ray, &mut seen).unwrap();
        // 32 voxels along the axis, α = 0.05 each; the number of samples is off by one at most.
        let exact = |voxels: f64| 1.0 - 0.95f64.powf(voxels);
        let slack = f64::from(step) * 0.5;
        let alpha = f64::from(seen[0][3]);
        assert!(alpha > exact(32.0 - slack) - 1e-4 && alpha < exact(32.0 + slack) + 1e-4);
        let samples = 64.0 / f64::from(step);
        assert!(
            (work.steps as f64 - samples).abs() <= 1.0,
            "{step}: {work:?}"
        );
        assert!((seen[0][0] / seen[0][3] - 0.5).abs() < 1e-3);
    }
}

/// What rays see does not depend on who goes with them; rays off the screen are not cast; bad steps are
/// refused.
#[test]
fn rays_are_their_own() {
    let volume = volume(GeneratedVolume::Filaments);
    let view = view(&volume, 35.0, 0.8);
    let transfer = TransferFunction::of_volume(&volume);
    let caster = Caster::new(&volume, &transfer, &CastOptions::default()).unwrap();
    let ray = |i: usize| Ray {
        px: DVec2::new((i * 37 % 47) as f64, (i * 13 % 34) as f64),
        step: 1.0 + (i % 5) as f32 * 0.7,
    };
    let mut all = vec![[9.0; 4]; 1000];
    let work = caster.cast(&view, ray, &mut all).unwrap();
    let off = (0..1000)
        .filter(|i| ray(*i).px.x > 42.0 || ray(*i).px.y > 30.0)
        .count() as u64;
    assert!(off > 0);
    assert_eq!((work.rays_off_screen, work.rays), (off, 1000 - off));
    let mut back = vec![[9.0; 4]; 1000];
    let other = caster.cast(&view, |i| ray(999 - i), &mut back).unwrap();
    back.reverse();
    assert_eq!(all, back);
    assert_eq!(work.steps_seen, other.steps_seen);
    // Those of base steps among themselves, where the table has what others work out.
    let mut alike = vec![[9.0; 4]; 200];
    let other = caster.cast(&view, |i| ray(5 * i), &mut alike).unwrap();
    assert!(other.steps_seen > 100);
    assert!(alike.iter().zip(all.iter().step_by(5)).all(|(a, b)| a == b));
    for (i, seen) in all.iter().enumerate() {
        let px = ray(i).px;
        if px.x > 42.0 || px.y > 30.0 {
            assert_eq!(*seen, [0.0; 4]);
        }
    }
    for step in [0.0, -1.0, f32::NAN, 1e9] {
        let bad = |_| Ray {
            px: DVec2::splat(5.0),
            step,
        };
        let error = caster.cast(&view, bad, &mut [[0.0; 4]; 3]).unwrap_err();
        assert!(matches!(error, CastError::Step { ray: 0, .. }));
    }
}

/// A plan of every pixel is the full image; layers cast their own samples alone.
#[test]
fn any_plan_is_cast() {
    let volume = volume(GeneratedVolume::Vortices);
    let view = view(&volume, 35.0, 0.8);
    let transfer = TransferFunction::of_volume(&volume);
    let caster = Caster::new(&volume, &transfer, &CastOptions::default()).unwrap();
    let full = caster.full(&view).unwrap();
    let plan = SamplePlan::full(Eye::Cyclopean, view.optics.size);
    let passes = caster.passes(&view, &plan).unwrap();
    assert_eq!(passes, [full]);
    let mut wrong = plan.clone();
    wrong.display_px.x += 1;
    assert!(matches!(
        caster.passes(&view, &wrong),
        Err(CastError::OtherSize { .. })
    ));
}

/// Light from elsewhere: the side towards it is brighter.
#[test]
fn light_comes_from_where_it_is_said() {
    let volume = GeneratedVolume::Shells.build(40, 2).unwrap();
    let view = view(&volume, 0.0, 1.0);
    let lit = |x: f64| {
        let phong = Phong {
            light: Light::Towards(DVec3::new(x, 0.0, 0.2)),
            ..Phong::default()
        };
        let options = CastOptions {
            phong: Some(phong),
            ..CastOptions::default()
        };
        let image = draw(&volume, &view, options).image;
        let half = |left: bool| -> f32 {
            let pixels = image.rgb.iter().enumerate();
            pixels
                .filter(|(k, _)| (k % 42 < 21) == left)
                .map(|(_, p)| p[0])
                .sum()
        };
        half(true) - half(false)
    };
    assert!(
        lit(-1.0) > 2.0 && lit(1.0) < -2.0,
        "{} {}",
        lit(-1.0),
        lit(1.0)
    );
}

#[test]
fn bad_options_are_refused() {
    let volume = GeneratedVolume::Jet.build(8, 1).unwrap();
    let transfer = TransferFunction::of_volume(&volume);
    let own = CastOptions::default();
    let refused = |options: CastOptions| {
        let error = Caster::new(&volume, &transfer, &options).unwrap_err();
        error.to_string()
    };
    let step = |step_voxels| refused(CastOptions { step_voxels, ..own });
    assert!(step(0.0).contains("step_voxels = 0") && step(f64::NAN).contains("NaN"));
    assert!(
        refused(CastOptions {
            terminate: 1.0,
            ..own
        })
        .contains("terminate")
    );
    assert!(
        refused(CastOptions {
            background: [2.0; 3],
            ..own
        })
        .contains("background")
    );
    let phong = Some(Phong {
        shininess: 0,
        ..Phong::default()
    });
    assert!(refused(CastOptions { phong, ..own }).contains("shininess"));
    let long = DAffine3::from_scale(DVec3::new(1e-6, 1.0, 1.0));
    let thin = volume.clone().placed(long).unwrap();
    assert!(Caster::new(&thin, &transfer, &own).is_err());
}
