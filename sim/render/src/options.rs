use crate::RenderError;

/// How to draw. Nothing here but `near_m` changes the picture. Made by changing the default:
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
}

/// Which instructions the kernels use; the pictures are the same, bit for bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Simd {
    /// The widest that this machine has and the kernels support.
    #[default]
    Auto,
    /// One lane at a time: the specification.
    Scalar,
}

impl Default for RenderOptions {
    /// Widest instructions; near plane at 5 cm; passes are not kept.
    fn default() -> Self {
        Self {
            simd: Simd::Auto,
            near_m: 0.05,
            keep_passes: false,
        }
    }
}

impl RenderOptions {
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        if (1e-4..=1e3).contains(&self.near_m) {
            return Ok(());
        }
        Err(RenderError::OutOfRange {
            field: "near_m",
            value: self.near_m.to_string(),
            valid: "from 0.0001 to 1000 m".into(),
        })
    }
}
