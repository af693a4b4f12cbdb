//! Small vocabulary over lanes. Everything is built from + − × ÷ √, comparison and selection, whose
//! results IEEE 754 defines, so each vector level gives the same bits.

use fearless_simd::prelude::*;
pub use fearless_simd::{f32x4, f32x8, i32x8, mask32x8};

/// A vector level that kernels are compiled for.
pub trait Simd: fearless_simd::Simd {
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
pub fn apart<S: Simd, T>(simd: S, f: impl FnOnce() -> T) -> T {
    simd.vectorize(f)
}

/// Runs `f`, which must be `#[inline(always)]`: in its caller where lanes are vectors, as a function of
/// its own where each of them is eight numbers in memory. There, time to compile grows faster than
/// length (one function of all shading took minutes), and a call costs little beside the work.
#[inline(always)]
pub fn piece<S: Simd, T>(simd: S, f: impl FnOnce() -> T) -> T {
    if S::SCALAR { apart(simd, f) } else { f() }
}

/// Eight lanes of f32.
pub type F<S> = f32x8<S>;

/// Lanes of f32, of any number.
pub trait Float<S: Simd>: SimdFloat<S, Element = f32> {}

impl<S: Simd, V: SimdFloat<S, Element = f32>> Float<S> for V {}

/// `[f(0), f(1)]`. Unlike `array::map`, it is always inlined: what is not runs without the instructions of
/// the kernel that calls it.
#[inline(always)]
pub fn two<T>(f: impl Fn(usize) -> T) -> [T; 2] {
    [f(0), f(1)]
}

/// `[f(0), f(1), f(2)]`; see [`two`].
#[inline(always)]
pub fn three<T>(f: impl Fn(usize) -> T) -> [T; 3] {
    [f(0), f(1), f(2)]
}

/// `v` in every lane.
#[inline(always)]
pub fn splat<S: Simd>(simd: S, v: f32) -> F<S> {
    f32x8::splat(simd, v)
}

/// `a` where `a > b`, else `b` (so NaN in `a` gives `b`).
#[inline(always)]
pub fn max<S: Simd, V: Float<S>>(a: V, b: V) -> V {
    a.simd_gt(b).select(a, b)
}

/// `a` where `a < b`, else `b` (so NaN in `a` gives `b`).
#[inline(always)]
pub fn min<S: Simd, V: Float<S>>(a: V, b: V) -> V {
    a.simd_lt(b).select(a, b)
}

/// Clamps to 0..=1; NaN becomes 0.
#[inline(always)]
pub fn saturate<S: Simd, V: Float<S>>(a: V) -> V {
    let simd = a.token();
    piece(
        simd,
        #[inline(always)]
        || min(max(a, V::splat(simd, 0.0)), V::splat(simd, 1.0)),
    )
}

/// Three numbers from the `k`-th triple on, and one more that is of no use.
#[inline(always)]
pub fn triple<S: Simd>(simd: S, all: &[f32], k: usize) -> f32x4<S> {
    match all.get(3 * k..3 * k + 4) {
        Some(four) => f32x4::from_slice(simd, four),
        None => {
            let [a, b, c] = three(
                #[inline(always)]
                |i| all[3 * k + i],
            );
            f32x4::from_slice(simd, &[a, b, c, c])
        }
    }
}

/// Stores the first three numbers as the `k`-th triple. The fourth spoils the next triple, if there is
/// one: triples are stored from the first to the last.
#[inline(always)]
pub fn put_triple<S: Simd>(all: &mut [f32], k: usize, v: f32x4<S>) {
    match all.get_mut(3 * k..3 * k + 4) {
        Some(out) => v.store_slice(out),
        None => {
            for i in 0..3 {
                all[3 * k + i] = v[i];
            }
        }
    }
}
