//! What bounds of moving triangles leave out.

use foveasim_assets::study_camera;
use foveasim_models::Pose;
use foveasim_render::{Bound, BoundCounts, bound_counts};
use glam::DVec3;

use crate::common::view;
use crate::moving::{lens, scattering, turning};
use crate::{STUDY, options, plan};

/// No covered sample is left out, hidden ones included: triangle by triangle what is found without any bound. A million with
/// `FOVEASIM_THOROUGH=1`.
#[test]
#[expect(clippy::print_stderr, reason = "it says what it counted")]
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

/// Published bounds find no more than ours does; how much they miss, and what each tests.
#[test]
#[expect(clippy::print_stderr, reason = "it says what it counted")]
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
