use foveasim_models::math::{cos, sin, sqrt};
use foveasim_models::{Role, Stream};
use glam::{DVec2, UVec2};

use crate::MaskSpec;
use crate::cells::nearest_sites;
use crate::moments::{Moments, moments};
use crate::phi::{FINE, ONE, Phi};
use crate::spec::SUBPIXELS;

/// One iteration of Linde-Buzo-Gray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LbgIteration {
    /// Its number, from 0.
    pub iteration: u32,
    /// h: cells within 1 ± h/2 rays stay.
    pub width: f64,
    /// Sites it began with.
    pub sites: u64,
    /// … of which were split in two.
    pub split: u64,
    /// … of which were left out.
    pub merged: u64,
    /// Least and greatest share of density of a cell \[rays\].
    pub share: [f64; 2],
    /// Root of the mean squared way of those that were free to move and neither split nor merged \[px\].
    pub moved_px: f64,
    /// ΣT, all cells' shares \[rays\]: the same in every iteration.
    pub total: f64,
}

/// How sites came to rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Convergence {
    /// Every iteration; in the last one nothing is split or merged.
    pub iterations: Vec<LbgIteration>,
    /// ∫Φ over the mask's pixels \[rays\].
    pub integral: f64,
}

impl Convergence {
    /// The last iteration's h, and how many sites there are over ∫Φ; with what the former allows of the latter,
    /// \[1/(1 + h/2), 1/(1 − h/2)\] (no upper limit from h = 2 on).
    pub fn ratio(&self) -> Option<(f64, f64, [f64; 2])> {
        let last = self.iterations.last()?;
        let half = last.width / 2.0;
        let most = if half < 1.0 {
            1.0 / (1.0 - half)
        } else {
            f64::INFINITY
        };
        let ratio = last.sites as f64 / self.integral;
        Some((last.width, ratio, [1.0 / (1.0 + half), most]))
    }
}

/// Sites at rest.
pub(crate) struct Settled {
    /// Where they are \[px\].
    pub(crate) sites: Vec<DVec2>,
    /// Square root of each cell's area \[px\].
    pub(crate) spacing: Vec<f32>,
    pub(crate) convergence: Convergence,
}

/// What becomes of a cell.
enum Fate {
    Split,
    Merge,
    Stay,
}

/// Weighted Linde-Buzo-Gray (Deussen et al. 2017; Bruder 2019, §4.1): cells are split or merged until each holds about one
/// ray's share of the density; those that do move to their middle.
///
/// A pixel with a density of at least 1 − h₀/2, which no merging would take away, is a cell of its own and its site stays in
/// its middle: so full rate is reached around the gaze. All else is done on parts of pixels.
///
/// `progress` is told of every iteration.
pub(crate) fn settle(spec: &MaskSpec, phi: &Phi, progress: &dyn Fn(&LbgIteration)) -> Settled {
    let (mut sites, pinned) = begin(spec);
    let mut iterations = Vec::new();
    for iteration in 0.. {
        let owner = nearest_sites(phi.size(), &sites);
        let cells = moments(phi, &owner, &sites);
        let random = &mut Stream::new(spec.seed, Role::Mask, 1 + u64::from(iteration));
        let (next, row) = improve(spec, iteration, &sites, pinned, &cells, random);
        progress(&row);
        iterations.push(row);
        // A pixel's own cell may have lost part of it to a site that will yet move away.
        if row.split + row.merged == 0 && row.share[0] >= 1.0 - row.width / 2.0 {
            let convergence = Convergence {
                iterations,
                integral: phi.total() as f64 / ONE as f64,
            };
            let fine = f64::from(FINE);
            let spacing = |cell: &Moments| (sqrt(f64::from(cell.parts)) / fine) as f32;
            return Settled {
                sites: sites.into_iter().map(|site| site / fine).collect(),
                spacing: cells.iter().map(spacing).collect(),
                convergence,
            };
        }
        sites = next;
    }
    unreachable!("h grows until no cell holds too little or too much")
}

