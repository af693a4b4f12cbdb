//! The vocabulary of what is done block by block: sixteen lanes. Chains of operations are long and wait for one another;
//! twice the lanes of one vector keep a processor busy between them, and with AVX-512 they are one vector.

use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16, u32x16};

pub use crate::lanes::{Simd, apart, max, min, piece, saturate, two};

/// Lanes.
pub const WIDTH: usize = 16;

/// Lanes of f32.
pub type F<S> = f32x16<S>;
/// Lanes of i32.
pub type I<S> = i32x16<S>;
/// Lanes of u32.
pub type U<S> = u32x16<S>;
/// Lanes of truth.
pub type M<S> = mask32x16<S>;

/// Three numbers in each lane: a point, direction or colour.
#[derive(Clone, Copy)]
pub struct V3<S: Simd> {
    /// x, or red.
    pub x: F<S>,
    /// y, or green.
    pub y: F<S>,
    /// z, or blue.
    pub z: F<S>,
}

/// `v` in every lane.
#[inline(always)]
pub fn splat<S: Simd>(simd: S, v: f32) -> F<S> {
    F::splat(simd, v)
}

/// a + t·(b − a): exactly `a` where a = b.
#[inline(always)]
pub fn mix<S: Simd>(a: F<S>, b: F<S>, t: F<S>) -> F<S> {
    piece(
        a.simd,
        #[inline(always)]
        || a + t * (b - a),
    )
}

/// 0 below `low`, 1 above `high`, 3x² − 2x³ between.
#[inline(always)]
pub fn smoothstep<S: Simd>(low: F<S>, high: F<S>, x: F<S>) -> F<S> {
    piece(
        x.simd,
        #[inline(always)]
        || {
            let t = saturate((x - low) / (high - low));
            t * t * (splat(x.simd, 3.0) - t * 2.0)
        },
    )
}

// Functions, not operators: it stays plain to see what must be inlined.
#[expect(clippy::should_implement_trait)]
impl<S: Simd> V3<S> {
    /// `v` in every lane.
    #[inline(always)]
    pub fn splat(simd: S, v: [f32; 3]) -> Self {
        Self {
            x: splat(simd, v[0]),
            y: splat(simd, v[1]),
            z: splat(simd, v[2]),
        }
    }

    /// The sum.
    #[inline(always)]
    pub fn add(self, o: Self) -> Self {
        piece(
            self.x.simd,
            #[inline(always)]
            || Self {
                x: self.x + o.x,
                y: self.y + o.y,
                z: self.z + o.z,
            },
        )
    }

    /// Times a number in each lane.
    #[inline(always)]
    pub fn scale(self, k: F<S>) -> Self {
        piece(
            self.x.simd,
            #[inline(always)]
            || Self {
                x: self.x * k,
                y: self.y * k,
                z: self.z * k,
            },
        )
    }

    /// The product of components.
    #[inline(always)]
    pub fn mul(self, o: Self) -> Self {
        piece(
            self.x.simd,
            #[inline(always)]
            || Self {
                x: self.x * o.x,
                y: self.y * o.y,
                z: self.z * o.z,
            },
        )
    }

    /// [`mix`] of components.
    #[inline(always)]
    pub fn mix(self, o: Self, t: F<S>) -> Self {
        piece(
            self.x.simd,
            #[inline(always)]
            || Self {
                x: mix(self.x, o.x, t),
                y: mix(self.y, o.y, t),
                z: mix(self.z, o.z, t),
            },
        )
    }

    /// The scalar product.
    #[inline(always)]
    pub fn dot(self, o: Self) -> F<S> {
        piece(
            self.x.simd,
            #[inline(always)]
            || self.x * o.x + self.y * o.y + self.z * o.z,
        )
    }

    /// Unit length; zero stays finite.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        piece(
            self.x.simd,
            #[inline(always)]
            || {
                let simd = self.x.simd;
                let length = max(self.dot(self), splat(simd, 1e-30)).sqrt();
                self.scale(splat(simd, 1.0) / length)
            },
        )
    }
}
