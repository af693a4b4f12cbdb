use std::f64::consts::PI;

use foveasim_models::math::{atan2, cos, hypot, quantile_sorted, sin, sqrt, sum};
use glam::DVec2;
use rayon::prelude::*;

use crate::Mask;

/// How sites lie to one another: whether a grid shows.
#[derive(Debug, Clone, PartialEq)]
pub struct SpacingStatistics {
    /// By how far apart they are.
    pub rings: Vec<SpacingRing>,
    /// Of all those that are more than 1.5 px apart.
    pub pairs: PairCorrelation,
}

/// Sites whose spacing lies between two powers of two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpacingRing {
    /// Least spacing \[px\].
    pub from_px: f64,
    /// Spacing that is too much \[px\].
    pub to_px: f64,
    /// Sites looked at.
    pub sites: u64,
    /// Distance of the nearest other site over the spacing: 5th percentile and median. Hexagons have 1.07, squares 1,
    /// and sites at random 0.13 and 0.47.
    pub nearest: [f64; 2],
    /// |mean of e^{ikθ}| for the direction θ of the nearest other site and k = 4 and 6: one for a grid of squares or hexagons
    /// that lie alike, and about 1/√sites where all directions are alike.
    pub aligned: [f64; 2],
}

/// How many other sites there are at each distance, over how many there would be if they lay at random.
#[derive(Debug, Clone, PartialEq)]
pub struct PairCorrelation {
    /// Middle of each bin, in units of the pair's spacing, and the ratio.
    pub bins: Vec<[f64; 2]>,
    /// Sites that distances were taken from.
    pub sites: u64,
}

/// Distances are taken from at most so many sites.
const FROM_SITES: usize = 3000;
const BIN: f64 = 0.1;
const BINS: usize = 40;

/// What one site sees.
struct Seen {
    spacing: f64,
    nearest: f64,
    direction: f64,
    bins: [u32; BINS],
}

impl SpacingStatistics {
    /// Of every so many sites of `mask`, along its order.
    pub fn of(mask: &Mask) -> Self {
        let (sites, spacing) = (mask.sites(), mask.spacing());
        let middle = mask.size().as_dvec2() / 2.0;
        // Cells at the border are cut.
        let inside = |k: &usize| {
            let away = (sites[*k] - middle).abs() + 4.5 * f64::from(spacing[*k]);
            away.cmplt(middle).all()
        };
        let all: Vec<usize> = (0..sites.len()).filter(inside).collect();
        let every = all.len().div_ceil(FROM_SITES).max(1);
        let chosen: Vec<usize> = all.into_iter().step_by(every).collect();
        let look = |&k: &usize| {
            let own = f64::from(spacing[k]);
            let mut seen = Seen {
                spacing: own,
                nearest: f64::INFINITY,
                direction: 0.0,
                bins: [0; BINS],
            };
            for (other, (&at, &its)) in sites.iter().zip(spacing).enumerate() {
                let way: DVec2 = at - sites[k];
                let squared = way.length_squared();
                if squared < seen.nearest && other != k {
                    seen.nearest = squared;
                    seen.direction = atan2(way.y, way.x);
                }
                let unit = own * f64::from(its);
                let reach = BIN * BINS as f64;
                if squared < reach * reach * unit && other != k {
                    seen.bins[((sqrt(squared / unit) / BIN) as usize).min(BINS - 1)] += 1;
                }
            }
            seen.nearest = sqrt(seen.nearest) / own;
            seen
        };
        let seen: Vec<Seen> = chosen.par_iter().map(look).collect();
        let spacings = [0.0, 1.5, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
        let rings = spacings
            .windows(2)
            .filter_map(|w| ring(&seen, [w[0], w[1]]));
        Self {
            rings: rings.collect(),
            pairs: pairs(&seen),
        }
    }
}

fn ring(seen: &[Seen], [from_px, to_px]: [f64; 2]) -> Option<SpacingRing> {
    let these: Vec<&Seen> = seen
        .iter()
        .filter(|s| (from_px..to_px).contains(&s.spacing))
        .collect();
    if these.is_empty() {
        return None;
    }
    let mut nearest: Vec<f64> = these.iter().map(|s| s.nearest).collect();
    nearest.sort_by(f64::total_cmp);
    let aligned = [4.0, 6.0].map(|k| {
        let part =
            |f: fn(f64) -> f64| sum(&these.iter().map(|s| f(k * s.direction)).collect::<Vec<_>>());
        hypot(part(cos), part(sin)) / these.len() as f64
    });
    Some(SpacingRing {
        from_px,
        to_px,
        sites: these.len() as u64,
        nearest: [0.05, 0.5].map(|q| quantile_sorted(&nearest, q)),
        aligned,
    })
}

fn pairs(seen: &[Seen]) -> PairCorrelation {
    // Below, the pixels' own grid shows: sites are one per pixel.
    let these = || seen.iter().filter(|s| s.spacing >= 1.5);
    let sites = these().count() as u64;
    let bin = |k: usize| {
        let (inner, outer) = (BIN * k as f64, BIN * (k + 1) as f64);
        let expected = PI * (outer * outer - inner * inner) * sites.max(1) as f64;
        let found: u64 = these().map(|s| u64::from(s.bins[k])).sum();
        [(inner + outer) / 2.0, found as f64 / expected]
    };
    PairCorrelation {
        bins: (0..BINS).map(bin).collect(),
        sites,
    }
}
