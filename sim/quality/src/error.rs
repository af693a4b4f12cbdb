use glam::UVec2;
use thiserror::Error;

/// Why two images cannot be compared.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum QualityError {
    /// The images do not have the same pixels.
    #[error("cannot compare an image of {} x {} with one of {} x {} pixels; sizes must be equal", a.x, a.y, b.x, b.y)]
    SizesDiffer {
        /// Size of the first.
        a: UVec2,
        /// Size of the second.
        b: UVec2,
    },
    /// SSIM's window does not fit.
    #[error("SSIM of an image of {} x {} pixels: both sides must be at least {valid}, the window's", size.x, size.y)]
    TooSmall {
        /// The image's size.
        size: UVec2,
        /// The least width and height.
        valid: u32,
    },
    /// An image has no pixels.
    #[error("an image of {} x {} pixels has nothing to compare", size.x, size.y)]
    Empty {
        /// The image's size.
        size: UVec2,
    },
    /// Not one value per pixel.
    #[error("{given} values for an image of {} x {} pixels; there must be one per pixel", size.x, size.y)]
    Length {
        /// The image's size.
        size: UVec2,
        /// How many values there are.
        given: usize,
    },
    /// A value is NaN or infinite.
    #[error("pixel ({x}, {y}) = {value}: must be a finite number")]
    NotFinite {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// The value.
        value: f64,
    },
    /// Ring edges that are no rings.
    #[error("ring edges {edges:?} [deg]: must be increasing numbers from 0 to below 90")]
    RingEdges {
        /// The edges given \[deg\].
        edges: Vec<f64>,
    },
    /// A gaze that points nowhere.
    #[error("gaze direction {gaze:?}: must be finite and longer than zero")]
    Gaze {
        /// The vector given.
        gaze: [f64; 3],
    },
    /// The image plane and the images do not have the same pixels.
    #[error("a viewport of {} x {} pixels for images of {} x {}; sizes must be equal", viewport.x, viewport.y, images.x, images.y)]
    ViewportDiffers {
        /// The viewport's size.
        viewport: UVec2,
        /// The images' size.
        images: UVec2,
    },
    /// No frame was given.
    #[error("flicker of no frames: at least one must be given")]
    NoFrames,
}
