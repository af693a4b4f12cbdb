use foveasim_models::{Affine, Feather, Lattice, Map, Pass, Region, Resolve, SamplePlan};
use foveasim_models::{Viewport, Work};
use glam::{DVec2, DVec3, UVec2};

use crate::RenderOptions;
use crate::tile::{BLOCK, BLOCKS_ACROSS, LANES, LaneSet, SampleTile, TILE, position_of, sampled};

/// Which samples of a pass are drawn.
#[derive(Debug)]
pub(crate) struct Live<'a> {
    region: Option<&'a Region>,
    hidden: Option<Hidden<'a>>,
}

/// What inner layers hide of a pass: all that is seen only where they have full weight.
#[derive(Debug)]
struct Hidden<'a> {
    optics: &'a Viewport,
    map: Affine,
    gaze: DVec3,
    /// Cosine of the eccentricity up to which all is hidden.
    cosine: f64,
}

/// The blending kernel works in single precision: what it calls full weight ends this much earlier.
const SLACK: f64 = 1e-4;

impl<'a> Live<'a> {
    /// For pass `index` of a plan; what is hidden is left out if `skip_hidden`.
    pub(crate) fn new(
        plan: &'a SamplePlan,
        index: usize,
        optics: &'a Viewport,
        skip_hidden: bool,
    ) -> Self {
        let pass = &plan.passes[index];
        let region = Some(&pass.region).filter(|r| **r != Region::All);
        let hidden = match (&plan.resolve, pass.map) {
            (Resolve::Feather(feather), Map::Affine(map)) if skip_hidden => {
                Hidden::new(plan, feather, index, optics, map)
            }
            _ => None,
        };
        Self { region, hidden }
    }

    /// Whether every sample is drawn.
    pub(crate) fn is_all(&self) -> bool {
        self.region.is_none() && self.hidden.is_none()
    }

    /// Takes samples that are not drawn out of the lanes of each block that are `valid`, and counts them.
    pub(crate) fn clear(&self, tile: &SampleTile, valid: &mut [LaneSet], work: &mut Work) {
        if self.is_all() {
            return;
        }
        let all = u64::from(tile.size.x) * u64::from(tile.size.y);
        if let Some(region) = self.region {
            clear_dead(region, tile, valid);
        }
        let live = samples(valid);
        work.samples_dead += all - live;
        if let Some(hidden) = &self.hidden
            && hidden.touches(tile)
        {
            hidden.clear(tile, valid);
            work.samples_hidden += live - samples(valid);
        }
    }
}

/// First sample of the least box that holds all live ones of a pass, and one past its last: beyond it, nothing is drawn. Of
/// passes whose samples do not lie evenly, all `size` positions of their projection.
pub(crate) fn live_box(pass: &Pass, size: UVec2, options: &RenderOptions) -> [UVec2; 2] {
    match (&pass.region, sampled(pass)) {
        (Region::Cells(mask), Map::Affine(_)) if options.skip.outside => {
            mask.bounds().unwrap_or([UVec2::ZERO; 2])
        }
        _ => [UVec2::ZERO, size],
    }
}

fn samples(valid: &[LaneSet]) -> u64 {
    valid.iter().map(|v| u64::from(v.count_ones())).sum()
}

/// Takes out what is dead.
fn clear_dead(region: &Region, tile: &SampleTile, valid: &mut [LaneSet]) {
    for y in 0..tile.size.y {
        let live = live_in_row(region, tile, y);
        let first = (y / BLOCK[1] * BLOCKS_ACROSS) as usize;
        let blocks = &mut valid[first..first + BLOCKS_ACROSS as usize];
        for (k, lanes) in blocks.iter_mut().enumerate() {
            let four = (live >> (BLOCK[0] as usize * k)) as LaneSet & 0xf;
            let shift = y % BLOCK[1] * BLOCK[0];
            *lanes &= !(0xf << shift) | four << shift;
        }
    }
}

