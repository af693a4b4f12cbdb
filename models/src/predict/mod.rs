//! Head pose for a time to come.

mod double_exponential;
mod head;
mod kalman;
mod motion;

pub use head::{HeadPredictor, HeadTracker};
pub use kalman::KalmanNoise;
pub use motion::{Motion, Twist};
