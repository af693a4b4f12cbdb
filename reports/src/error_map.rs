use foveasim_models::{Image, linear_from_srgb};

use crate::colour_bar::error_scale;
use crate::{ColourMap, ReportError};

/// Where two images differ, as colours, with the scale that gives the colours their meaning.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorMap {
    /// |luma − luma of the reference| per pixel, in [`ColourMap::Inferno`]: black is equal.
    pub image: Image,
    /// The difference \[grey levels of 255\] drawn in the brightest colour, and all above it.
    pub full_scale: f64,
    /// The largest difference there is \[grey levels\].
    pub max: f64,
    /// Fraction of pixels that differ by more than the full scale.
    pub clipped: f64,
}

/// A good full scale \[grey levels of 255\] for foveated images: strong errors can be told apart.
pub const ERROR_FULL_SCALE: f64 = 64.0;

/// Maps the luma difference of two images to colours; `full_scale` \[grey levels of 255\] and above is
/// brightest (16 shows what SSIM just begins to see; 64 tells strong errors apart).
///
/// # Errors
/// If the sizes differ, or the scale is not above 0 and at most 255.
pub fn error_map(
    image: &Image,
    reference: &Image,
    full_scale: f64,
) -> Result<ErrorMap, ReportError> {
    if image.size != reference.size {
        return Err(ReportError::SizesDiffer {
            a: image.size.to_array(),
            b: reference.size.to_array(),
        });
    }
    if !(full_scale > 0.0 && full_scale <= 255.0) {
        let valid = "a number above 0, at most 255";
        return Err(ReportError::OutOfRange {
            what: "full scale of the error map [grey levels]",
            value: full_scale,
            valid,
        });
    }
    let differences: Vec<f64> = image
        .to_luma()
        .iter()
        .zip(reference.to_luma())
        .map(|(a, b)| (a - b).abs())
        .collect();
    let colour = |d: &f64| {
        ColourMap::Inferno
            .at(d / full_scale)
            .map(|v| linear_from_srgb(f64::from(v) / 255.0) as f32)
    };
    let over = differences.iter().filter(|d| **d > full_scale).count();
    Ok(ErrorMap {
        image: Image {
            size: image.size,
            rgb: differences.iter().map(colour).collect(),
        },
        full_scale,
        max: differences.iter().copied().fold(0.0, f64::max),
        clipped: over as f64 / differences.len().max(1) as f64,
    })
}

impl ErrorMap {
    /// The colour bar with its numbers, as SVG.
    pub fn scale_svg(&self) -> String {
        error_scale(
            self.full_scale,
            "absolute luma difference [grey levels of 255]",
        )
    }

    /// What the picture shows, in a sentence.
    pub fn caption(&self) -> String {
        format!(
            "Absolute luma difference from the reference; black is equal, the brightest colour is {} \
             grey levels or more ({:.2} % of the pixels are beyond; the largest difference is {:.1}).",
            crate::svg::number(self.full_scale),
            self.clipped * 100.0,
            self.max
        )
    }
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    #[test]
    fn equal_is_black_and_the_scale_is_stated() {
        let grey =
            |code: f64| Image::filled(UVec2::new(4, 2), [linear_from_srgb(code / 255.0) as f32; 3]);
        let mut image = grey(100.0);
        image.rgb[3] = grey(150.0).rgb[0];
        let map = error_map(&image, &grey(100.0), 32.0).unwrap();
        assert_eq!(map.image.to_srgb8()[..3], ColourMap::Inferno.at(0.0));
        assert_eq!(map.image.to_srgb8()[9..12], ColourMap::Inferno.at(1.0));
        assert!((map.max - 50.0).abs() < 1e-9 && map.clipped == 0.125);
        assert!(
            map.caption().contains("32 grey levels or more (12.50 %"),
            "{}",
            map.caption()
        );
    }

    #[test]
    fn nonsense_is_refused() {
        let image = Image::filled(UVec2::new(4, 2), [0.5; 3]);
        for scale in [0.0, -1.0, 256.0, f64::NAN] {
            assert!(matches!(
                error_map(&image, &image, scale),
                Err(ReportError::OutOfRange { .. })
            ));
        }
        let other = Image::filled(UVec2::new(2, 4), [0.5; 3]);
        assert!(matches!(
            error_map(&image, &other, 9.0),
            Err(ReportError::SizesDiffer { .. })
        ));
    }
}
