use std::collections::BTreeMap;

use glam::{DVec2, UVec2};

use super::Request;
use super::estimate::{Estimate, PassEstimate};
use crate::{Affine, CellMask, Lattice, Map, Pass, Region, Resolve, SamplePlan};

/// How densely a cell is sampled: samples per four display pixels along each axis, 1 to 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Density {
    pub(super) x: u32,
    pub(super) y: u32,
}

impl Density {
    /// Display pixels per sample.
    fn scale(self) -> DVec2 {
        4.0 / DVec2::new(f64::from(self.x), f64::from(self.y))
    }

    fn samples_of(self, pixels: f64) -> f64 {
        pixels * f64::from(self.x * self.y) / 16.0
    }

    /// Finest first.
    fn order(self) -> impl Ord {
        std::cmp::Reverse((self.x * self.y, self))
    }
}

/// A display cut into cells of `cell` pixels (a multiple of four), each sampled at a density of its own
/// (row by row).
///
/// Each density is a pass: a grid over the whole display of which the cells with that density are
/// live. A grid ends on the display's edge or, where that cuts a sample, less than a sample beyond it,
/// as hardware does; every display pixel lies in a live sample of exactly one pass.
pub(super) fn plan(
    method: String,
    request: &Request,
    cell: UVec2,
    densities: &[Density],
) -> SamplePlan {
    let size = request.viewport.size;
    let across = size.x.div_ceil(cell.x);
    let mut distinct = densities.to_vec();
    distinct.sort_unstable_by_key(|d| d.order());
    distinct.dedup();
    let full = SamplePlan::full(request.eye, size);
    if distinct == [Density { x: 4, y: 4 }] {
        return SamplePlan { method, ..full };
    }
    let pass = |density: &Density| {
        let per_four = UVec2::new(density.x, density.y);
        let lattice = UVec2::new(samples(size.x, density.x), samples(size.y, density.y));
        let live = |at: UVec2| densities[(at.y * across + at.x) as usize] == *density;
        Pass {
            lattice: Lattice::Grid(lattice),
            map: Map::Affine(Affine {
                origin: DVec2::ZERO,
                scale: density.scale(),
            }),
            region: match distinct.len() {
                1 => Region::All,
                _ => Region::Cells(CellMask::new(lattice, cell / 4 * per_four, live)),
            },
            ..full.passes[0].clone()
        }
    };
    SamplePlan {
        method,
        display_px: size,
        passes: distinct.iter().map(pass).collect(),
        resolve: Resolve::Mosaic,
    }
}

/// Samples that cover so many pixels.
fn samples(pixels: u32, per_four: u32) -> u32 {
    let samples = (u64::from(pixels) * u64::from(per_four)).div_ceil(4);
    u32::try_from(samples).expect("no more samples than pixels")
}

/// Pixels at each density, as passes.
#[derive(Default)]
pub(super) struct Tally(BTreeMap<Density, f64>);

impl Tally {
    pub(super) fn add(&mut self, density: Density, pixels: f64) {
        *self.0.entry(density).or_default() += pixels;
    }

    pub(super) fn estimate(self) -> Estimate {
        let display_pixels = self.0.values().sum();
        let mut densities: Vec<(Density, f64)> = self.0.into_iter().collect();
        densities.sort_unstable_by_key(|(density, _)| density.order());
        let pass = |(density, pixels): (Density, f64)| {
            PassEstimate::new(density.samples_of(pixels), density.scale())
        };
        Estimate {
            passes: densities.into_iter().map(pass).collect(),
            display_pixels,
        }
    }
}
