//! Shadows, light from an image of the sky, and ambient occlusion.

use foveasim_assets::{
    GeneratedScene, Instance, Material, Mesh, Pattern, Scene, Similarity, Sky, Sun, Surface,
    Vertex, look_at,
};
use foveasim_models::{
    Eye, Filter, Image, Interpolation, Lattice, LogPolar, Map, Region, Resolve, SamplePlan, View,
    Viewport,
};
use foveasim_render::{Focus, Lighting, Occlusion, RenderOptions, Shadows, Simd, render};
use glam::{DVec3, UVec2};

const ALBEDO: f32 = 0.5;
const AMBIENT: f32 = 0.25;

/// Squares of the given corners, of one grey, under a sun in direction `sun`.
fn squares(corners: &[[DVec3; 4]], sun: DVec3) -> Scene {
    let mesh = |c: &[DVec3; 4]| {
        let normal = (c[1] - c[0]).cross(c[3] - c[0]);
        let vertex = |position: &DVec3| Vertex {
            position: *position,
            normal,
            uv: [0.0; 2],
        };
        let vertices: Vec<Vertex> = c.iter().map(vertex).collect();
        Mesh::new(&vertices, vec![[0, 1, 2], [0, 2, 3]]).unwrap()
    };
    let instance = |mesh| Instance {
        mesh,
        lod: None,
        material: 0,
        world_from_object: Similarity::IDENTITY,
        two_sided: true,
    };
    let grey = Surface {
        albedo: [[ALBEDO; 3]; 2],
        pattern: Pattern::Plain,
        frequency: 1.0,
        roughness: 1.0,
        f0: 0.0,
        environment: 0.0,
        seed: 0,
    };
    Scene::new(
        corners.iter().map(mesh).collect(),
        (0..corners.len()).map(instance).collect(),
        vec![Material::Surface(grey)],
        Sky::Uniform([AMBIENT; 3]),
        Sun {
            direction: sun,
            radiance: [1.0; 3],
        },
    )
    .unwrap()
}

/// A square of half side `half` about `centre`, looking up.
fn level(centre: DVec3, half: f64) -> [DVec3; 4] {
    [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]]
        .map(|[x, z]| centre + DVec3::new(x * half, 0.0, z * half))
}

/// From 4 m above, looking down: 100 pixels to the metre on the floor.
fn from_above() -> View {
    let optics = Viewport::symmetric(UVec2::new(200, 200), 0.25).unwrap();
    let eye = look_at(DVec3::Y * 4.0, DVec3::ZERO).unwrap();
    View::still(Eye::Cyclopean, optics, eye)
}

fn draw(scene: &Scene, view: &View, lighting: Lighting) -> Image {
    let plan = SamplePlan::full(view.eye, view.optics.size);
    let options = RenderOptions {
        lighting,
        ..RenderOptions::default()
    };
    render(scene, view, &plan, &options).unwrap().image
}

#[test]
fn what_stands_before_the_sun_casts_a_shadow() {
    // A square of 40 cm, 1 m above the floor, out of sight to the left; the sun stands at 45° there.
    let floor = level(DVec3::ZERO, 3.0);
    let above = level(DVec3::new(-1.0, 1.0, 0.0), 0.2);
    let scene = squares(&[floor, above], DVec3::new(-1.0, 1.0, 0.0));
    let view = from_above();
    let plain = draw(&scene, &view, Lighting::default());
    for focus in [
        None,
        Some(Focus {
            centre: DVec3::ZERO,
            radius_m: 1.0,
        }),
    ] {
        let shadows = Some(Shadows { size: 1024, focus });
        let lit = draw(
            &scene,
            &view,
            Lighting {
                shadows,
                ..Lighting::default()
            },
        );
        // In shadow, there is the sky's light alone.
        let dark = ALBEDO * AMBIENT;
        let texel_px = if focus.is_some() { 0.5 } else { 2.0 };
        let mut wrong = 0;
        for (k, (a, b)) in lit.rgb.iter().zip(&plain.rgb).enumerate() {
            let x = ((k % 200) as f64 + 0.5 - 100.0) / 100.0;
            let z = ((k / 200) as f64 + 0.5 - 100.0) / 100.0;
            let inside = 0.2 - x.abs().max(z.abs());
            // Within the lift, and a texel, of the edge it may be either.
            if inside.abs() < 0.01 * (1.0 + 2.0 * texel_px) {
                continue;
            }
            let want = if inside > 0.0 { dark } else { b[0] };
            wrong += u32::from((a[0] - want).abs() > 1e-5);
        }
        assert_eq!(wrong, 0, "{focus:?}");
    }
}

#[test]
fn an_even_sky_sheds_an_even_light() {
    let scene = squares(&[level(DVec3::ZERO, 3.0)], DVec3::new(0.3, 1.0, 0.2));
    let view = from_above();
    let image_based = Lighting {
        image_based: true,
        ..Lighting::default()
    };
    let (plain, lit) = (
        draw(&scene, &view, Lighting::default()),
        draw(&scene, &view, image_based),
    );
    for (a, b) in plain.rgb.iter().zip(&lit.rgb) {
        assert!((a[0] - b[0]).abs() < 1e-6);
    }
    // And another sky another one.
    let scene = GeneratedScene::Machine { rpm: 0.0 }.build(1);
    let optics = Viewport::symmetric(UVec2::new(64, 48), 0.6).unwrap();
    let eye = GeneratedScene::Machine { rpm: 0.0 }.camera(0.0, 1);
    let view = View::still(Eye::Cyclopean, optics, eye);
    assert_ne!(
        draw(&scene, &view, Lighting::default()),
        draw(&scene, &view, image_based)
    );
}

