//! Sampling masks that follow the eye (Bruder et al., *Voronoi-Based Foveated Volume Rendering*, 2019).
//!
//! A [`Mask`] says where rays are cast for any gaze: sites on a plane twice the display in each axis, dense in its
//! middle, shifted so that the middle lies where the eye looks. It is built once ([`Mask::build`], or by way of a
//! [`Cache`]) and holds for every one of its pixels the weights with which the sites around it give that pixel.
//! A [`PlacedMask`] is a mask at one gaze: the rays to cast, and the image from what they saw.
//!
//! * Sites: weighted Linde-Buzo-Gray, [`MaskSpec`], [`Convergence`]; in true Morton order.
//! * Weights: [`Delaunay`] gives Sibson's natural-neighbour weights in double precision, [`Weights`] holds them in
//!   16 bits.
//! * [`TemporalMean`]: the mean of the last frames.
//!
//! Everything is a pure function of the specification: results do not depend on the number of threads.
//!
//! # Simplifications
//!
//! A mask moves by whole pixels, so gaze is rounded to the nearest. Density depends on the distance from the gaze on
//! the display, not on where on the display that is.

mod cache;
mod cells;
mod delaunay;
mod error;
mod file;
mod ghosts;
mod lbg;
mod mask;
mod moments;
mod morton;
mod natural;
mod phi;
mod picture;
mod placed;
mod smooth;
mod spec;
mod statistics;
mod step;
mod weights;

pub use cache::{Cache, Cached};
pub use delaunay::Delaunay;
pub use error::MaskError;
pub use lbg::{Convergence, LbgIteration};
pub use mask::Mask;
pub use natural::{NaturalNeighbours, Neighbour};
pub use picture::{cells_picture, order_picture};
pub use placed::PlacedMask;
pub use smooth::TemporalMean;
pub use spec::{Hysteresis, Interpolation, MaskSpec};
pub use statistics::{PairCorrelation, SpacingRing, SpacingStatistics};
pub use step::StepLaw;
pub use weights::{WEIGHT_STEP, Weights};
