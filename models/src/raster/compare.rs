use std::ops::AddAssign;

use glam::UVec2;

use super::{Forms, MovingTriangle, Nodes, Outline, PublishedBound, Real, SampleTable, Sampling};

/// What bounds did for triangles, beside a test of every sample.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Comparison {
    /// Samples that the triangles cover.
    pub covered: u64,
    /// The published bounds, in the order of [`PublishedBound::ALL`].
    pub published: [Missed; 3],
    /// Ours.
    pub conservative: Missed,
}

/// What one bound did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Missed {
    /// Lanes of the blocks of 4 × 4 samples that are tested, idle ones included.
    pub tested: u64,
    /// Covered samples that the bound leaves out.
    pub outside: u64,
    /// Those of them that no block tests by chance either.
    pub lost: u64,
    /// Triangles that it does not bound at all, because they reach behind the eye or an edge has no image.
    pub unbounded: u64,
}

impl Missed {
    /// Sample test efficiency: covered over tested; 1 where nothing is tested.
    pub fn efficiency(&self, covered: u64) -> f64 {
        match self.tested {
            0 => 1.0,
            tested => covered as f64 / tested as f64,
        }
    }
}

impl AddAssign for Missed {
    fn add_assign(&mut self, other: Self) {
        self.tested += other.tested;
        self.outside += other.outside;
        self.lost += other.lost;
        self.unbounded += other.unbounded;
    }
}

impl AddAssign for Comparison {
    fn add_assign(&mut self, other: Self) {
        self.covered += other.covered;
        for (sum, more) in self.published.iter_mut().zip(other.published) {
            *sum += more;
        }
        self.conservative += other.conservative;
    }
}

/// Blocks that are tested.
struct Blocks {
    across: u32,
    dispatched: Vec<bool>,
}

/// Samples each way of a block.
const BLOCK: u32 = 4;

impl Blocks {
    fn new(lattice: UVec2) -> Self {
        let blocks = (lattice + (BLOCK - 1)) / BLOCK;
        Self {
            across: blocks.x,
            dispatched: vec![false; (blocks.x * blocks.y) as usize],
        }
    }

    fn of(&mut self, sample: UVec2) -> &mut bool {
        let block = sample / BLOCK;
        &mut self.dispatched[(block.y * self.across + block.x) as usize]
    }

    fn lanes(&self) -> u64 {
        let count = self.dispatched.iter().filter(|d| **d).count();
        count as u64 * u64::from(BLOCK * BLOCK)
    }
}

/// Tests a triangle's every sample, and counts what each bound leaves out of what it covers.
pub fn compare<T: Real>(
    triangle: &MovingTriangle,
    forms: &Forms<T>,
    sampling: &Sampling,
    table: &SampleTable<T>,
    nodes: &Nodes<T>,
) -> Comparison {
    let live: Vec<_> = table
        .block(UVec2::ZERO, table.lattice().max_element())
        .collect();
    let covered: Vec<_> = live
        .iter()
        .filter(|(_, looks)| forms.covers(*looks))
        .map(|(sample, _)| *sample)
        .collect();
    let published = PublishedBound::ALL.map(|bound| {
        let outline = bound.outline(triangle, sampling);
        let mut blocks = Blocks::new(table.lattice());
        let holds = |sample: &UVec2| outline.contains(sample.as_dvec2() + 0.5);
        for (sample, _) in &live {
            *blocks.of(*sample) |= holds(sample);
        }
        let outside = covered.iter().filter(|s| !holds(s)).count() as u64;
        missed(blocks, &covered, outside, outline == Outline::Everything)
    });
    let mut blocks = Blocks::new(table.lattice());
    nodes.visit(forms, |first| *blocks.of(first) = true);
    let mut conservative = missed(blocks, &covered, 0, false);
    // It bounds blocks, not samples.
    conservative.outside = conservative.lost;
    Comparison {
        covered: covered.len() as u64,
        published,
        conservative,
    }
}

fn missed(mut blocks: Blocks, covered: &[UVec2], outside: u64, unbounded: bool) -> Missed {
    let tested = blocks.lanes();
    let lost = covered.iter().filter(|s| !*blocks.of(**s)).count() as u64;
    Missed {
        tested,
        outside,
        lost,
        unbounded: u64::from(unbounded),
    }
}
