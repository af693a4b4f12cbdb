//! One property for every method that promises it: no two samples are farther apart than the eye, or
//! the display, can tell. And what a mosaic promises: every pixel has one sample.

use foveasim_models::foveation::{Aim, Method, Request};
use foveasim_models::math::to_deg;
use foveasim_models::{
    Acuity, Affine, Eye, GazeDirection, Lattice, Map, Pass, Region, Resolve, SamplePlan, Shading,
    Viewport,
};
use glam::{DVec2, DVec3, UVec2};
use proptest::prelude::*;

fn grid(pass: &Pass) -> (UVec2, Affine) {
    match (pass.lattice, pass.map) {
        (Lattice::Grid(size), Map::Affine(map)) => (size, map),
        other => panic!("not an affine grid: {other:?}"),
    }
}

/// The live sample of a pass whose cell holds display pixel position `px`.
fn holder(pass: &Pass, px: DVec2) -> Option<UVec2> {
    let (size, map) = grid(pass);
    let at = map.lattice_from_display(px).floor();
    if at.min_element() < 0.0 || !at.as_uvec2().cmplt(size).all() {
        return None;
    }
    let sample = at.as_uvec2();
    match &pass.region {
        Region::All => Some(sample),
        Region::Cells(mask) => mask.is_live(sample).then_some(sample),
        other => panic!("{other:?}"),
    }
}

/// Display pixels per evaluation of shading along each axis at pixel position `px`: of the coarsest pass
/// that shows there.
fn spacing(plan: &SamplePlan, viewport: &Viewport, px: DVec2) -> DVec2 {
    let of = |pass: &Pass, sample: UVec2| match &pass.shading {
        Shading::PerSample => grid(pass).1.scale,
        Shading::Coarse(rates) => {
            let rate = rates.rate(sample);
            grid(pass).1.scale * DVec2::new(f64::from(rate.x), f64::from(rate.y))
        }
        other => panic!("{other:?}"),
    };
    match &plan.resolve {
        Resolve::Direct | Resolve::Mosaic => {
            let mut found = plan
                .passes
                .iter()
                .filter_map(|p| holder(p, px).map(|s| of(p, s)));
            found.next().expect("every pixel has a sample")
        }
        Resolve::Feather(feather) => {
            let d = viewport.direction(px);
            let along = d.dot(feather.gaze);
            let tan = if along > 0.0 {
                d.cross(feather.gaze).length() / along
            } else {
                f64::INFINITY
            };
            // A pass mixes in from where the one inside it begins to fade.
            let last = feather
                .edges_tan
                .iter()
                .take_while(|[full, _]| tan > *full)
                .count();
            grid(&plan.passes[last]).1.scale
        }
        other => panic!("{other:?}"),
    }
}

/// How far display pixel position `px` turns the ray per pixel along x and along y, by central
/// differences \[deg\].
fn turn(viewport: &Viewport, px: DVec2) -> [DVec3; 2] {
    const H: f64 = 1e-3;
    [DVec2::X, DVec2::Y].map(|axis| {
        let at = |s: f64| viewport.direction(px + axis * s).normalize();
        (at(H) - at(-H)) / (2.0 * H) * to_deg(1.0)
    })
}

const METHODS: [&str; 13] = [
    "layers:3:strict",
    "layers:5:strict",
    "layers:2:strict:fixed=10",
    "vrs",
    "vrs:tile=8:max=2",
    "vrs:tile=32:fixed",
    "fdm",
    "fdm:tile=32:fixed=7",
    "rates",
    "rates:bands=7:fixed=25",
    "quad:auto",
    "quad:auto:peripheral=0.23",
    "quad:auto:fixed=12",
];

