use std::io::Cursor;

use image::{ImageFormat, ImageReader, Limits};

use crate::{Encoding, LARGEST_SIDE, Texture, Wrap};

/// Most memory that decoding one picture may take \[bytes\].
const MOST_BYTES: u64 = 1 << 29;
/// Most pixels that one byte of a file can stand for: a PNG of one bit a pixel, of which DEFLATE
/// makes at most 1032 bytes out of one.
const PIXELS_PER_BYTE: u64 = 8 * 1032;

/// A PNG or JPEG file's pixels as a texture.
pub(super) fn decode(bytes: &[u8], encoding: Encoding, wrap: [Wrap; 2]) -> Result<Texture, String> {
    let format = image::guess_format(bytes).ok();
    let Some(format @ (ImageFormat::Png | ImageFormat::Jpeg)) = format else {
        return Err("is not a PNG or JPEG picture".into());
    };
    let reader = || ImageReader::with_format(Cursor::new(bytes), format);
    let (width, height) = reader().into_dimensions().map_err(|e| one_line(&e))?;
    let pixels = u64::from(width) * u64::from(height);
    let size = format!("claims {width} x {height} pixels");
    if width.max(height) > LARGEST_SIDE {
        return Err(format!("{size}: at most {LARGEST_SIDE} on a side are read"));
    }
    if pixels > PIXELS_PER_BYTE * bytes.len() as u64 {
        return Err(format!(
            "{size} in {} bytes, which cannot hold them",
            bytes.len()
        ));
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_BYTES);
    let mut reader = reader();
    reader.limits(limits);
    let picture = reader.decode().map_err(|e| one_line(&e))?.into_rgba8();
    let texels = picture.pixels().map(|p| p.0).collect();
    Texture::new([width, height], texels, encoding, wrap).map_err(|e| e.to_string())
}

fn one_line(error: &image::ImageError) -> String {
    let text = error.to_string();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(format: ImageFormat) -> Vec<u8> {
        let mut bytes = Vec::new();
        let pixels = image::RgbImage::from_pixel(9, 4, image::Rgb([200, 100, 0]));
        pixels
            .write_to(&mut Cursor::new(&mut bytes), format)
            .unwrap();
        bytes
    }

    fn try_decode(bytes: &[u8]) -> Result<Texture, String> {
        decode(bytes, Encoding::Srgb, [Wrap::Repeat; 2])
    }

    #[test]
    fn png_and_jpeg_are_read() {
        for format in [ImageFormat::Png, ImageFormat::Jpeg] {
            let texture = try_decode(&picture(format)).unwrap();
            assert_eq!(texture.levels()[0].size, [9, 4]);
            let texel = texture.texels()[0];
            assert!(texel[0].abs_diff(200) < 4 && texel[3] == 255, "{texel:?}");
        }
    }

    #[test]
    fn broken_and_boastful_pictures_are_refused() {
        let png = picture(ImageFormat::Png);
        for cut in [0, 4, 20, 40, png.len() - 20] {
            assert!(try_decode(&png[..cut]).is_err(), "{cut}");
        }
        // Width and height of a billion, with the checksum that goes with them.
        let mut boast = png.clone();
        boast[16..24].copy_from_slice(&[0x3b, 0x9a, 0xca, 0, 0x3b, 0x9a, 0xca, 0]);
        let crc = crc32(&boast[12..29]);
        boast[29..33].copy_from_slice(&crc.to_be_bytes());
        assert!(try_decode(&boast).is_err());
        // 8000 × 8000 in 80 bytes.
        boast[16..24].copy_from_slice(&[0, 0, 0x1f, 0x40, 0, 0, 0x1f, 0x40]);
        let crc = crc32(&boast[12..29]);
        boast[29..33].copy_from_slice(&crc.to_be_bytes());
        let text = try_decode(&boast).unwrap_err();
        assert!(
            text.contains("8000 x 8000") && text.contains("cannot hold"),
            "{text}"
        );
    }

    fn crc32(bytes: &[u8]) -> u32 {
        let step = |c: u32| {
            if c & 1 == 1 {
                0xedb8_8320 ^ (c >> 1)
            } else {
                c >> 1
            }
        };
        !bytes
            .iter()
            .fold(!0, |c, b| (0..8).fold(c ^ u32::from(*b), |c, _| step(c)))
    }
}
