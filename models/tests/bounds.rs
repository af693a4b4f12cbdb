//! The conservative bound against a test of every sample, and beside the published ones.
//!
//! `FOVEASIM_THOROUGH=1` takes a million triangles instead of a hundred thousand.

#![expect(clippy::print_stdout, reason = "the numbers are asked for")]

use foveasim_models::raster::{
    Comparison, Facing, Forms, MovingTriangle, Nodes, Real, SampleTable, Sampling, compare,
};
use foveasim_models::{
    Affine, Falloff, FalloffTable, LensMatched, LensSpec, LogPolar, Map, Radial, Reach, Region,
    Role, ScanSkew, Stream,
};
use glam::{DVec2, DVec3, UVec2};

/// Small displays, so that every sample can be tested; of one in eight the lattice has several tiles.
fn display(seed: u64) -> UVec2 {
    match seed % 8 {
        0 => UVec2::new(80, 68),
        _ => UVec2::new(46, 34),
    }
}

/// Samples of a random map, lens and scan.
struct Setting<T> {
    sampling: Sampling,
    table: SampleTable<T>,
    nodes: Nodes<T>,
}

fn setting<T: Real>(seed: u64) -> Setting<T> {
    let mut random = Stream::new(seed, Role::Scene, 0);
    let display = display(seed);
    let size = display.as_dvec2();
    // Inside, or in a corner.
    let gaze = match random.below(4) {
        0 => DVec2::ZERO,
        _ => DVec2::new(random.uniform(), random.uniform()) * size,
    };
    let (map, lattice) = match random.below(6) {
        0 => (Map::Affine(Affine::IDENTITY), display),
        1 => {
            let scale = random.range(0.7, 3.0);
            let map = Affine {
                origin: DVec2::splat(-3.3),
                scale: DVec2::splat(scale),
            };
            (Map::Affine(map), (size / scale + 5.0).as_uvec2())
        }
        2 => {
            let samples = size * random.range(0.5, 1.0);
            let alpha = random.range(0.5, 4.0);
            let map = LogPolar::new(gaze, display, alpha, samples.ceil()).unwrap();
            (Map::LogPolar(map), samples.ceil().as_uvec2())
        }
        3 => {
            let growth = DVec2::new(random.uniform(), random.uniform()) * 4.0 / size;
            let centre = gaze.round();
            let map = LensMatched::new(centre, centre, growth).unwrap();
            (Map::LensMatched(map), display)
        }
        which => {
            let points = [[0.0, 0.0], [0.3, 0.05], [0.7, 0.4], [1.0, 1.0]];
            let falloff = match random.below(4) {
                0 => Falloff::Table(FalloffTable::new(&points).unwrap()),
                _ => Falloff::power(random.range(1.0, 4.0)).unwrap(),
            };
            let reach = if which == 4 {
                Reach::Corner
            } else {
                Reach::Boundary
            };
            let map = Radial::new(gaze, display, falloff, reach, random.range(0.6, 1.2)).unwrap();
            (Map::Radial(map), map.lattice())
        }
    };
    let lens = (random.below(2) == 0).then(|| {
        let spec = LensSpec {
            coefficients: [random.range(-0.05, 0.4), random.range(0.0, 0.3)],
            centre: [random.range(0.4, 0.6), 0.5],
            radius: 1.0,
            chromatic: [1.0; 3],
        };
        spec.over(display).unwrap()
    });
    let scan = (random.below(4) != 0).then(|| {
        let x = random.range(-1.0, 1.0);
        let y = random.range(-1.0, 1.0) * (1.0 - x.abs());
        let axis = random.below(3);
        let d = [DVec2::new(x, 0.0), DVec2::new(0.0, y), DVec2::new(x, y)][axis as usize];
        ScanSkew::new(d).unwrap()
    });
    let sampling = Sampling {
        map,
        lens,
        scan,
        display_px: size,
    };
    let region = Region::on_display(&map, lattice, display);
    let table = SampleTable::new(&sampling, lattice, &region).unwrap();
    let nodes = Nodes::new(&table);
    Setting {
        sampling,
        table,
        nodes,
    }
}

/// A triangle somewhere about the display, of any size, slender or not, that moves and turns little or much,
/// through the eye's plane or behind it or not.
fn triangle(random: &mut Stream, size: DVec2) -> MovingTriangle {
    let about = |random: &mut Stream, reach: f64| {
        DVec2::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0)) * reach
    };
    let log = |random: &mut Stream, low: f64, high: f64| low * (high / low).powf(random.uniform());
    let middle = DVec2::new(random.range(-0.3, 1.3), random.range(-0.3, 1.3)) * size;
    let extent = log(random, 0.1, 300.0);
    let depth = log(random, 0.05, 50.0);
    let speed = log(random, 1e-3, 60.0) * f64::from(random.below(4) != 0);
    let crosses = random.below(5) == 0;
    let sliver = random.below(5) == 0;
    let along = about(random, extent);
    let motion = about(random, speed);
    let mut corner = |shared: DVec2| {
        let away = match sliver {
            true => along * random.range(-1.0, 1.0) + about(random, 1e-6),
            false => about(random, extent),
        };
        let mut w = depth * random.range(0.5, 2.0);
        let mut end_w = w * random.range(0.7, 1.4);
        if crosses {
            w *= random.range(-1.0, 1.0);
            end_w *= random.range(-1.0, 1.0);
        }
        let place = middle + away;
        let moved = place + shared + about(random, speed * 0.3);
        [(place * w).extend(w), (moved * end_w).extend(end_w)]
    };
    let corners: [[DVec3; 2]; 3] = [(); 3].map(|()| corner(motion));
    MovingTriangle::new(corners.map(|c| c[0]), corners.map(|c| c[1]))
}

