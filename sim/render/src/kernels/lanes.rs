//! Small vocabulary over eight lanes. Everything is built from + − × ÷ √, comparison and selection,
//! whose results IEEE 754 defines, so each vector level gives the same bits.

use fearless_simd::prelude::*;
pub(crate) use fearless_simd::{f32x8, i32x8, mask32x8, u32x8};

/// A vector level that kernels are compiled for.
pub(crate) trait Simd: fearless_simd::Simd {
    /// Whether each lane is computed by itself.
    const SCALAR: bool;
}

impl Simd for fearless_simd::Fallback {
    const SCALAR: bool = true;
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
impl Simd for fearless_simd::Avx2 {
    const SCALAR: bool = false;
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
impl Simd for fearless_simd::Avx512 {
    const SCALAR: bool = false;
}

#[cfg(target_arch = "aarch64")]
impl Simd for fearless_simd::Neon {
    const SCALAR: bool = false;
}

/// Runs `f`, which must be `#[inline(always)]`, as a function of its own with the instructions of
/// `simd`: for what is long and called from several places.
#[inline(never)]
pub(crate) fn apart<S: Simd, T>(simd: S, f: impl FnOnce() -> T) -> T {
    simd.vectorize(f)
}

/// Runs `f`, which must be `#[inline(always)]`: in its caller where lanes are vectors, as a function of
/// its own where each of them is eight numbers in memory. There, time to compile grows faster than
/// length (one function of all shading took minutes), and a call costs little beside the work.
#[inline(always)]
pub(crate) fn piece<S: Simd, T>(simd: S, f: impl FnOnce() -> T) -> T {
    if S::SCALAR { apart(simd, f) } else { f() }
}

/// Eight lanes of f32.
pub(crate) type F<S> = f32x8<S>;

/// Three eight-lane numbers: a point, direction or colour.
#[derive(Clone, Copy)]
pub(crate) struct V3<S: Simd> {
    pub(crate) x: F<S>,
    pub(crate) y: F<S>,
    pub(crate) z: F<S>,
}

/// `[f(0), f(1)]`. Unlike `array::map`, it is always inlined: what is not runs without the instructions of
/// the kernel that calls it.
#[inline(always)]
pub(crate) fn two<T>(f: impl Fn(usize) -> T) -> [T; 2] {
    [f(0), f(1)]
}

/// `[f(0), f(1), f(2)]`; see [`two`].
#[inline(always)]
pub(crate) fn three<T>(f: impl Fn(usize) -> T) -> [T; 3] {
    [f(0), f(1), f(2)]
}

#[inline(always)]
pub(crate) fn splat<S: Simd>(simd: S, v: f32) -> F<S> {
    f32x8::splat(simd, v)
}

/// `a` where `a > b`, else `b` (so NaN in `a` gives `b`).
#[inline(always)]
pub(crate) fn max<S: Simd>(a: F<S>, b: F<S>) -> F<S> {
    a.simd_gt(b).select(a, b)
}

/// `a` where `a < b`, else `b` (so NaN in `a` gives `b`).
#[inline(always)]
pub(crate) fn min<S: Simd>(a: F<S>, b: F<S>) -> F<S> {
    a.simd_lt(b).select(a, b)
}

/// Clamps to 0..=1; NaN becomes 0.
#[inline(always)]
pub(crate) fn saturate<S: Simd>(a: F<S>) -> F<S> {
    let simd = a.token_of();
    min(max(a, splat(simd, 0.0)), splat(simd, 1.0))
}

/// a + t·(b − a): exactly `a` where a = b.
#[inline(always)]
pub(crate) fn mix<S: Simd>(a: F<S>, b: F<S>, t: F<S>) -> F<S> {
    a + t * (b - a)
}

/// 0 below `low`, 1 above `high`, 3x² − 2x³ between.
#[inline(always)]
pub(crate) fn smoothstep<S: Simd>(low: F<S>, high: F<S>, x: F<S>) -> F<S> {
    let t = saturate((x - low) / (high - low));
    t * t * (splat(x.token_of(), 3.0) - t * 2.0)
}

/// Where the lane's SIMD token is.
pub(crate) trait TokenOf<S> {
    fn token_of(self) -> S;
}

impl<S: Simd> TokenOf<S> for F<S> {
    #[inline(always)]
    fn token_of(self) -> S {
        self.simd
    }
}

impl<S: Simd> V3<S> {
    #[inline(always)]
    pub(crate) fn splat(simd: S, v: [f32; 3]) -> Self {
        Self {
            x: splat(simd, v[0]),
            y: splat(simd, v[1]),
            z: splat(simd, v[2]),
        }
    }

    #[inline(always)]
    pub(crate) fn add(self, o: Self) -> Self {
        Self {
            x: self.x + o.x,
            y: self.y + o.y,
            z: self.z + o.z,
        }
    }

    #[inline(always)]
    pub(crate) fn scale(self, k: F<S>) -> Self {
        Self {
            x: self.x * k,
            y: self.y * k,
            z: self.z * k,
        }
    }

    #[inline(always)]
    pub(crate) fn mul(self, o: Self) -> Self {
        Self {
            x: self.x * o.x,
            y: self.y * o.y,
            z: self.z * o.z,
        }
    }

    #[inline(always)]
    pub(crate) fn mix(self, o: Self, t: F<S>) -> Self {
        Self {
            x: mix(self.x, o.x, t),
            y: mix(self.y, o.y, t),
            z: mix(self.z, o.z, t),
        }
    }

    #[inline(always)]
    pub(crate) fn dot(self, o: Self) -> F<S> {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    /// Unit length; zero stays finite.
    #[inline(always)]
    pub(crate) fn normalize(self) -> Self {
        let simd = self.x.simd;
        let length = max(self.dot(self), splat(simd, 1e-30)).sqrt();
        self.scale(splat(simd, 1.0) / length)
    }
}
