use foveasim_models::math;

use crate::{Plane, QualityError};

/// The largest value of an 8-bit channel, and of luma.
pub const PEAK: f64 = 255.0;

/// Mean squared difference of two planes.
///
/// # Errors
/// If their sizes differ.
pub fn mse(a: &Plane, b: &Plane) -> Result<f64, QualityError> {
    a.same_size(b)?;
    let square = |(x, y): (&f64, &f64)| (x - y) * (x - y);
    let squares: Vec<f64> = a.values().iter().zip(b.values()).map(square).collect();
    Ok(math::mean(&squares))
}

/// Peak signal-to-noise ratio \[dB\] of a mean squared error: 10·log₁₀(255² / mse); infinite for equal
/// images.
pub fn psnr_db(mse: f64) -> f64 {
    if mse == 0.0 {
        f64::INFINITY
    } else {
        10.0 * math::log(PEAK * PEAK / mse) / std::f64::consts::LN_10
    }
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    #[test]
    fn known_values() {
        let plane = |v| Plane::new(UVec2::new(4, 1), vec![v; 4]).unwrap();
        assert_eq!(mse(&plane(10.0), &plane(13.0)).unwrap(), 9.0);
        // One grey level everywhere: 20·log₁₀ 255.
        assert!((psnr_db(1.0) - 48.130_803_608_679_1).abs() < 1e-12);
        assert!((psnr_db(PEAK * PEAK)).abs() < 1e-12);
        assert_eq!(psnr_db(0.0), f64::INFINITY);
    }
}
