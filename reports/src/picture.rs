use base64::Engine;
use foveasim_models::Image;
use glam::UVec2;
use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use sha2::{Digest, Sha256};

use crate::ReportError;

/// An image as a PNG file, 8-bit sRGB.
///
/// # Errors
/// If it has no pixels, or not one colour per pixel.
pub fn png(image: &Image) -> Result<Vec<u8>, ReportError> {
    let UVec2 {
        x: width,
        y: height,
    } = image.size;
    let error = |why: String| ReportError::Picture { width, height, why };
    let pixels = width as usize * height as usize;
    if pixels == 0 {
        return Err(error("it has no pixels".into()));
    }
    if image.rgb.len() != pixels {
        return Err(error(format!("it holds {} colours", image.rgb.len())));
    }
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
        .write_image(
            &image.to_srgb8(),
            width,
            height,
            image::ExtendedColorType::Rgb8,
        )
        .map_err(|e| error(e.to_string()))?;
    Ok(bytes)
}

/// SHA-256 of an image's size and 8-bit sRGB values (not of any file form), as 64 hexadecimal digits.
pub fn image_digest(image: &Image) -> String {
    let mut hash = Sha256::new();
    hash.update(image.size.x.to_le_bytes());
    hash.update(image.size.y.to_le_bytes());
    hash.update(image.to_srgb8());
    hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

/// Images beside each other from left to right, tops aligned, `gap` px of mid grey between them.
pub fn side_by_side(images: &[&Image], gap: u32) -> Image {
    let gaps = gap * (images.len() as u32).saturating_sub(1);
    let width = images.iter().map(|i| i.size.x).sum::<u32>() + gaps;
    let height = images.iter().map(|i| i.size.y).max().unwrap_or(0);
    let mut out = Image::filled(UVec2::new(width, height), [0.214; 3]);
    let mut left = 0;
    for image in images {
        for y in 0..image.size.y {
            let from = (y * image.size.x) as usize;
            let to = (y * width + left) as usize;
            let n = image.size.x as usize;
            out.rgb[to..to + n].copy_from_slice(&image.rgb[from..from + n]);
        }
        left += image.size.x + gap;
    }
    out
}

/// The image by the smallest whole factor smaller at which it is at most `max_width` px wide (at least
/// 1); unchanged if it is already.
///
/// Each pixel is the mean of the light of those it stands for; at the right and bottom edge those may
/// be fewer.
pub fn shrink(image: &Image, max_width: u32) -> Image {
    let factor = image.size.x.div_ceil(max_width.max(1)).max(1);
    if factor == 1 {
        return image.clone();
    }
    let size = UVec2::new(image.size.x.div_ceil(factor), image.size.y.div_ceil(factor));
    let mut rgb = Vec::with_capacity(size.x as usize * size.y as usize);
    for y in 0..size.y {
        let rows = y * factor..((y + 1) * factor).min(image.size.y);
        for x in 0..size.x {
            let columns = x * factor..((x + 1) * factor).min(image.size.x);
            let mut sum = [0.0f64; 3];
            for v in rows.clone() {
                for u in columns.clone() {
                    for (sum, light) in sum.iter_mut().zip(image.at(u, v)) {
                        *sum += f64::from(light);
                    }
                }
            }
            let pixels = f64::from(rows.len() as u32 * columns.len() as u32);
            rgb.push(sum.map(|s| (s / pixels) as f32));
        }
    }
    Image { size, rgb }
}

/// A PNG as a `data:` address, to stand inside HTML or SVG.
pub(crate) fn data_uri(image: &Image) -> Result<String, ReportError> {
    let text = base64::engine::general_purpose::STANDARD.encode(png(image)?);
    Ok(format!("data:image/png;base64,{text}"))
}

#[cfg(test)]
mod tests {
    use foveasim_models::linear_from_srgb;

    use super::*;

    /// Every 8-bit grey level, in a colour of its own.
    fn ramp() -> Image {
        let mut image = Image::filled(UVec2::new(16, 16), [0.0; 3]);
        for (i, p) in image.rgb.iter_mut().enumerate() {
            *p = [i, 255 - i, i / 2].map(|v| linear_from_srgb(v as f64 / 255.0) as f32);
        }
        image
    }

    #[test]
    fn png_holds_the_srgb_values() {
        let decoded = image::load_from_memory(&png(&ramp()).unwrap())
            .unwrap()
            .to_rgb8();
        assert_eq!(decoded.dimensions(), (16, 16));
        assert_eq!(decoded.into_raw(), ramp().to_srgb8());
    }

    #[test]
    fn digest_sees_values_and_shape() {
        let mut other = ramp();
        assert_eq!(image_digest(&other), image_digest(&ramp()));
        other.size = UVec2::new(32, 8);
        assert_ne!(image_digest(&other), image_digest(&ramp()));
        let mut other = ramp();
        other.rgb[7][1] += 0.01;
        assert_ne!(image_digest(&other), image_digest(&ramp()));
    }

    #[test]
    fn no_pixels_no_png() {
        assert!(png(&Image::filled(UVec2::new(0, 4), [0.0; 3])).is_err());
        let mut short = ramp();
        short.rgb.pop();
        let text = png(&short).unwrap_err().to_string();
        assert_eq!(
            text,
            "cannot encode a picture of 16 x 16 pixels: it holds 255 colours"
        );
    }

    #[test]
    fn shrinking_averages_light() {
        let mut image = Image::filled(UVec2::new(5, 3), [0.0; 3]);
        for (i, p) in image.rgb.iter_mut().enumerate() {
            *p = [i as f32; 3];
        }
        assert_eq!(shrink(&image, 5), image);
        assert_eq!(shrink(&image, 9), image);
        let half = shrink(&image, 3);
        assert_eq!(half.size, UVec2::new(3, 2));
        // Pixels 0, 1, 5, 6; the corner has only pixel 14.
        assert_eq!((half.at(0, 0), half.at(2, 1)), ([3.0; 3], [14.0; 3]));
        assert_eq!(shrink(&image, 4), half, "no factor between 1 and 2");
        for width in [0, 1] {
            let one = shrink(&image, width);
            assert_eq!((one.size, one.at(0, 0)), (UVec2::ONE, [7.0; 3]));
        }
        let none = Image::filled(UVec2::new(0, 4), [0.0; 3]);
        assert_eq!(shrink(&none, 3), none);
    }

    #[test]
    fn images_stand_in_their_order() {
        let (a, b) = (
            Image::filled(UVec2::new(2, 1), [0.0; 3]),
            Image::filled(UVec2::new(1, 2), [1.0; 3]),
        );
        let both = side_by_side(&[&a, &b], 1);
        assert_eq!(both.size, UVec2::new(4, 2));
        assert_eq!((both.at(1, 0), both.at(3, 1)), ([0.0; 3], [1.0; 3]));
        assert_eq!(both.at(2, 0), both.at(0, 1));
        assert_eq!(side_by_side(&[], 3).size, UVec2::ZERO);
    }
}
