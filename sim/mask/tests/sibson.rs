//! Sibson's weights against exact rational arithmetic, and what must hold for any sites.

use foveasim_mask::{Delaunay, MaskError, NaturalNeighbours, Neighbour};
use foveasim_models::{Role, Stream};
use glam::DVec2;
use serde_json::Value;

fn point(v: &Value) -> DVec2 {
    DVec2::new(v[0].as_f64().unwrap(), v[1].as_f64().unwrap())
}

fn nearest(sites: &[DVec2], q: DVec2) -> u32 {
    let distance = |k: &usize| sites[*k].distance_squared(q);
    let nearest = (0..sites.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.unwrap() as u32
}

/// 200 sites, and 50 places of which some lie on edges, close to the hull, outside it, or 2⁻²⁴ from a site.
#[test]
fn weights_are_those_of_exact_arithmetic() {
    let data: Value = serde_json::from_str(include_str!("data/sibson.json")).unwrap();
    let sites: Vec<DVec2> = data["sites"]
        .as_array()
        .unwrap()
        .iter()
        .map(point)
        .collect();
    let delaunay = Delaunay::new(&sites).unwrap();
    let mut finder = NaturalNeighbours::new(&delaunay);
    let mut found = Vec::new();
    for query in data["queries"].as_array().unwrap() {
        let q = point(&query["at"]);
        let exists = finder.sibson(q, nearest(&sites, q), &mut found);
        let Some(exact) = query["weights"].as_object() else {
            assert!(!exists && found.is_empty(), "{query}");
            continue;
        };
        assert!(exists, "{query}");
        // Areas of cells as small as the way to a site cancel.
        let near_site = query["category"].as_str().unwrap().starts_with("near_site");
        let tolerance = if near_site { 1e-8 } else { 1e-12 };
        let weight = |site: u32| {
            let of = found.iter().find(|n| n.site == site);
            of.map_or(0.0, |n| n.weight)
        };
        for (site, value) in exact {
            let error = weight(site.parse().unwrap()) - value.as_f64().unwrap();
            assert!(error.abs() < tolerance, "{error:e} {query}");
        }
        let known = |n: &&Neighbour| exact.contains_key(&n.site.to_string());
        let others: f64 = found.iter().filter(|n| !known(n)).map(|n| n.weight).sum();
        assert!(others < 1e-12, "{others:e} {query}");
    }
}

/// Weights of at least 0 that sum up to one and give linear functions back, for sites at random, on a grid (all circles
/// of whose squares have four sites on them) and on a circle.
#[test]
fn linear_functions_are_given_back() {
    let random = &mut Stream::new(5, Role::Mask, 0);
    let at_random: Vec<DVec2> = (0..400)
        .map(|_| DVec2::new(random.range(-7.0, 9.0), random.range(-3.0, 30.0)))
        .collect();
    let grid: Vec<DVec2> = (0..144)
        .map(|k| DVec2::new(f64::from(k % 12), f64::from(k / 12)))
        .collect();
    let mut round: Vec<DVec2> = (0..24)
        .map(|k| DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / 24.0) * 5.0)
        .collect();
    round.push(DVec2::new(0.1, 0.2));
    for sites in [at_random, grid, round] {
        let delaunay = Delaunay::new(&sites).unwrap();
        let mut finder = NaturalNeighbours::new(&delaunay);
        let mut found = Vec::new();
        let low = sites.iter().copied().reduce(DVec2::min).unwrap();
        let high = sites.iter().copied().reduce(DVec2::max).unwrap();
        let (mut inside, mut worst) = ([0; 2], [0f64; 2]);
        for k in 0..4000 {
            let part = DVec2::new(random.uniform(), random.uniform());
            // Every other place is on the grid's lines, or half way.
            let q = low + part * (high - low);
            let q = if k % 2 == 0 {
                q
            } else {
                (2.0 * q).round() / 2.0
            };
            let nearest = nearest(&sites, q);
            for method in 0..2 {
                let exists = match method {
                    0 => finder.sibson(q, nearest, &mut found),
                    _ => finder.barycentric(q, nearest, &mut found),
                };
                if !exists {
                    continue;
                }
                inside[method] += 1;
                let sum: f64 = found.iter().map(|n| n.weight).sum();
                let back: DVec2 = found
                    .iter()
                    .map(|n| n.weight * sites[n.site as usize])
                    .sum();
                assert!(found.iter().all(|n| n.weight >= 0.0) && (sum - 1.0).abs() < 1e-12);
                worst[method] = worst[method].max((back - q).length() / (high - low).length());
            }
        }
        assert!(inside.iter().all(|n| *n > 2500), "{inside:?}");
        // Close to the hull cells reach far, and areas cancel.
        assert!(worst[0] < 1e-9 && worst[1] < 1e-13, "{worst:?}");
    }
}

/// A place at a site has that site's value, and one in the middle of a square a quarter of each.
#[test]
fn known_places() {
    let square = [(0.0, 0.0), (2.0, 0.0), (0.0, 2.0), (2.0, 2.0), (9.0, 1.0)];
    let sites = square.map(DVec2::from);
    let delaunay = Delaunay::new(&sites).unwrap();
    let mut finder = NaturalNeighbours::new(&delaunay);
    let mut found = Vec::new();
    assert!(finder.sibson(sites[3], 3, &mut found));
    assert_eq!(
        found,
        [Neighbour {
            site: 3,
            weight: 1.0
        }]
    );
    assert!(finder.sibson(DVec2::ONE, 0, &mut found));
    for n in &found {
        let expected = if n.site < 4 { 0.25 } else { 0.0 };
        assert!((n.weight - expected).abs() < 1e-15, "{found:?}");
    }
    assert!(!finder.sibson(DVec2::new(-0.1, 1.0), 0, &mut found) && found.is_empty());
}

#[test]
fn sites_without_triangles_are_refused() {
    let refused = |sites: &[(f64, f64)]| {
        let sites: Vec<DVec2> = sites.iter().map(|&p| p.into()).collect();
        match Delaunay::new(&sites) {
            Err(error @ MaskError::Sites { .. }) => error.to_string(),
            other => panic!("{other:?}"),
        }
    };
    assert!(refused(&[]).starts_with("0 sites cannot be triangulated"));
    assert!(refused(&[(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)]).contains("on a line"));
    assert!(
        refused(&[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 0.0)]).contains("only 3 different")
    );
    assert!(!refused(&[(0.0, 0.0), (1.0, 0.0), (f64::NAN, 1.0)]).is_empty());
}
