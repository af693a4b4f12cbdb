//! What kernel foveated rendering pays in time, and what it costs in error: measured.

mod errors;
mod pair;
mod report;
mod times;

pub use errors::{KernelErrorRow, KernelErrors, KernelRing};
pub use report::KernelMeasured;
pub use times::{KernelTimeRow, KernelTimes, KernelTimings};
pub(crate) use times::{median, one_colour};