fn requests() -> impl Strategy<Value = Request> {
    let edge = || 0.05f64..2.0;
    let edges = (edge(), edge(), edge(), edge());
    let size = (1u32..2500, 1u32..2500);
    let gaze = (-70.0f64..70.0, -60.0f64..60.0);
    let margin = prop_oneof![Just(0.0), 0.0f64..10.0];
    let ahead = -15.0f64..15.0;
    (edges, size, gaze, 0.0f64..0.08, margin, ahead).prop_map(
        |((l, r, u, d), (w, h), (az, el), slope, margin_deg, cant)| Request {
            eye: Eye::Left,
            viewport: Viewport::new(UVec2::new(w, h), [-l, r, u, -d]).unwrap(),
            acuity: Acuity::new(slope).unwrap(),
            gaze: GazeDirection::new(az, el),
            ahead: GazeDirection::new(cant, 0.0),
            margin_deg,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_sample_is_farther_than_the_eye_can_tell(
        request in requests(), method in prop::sample::select(&METHODS[..]),
        picks in prop::collection::vec((0.0f64..1.0, 0.0f64..1.0), 80),
        (reach, near) in (0.0f64..1.0, prop::collection::vec((-9.0f64..9.0, -9.0f64..9.0), 40)),
    ) {
        let method: Method = method.parse().unwrap();
        let mut request = request;
        if let Aim::Fixed { reach_deg } = method.aim() {
            // The eye may look anywhere within reach of ahead.
            let towards = request.gaze;
            let all = request.ahead.angle_to_deg(towards);
            request.gaze = request.ahead.interpolate(towards, (reach * reach_deg / all).min(1.0));
            prop_assume!(request.ahead.angle_to_deg(request.gaze) <= reach_deg);
        }
        let plan = method.plan(&request).unwrap();
        let viewport = &request.viewport;
        let edge = viewport.size.as_dvec2();
        let gaze = request.gaze.vector();
        // Layers are scaled by ω* = atan 2p, which is that much below two pixels' angle.
        let p = viewport.pixel_tan().max_element();
        let tolerance = 1e-6 + if matches!(method, Method::Layers(_)) { 2.0 * p * p } else { 0.0 };
        let anywhere = picks.iter().map(|(x, y)| DVec2::new(*x, *y) * edge);
        let about = near.iter().filter_map(|(az, el)| {
            let d = GazeDirection::new(request.gaze.azimuth_deg + az, request.gaze.elevation_deg + el);
            let px = viewport.project(d.vector())?;
            (px.cmpge(DVec2::ZERO) & px.cmplt(edge)).all().then_some(px)
        });
        for px in anywhere.chain(about).map(|px| px.floor() + 0.5) {
            let step = spacing(&plan, viewport, px);
            let e = viewport.eccentricity_deg(px, gaze) - request.margin_deg;
            let need = request.acuity.mar_deg(e) / 2.0;
            let [x, y] = turn(viewport, px);
            let out = viewport.direction(px).normalize();
            let tangential = gaze.cross(out).normalize_or(DVec3::X);
            let radial = tangential.cross(out);
            for (step, turn) in [(step.x, x), (step.y, y)] {
                // The length of a step bounds its part along the radius and across it.
                let parts = [radial, tangential].map(|axis| (turn * step).dot(axis).abs());
                let widest = parts[0].hypot(parts[1]);
                prop_assert!(
                    step <= 1.0 + 1e-9 || widest <= need * (1.0 + tolerance),
                    "{} px at {} is {} deg of {} ({} deg from the gaze)", step, px, widest, need, e
                );
            }
        }
    }

    /// Live samples cut the display into whole pixels, each of one sample, whatever its size.
    #[test]
    fn mosaics_partition_the_display(
        request in requests(), size in (1u32..150, 1u32..150),
        method in prop::sample::select(&["fdm:tile=8", "fdm", "fdm:tile=32:fixed=3", "rates", "rates:bands=3"][..]),
    ) {
        let method: Method = method.parse().unwrap();
        let viewport = Viewport { size: size.into(), ..request.viewport };
        let request = Request { viewport, ..request };
        let plan = method.plan(&request).unwrap();
        let edge = viewport.size.as_dvec2();
        for pass in &plan.passes {
            // Every sample has a part of the display, so the grid ends less than one beyond it.
            let (size, map) = grid(pass);
            let beyond = map.covers(size).max - edge;
            prop_assert!((beyond - map.scale).max_element() < 0.0 && beyond.min_element() >= -1e-9);
        }
        let mut used = std::collections::BTreeSet::new();
        for y in 0..viewport.size.y {
            for x in 0..viewport.size.x {
                let px = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
                let mut holders = 0;
                for (i, pass) in plan.passes.iter().enumerate() {
                    if let Some(sample) = holder(pass, px) {
                        holders += 1;
                        used.insert((i, sample.to_array()));
                    }
                }
                prop_assert_eq!(holders, 1, "pixel {} {}", x, y);
            }
        }
        // A live sample that has no pixel's middle is the last of a row or column of ¾ samples a pixel.
        let last = |pass: &Pass| {
            let (size, map) = grid(pass);
            let thirds = map.scale.cmpgt(DVec2::ONE) & map.scale.cmplt(DVec2::splat(1.5));
            u64::from(thirds.x) * u64::from(size.y) + u64::from(thirds.y) * u64::from(size.x)
        };
        let (drawn, used) = (plan.count().samples(), used.len() as u64);
        prop_assert!(used <= drawn && drawn <= used + plan.passes.iter().map(last).sum::<u64>());
    }
}
