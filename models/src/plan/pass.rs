use std::num::NonZeroU32;

use glam::DVec2;

use super::{Lattice, Map, Region, Shading};
use crate::Eye;

/// One set of samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Pass {
    /// Whose image.
    pub eye: Eye,
    /// How many samples, and how they are ordered.
    pub lattice: Lattice,
    /// Where they lie on the display.
    pub map: Map,
    /// Which of the lattice's samples are drawn.
    pub region: Region,
    /// Where in its cell each sample is taken: a shift from the middle, in lattice steps, each part from
    /// −½ to ½. It stands for the whole cell all the same, so reconstruction takes it to be in the
    /// middle. Jitter is a shift that changes from frame to frame (Guenter 2012, §4.2).
    pub offset: DVec2,
    /// How visibility is found for them.
    pub visibility: Visibility,
    /// Where shading is evaluated.
    pub shading: Shading,
    /// In which frames.
    pub cadence: Cadence,
}

/// How visibility is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Visibility {
    /// For each sample of the pass, at one or more positions in its cell.
    Own(Msaa),
    /// By an earlier pass of the plan (its index): a sample sees what the sample of that pass does whose
    /// cell holds it. Published kernel foveated rendering finds visibility at full resolution and shades
    /// log-polar texels.
    Shared(usize),
}

/// Multisample antialiasing: at how many positions of a sample's cell visibility is found. Shading is
/// evaluated once for each triangle that is visible at any of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Msaa {
    /// In the middle.
    #[default]
    One,
    /// At four, on a rotated grid.
    Four,
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

impl Pass {
    /// How many samples are drawn: the live ones.
    pub fn live(&self) -> u64 {
        match &self.region {
            Region::All => self.lattice.samples(),
            Region::Cells(mask) => mask.samples(),
            Region::Spans(spans) => spans.samples(),
        }
    }

    /// For how many samples visibility is found: the live ones, or none if another pass finds it.
    pub fn samples(&self) -> u64 {
        match self.visibility {
            Visibility::Own(_) => self.live(),
            Visibility::Shared(_) => 0,
        }
    }

    /// At most how often shading is evaluated where no sample shows two triangles.
    pub fn shadings(&self) -> u64 {
        match (&self.shading, &self.region) {
            (Shading::Nowhere, _) => 0,
            (Shading::PerSample, _) => self.live(),
            (Shading::Coarse(rates), Region::All) => rates.blocks(),
            (Shading::Coarse(rates), region) => rates.blocks_where(|s| region.is_live(s)),
        }
    }
}

impl Msaa {
    /// Positions of visibility per sample.
    pub fn positions(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Four => 4,
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
