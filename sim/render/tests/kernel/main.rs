//! Lattices that are bent: what is seen and shaded at samples that a map places, and images made of them.

#[path = "../common/mod.rs"]
mod common;
mod eyes;
mod images;
mod seen;

use std::sync::LazyLock;

use foveasim_assets::{Scene, study_scene};
use foveasim_models::{
    Affine, Eye, Filter, Interpolation, Lattice, LensMatched, LogPolar, Map, Region, Resolve,
    SamplePlan, Shading, Visibility,
};
use glam::{DVec2, UVec2};

/// The study scene; its sky takes a while to make.
static STUDY: LazyLock<Scene> = LazyLock::new(|| study_scene(1));

const BILINEAR: Filter = Filter {
    interpolation: Interpolation::Bilinear,
    smooth_from: None,
    mips: false,
};

/// One pass over a lattice that `map` bends.
fn bent(display: UVec2, lattice: UVec2, map: Map) -> SamplePlan {
    let mut plan = SamplePlan::full(Eye::Cyclopean, display);
    plan.method = format!("{map:?}");
    plan.passes[0].lattice = Lattice::Grid(lattice);
    plan.passes[0].map = map;
    plan.passes[0].region = Region::on_display(&map, lattice, display);
    plan.resolve = Resolve::Inverse(BILINEAR);
    plan
}

/// Kernel foveated rendering, direct form.
fn kernel(display: UVec2, sigma: f64, alpha: f64, gaze: DVec2) -> SamplePlan {
    let lattice = (display.as_dvec2() / sigma).ceil().as_uvec2();
    let map = LogPolar::new(gaze, display, alpha, lattice.as_dvec2()).unwrap();
    bent(display, lattice, Map::LogPolar(map))
}

/// The same with visibility found at full resolution.
fn published(direct: &SamplePlan) -> SamplePlan {
    let mut plan = direct.clone();
    let mut full = SamplePlan::full(Eye::Cyclopean, plan.display_px)
        .passes
        .remove(0);
    full.shading = Shading::Nowhere;
    assert_eq!(full.map, Map::Affine(Affine::IDENTITY));
    plan.passes[0].visibility = Visibility::Shared(0);
    plan.passes.insert(0, full);
    plan
}

/// Lens-matched shading about `centre`, which is a whole pixel.
fn lens_matched(display: UVec2, centre: DVec2, growth: f64) -> SamplePlan {
    let growth = DVec2::splat(growth) / (display.as_dvec2() / 2.0);
    let shrunk = |d: f64, k: usize| (d / (1.0 + growth[k] * d)).ceil();
    let before = DVec2::new(shrunk(centre.x, 0), shrunk(centre.y, 1));
    let rest = display.as_dvec2() - centre;
    let after = DVec2::new(shrunk(rest.x, 0), shrunk(rest.y, 1));
    let map = LensMatched::new(centre, before, growth).unwrap();
    bent(display, (before + after).as_uvec2(), Map::LensMatched(map))
}

/// The same with so many samples for each, along each side.
fn finer(plan: SamplePlan, scale: f64) -> SamplePlan {
    let (Map::LensMatched(map), Lattice::Grid(grid)) = (plan.passes[0].map, plan.passes[0].lattice)
    else {
        unreachable!("a lens-matched plan")
    };
    let centre = map.centre() * scale;
    let map = LensMatched::new(map.centre_px(), centre, map.growth()).unwrap();
    let lattice = (grid.as_dvec2() * scale).ceil().as_uvec2();
    bent(
        plan.display_px,
        lattice,
        Map::LensMatched(map.scaled(scale).unwrap()),
    )
}

/// Plans of all kinds for a display: gazes on it, at its corner and beyond, kernels of all steepnesses.
fn plans(display: UVec2) -> Vec<SamplePlan> {
    let size = display.as_dvec2();
    let gazes = [
        size / 2.0,
        DVec2::new(0.31, 0.77) * size,
        DVec2::ZERO,
        size,
        DVec2::new(1.5, 0.2) * size,
        DVec2::new(-3.0, 7.0) * size,
    ];
    let mut plans = Vec::new();
    for (k, alpha) in [0.05, 0.25, 1.0, 2.3, 4.0, 20.0].into_iter().enumerate() {
        let sigma = [1.0, 1.8, 2.4, 3.0][k % 4];
        plans.push(kernel(display, sigma, alpha, gazes[k]));
        plans.push(kernel(display, sigma, alpha, gazes[(k + 1) % 2]));
    }
    plans.push(lens_matched(display, (size / 2.0).floor(), 0.6));
    plans.push(lens_matched(display, DVec2::ZERO, 1.3));
    plans.push(finer(lens_matched(display, (size / 2.0).floor(), 2.0), 2.5));
    plans
}
