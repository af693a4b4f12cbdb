//! How close a picture is to its reference: SSIM, PSNR and brightness bias, over the whole image and
//! by ring of eccentricity; and how much of the difference flickers from frame to frame.
//!
//! [`compare()`] does all of it for two rendered images; [`ssim()`] and [`mse`] work on raw [`Plane`]s;
//! [`Flicker`] takes a sequence of them frame by frame, [`FollowedFlicker`] the same at points that move.
//! Everything is measured on 8-bit sRGB code values (peak 255), as the image-quality literature does,
//! and everything is a pure function: no result depends on the number of threads.
//!
//! # Simplifications
//!
//! SSIM knows nothing of where the viewer looks; the rings say where a difference lies, not whether
//! it is seen. Colour is judged by PSNR over RGB only; SSIM sees luma.

mod compare;
mod error;
mod flicker;
mod followed;
mod plane;
mod psnr;
mod rings;
mod ssim;

pub use compare::{Comparison, Measures, compare};
pub use error::QualityError;
pub use flicker::{Flicker, FlickerMap, RingFlicker};
pub use followed::{FollowedFlicker, FollowedMap};
pub use plane::Plane;
pub use psnr::{PEAK, mse, psnr_db};
pub use rings::{RingQuality, Rings};
pub use ssim::{Ssim, WINDOW, ssim, ssim_by_definition};