fn thorough() -> bool {
    std::env::var_os("FOVEASIM_THOROUGH").is_some_and(|v| v == "1")
}

/// How many samples a bound leaves out, and blocks it leaves, over random triangles.
fn check<T: Real>(settings: u64, triangles: u64) {
    let (mut covered, mut tested, mut all, mut seen) = (0u64, 0u64, 0u64, 0u64);
    for s in 0..settings {
        let Setting { table, nodes, .. } = setting::<T>(s);
        let samples: Vec<_> = table
            .block(UVec2::ZERO, table.lattice().max_element())
            .collect();
        let across = table.lattice().x.div_ceil(4);
        let mut visited = vec![u64::MAX; (across * table.lattice().y.div_ceil(4)) as usize];
        for k in 0..triangles {
            let triangle = triangle(
                &mut Stream::new(s, Role::Population, k),
                display(s).as_dvec2(),
            );
            let facing = if k % 3 == 0 {
                Facing::Front
            } else {
                Facing::Both
            };
            let Some(forms) = Forms::<T>::new(&triangle, facing) else {
                continue;
            };
            let visits = nodes.visit(&forms, |first| {
                visited[(first.y / 4 * across + first.x / 4) as usize] = k;
            });
            let before = covered;
            for (sample, looks) in &samples {
                if forms.covers(*looks) {
                    covered += 1;
                    let block = (sample.y / 4 * across + sample.x / 4) as usize;
                    assert_eq!(
                        visited[block], k,
                        "{sample} of setting {s}, triangle {k}: {triangle:?}"
                    );
                }
            }
            tested += 16 * visits.blocks;
            all += samples.len() as u64;
            seen += u64::from(covered > before);
        }
    }
    println!(
        "{} triangles, {seen} seen: {covered} samples covered, {tested} tested of {all}",
        settings * triangles
    );
    // Neither empty nor all.
    assert!(
        seen > settings * triangles / 20 && tested < all / 2,
        "{seen} {tested} {all}"
    );
}

#[test]
fn no_sample_is_missed_in_f32() {
    let (settings, triangles) = if thorough() { (200, 5000) } else { (80, 1250) };
    check::<f32>(settings, triangles);
}

#[test]
fn no_sample_is_missed_in_f64() {
    let (settings, triangles) = if thorough() { (200, 1000) } else { (80, 125) };
    check::<f64>(settings, triangles);
}

/// The published bounds leave out samples, and ours none.
#[test]
fn the_published_bounds_miss_samples() {
    let (settings, triangles) = if thorough() { (200, 500) } else { (60, 60) };
    let (mut total, mut bounded) = (Comparison::default(), Comparison::default());
    let (mut triangles_seen, mut triangles_bounded) = (0, 0);
    for s in 0..settings {
        let Setting {
            sampling,
            table,
            nodes,
        } = setting::<f32>(s);
        if matches!(sampling.map, Map::LogPolar(_)) {
            // Edges wrap around: the paper's bounds are not meant for it.
            continue;
        }
        for k in 0..triangles {
            let triangle = triangle(
                &mut Stream::new(s, Role::Population, k),
                display(s).as_dvec2(),
            );
            if let Some(forms) = Forms::new(&triangle, Facing::Both) {
                let found = compare(&triangle, &forms, &sampling, &table, &nodes);
                total += found;
                triangles_seen += 1;
                if found.published.iter().all(|m| m.unbounded == 0) {
                    bounded += found;
                    triangles_bounded += 1;
                }
            }
        }
    }
    let sums = [
        ("all", triangles_seen, total),
        ("in front of the eye", triangles_bounded, bounded),
    ];
    for (what, count, sum) in sums {
        println!("{what}: {count} triangles, {} samples covered", sum.covered);
        let names = ["box", "simple", "adaptive", "ours"];
        let each = sum.published.into_iter().chain([sum.conservative]);
        for (name, m) in names.into_iter().zip(each) {
            println!("  {name}: {:.3}, {m:?}", m.efficiency(sum.covered));
        }
    }
    assert_eq!(total.conservative.lost, 0);
    let [boxed, simple, adaptive] = total.published;
    assert!(simple.outside > 0 && adaptive.outside > 0 && adaptive.lost > 0);
    assert!(boxed.tested > 0);
}
