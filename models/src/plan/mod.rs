//! [`SamplePlan`] and its parts.

mod count;
mod falloff;
mod lattice;
mod lens_matched;
mod log_polar;
mod map;
mod on_display;
mod pass;
mod radial;
mod region;
mod resolve;
mod shading;
mod spans;

pub use count::{PassCount, PlanCount};
pub use falloff::{Falloff, FalloffTable};
pub use lattice::Lattice;
pub use lens_matched::LensMatched;
pub use log_polar::LogPolar;
pub use map::{Affine, Map, Spacing};
pub use pass::{Cadence, Msaa, Pass, Visibility};
pub use radial::{Radial, Reach};
pub use region::{CellMask, Region};
pub use resolve::{Feather, Filter, Interpolation, Resolve};
pub use shading::{Shading, ShadingRate, TileRates};
pub use spans::Spans;

use glam::{DVec2, UVec2};

use crate::Eye;

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

impl SamplePlan {
    /// Every display pixel sampled once.
    pub fn full(eye: Eye, display_px: UVec2) -> Self {
        let pass = Pass {
            eye,
            lattice: Lattice::Grid(display_px),
            map: Map::Affine(Affine::IDENTITY),
            region: Region::All,
            offset: DVec2::ZERO,
            visibility: Visibility::Own(Msaa::One),
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

    /// The same samples with visibility found at other positions of each.
    #[must_use]
    pub fn with_msaa(mut self, msaa: Msaa) -> Self {
        for pass in &mut self.passes {
            if let Visibility::Own(_) = pass.visibility {
                pass.visibility = Visibility::Own(msaa);
            }
        }
        self
    }

    /// Where a sample of pass `pass` is taken \[display px\]: at its cell's middle, shifted by the
    /// pass's offset; with [`Region::Spans`] no farther out than the display's edge.
    ///
    /// # Panics
    /// If there is no such pass.
    pub fn position(&self, pass: usize, sample: UVec2) -> DVec2 {
        let pass = &self.passes[pass];
        let at = sample.as_dvec2() + 0.5 + pass.offset;
        let place = pass.map.display_from_lattice(at);
        match pass.region {
            Region::Spans(_) => place.clamp(DVec2::ZERO, self.display_px.as_dvec2()),
            _ => place,
        }
    }

    /// Exact counts.
    pub fn count(&self) -> PlanCount {
        let count = |p: &Pass| PassCount {
            samples: p.samples(),
            shadings: p.shadings(),
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
        due.map(Pass::samples).sum()
    }

    /// Evaluations of shading in `frame` (see [`PassCount::shadings`]).
    pub fn shadings_in_frame(&self, frame: u64) -> u64 {
        let due = self.passes.iter().filter(|p| p.cadence.is_due(frame));
        due.map(Pass::shadings).sum()
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
    fn msaa_changes_visibility_alone() {
        let plan = SamplePlan::full(Eye::Cyclopean, UVec2::new(8, 4));
        let four = plan.clone().with_msaa(Msaa::Four);
        assert_eq!(four.passes[0].visibility, Visibility::Own(Msaa::Four));
        assert_eq!(four.count(), plan.count());
        assert_eq!(four.with_msaa(Msaa::One), plan);
    }
}
