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
