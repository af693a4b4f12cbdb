use foveasim_models::{Msaa, Shading, ShadingRate, TileRates, Work};
use glam::UVec2;

use crate::group::{Fragment, Groups};
use crate::kernels::Kernel;
use crate::kernels::lanes::Simd;
use crate::tile::{
    ALL, BLOCK, LANES, LaneSet, SampleTile, TILE, TILE_SAMPLES, TileBuffers, index_of, position_of,
};

/// Not crossed by an edge.
const WHOLE: u16 = u16::MAX;

/// What is to be shaded with one material, or as sky.
#[derive(Debug, Default)]
pub(crate) struct Bucket {
    /// Blocks of samples that see this material alone, each sample one triangle.
    pub(crate) blocks: Vec<u16>,
    /// All the rest.
    pub(crate) groups: Groups,
}

/// The work of shading one tile, sorted by material.
#[derive(Debug)]
pub(crate) struct Fragments {
    /// Sky first, then each material of the scene.
    pub(crate) buckets: Vec<Bucket>,
    /// The slots of visible triangles, in the order of slots.
    pub(crate) visible: Vec<u32>,
    /// For each slot that is visible, its place in `visible`.
    pub(crate) of_slot: Vec<u32>,
    /// For each slot, its bucket.
    bucket_of: Vec<u32>,
    /// For each slot, whether it is visible.
    seen: Vec<bool>,
    /// The bucket of all that is visible, if it is one.
    only: Option<u32>,
    /// Samples crossed by an edge: column and row.
    pub(crate) edges: Vec<[u8; 2]>,
    /// For each sample, its place in `edges`.
    edge_of: Vec<u16>,
}

/// How a tile is shaded.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rates<'a>(pub(crate) Option<&'a TileRates>);

impl<'a> Rates<'a> {
    pub(crate) fn of(shading: &'a Shading) -> Self {
        match shading {
            Shading::Coarse(rates) => Self(Some(rates)),
            _ => Self(None),
        }
    }

    fn at(self, sample: UVec2) -> ShadingRate {
        self.0.map_or(ShadingRate::FULL, |rates| rates.rate(sample))
    }
}

impl Fragments {
    pub(crate) fn new(materials: usize) -> Self {
        Self {
            buckets: (0..=materials).map(|_| Bucket::default()).collect(),
            visible: Vec::new(),
            of_slot: Vec::new(),
            bucket_of: Vec::new(),
            seen: Vec::new(),
            only: None,
            edges: Vec::new(),
            edge_of: vec![WHOLE; TILE_SAMPLES],
        }
    }

    /// Which edge sample a sample of the tile is, if it is one.
    #[inline(always)]
    pub(crate) fn edge(&self, x: u32, y: u32) -> Option<usize> {
        let edge = self.edge_of[index_of(x, y)];
        (edge != WHOLE).then_some(edge as usize)
    }

    /// Collects what is visible in a tile.
    #[inline(always)]
    fn collect(&mut self, tile: &SampleTile, c: &Collector<'_>, rates: Rates<'_>, work: &mut Work) {
        for block in 0..c.buffers.valid.len() {
            if c.buffers.valid[block] == 0 && rates.0.is_none() {
                continue;
            }
            let first = UVec2::from(position_of(block * LANES));
            if first.cmpge(tile.size).any() {
                continue;
            }
            match rates.at(tile.origin + first) {
                ShadingRate { x: 1, y: 1 } => self.block(c, block, first, work),
                rate => self.coarse(c, first, rate, work),
            }
        }
        for (bucket, count) in self.buckets.iter_mut().zip(0..) {
            bucket.groups.fill();
            let shaded = bucket.blocks.len() * LANES + bucket.groups.len();
            if count == 0 {
                work.samples_sky += shaded as u64;
            } else {
                work.samples_shaded += shaded as u64;
            }
        }
    }

    /// Forgets the tile before.
    fn clear(&mut self) {
        for bucket in &mut self.buckets {
            bucket.blocks.clear();
            bucket.groups.clear();
        }
        for [x, y] in self.edges.drain(..) {
            self.edge_of[index_of(x.into(), y.into())] = WHOLE;
        }
    }

