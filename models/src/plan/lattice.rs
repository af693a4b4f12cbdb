use glam::UVec2;

/// The index space of a pass's samples. Sample (i, j) sits at (i + ½, j + ½).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Lattice {
    /// A regular grid, width × height.
    Grid(UVec2),
}

impl Lattice {
    /// How many samples.
    pub fn samples(self) -> u64 {
        match self {
            Self::Grid(size) => u64::from(size.x) * u64::from(size.y),
        }
    }
}
