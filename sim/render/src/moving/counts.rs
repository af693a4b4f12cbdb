use foveasim_assets::Scene;
use foveasim_models::{SamplePlan, View, Work};
use glam::UVec2;

use crate::pass::count_tests;
use crate::tile::{LANES, LaneSet, TILE, position_of};
use crate::{Bound, RenderError, RenderOptions};

/// Tests and hits of a tile's samples and triangles.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    /// By block and lane: tests, hits.
    pub(crate) samples: Vec<[[u32; 2]; LANES]>,
    /// By triangle of the tile.
    pub(crate) triangles: Vec<[u64; 2]>,
}

impl Counts {
    pub(crate) fn clear(&mut self, blocks: usize, triangles: usize) {
        self.samples.clear();
        self.samples.resize(blocks, [[0; 2]; LANES]);
        self.triangles.clear();
        self.triangles.resize(triangles, [0; 2]);
    }

    /// A block was tested against the triangle of a slot.
    #[cold]
    #[inline(never)]
    pub(crate) fn add(&mut self, slot: u32, block: usize, valid: LaneSet, covered: LaneSet) {
        for (lane, [tested, hits]) in self.samples[block].iter_mut().enumerate() {
            *tested += u32::from(valid >> lane & 1);
            *hits += u32::from(covered >> lane & 1);
        }
        let [tested, hits] = &mut self.triangles[slot as usize - 1];
        *tested += LANES as u64;
        *hits += u64::from(covered.count_ones());
    }
}

/// What a bound did in one pass.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundCounts {
    /// The lattice of the pass.
    pub lattice: UVec2,
    /// How often each sample was tested against a triangle, row by row.
    pub tested: Vec<u32>,
    /// How often it was covered.
    pub covered: Vec<u32>,
    /// Of each triangle that was tested: instance, triangle of its mesh, lanes tested (all of each dispatched 4 × 4
    /// block, idle ones included), samples covered. In the order of the scene.
    pub triangles: Vec<TriangleCount>,
    /// All of it.
    pub work: Work,
}

/// What a bound did for one triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TriangleCount {
    /// Index of the instance in the scene.
    pub instance: u32,
    /// Index of the triangle in its mesh.
    pub triangle: u32,
    /// Lanes tested.
    pub tested: u64,
    /// Samples covered.
    pub covered: u64,
}

/// Draws visibility of pass `pass` with a bound and counts what is tested and what is covered, of each sample and each triangle: sample
/// test efficiency is covered over tested (Friston 2019, §6.1). Hidden triangles are tested like others.
///
/// # Errors
/// As [`visibility`](crate::visibility).
pub fn bound_counts(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    pass: usize,
    bound: Bound,
    options: &RenderOptions,
) -> Result<BoundCounts, RenderError> {
    let mut options = RenderOptions {
        bound: Some(bound),
        ..*options
    };
    options.skip.occluded = false;
    let mut found = BoundCounts {
        lattice: UVec2::ZERO,
        tested: Vec::new(),
        covered: Vec::new(),
        triangles: Vec::new(),
        work: Work::default(),
    };
    count_tests(scene, view, plan, pass, &options, &mut found)?;
    found.triangles.sort_by_key(|t| (t.instance, t.triangle));
    found.triangles.dedup_by(|more, kept| {
        let same = (more.instance, more.triangle) == (kept.instance, kept.triangle);
        if same {
            kept.tested += more.tested;
            kept.covered += more.covered;
        }
        same
    });
    Ok(found)
}

impl BoundCounts {
    /// Adds the counts of a tile whose first sample is `origin`.
    pub(crate) fn add_tile(&mut self, origin: UVec2, size: UVec2, counts: &Counts) {
        for (block, samples) in counts.samples.iter().enumerate() {
            for (lane, [tested, covered]) in samples.iter().enumerate() {
                let [x, y] = position_of(block * LANES + lane);
                if x >= size.x.min(TILE) || y >= size.y.min(TILE) {
                    continue;
                }
                let place = ((origin.y + y) * self.lattice.x + origin.x + x) as usize;
                self.tested[place] += tested;
                self.covered[place] += covered;
            }
        }
    }

    /// Covered over tested, of all triangles; 1 where nothing is tested.
    pub fn efficiency(&self) -> f64 {
        match self.work.samples_tested {
            0 => 1.0,
            tested => self.work.samples_covered as f64 / tested as f64,
        }
    }
}