    /// Finds which of `slots` slots are visible, and their buckets.
    #[inline(always)]
    fn find_visible(&mut self, buffers: &TileBuffers, slots: usize, material: impl Fn(u32) -> u32) {
        // Marks need no branches. Samples that are not drawn were cleared: they show sky.
        self.seen.clear();
        self.seen.resize(slots + 1, false);
        for row in &buffers.slot {
            for &slot in row {
                self.seen[slot as usize] = true;
            }
        }
        self.visible.clear();
        self.of_slot.clear();
        self.of_slot.resize(slots + 1, 0);
        self.bucket_of.clear();
        self.bucket_of.resize(slots + 1, 0);
        for slot in 1..=slots {
            if self.seen[slot] {
                self.of_slot[slot] = self.visible.len() as u32;
                self.bucket_of[slot] = material(slot as u32) + 1;
                self.visible.push(slot as u32);
            }
        }
        let buckets = self
            .visible
            .iter()
            .map(|slot| self.bucket_of[*slot as usize]);
        let first = if self.seen[0] {
            0
        } else {
            self.visible
                .first()
                .map_or(0, |slot| self.bucket_of[*slot as usize])
        };
        self.only = buckets.into_iter().all(|b| b == first).then_some(first);
    }

    /// A block of samples, each shaded by itself.
    #[inline(always)]
    fn block(&mut self, c: &Collector<'_>, block: usize, first: UVec2, work: &mut Work) {
        let positions = c.msaa.positions() as usize;
        let valid = c.buffers.valid[block];
        let slots = &c.buffers.slot[block * positions..(block + 1) * positions];
        let (nearest, others) = (&slots[0], &slots[1..]);
        let mut differ = [0; LANES];
        for row in others {
            for (d, (a, b)) in differ.iter_mut().zip(row.iter().zip(nearest)) {
                *d |= a ^ b;
            }
        }
        let crossed = if c.all_edges && positions > 1 {
            valid
        } else {
            lanes(
                #[inline(always)]
                |lane| differ[lane] != 0,
            ) & valid
        };
        if crossed == 0 && valid == ALL {
            let bucket = self.only.unwrap_or(self.bucket_of[nearest[0] as usize]);
            let alike = self.only.is_some()
                || nearest
                    .iter()
                    .fold(0, |d, slot| d | (self.bucket_of[*slot as usize] ^ bucket))
                    == 0;
            if alike {
                self.buckets[bucket as usize].blocks.push(block as u16);
                return;
            }
        }
        let mut left = valid;
        while left != 0 {
            let lane = left.trailing_zeros();
            left &= left - 1;
            let at = first + UVec2::new(lane % BLOCK[0], lane / BLOCK[0]);
            if crossed >> lane & 1 == 0 {
                let all = (1 << positions) - 1;
                self.push(nearest[lane as usize], at, UVec2::ONE, all, true);
            } else {
                let four = std::array::from_fn(|p| slots[p][lane as usize]);
                self.edge_sample(four, at, work);
            }
        }
    }

    /// A sample that several triangles, or a triangle and the sky, are seen in at its four positions.
    #[inline]
    fn edge_sample(&mut self, slots: [u32; 4], at: UVec2, work: &mut Work) {
        self.mark_edge(at, work);
        let mut left = 0b1111u64;
        while left != 0 {
            let slot = slots[left.trailing_zeros() as usize];
            let seen = (0..4).fold(0, |seen, p| seen | u64::from(slots[p] == slot) << p);
            left &= !seen;
            self.push(slot, at, UVec2::ONE, seen, seen == 0b1111);
        }
    }

    fn mark_edge(&mut self, at: UVec2, work: &mut Work) {
        self.edge_of[index_of(at.x, at.y)] = self.edges.len() as u16;
        self.edges.push([at.x as u8, at.y as u8]);
        work.samples_with_edge += 1;
    }

