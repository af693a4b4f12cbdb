use foveasim_models::{Image, math, srgb8_from_linear};
use rayon::prelude::*;

use crate::{Plane, QualityError, mse, psnr_db, ssim};

/// How close an image is to its reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measures {
    /// Mean squared error of luma \[grey levels² of 255\].
    pub mse_luma: f64,
    /// Mean squared error over the three 8-bit sRGB channels \[grey levels²\].
    pub mse_rgb: f64,
    /// PSNR of luma \[dB\]; infinite where the images are equal.
    pub psnr_luma_db: f64,
    /// PSNR over the three channels \[dB\]; infinite where the images are equal.
    pub psnr_rgb_db: f64,
    /// Mean SSIM of luma (see [`crate::Ssim::mean`]).
    pub ssim: f64,
    /// Mean luma of the image minus that of the reference \[grey levels\]: brighter is positive.
    pub bias: f64,
    /// Largest difference of luma \[grey levels\].
    pub max_abs: f64,
}

/// Two images compared: the measures of the whole, and what is needed for those of its parts.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Over the whole image.
    pub whole: Measures,
    /// SSIM of every pixel.
    pub ssim_map: Plane,
    /// Luma of the image, 0 to 255.
    pub image: Plane,
    /// Luma of the reference, 0 to 255.
    pub reference: Plane,
}

/// Compares an image with its reference, as 8-bit sRGB.
///
/// # Errors
/// If the sizes differ, or a side is shorter than SSIM's window (11).
pub fn compare(image: &Image, reference: &Image) -> Result<Comparison, QualityError> {
    let (rgb_a, rgb_b) = (srgb8(image), srgb8(reference));
    let (a, b) = (luma(image, &rgb_a)?, luma(reference, &rgb_b)?);
    let similarity = ssim(&a, &b)?;
    // Whole numbers: exact in any order.
    let squares: u64 = rgb_a
        .as_flattened()
        .iter()
        .zip(rgb_b.as_flattened())
        .map(|(&x, &y)| u64::from(x.abs_diff(y)).pow(2))
        .sum();
    let mse_rgb = squares as f64 / (3 * rgb_a.len()) as f64;
    let mse_luma = mse(&a, &b)?;
    let differences: Vec<f64> = a
        .values()
        .iter()
        .zip(b.values())
        .map(|(x, y)| x - y)
        .collect();
    let whole = Measures {
        mse_luma,
        mse_rgb,
        psnr_luma_db: psnr_db(mse_luma),
        psnr_rgb_db: psnr_db(mse_rgb),
        ssim: similarity.mean,
        bias: math::mean(&differences),
        max_abs: differences.iter().fold(0.0, |m: f64, d| m.max(d.abs())),
    };
    Ok(Comparison {
        whole,
        ssim_map: similarity.map,
        image: a,
        reference: b,
    })
}

/// [`Image::to_srgb8`], in parallel: the dearest step of a comparison.
fn srgb8(image: &Image) -> Vec<[u8; 3]> {
    image
        .rgb
        .par_iter()
        .map(|c| c.map(srgb8_from_linear))
        .collect()
}

/// [`Image::to_luma`] from code values already at hand.
fn luma(image: &Image, rgb: &[[u8; 3]]) -> Result<Plane, QualityError> {
    let grey = |c: &[u8; 3]| {
        let [r, g, b] = c.map(f64::from);
        0.299 * r + 0.587 * g + 0.114 * b
    };
    Plane::new(image.size, rgb.par_iter().map(grey).collect())
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    #[test]
    fn luma_is_that_of_the_image() {
        let mut image = Image::filled(UVec2::new(50, 40), [0.0; 3]);
        for (i, p) in image.rgb.iter_mut().enumerate() {
            *p = [0.0005, 0.0003, 0.0007].map(|v| v * i as f32 - 0.1);
        }
        assert_eq!(luma(&image, &srgb8(&image)), Plane::luma(&image));
    }
}
