use std::cell::RefCell;
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

use astro_float::{BigFloat, Consts, RoundingMode};

/// Bits: more than three times those of f64, so that what cancels is still known to more digits than f64 has.
const BITS: usize = 256;
const ROUND: RoundingMode = RoundingMode::ToEven;

thread_local! {
    /// π, ln 2 and so on, to as many digits as were needed so far.
    static CONSTANTS: RefCell<Consts> =
        RefCell::new(Consts::new().expect("memory for a few constants"));
}

fn with_constants<T>(f: impl FnOnce(&mut Consts) -> T) -> T {
    CONSTANTS.with(|constants| f(&mut constants.borrow_mut()))
}

/// A number of many digits.
#[derive(Debug, Clone)]
pub(super) struct Big(BigFloat);

impl Big {
    pub(super) fn new(value: f64) -> Self {
        Self(BigFloat::from_f64(value, BITS))
    }

    pub(super) fn int(value: i128) -> Self {
        Self(BigFloat::from_i128(value, BITS))
    }

    pub(super) fn pi() -> Self {
        Self(with_constants(|c| c.pi(BITS, ROUND)))
    }

    pub(super) fn sqrt(&self) -> Self {
        Self(self.0.sqrt(BITS, ROUND))
    }

    pub(super) fn tan(&self) -> Self {
        Self(with_constants(|c| self.0.tan(BITS, ROUND, c)))
    }

    pub(super) fn sin(&self) -> Self {
        Self(with_constants(|c| self.0.sin(BITS, ROUND, c)))
    }

    pub(super) fn cos(&self) -> Self {
        Self(with_constants(|c| self.0.cos(BITS, ROUND, c)))
    }

    pub(super) fn atan(&self) -> Self {
        Self(with_constants(|c| self.0.atan(BITS, ROUND, c)))
    }

    pub(super) fn exp(&self) -> Self {
        Self(with_constants(|c| self.0.exp(BITS, ROUND, c)))
    }

    pub(super) fn ln(&self) -> Self {
        Self(with_constants(|c| self.0.ln(BITS, ROUND, c)))
    }

    /// Of a positive number.
    pub(super) fn pow(&self, exponent: &Self) -> Self {
        (self.ln() * exponent.clone()).exp()
    }

    /// The angle of (x, `self`) for `self` ≥ 0: 0 to π.
    pub(super) fn atan2(&self, x: &Self) -> Self {
        let zero = Self::new(0.0);
        match x.0.cmp(&zero.0) {
            Some(0) => Self::pi() / Self::new(2.0),
            Some(sign) if sign > 0 => (self.clone() / x.clone()).atan(),
            _ => (self.clone() / x.clone()).atan() + Self::pi(),
        }
    }

    pub(super) fn abs(&self) -> Self {
        Self(self.0.abs())
    }

    /// Within a bit of f64's last.
    pub(super) fn to_f64(&self) -> f64 {
        let Some((words, _, _, exponent, _)) = self.0.as_raw_parts() else {
            return match self.0.is_inf() {
                true => f64::INFINITY,
                false => f64::NAN,
            };
        };
        // A fraction below 1 in words, the last one the greatest; none is 0.
        let Some(first) = words.first() else {
            return 0.0;
        };
        let scale = 0.5f64.powi(size_of_val(first) as i32 * 8);
        let fraction = words.iter().fold(0.0, |f, &word| (f + word as f64) * scale);
        // In two steps: what is tiny must not become 0 on the way.
        let half = exponent / 2;
        let size = fraction * 2f64.powi(half) * 2f64.powi(exponent - half);
        if self.0.is_negative() { -size } else { size }
    }

    /// How far `value` is off, over this.
    pub(super) fn relative(&self, value: f64) -> f64 {
        let off = (Self::new(value) - self.clone()).abs();
        match off.0.is_zero() {
            true => 0.0,
            false => (off / self.abs()).to_f64(),
        }
    }

    /// How far `value` is off.
    pub(super) fn off(&self, value: f64) -> f64 {
        (Self::new(value) - self.clone()).abs().to_f64()
    }
}

impl PartialEq for Big {
    fn eq(&self, other: &Self) -> bool {
        self.0.cmp(&other.0) == Some(0)
    }
}

impl PartialOrd for Big {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.0.cmp(&other.0).map(|sign| sign.cmp(&0))
    }
}

impl Add for Big {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0.add(&other.0, BITS, ROUND))
    }
}

impl Sub for Big {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(self.0.sub(&other.0, BITS, ROUND))
    }
}

impl Mul for Big {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self(self.0.mul(&other.0, BITS, ROUND))
    }
}

impl Div for Big {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        Self(self.0.div(&other.0, BITS, ROUND))
    }
}

impl Neg for Big {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.neg())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back() {
        for value in [1.0, -0.1, 1e300, 1e-300, 123_456.789, f64::MIN_POSITIVE] {
            assert_eq!(Big::new(value).to_f64(), value);
        }
        assert_eq!(Big::int(-(1 << 100)).to_f64(), -(2f64.powi(100)));
        assert_eq!(Big::new(0.0).to_f64(), 0.0);
        let third = Big::new(1.0) / Big::new(3.0);
        assert!(third.relative(1.0 / 3.0) < 1.2e-16 && third.relative(1.0 / 3.0) > 0.0);
        assert!((Big::new(2.0).sqrt() * Big::new(2.0).sqrt()).relative(2.0) < 1e-70);
        assert!((Big::new(1.0).atan() * Big::new(4.0) - Big::pi()).abs() < Big::new(1e-70));
        assert!(
            Big::new(1.0)
                .atan2(&Big::new(-1.0))
                .relative(0.75 * std::f64::consts::PI)
                < 1e-15
        );
        assert_eq!(Big::new(2.0).exp().ln().to_f64(), 2.0);
    }
}
