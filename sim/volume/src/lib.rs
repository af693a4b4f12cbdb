//! The ray caster of volumes: light along rays through a [`Volume`](foveasim_assets::Volume), front to back.
//!
//! A [`Caster`] is a volume and a transfer function made ready. [`Caster::cast`] follows rays through any
//! positions of the display, each with its own step; [`Caster::full`] draws every pixel and
//! [`Caster::passes`] the samples of any plan.
//!
//! * Values and gradients (central differences of voxels) are interpolated trilinearly, then the transfer
//!   function is looked up (post-classification), then Phong's model is evaluated.
//! * Opacity is corrected for each ray's own step Δ: α' = 1 − (1 − α)^(Δ/Δ₀) (Bruder et al. 2019 make steps
//!   longer towards the periphery; uncorrected, it would grow dark there).
//! * The k-th sample of a ray lies at k steps from the eye, whatever was skipped before it: leaving out what
//!   is empty changes no bit.
//! * Rays go in packets of sixteen, through one source for every vector width: the same bits from each, and on
//!   any number of threads.
//!
//! # Simplifications
//!
//! One volume, no surfaces in it; light is not held back on its way to a sample (no shadows); the view does
//! not move while it is drawn.

mod caster;
mod cells;
mod corners;
mod error;
mod gradients;
mod image;
mod kernel;
mod levels;
mod options;
mod orbit;
mod packet;
mod table;
mod work;

#[cfg(test)]
mod exact;
#[cfg(test)]
mod tests;

pub use caster::{Caster, Prepared, Ray};
pub use error::CastError;
pub use foveasim_lanes::Instructions;
pub use image::{VolumeFrame, over};
pub use options::{CastOptions, Light, Phong, Storage};
pub use orbit::orbit;
pub use work::CastWork;
