use std::ops::{Add, Mul, Neg, Sub};

/// f32 or f64: the bound is proved for either, with its own rounding.
pub trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + sealed::Sealed
{
    /// u: the largest relative error of a rounded result, half the distance from 1 to the next number.
    const ROUNDOFF: f64;
    /// What rounding may add besides where results are too small to be normal numbers.
    const UNDERFLOW: f64;

    /// The nearest number.
    fn nearest(x: f64) -> Self;

    /// The same number.
    fn exact(self) -> f64;

    /// The size of a number.
    #[must_use]
    fn size(self) -> Self;

    /// 0.
    fn zero() -> Self {
        Self::nearest(0.0)
    }

    /// A number no smaller than `x` ≥ 0: the nearest one of what is a millionth more.
    fn no_less(x: f64) -> Self {
        Self::nearest(x * (1.0 + 1e-6))
    }
}

impl Real for f32 {
    const ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;
    // 2⁻⁸⁰; see docs/bounds.md, step 8.
    const UNDERFLOW: f64 = 8.271_806_125_530_277e-25;

    fn nearest(x: f64) -> Self {
        x as f32
    }

    fn exact(self) -> f64 {
        f64::from(self)
    }

    fn size(self) -> Self {
        self.abs()
    }
}

impl Real for f64 {
    const ROUNDOFF: f64 = f64::EPSILON / 2.0;
    const UNDERFLOW: f64 = 1e-290;

    fn nearest(x: f64) -> Self {
        x
    }

    fn exact(self) -> f64 {
        self
    }

    fn size(self) -> Self {
        self.abs()
    }
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}
