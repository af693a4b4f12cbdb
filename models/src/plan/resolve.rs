use glam::DVec3;

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
    /// Where several samples fall into a pixel it is their mean (from a mip chain of the lattice, by how
    /// many along each axis) instead of what lies at its middle.
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
