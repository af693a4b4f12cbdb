//! Numbers in lanes: hot loops are written once, as a [`Kernel`], and run at the widest level that the machine has.
//!
//! * Kernels use + − × ÷ √, comparison and selection alone (no fused products, no estimates), so that every level gives
//!   the same bits; one lane at a time is the specification.
//! * Closures and functions of a kernel must be `#[inline(always)]`, and `array::map` is not used: what is not inlined
//!   runs without the instructions of its level.
//! * [`lanes`] holds what is eight or any number wide, [`wide`] what is sixteen, [`transcendental`] the functions that
//!   processors do not define.

mod dispatch;
pub mod lanes;
pub mod transcendental;
pub mod wide;

pub use dispatch::{Instructions, Kernel, dispatch};
pub use fearless_simd::prelude;