#[test]
fn corners_are_dark_and_planes_are_not() {
    let floor = level(DVec3::ZERO, 3.0);
    let wall = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
        .map(|[z, y]| DVec3::new(0.3 + 1.5 * y, 1.5 * y, 6.0 * z - 3.0));
    let sun = DVec3::new(-0.2, 1.0, 0.0);
    let (view, radius_m) = (from_above(), 0.2);
    let occlusion = Lighting {
        occlusion: Some(Occlusion { radius_m }),
        ..Lighting::default()
    };
    let open = squares(&[floor], sun);
    assert_eq!(
        draw(&open, &view, occlusion),
        draw(&open, &view, Lighting::default())
    );
    let corner = squares(&[floor, wall], sun);
    let plain = draw(&corner, &view, Lighting::default());
    let dark = draw(&corner, &view, occlusion);
    let ratio = |x: usize| dark.rgb[100 * 200 + x][0] / plain.rgb[100 * 200 + x][0];
    // The wall rises 30 px to the right of the middle, at 45°; 20 px are the radius.
    assert_eq!(ratio(60), 1.0);
    assert!(
        ratio(126) < ratio(118) && ratio(118) < 1.0,
        "{} {}",
        ratio(126),
        ratio(118)
    );
    assert!(ratio(126) > 0.2);
}

/// With everything on, bent lattices, threads and instructions do not matter; nor do counters lie.
#[test]
fn light_is_the_same_for_any_threads_and_lanes() {
    let generated = GeneratedScene::Machine { rpm: 600.0 };
    let scene = generated.build(1);
    let display = UVec2::new(96, 64);
    let optics = Viewport::symmetric(display, 0.6).unwrap();
    let view = View::still(Eye::Cyclopean, optics, generated.camera(0.0, 1));
    let full = SamplePlan::full(view.eye, display);
    let mut bent = full.clone();
    let lattice = UVec2::new(60, 50);
    let centre = display.as_dvec2() / 2.0;
    let map = Map::LogPolar(LogPolar::new(centre, display, 0.6, lattice.as_dvec2()).unwrap());
    bent.passes[0].lattice = Lattice::Grid(lattice);
    bent.passes[0].map = map;
    bent.passes[0].region = Region::on_display(&map, lattice, display);
    bent.resolve = Resolve::Inverse(Filter {
        interpolation: Interpolation::Bilinear,
        smooth_from: None,
        mips: false,
    });
    let lighting = Lighting {
        shadows: Some(Shadows {
            size: 256,
            focus: None,
        }),
        ..Lighting::all()
    };
    for plan in [full, bent] {
        let draw = |threads: usize, simd, lighting| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let options = RenderOptions {
                simd,
                lighting,
                ..RenderOptions::default()
            };
            let frame = pool
                .unwrap()
                .install(|| render(&scene, &view, &plan, &options));
            frame.unwrap()
        };
        let one = draw(1, Simd::Auto, lighting);
        assert!(one == draw(3, Simd::Scalar, lighting));
        let plain = draw(2, Simd::Auto, Lighting::default());
        assert!(one.image != plain.image);
        assert_eq!(one.work.shadow_texels, 256 * 256);
        assert_eq!(one.work.shadow_triangles, scene.triangle_count());
        assert!(one.work.occlusion_reads > 0);
        let none = [
            plain.work.shadow_texels,
            plain.work.shadow_triangles,
            plain.work.occlusion_reads,
        ];
        assert_eq!(none, [0; 3]);
    }
}

#[test]
fn lights_that_cannot_be_are_refused() {
    let scene = squares(&[level(DVec3::ZERO, 1.0)], DVec3::Y);
    let view = from_above();
    let plan = SamplePlan::full(view.eye, view.optics.size);
    let refused = |lighting| {
        let options = RenderOptions {
            lighting,
            ..RenderOptions::default()
        };
        render(&scene, &view, &plan, &options)
            .unwrap_err()
            .to_string()
    };
    let occlusion = Some(Occlusion { radius_m: f64::NAN });
    let lighting = Lighting {
        occlusion,
        ..Lighting::default()
    };
    assert!(refused(lighting).contains("radius of occlusion = NaN"));
    let shadows = Some(Shadows {
        size: 1 << 20,
        focus: None,
    });
    let lighting = Lighting {
        shadows,
        ..Lighting::default()
    };
    assert!(refused(lighting).contains("from 16 to 8192"));
    let focus = Some(Focus {
        centre: DVec3::NAN,
        radius_m: 1.0,
    });
    let shadows = Some(Shadows { size: 64, focus });
    let lighting = Lighting {
        shadows,
        ..Lighting::default()
    };
    assert!(refused(lighting).contains("focus of shadows"));
}
