use std::str::FromStr;

use foveasim_assets::{Detail, LodRule};
use foveasim_models::{ModelError, unknown_name};

pub use foveasim_lanes::Instructions as Simd;

use crate::{Bound, Lighting, RenderError};

/// How to draw. Nothing here but `near_m`, `lod`, `lod_error`, `footprint`, `lighting`, `skip.back_faces`, `bound` and
/// `rolling_shading` changes the picture. Made by changing the default:
/// `RenderOptions { simd, ..RenderOptions::default() }`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderOptions {
    /// Which instructions the kernels use.
    pub simd: Simd,
    /// Nothing nearer than this is drawn \[m\], measured along the view axis.
    pub near_m: f64,
    /// Whether the frame keeps the samples of its passes beside its image, for what is made of them
    /// later. They can take several times the memory of the image; by default they are dropped.
    pub keep_passes: bool,
    /// Which of an instance's levels of detail is drawn. Coarser ones change the picture, within the bounds
    /// that [`LodRule`] gives.
    pub lod: LodRule,
    /// By how many samples a level chosen by [`LodRule::Footprint`] may be off the shape: 1/64 to 16.
    pub lod_error: f64,
    /// Over how much of what it stands for a sample's shading averages, along each side: 1 is all. Below 1
    /// there is more detail and more aliasing, as with a negative mip bias: 1/16 to 4.
    pub footprint: f64,
    /// Light beyond a sun and an even sky.
    pub lighting: Lighting,
    /// What is left out because the picture does not need it.
    pub skip: Skip,
    /// Which bound finds the samples to be tested of moving triangles. Without one, passes of which nothing moves and no lens
    /// is before the display are drawn from snapped triangles, others with [`Bound::Conservative`]. Asked for, a
    /// bound is used for all passes: published ones may miss samples.
    pub bound: Option<Bound>,
    /// On a rolling display, whether each sample is shaded as seen from where the eye is at its own time, with
    /// the normal that the surface has then; else from where it was at the scan's start, as an image is that was warped afterwards.
    pub rolling_shading: bool,
}

/// Work that a picture does not need, each part to be left out or done all the same: for measuring what
/// leaving it out saves. All are left out by default.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Skip {
    /// Triangles seen from behind. Open surfaces lose their backs, unless their instance is
    /// [`two_sided`](foveasim_assets::Instance::two_sided); closed ones look the same without, but for
    /// samples on their outlines: where a surface turns away, its back begins at the very depth of its
    /// front, and snapping (by up to 1/512 of a sample) decides which of the two neighbours is nearer.
    pub back_faces: bool,
    /// Instances whose bounds lie outside the view of a pass. The picture is the same, bit for bit.
    pub outside: bool,
    /// Triangles behind all that a tile, or one of its cells of 8 × 8 samples, shows already. The
    /// picture is the same, bit for bit.
    pub occluded: bool,
    /// Samples that inner layers hide. The picture is the same, bit for bit.
    pub hidden: bool,
    /// Transforming vertices for each pass anew. The picture is the same, bit for bit.
    pub repeated_vertices: bool,
    /// Resolving samples that no edge crosses, where samples have several positions of visibility. The
    /// picture is the same, bit for bit.
    pub whole_samples: bool,
    /// Choosing objects and transforming vertices for each of two eyes anew
    /// (see [`render_stereo`](crate::render_stereo)). The pictures are the same, bit for bit.
    pub repeated_for_eyes: bool,
}

impl Skip {
    /// Everything that can be left out.
    pub const ALL: Self = Self {
        back_faces: true,
        outside: true,
        occluded: true,
        hidden: true,
        repeated_vertices: true,
        whole_samples: true,
        repeated_for_eyes: true,
    };
    /// Nothing.
    pub const NONE: Self = Self {
        back_faces: false,
        outside: false,
        occluded: false,
        hidden: false,
        repeated_vertices: false,
        whole_samples: false,
        repeated_for_eyes: false,
    };

    /// The parts' names, as users write them.
    pub const NAMES: [&str; 7] = [
        "back-faces",
        "outside",
        "occluded",
        "hidden",
        "repeated-vertices",
        "whole-samples",
        "repeated-for-eyes",
    ];

    fn part(&mut self, name: &str) -> Option<&mut bool> {
        Some(match name {
            "back-faces" => &mut self.back_faces,
            "outside" => &mut self.outside,
            "occluded" => &mut self.occluded,
            "hidden" => &mut self.hidden,
            "repeated-vertices" => &mut self.repeated_vertices,
            "whole-samples" => &mut self.whole_samples,
            "repeated-for-eyes" => &mut self.repeated_for_eyes,
            _ => return None,
        })
    }
}

impl FromStr for Skip {
    type Err = ModelError;

    /// Reads `all`, `none`, or [names](Self::NAMES) of what is left out, separated by commas.
    fn from_str(text: &str) -> Result<Self, ModelError> {
        match text {
            "all" => return Ok(Self::ALL),
            "none" => return Ok(Self::NONE),
            _ => {}
        }
        let mut skip = Self::NONE;
        for name in text.split(',').map(str::trim) {
            match skip.part(name) {
                Some(part) => *part = true,
                None => return Err(unknown_name("part to skip", name, &VALID)),
            }
        }
        Ok(skip)
    }
}

/// What a list of parts to skip is made of.
const VALID: [&str; Skip::NAMES.len() + 2] = {
    let [a, b, c, d, e, f, g] = Skip::NAMES;
    ["all", "none", a, b, c, d, e, f, g]
};

impl Default for Skip {
    fn default() -> Self {
        Self::ALL
    }
}

impl Default for RenderOptions {
    /// Widest instructions; near plane at 5 cm; shading averages over whole samples; passes are not kept.
    fn default() -> Self {
        Self {
            simd: Simd::Auto,
            near_m: 0.05,
            keep_passes: false,
            lod: LodRule::default(),
            lod_error: Detail::ERROR_SAMPLES,
            footprint: 1.0,
            lighting: Lighting::default(),
            skip: Skip::ALL,
            bound: None,
            rolling_shading: true,
        }
    }
}

impl RenderOptions {
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let out_of_range = |field, value: f64, valid: &str| {
            Err(RenderError::OutOfRange {
                field,
                value: value.to_string(),
                valid: valid.into(),
            })
        };
        if !(1e-4..=1e3).contains(&self.near_m) {
            return out_of_range("near_m", self.near_m, "from 0.0001 to 1000 m");
        }
        if !(0.015625..=16.0).contains(&self.lod_error) {
            return out_of_range("lod_error", self.lod_error, "from 1/64 to 16 samples");
        }
        if !(0.0625..=4.0).contains(&self.footprint) {
            return out_of_range("footprint", self.footprint, "from 1/16 to 4 samples");
        }
        self.lighting.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_skipped_by_name() {
        assert_eq!("all".parse(), Ok(Skip::ALL));
        assert_eq!("none".parse(), Ok(Skip::NONE));
        assert_eq!(Skip::NAMES.join(",").parse(), Ok(Skip::ALL));
        let two = Skip {
            hidden: true,
            occluded: true,
            ..Skip::NONE
        };
        assert_eq!("hidden, occluded".parse(), Ok(two));
        for wrong in ["", "hiden", "hidden,", "all,hidden"] {
            assert!(wrong.parse::<Skip>().is_err(), "{wrong:?}");
        }
        let error = "hiden".parse::<Skip>().unwrap_err().to_string();
        assert!(error.contains("did you mean `hidden`?"), "{error}");
    }
}
