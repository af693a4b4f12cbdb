use std::num::NonZeroU32;

use glam::{DVec2, DVec3, UVec2};

use crate::{Eye, Rect};

/// Where a foveation method puts its samples: data, not code in a renderer. The same plan is counted
/// and drawn, so prediction and picture cannot drift apart.
#[derive(Debug, Clone, PartialEq)]
pub struct SamplePlan {
    /// The method that made it, as users write it (`layers:3`).
    pub method: String,
    /// The image it is for.
    pub display_px: UVec2,
    /// What is sampled, innermost first.
    pub passes: Vec<Pass>,
    /// How the passes become the displayed image.
    pub resolve: Resolve,
}

/// One set of samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Pass {
    /// Whose image.
    pub eye: Eye,
    /// How many samples, and how they are ordered.
    pub lattice: Lattice,
    /// Where they lie on the display.
    pub map: Map,
    /// How visibility is found for them.
    pub visibility: Visibility,
    /// Where shading is evaluated.
    pub shading: Shading,
    /// In which frames.
    pub cadence: Cadence,
}

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

/// How visibility is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Visibility {
    /// At each sample of the pass.
    Own,
}

/// Where shading is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Shading {
    /// Once for each visible sample.
    PerSample,
}

/// In which frames a pass is drawn: those with `frame % every == phase` (a phase from `every` on is
/// never due).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cadence {
    /// One frame in this many.
    pub every: NonZeroU32,
    /// Which one.
    pub phase: u32,
}

/// How passes become the displayed image.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Resolve {
    /// The only pass is the image, sample for pixel.
    Direct,
    /// Passes are interpolated bilinearly and blended by eccentricity.
    Feather(Feather),
}

/// Circular blending masks about the gaze (Guenter 2012, Fig. 3), measured by the tangent of
/// eccentricity so that no inverse trigonometry is needed per pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Feather {
    /// Unit gaze direction, eye frame.
    pub gaze: DVec3,
    /// For each pass but the last: tangents of the eccentricity where its weight begins to fall from
    /// one, and where it reaches zero (smoothstep between).
    pub edges_tan: Vec<[f64; 2]>,
}

/// Samples of one pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PassCount {
    /// Samples each time it is drawn.
    pub samples: u64,
    /// One frame in this many.
    pub every: u32,
}

/// Exact sample counts of a plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanCount {
    /// Per pass, in the plan's order.
    pub passes: Vec<PassCount>,
    /// Pixels of the image the plan is for.
    pub display_pixels: u64,
}

impl Cadence {
    /// Every frame.
    pub const EVERY_FRAME: Self = Self {
        every: NonZeroU32::MIN,
        phase: 0,
    };

    /// Whether the pass is drawn in `frame`.
    pub fn is_due(self, frame: u64) -> bool {
        frame % u64::from(self.every.get()) == u64::from(self.phase)
    }
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

impl SamplePlan {
    /// Every display pixel sampled once.
    pub fn full(eye: Eye, display_px: UVec2) -> Self {
        let pass = Pass {
            eye,
            lattice: Lattice::Grid(display_px),
            map: Map::Affine(Affine::IDENTITY),
            visibility: Visibility::Own,
            shading: Shading::PerSample,
            cadence: Cadence::EVERY_FRAME,
        };
        Self {
            method: "full".into(),
            display_px,
            passes: vec![pass],
            resolve: Resolve::Direct,
        }
    }

    /// Exact counts.
    pub fn count(&self) -> PlanCount {
        let count = |p: &Pass| PassCount {
            samples: p.lattice.samples(),
            every: p.cadence.every.get(),
        };
        PlanCount {
            passes: self.passes.iter().map(count).collect(),
            display_pixels: u64::from(self.display_px.x) * u64::from(self.display_px.y),
        }
    }

    /// Samples drawn in `frame`.
    pub fn samples_in_frame(&self, frame: u64) -> u64 {
        let due = self.passes.iter().filter(|p| p.cadence.is_due(frame));
        due.map(|p| p.lattice.samples()).sum()
    }
}

impl PlanCount {
    /// Samples when every pass is drawn.
    pub fn samples(&self) -> u64 {
        self.passes.iter().map(|p| p.samples).sum()
    }

    /// Samples per frame on average, each pass at its own cadence.
    pub fn samples_staggered(&self) -> f64 {
        self.passes
            .iter()
            .map(|p| p.samples as f64 / f64::from(p.every))
            .sum()
    }

    /// Display pixels per sample: how many times fewer samples than full resolution.
    pub fn ratio(&self) -> f64 {
        self.display_pixels as f64 / self.samples() as f64
    }

    /// Display pixels per sample drawn, each pass at its own cadence.
    pub fn ratio_staggered(&self) -> f64 {
        self.display_pixels as f64 / self.samples_staggered()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_counts_every_pixel() {
        let plan = SamplePlan::full(Eye::Cyclopean, UVec2::new(1920, 1080));
        assert_eq!(plan.count().samples(), 1920 * 1080);
        assert_eq!(plan.count().ratio(), 1.0);
        assert_eq!(plan.samples_in_frame(3), 1920 * 1080);
    }

    #[test]
    fn frames_in_which_a_pass_is_due() {
        let due = |every, phase| {
            let cadence = Cadence {
                every: NonZeroU32::new(every).unwrap(),
                phase,
            };
            (0..6).filter(|f| cadence.is_due(*f)).collect::<Vec<_>>()
        };
        assert_eq!(due(1, 0), [0, 1, 2, 3, 4, 5]);
        assert_eq!(due(3, 1), [1, 4]);
        assert_eq!(due(2, 2), [0; 0]);
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
}
