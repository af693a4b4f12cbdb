//! The one door to transcendental functions, and sums whose order is fixed.
//!
//! The platform's `sin` may differ from machine to machine by a bit; `libm`'s does not. Everything
//! whose result can reach a golden file goes through here.

pub use libm::{
    acos, asin, atan, atan2, cos, erf, erfc, exp, hypot, log, log10, pow, sin, sqrt, tan,
};

/// Degrees per radian.
pub const DEG_PER_RAD: f64 = 180.0 / std::f64::consts::PI;

/// Degrees to radians.
pub fn to_rad(deg: f64) -> f64 {
    deg / DEG_PER_RAD
}

/// Radians to degrees.
pub fn to_deg(rad: f64) -> f64 {
    rad * DEG_PER_RAD
}

/// Tangent of an angle in degrees.
pub fn tan_deg(deg: f64) -> f64 {
    tan(to_rad(deg))
}

/// Arc tangent, in degrees.
pub fn atan_deg(x: f64) -> f64 {
    to_deg(atan(x))
}

/// Sum by pairwise halving: the same order for the same length, and an error that grows with
/// log₂ n instead of n.
pub fn sum(values: &[f64]) -> f64 {
    const BLOCK: usize = 32;
    if values.len() <= BLOCK {
        values.iter().sum()
    } else {
        let (left, right) = values.split_at(values.len() / 2);
        sum(left) + sum(right)
    }
}

/// Arithmetic mean with [`sum`]; NaN for no values.
pub fn mean(values: &[f64]) -> f64 {
    sum(values) / values.len() as f64
}

/// The quantile `q` in 0..=1 of values sorted ascending, linear between order statistics
/// (Hyndman & Fan type 7); NaN for no values.
pub fn quantile_sorted(sorted: &[f64], q: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let h = q.clamp(0.0, 1.0) * last as f64;
    let low = h as usize;
    let high = (low + 1).min(last);
    sorted[low] + (h - low as f64) * (sorted[high] - sorted[low])
}

/// The smooth step from 0 at `x ≤ 0` to 1 at `x ≥ 1`: 3x² − 2x³.
pub fn smoothstep(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate() {
        let v = [0.0, 1.0, 2.0, 3.0];
        assert_eq!(quantile_sorted(&v, 0.5), 1.5);
        assert_eq!(quantile_sorted(&v, 1.0), 3.0);
        assert!(quantile_sorted(&[], 0.5).is_nan());
    }

    #[test]
    fn pairwise_sum_is_accurate() {
        let v = vec![0.1; 1_000_000];
        assert!((sum(&v) - 100_000.0).abs() < 1e-9);
    }
}
