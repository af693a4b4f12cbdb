use glam::{DMat2, DVec2, UVec2};

use super::{LensMatched, LogPolar, Radial};
use crate::Rect;

/// From lattice to display pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Map {
    /// Scale and shift.
    Affine(Affine),
    /// Rings and spokes about the gaze.
    LogPolar(LogPolar),
    /// Four quadrants whose w grows outwards.
    LensMatched(LensMatched),
    /// A buffer that magnifies the fovea.
    Radial(Radial),
}

/// display = origin + scale · lattice, per axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Affine {
    /// Display pixel of lattice position (0, 0).
    pub origin: DVec2,
    /// Display pixels per lattice step.
    pub scale: DVec2,
}

/// How far apart samples lie at a place, seen from a centre: what a wave along the radius, and one
/// across it, meets. Of the two lattice steps the one that reaches farther along each counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spacing {
    /// Along the radius.
    pub radial: f64,
    /// Across it.
    pub tangential: f64,
}

impl Map {
    /// Lattice position to display pixels.
    pub fn display_from_lattice(&self, p: DVec2) -> DVec2 {
        match self {
            Self::Affine(map) => map.display_from_lattice(p),
            Self::LogPolar(map) => map.display_from_lattice(p),
            Self::LensMatched(map) => map.display_from_lattice(p),
            Self::Radial(map) => map.display_from_lattice(p),
        }
    }

    /// Display pixels to lattice position.
    pub fn lattice_from_display(&self, p: DVec2) -> DVec2 {
        match self {
            Self::Affine(map) => map.lattice_from_display(p),
            Self::LogPolar(map) => map.lattice_from_display(p),
            Self::LensMatched(map) => map.lattice_from_display(p),
            Self::Radial(map) => map.lattice_from_display(p),
        }
    }

    /// Display pixels per lattice step at lattice position `p`: the first column is a step along x, the
    /// second along y (the Jacobian).
    pub fn steps(&self, p: DVec2) -> DMat2 {
        match self {
            Self::Affine(map) => DMat2::from_diagonal(map.scale),
            Self::LogPolar(map) => map.steps(p),
            Self::LensMatched(map) => map.steps(p),
            Self::Radial(map) => map.steps(p),
        }
    }

    /// Spacing of samples \[px\] at lattice position `p` along and across the line from display position
    /// `centre`; at the centre itself, along and across the display's x.
    pub fn spacing(&self, p: DVec2, centre: DVec2) -> Spacing {
        let away = self.display_from_lattice(p) - centre;
        Spacing::of(self.steps(p), away)
    }

    /// Whether the lattice's last row borders on its first.
    pub fn wraps(&self) -> bool {
        matches!(self, Self::LogPolar(_))
    }
}

impl Spacing {
    /// Of a lattice with `steps` at a place that lies in direction `away` (of any length) from the
    /// centre.
    pub fn of(steps: DMat2, away: DVec2) -> Self {
        let along = away.try_normalize().unwrap_or(DVec2::X);
        let reach = |direction: DVec2| {
            let [a, b] = [steps.x_axis, steps.y_axis].map(|step| step.dot(direction).abs());
            a.max(b)
        };
        Self {
            radial: reach(along),
            tangential: reach(along.perp()),
        }
    }

    /// The larger of the two.
    pub fn larger(self) -> f64 {
        self.radial.max(self.tangential)
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

    /// Maps are copied from plans to where samples are placed.
    #[test]
    fn maps_stay_small() {
        assert!(size_of::<Map>() <= 240, "{}", size_of::<Map>());
    }

    #[test]
    fn affine_inverts() {
        let map = Affine {
            origin: DVec2::new(-3.0, 7.5),
            scale: DVec2::new(2.5, 4.0),
        };
        let p = DVec2::new(11.0, -2.0);
        assert_eq!(map.lattice_from_display(map.display_from_lattice(p)), p);
    }

    #[test]
    fn spacing_along_and_across() {
        let map = Map::Affine(Affine {
            origin: DVec2::ZERO,
            scale: DVec2::new(2.0, 4.0),
        });
        let at = |x: f64, y: f64| map.spacing(DVec2::new(x, y), DVec2::ZERO);
        assert_eq!((at(5.0, 0.0).radial, at(5.0, 0.0).tangential), (2.0, 4.0));
        assert_eq!((at(0.0, 5.0).radial, at(0.0, 5.0).tangential), (4.0, 2.0));
        assert_eq!(at(0.0, 0.0), at(5.0, 0.0));
        // Display (8, 8): both steps lie aslant, and the longer one reaches farther along both.
        let aslant = at(4.0, 2.0);
        assert!((aslant.larger() - 8f64.sqrt()).abs() < 1e-12);
        assert!((aslant.radial - aslant.tangential).abs() < 1e-12);
    }
}
