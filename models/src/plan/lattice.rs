use glam::{DVec2, UVec2};

use crate::Rect;

/// The index space of a pass's samples. Sample (i, j) sits at (i + ½, j + ½).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Lattice {
    /// A regular grid, width × height.
    Grid(UVec2),
}

/// From lattice to display pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Map {
    /// Scale and shift.
    Affine(Affine),
}

/// display = origin + scale · lattice, per axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Affine {
    /// Display pixel of lattice position (0, 0).
    pub origin: DVec2,
    /// Display pixels per lattice step.
    pub scale: DVec2,
}

impl Lattice {
    /// How many samples.
    pub fn samples(self) -> u64 {
        match self {
            Self::Grid(size) => u64::from(size.x) * u64::from(size.y),
        }
    }
}

impl Affine {
    /// One sample per display pixel.
    pub const IDENTITY: Self = Self {
        origin: DVec2::ZERO,
        scale: DVec2::ONE,
    };

    /// Lattice position to display pixels.
    pub fn display_from_lattice(&self, p: DVec2) -> DVec2 {
        self.origin + self.scale * p
    }

    /// Display pixels to lattice position.
    pub fn lattice_from_display(&self, p: DVec2) -> DVec2 {
        (p - self.origin) / self.scale
    }

    /// The part of the display that a grid of `size` covers.
    pub fn covers(&self, size: UVec2) -> Rect {
        let max = self.display_from_lattice(size.as_dvec2());
        Rect {
            min: self.origin,
            max,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn affine_inverts() {
        let map = Affine {
            origin: DVec2::new(-3.0, 7.5),
            scale: DVec2::new(2.5, 4.0),
        };
        let p = DVec2::new(11.0, -2.0);
        assert_eq!(map.lattice_from_display(map.display_from_lattice(p)), p);
    }
}