/// The live samples of a row of a tile, one bit for each.
fn live_in_row(region: &Region, tile: &SampleTile, y: u32) -> u64 {
    let below = |x: u32| u64::MAX.checked_shr(TILE - x.min(TILE)).unwrap_or(0);
    if let Region::Spans(spans) = region {
        let live = spans.row(tile.origin.y + y);
        let [start, end] = [live.start, live.end].map(|x| {
            let x = x.saturating_sub(tile.origin.x);
            below(x.min(tile.size.x))
        });
        return end & !start;
    }
    // Samples of one cell are alike.
    let cell = match region {
        Region::Cells(mask) => mask.cell().x,
        _ => 1,
    };
    let (mut live, mut x) = (0, 0);
    while x < tile.size.x {
        let next = ((tile.origin.x + x) / cell + 1) * cell - tile.origin.x;
        let end = next.min(tile.size.x);
        if region.is_live(tile.origin + UVec2::new(x, y)) {
            live |= below(end) & !below(x);
        }
        x = end;
    }
    live
}

impl<'a> Hidden<'a> {
    fn new(
        plan: &SamplePlan,
        feather: &Feather,
        index: usize,
        optics: &'a Viewport,
        map: Affine,
    ) -> Option<Self> {
        // The widest of the inner layers that has samples at all.
        let from = (0..index)
            .filter(|&k| plan.passes[k].lattice.samples() > 0)
            .filter_map(|k| feather.edges_tan.get(k))
            .map(|edge| edge[0])
            .fold(0.0, f64::max);
        let tan = from * (1.0 - SLACK) - 1e-6;
        // From 45° on, cones are left alone: layers that wide hide little that is on a screen.
        (tan > 0.0 && tan < 1.0).then(|| Self {
            optics,
            map,
            gaze: feather.gaze,
            cosine: 1.0 / foveasim_models::math::sqrt(1.0 + tan * tan),
        })
    }

    /// Whether a lattice position is seen within the cone.
    fn holds(&self, lattice: DVec2) -> bool {
        let d = self
            .optics
            .direction(self.map.display_from_lattice(lattice));
        let along = d.dot(self.gaze);
        along > 0.0 && along * along >= self.cosine * self.cosine * d.length_squared()
    }

    /// Whether all pixels that read a sample between `low` and `high` are in the cone. They lie less
    /// than a sample's width away, and a cone meets the image in a convex region: corners will do.
    fn hides(&self, low: UVec2, high: UVec2) -> bool {
        let low = low.as_dvec2() - 0.5;
        let high = high.as_dvec2() + 0.5;
        [
            low,
            high,
            DVec2::new(low.x, high.y),
            DVec2::new(high.x, low.y),
        ]
        .into_iter()
        .all(|corner| self.holds(corner))
    }

    /// Whether any sample of the tile may be hidden: whether its part nearest to the gaze is.
    fn touches(&self, tile: &SampleTile) -> bool {
        let Some(centre) = self.optics.project(self.gaze) else {
            return true;
        };
        let (low, high) = (tile.origin.as_dvec2(), (tile.origin + tile.size).as_dvec2());
        let nearest = self.map.lattice_from_display(centre).clamp(low, high);
        // The region is not a circle about the gaze's place, but it is convex and holds it.
        let margin = f64::from(TILE);
        self.holds(nearest) || (nearest - self.map.lattice_from_display(centre)).length() < margin
    }

    fn clear(&self, tile: &SampleTile, valid: &mut [LaneSet]) {
        for (block, lanes) in valid.iter_mut().enumerate() {
            let [x, y] = position_of(block * LANES);
            let first = tile.origin + UVec2::new(x, y);
            if self.hides(first, first + UVec2::from(BLOCK)) {
                *lanes = 0;
                continue;
            }
            for lane in 0..LANES {
                let [x, y] = position_of(block * LANES + lane);
                let sample = tile.origin + UVec2::new(x, y);
                if *lanes >> lane & 1 != 0 && self.hides(sample, sample + UVec2::ONE) {
                    *lanes &= !(1 << lane);
                }
            }
        }
    }
}

/// Samples of a grid that a pass covers; nothing for what is not a grid.
pub(crate) fn grid(pass: &Pass) -> UVec2 {
    match pass.lattice {
        Lattice::Grid(size) => size,
        _ => UVec2::ZERO,
    }
}
