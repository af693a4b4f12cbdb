//! Which samples of a warped lattice a moving triangle may cover, in closed form.
//!
//! Perceptual rasterization (Friston 2019) samples a moving scene at places and times that are no plain
//! grid: magnified at the fovea, seen through a lens, rolling with the display. [`Sampling`] says where and when a sample
//! looks. Whether a triangle covers it is decided sample by sample ([`Forms::covers`]); what makes that affordable is
//! a bound that leaves out most samples:
//!
//! * [`PublishedBound`]: the paper's three, from displaced edges ([`Zenon`] says where corners go). They can
//!   miss samples, which [`compare`] counts;
//! * [`Nodes`]: ours, from blocks of samples. It is proved not to miss any, rounding included: `docs/bounds.md`.
//!
//! This is the mathematics in f64 and, where kernels will use it, in f32; it draws nothing.

mod compare;
mod forms;
mod moving;
mod node;
mod nodes;
mod outline;
mod published;
mod real;
mod sampling;
mod table;
mod zenon;

pub use compare::{Comparison, Missed, compare};
pub use forms::{Facing, Forms};
pub use moving::{MovingPoint, MovingTriangle};
pub use node::Node;
pub use nodes::{Nodes, Visits};
pub use outline::Outline;
pub use published::PublishedBound;
pub use real::Real;
pub use sampling::{RaySample, Sampling};
pub use table::SampleTable;
pub use zenon::{Catches, Zenon};
