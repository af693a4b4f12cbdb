use std::path::PathBuf;

use foveasim_models::ModelError;
use thiserror::Error;

/// Why there is no mask, or no image from it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MaskError {
    /// A number that no mask can be built from.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Two sites at one place, or fewer than a triangle needs.
    #[error("{sites} sites cannot be triangulated: {reason}")]
    Sites {
        /// How many there are.
        sites: usize,
        /// What is wrong.
        reason: String,
    },
    /// Not one value per ray, or not one colour per pixel.
    #[error("{given} {what}; there must be {wanted}")]
    Length {
        /// What was counted.
        what: &'static str,
        /// How many there are.
        given: usize,
        /// How many there must be.
        wanted: usize,
    },
    /// A file that cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file that is no mask, or none of this specification.
    #[error("{}: {reason}", path.display())]
    Damaged {
        /// Which.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
}
