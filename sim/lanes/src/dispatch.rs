use fearless_simd as fs;

use crate::lanes;

/// Which instructions kernels use; results are the same, bit for bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Instructions {
    /// The widest that this machine has and kernels support.
    #[default]
    Auto,
    /// One lane at a time: the specification.
    Scalar,
}

/// A piece of work written once for every vector level. `run` must be `#[inline(always)]`, so that
/// it is compiled for the instructions of its caller.
pub trait Kernel {
    /// What it gives.
    type Output;
    /// Does it, with the instructions of `simd`.
    fn run<S: lanes::Simd>(self, simd: S) -> Self::Output;
}

/// Runs `kernel` at the level asked for, decided at run time.
///
/// Not all levels that the SIMD crate has are compiled: kernels are eight and sixteen lanes wide, which
/// AVX-512 serves whole and AVX2 and NEON in parts, and the fallback is correct everywhere.
pub fn dispatch<K: Kernel>(choice: Instructions, kernel: K) -> K::Output {
    if choice == Instructions::Auto {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            let level = fs::Level::new();
            if let Some(simd) = level.as_avx512() {
                return at(simd, kernel);
            }
            if let Some(simd) = level.as_avx2() {
                return at(simd, kernel);
            }
        }
        #[cfg(target_arch = "aarch64")]
        if let Some(simd) = fs::Level::new().as_neon() {
            return at(simd, kernel);
        }
    }
    at(fs::Fallback::new(), kernel)
}

fn at<S: lanes::Simd, K: Kernel>(simd: S, kernel: K) -> K::Output {
    fs::Simd::vectorize(
        simd,
        #[inline(always)]
        || kernel.run(simd),
    )
}