    /// `every`: seen at all positions of all its samples.
    #[inline(always)]
    fn push(&mut self, slot: u32, first: UVec2, size: UVec2, seen: u64, every: bool) {
        let bucket = self.bucket_of[slot as usize] as usize;
        self.buckets[bucket].groups.push(Fragment {
            name: self.of_slot[slot as usize],
            first: [first.x as u8, first.y as u8],
            size: [size.x as u8, size.y as u8],
            seen,
            beside: !every || size != UVec2::ONE,
        });
    }

    /// The blocks of coarse shading that begin in a block of samples.
    fn coarse(&mut self, c: &Collector<'_>, first: UVec2, rate: ShadingRate, work: &mut Work) {
        let size = UVec2::new(rate.x, rate.y);
        for y in (first.y..first.y + BLOCK[1]).filter(|y| y % rate.y == 0) {
            for x in (first.x..first.x + BLOCK[0]).filter(|x| x % rate.x == 0) {
                self.group(c, UVec2::new(x, y), size, work);
            }
        }
    }

    /// Everything visible in `size` samples from `first` on: one fragment for each triangle.
    fn group(&mut self, c: &Collector<'_>, first: UVec2, size: UVec2, work: &mut Work) {
        let positions = c.msaa.positions() as usize;
        // At most 16 samples of 4 positions.
        let (mut found, mut count) = ([(0u32, 0u64); 64], 0);
        for dy in 0..size.y {
            for dx in 0..size.x {
                let (x, y) = (first.x + dx, first.y + dy);
                if x >= TILE || y >= TILE {
                    continue;
                }
                let index = index_of(x, y);
                let (block, lane) = (index / LANES, index % LANES);
                if c.buffers.valid[block] >> lane & 1 == 0 {
                    continue;
                }
                let sample = (dy * size.x + dx) as usize;
                let mut several = c.all_edges && positions > 1;
                for p in 0..positions {
                    let slot = c.buffers.slot[block * positions + p][lane];
                    let bit = 1 << (sample * positions + p);
                    let place = found[..count].iter().position(|f| f.0 == slot);
                    let place = place.unwrap_or_else(|| {
                        count += 1;
                        count - 1
                    });
                    found[place] = (slot, found[place].1 | bit);
                    several |= slot != c.buffers.slot[block * positions][lane];
                }
                if several {
                    self.mark_edge(UVec2::new(x, y), work);
                }
            }
        }
        for &(slot, seen) in &found[..count] {
            let every = seen == (1 << positions) - 1;
            self.push(slot, first, size, seen, every);
        }
    }
}

/// The lanes that `holds` of.
#[inline(always)]
fn lanes(holds: impl Fn(usize) -> bool) -> LaneSet {
    (0..LANES).fold(0, |set, lane| set | LaneSet::from(holds(lane)) << lane)
}

/// Collects what is visible in a tile of `slots` slots.
pub(crate) struct Collect<'a, M> {
    pub(crate) fragments: &'a mut Fragments,
    pub(crate) tile: &'a SampleTile,
    pub(crate) buffers: &'a TileBuffers,
    pub(crate) msaa: Msaa,
    pub(crate) rates: Rates<'a>,
    /// Whether samples are resolved that no edge crosses.
    pub(crate) all_edges: bool,
    pub(crate) slots: usize,
    /// That of a slot from 1 on.
    pub(crate) material: M,
    pub(crate) work: &'a mut Work,
}

impl<M: Fn(u32) -> u32> Kernel for Collect<'_, M> {
    type Output = ();

    /// Plain loops, which the compiler gives the instructions of the level.
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self {
            fragments, buffers, ..
        } = self;
        fragments.clear();
        fragments.find_visible(buffers, self.slots, self.material);
        let collector = Collector {
            buffers,
            msaa: self.msaa,
            all_edges: self.all_edges,
        };
        fragments.collect(self.tile, &collector, self.rates, self.work);
    }
}

/// What a tile shows.
#[derive(Clone, Copy)]
struct Collector<'a> {
    buffers: &'a TileBuffers,
    msaa: Msaa,
    all_edges: bool,
}