/// Where sites begin \[parts of pixels\], and how many of them, which come first, stay there: one in the middle of each pixel
/// at full rate, and one anywhere in another with probability Φ.
fn begin(spec: &MaskSpec) -> (Vec<DVec2>, usize) {
    let random = &mut Stream::new(spec.seed, Role::Mask, 0);
    let full_rate = 1.0 - spec.hysteresis.start / 2.0;
    let (size, fine) = (spec.mask_px(), f64::from(FINE));
    let middle = spec.display_px.as_dvec2();
    let (mut sites, mut free) = (Vec::new(), Vec::new());
    for y in 0..size.y {
        for x in 0..size.x {
            let corner = UVec2::new(x, y).as_dvec2();
            let density = spec.density.at((corner + 0.5).distance(middle));
            if density >= full_rate {
                sites.push((corner + 0.5) * fine);
            } else if random.uniform() < density {
                let within = DVec2::new(random.uniform(), random.uniform());
                free.push(on_grid((corner + within) * fine, size.as_dvec2() * fine));
            }
        }
    }
    let pinned = sites.len();
    sites.extend(free);
    if sites.is_empty() {
        sites.push(middle * fine);
    }
    (sites, pinned)
}

fn improve(
    spec: &MaskSpec,
    iteration: u32,
    sites: &[DVec2],
    pinned: usize,
    cells: &[Moments],
    random: &mut Stream,
) -> (Vec<DVec2>, LbgIteration) {
    let width = spec.hysteresis.width(iteration);
    let within = spec.mask_px().as_dvec2() * f64::from(FINE);
    let (low, high) = (1.0 - width / 2.0, 1.0 + width / 2.0);
    let fate = |cell: &Moments| match cell.rays() {
        // A cell without a pixel, or all of whose pixels have none of the density, stands for nothing.
        _ if cell.density == 0 => Fate::Merge,
        share if share > high => Fate::Split,
        share if share < low => Fate::Merge,
        _ => Fate::Stay,
    };
    let mut next = Vec::with_capacity(sites.len());
    let (mut split, mut merged, mut total, mut squares) = (0, 0, 0, 0.0);
    let mut share = [f64::INFINITY, 0.0f64];
    let mut added = Vec::new();
    for (number, (&site, cell)) in sites.iter().zip(cells).enumerate() {
        total += cell.density;
        share = [share[0].min(cell.rays()), share[1].max(cell.rays())];
        if number < pinned {
            next.push(site);
            // What it has too much of lies to one side, and gets a site there.
            let away = cell.centroid(site) - site;
            if let (Fate::Split, Some(side)) = (fate(cell), away.try_normalize()) {
                split += 1;
                added.push(on_grid(site + f64::from(FINE) * side, within));
            }
            continue;
        }
        match fate(cell) {
            Fate::Merge => merged += 1,
            Fate::Stay => {
                let to = on_grid(cell.centroid(site), within);
                squares += to.distance_squared(site);
                next.push(to);
            }
            Fate::Split => {
                split += 1;
                let axis = cell.long_axis().unwrap_or_else(|| {
                    let angle = std::f64::consts::TAU * random.uniform();
                    DVec2::new(cos(angle), sin(angle))
                });
                // Half the radius of a disc of the cell's size to either side.
                let half = 0.5 * sqrt(f64::from(cell.parts) / std::f64::consts::PI);
                let middle = cell.centroid(site);
                next.extend(
                    [middle - half * axis, middle + half * axis].map(|p| on_grid(p, within)),
                );
            }
        }
    }
    next.extend(added);
    if next.is_empty() {
        // Cells so small that all fall: begin again from one.
        next.extend(sites.first());
    }
    let stayed = ((sites.len() - pinned) as u64 - split - merged).max(1);
    let row = LbgIteration {
        iteration,
        width,
        sites: sites.len() as u64,
        split,
        merged,
        share,
        moved_px: sqrt(squares / stayed as f64) / f64::from(FINE),
        total: total as f64 / ONE as f64,
    };
    (next, row)
}

/// The nearest place that sites are kept to \[parts of pixels\]: inside the mask, and off its edge, where a site and its
/// mirror image would coincide.
fn on_grid(p: DVec2, within: DVec2) -> DVec2 {
    const STEPS: f64 = SUBPIXELS / FINE as f64;
    let p = p.clamp(DVec2::splat(0.25), within - 0.25);
    (p * STEPS + 0.5).floor() / STEPS
}
