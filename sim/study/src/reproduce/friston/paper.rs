//! What Friston et al. 2019 print as numbers; their Figs 12 to 15 are pictures without them.

/// Frames of head motion recorded (§5.2).
pub(super) const HEAD_FRAMES: u32 = 3459;
/// Error of linear prediction (§5.2): translation \[m\], rotation \[deg\].
pub(super) const HEAD_LINEAR: (f64, f64) = (0.001, 0.25);
/// Error of a pose that stays (§5.2): translation \[m\], rotation \[deg\].
pub(super) const HEAD_CONSTANT: (f64, f64) = (0.05, 1.3);
