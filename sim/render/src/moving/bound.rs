use std::str::FromStr;

use foveasim_models::raster::{MovingTriangle, Outline, PublishedBound, Sampling};
use foveasim_models::{ModelError, unknown_name};
use glam::{DVec2, UVec2};

use crate::tile::{BLOCK, BLOCKS_ACROSS, LANES, LaneSet, TILE};

/// Which blocks of samples are tested against a moving triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Bound {
    /// Those that [`foveasim_models::raster::Node`] leaves: none with a covered sample is left out.
    #[default]
    Conservative,
    /// Those with a sample in the box around the bent edges (Friston 2019, §4).
    Box,
    /// Those with a sample in the polygon displaced from unbent edges (§4.1).
    Simple,
    /// Those with a sample in the polygon displaced from the lines between bent edges' ends (§4.2).
    Adaptive,
    /// All there are: what the others are held against.
    Everything,
}

impl Bound {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Box,
        Self::Simple,
        Self::Adaptive,
        Self::Conservative,
        Self::Everything,
    ];

    /// Their names, as users write them, in the order of [`Bound::ALL`].
    pub const NAMES: [&str; 5] = ["box", "simple", "adaptive", "conservative", "everything"];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Simple => "simple",
            Self::Adaptive => "adaptive",
            Self::Conservative => "conservative",
            Self::Everything => "everything",
        }
    }

    /// Whether it leaves a part of the lattice for each triangle, instead of asking blocks.
    pub(crate) fn is_outlined(self) -> bool {
        self != Self::Conservative
    }

    /// What it leaves of the lattice for a triangle.
    pub(crate) fn outline(self, t: &MovingTriangle, sampling: &Sampling) -> Outline {
        let published = match self {
            Self::Conservative | Self::Everything => return Outline::Everything,
            Self::Box => PublishedBound::Box,
            Self::Simple => PublishedBound::Simple,
            Self::Adaptive => PublishedBound::Adaptive,
        };
        published.outline(t, sampling)
    }
}

impl FromStr for Bound {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        let found = Self::ALL.into_iter().find(|bound| bound.name() == text);
        found.ok_or_else(|| unknown_name("bound", text, &Self::NAMES))
    }
}

/// What a published bound leaves of a tile, triangle by triangle.
#[derive(Debug, Default)]
pub(crate) struct Outlines {
    /// Where the blocks of each triangle begin.
    first: Vec<u32>,
    blocks: Vec<u8>,
}

impl Outlines {
    /// Forgets all.
    pub(crate) fn clear(&mut self) {
        self.first.clear();
        self.first.push(0);
        self.blocks.clear();
    }

    /// The blocks of the `index`-th triangle.
    pub(crate) fn blocks(&self, index: usize) -> impl Iterator<Item = u8> + use<'_> {
        let range = self.first[index] as usize..self.first[index + 1] as usize;
        self.blocks[range].iter().copied()
    }

    /// Adds the blocks of a tile from lattice position `origin` on that have a valid sample within an outline.
    pub(crate) fn push(&mut self, outline: &Outline, origin: UVec2, valid: &[LaneSet]) {
        let origin = origin.as_dvec2();
        let all = [[0, BLOCKS_ACROSS]; 2];
        let range = match outline {
            Outline::Nothing => [[0, 0]; 2],
            Outline::Polygon(corners) => {
                let low = corners.iter().fold(DVec2::INFINITY, |m, p| m.min(*p)) - origin;
                let high = corners.iter().fold(DVec2::NEG_INFINITY, |m, p| m.max(*p)) - origin;
                [0, 1].map(|k| {
                    let block = f64::from(BLOCK[k]);
                    let end = f64::from(TILE);
                    let first = (low[k].clamp(0.0, end) / block).floor() as u32;
                    [first, (high[k].clamp(0.0, end) / block).ceil() as u32]
                })
            }
            _ => all,
        };
        for y in range[1][0]..range[1][1] {
            for x in range[0][0]..range[0][1] {
                let block = (y * BLOCKS_ACROSS + x) as usize;
                let holds = |lane: usize| {
                    let lane = lane as u32;
                    let sample = UVec2::new(x * BLOCK[0] + lane % 4, y * BLOCK[1] + lane / 4);
                    outline.contains(origin + sample.as_dvec2() + 0.5)
                };
                if (0..LANES).any(|lane| valid[block] >> lane & 1 != 0 && holds(lane)) {
                    self.blocks.push(block as u8);
                }
            }
        }
        self.first.push(self.blocks.len() as u32);
    }
}
