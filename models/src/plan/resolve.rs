use std::str::FromStr;

use glam::DVec3;

use crate::{ModelError, unknown_name};

/// How passes become the displayed image.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Resolve {
    /// The only pass is the image, sample for pixel.
    Direct,
    /// Passes are interpolated bilinearly and blended by eccentricity.
    Feather(Feather),
    /// Each pixel comes from the first pass that has a live sample whose cell holds it, interpolated
    /// bilinearly; where a neighbour is not live, the sample that holds the pixel stands for it.
    Mosaic,
    /// Each pixel looks its samples up in the last pass by the inverse of that pass's map.
    Inverse(Filter),
}

/// How a pixel is put together from the samples around its place in a lattice. Only live samples count,
/// with what is left of the weights scaled up to one; the sample whose cell holds the pixel is always
/// live. Rows wrap where the map does ([`Map::wraps`](super::Map::wraps)); elsewhere, and towards the gaze,
/// reading clamps to the lattice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filter {
    /// Between samples.
    pub interpolation: Interpolation,
    /// Against flicker and stair-steps in the periphery: from this lattice column on, samples are first
    /// smoothed with their neighbours by the 3 × 3 Gaussian (1 2 1)·(1 2 1)/16.
    pub smooth_from: Option<u32>,
    /// Where several samples fall into a pixel it is their mean instead of what lies at its middle: of a log-polar
    /// lattice by how many there are along each axis, of a radial one from a chain of halved copies, linearly between
    /// the two whose samples lie just closer than pixels and just farther apart.
    pub mips: bool,
}

/// What stands between samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interpolation {
    /// The sample whose cell holds the pixel.
    Nearest,
    /// The four around it, bilinearly.
    #[default]
    Bilinear,
    /// The sixteen around it by Catmull-Rom weights (Keys 1981), no less than zero; bilinearly where one of them is not
    /// live. Linear in lattice position where the samples are.
    Cubic,
    /// Those near it on the display, by where on the display they are (Friston 2019, §3.1.1): a kernel as wide as a
    /// pixel, or as the samples' spacing where that is more, along each direction. What `mips` and `smooth_from` are for
    /// is part of it.
    Gather,
}

impl Interpolation {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Nearest, Self::Bilinear, Self::Cubic, Self::Gather];

    /// As users write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nearest => "nearest",
            Self::Bilinear => "bilinear",
            Self::Cubic => "cubic",
            Self::Gather => "gather",
        }
    }
}

impl FromStr for Interpolation {
    type Err = ModelError;

    /// Reads a [name](Interpolation::name).
    fn from_str(text: &str) -> Result<Self, ModelError> {
        let found = Self::ALL.into_iter().find(|i| i.name() == text);
        found.ok_or_else(|| unknown_name("filter", text, &Self::ALL.map(Self::name)))
    }
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
