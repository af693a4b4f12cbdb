use std::sync::LazyLock;

use glam::UVec2;

use crate::math;

/// A picture in linear light, red, green, blue, row by row from the top-left.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Pixels, width × height.
    pub size: UVec2,
    /// `size.x * size.y` colours; 1 is the display's white.
    pub rgb: Vec<[f32; 3]>,
}

impl Image {
    /// A picture of one colour.
    pub fn filled(size: UVec2, colour: [f32; 3]) -> Self {
        Self {
            size,
            rgb: vec![colour; size.x as usize * size.y as usize],
        }
    }

    /// The colour of pixel (x, y).
    pub fn at(&self, x: u32, y: u32) -> [f32; 3] {
        self.rgb[y as usize * self.size.x as usize + x as usize]
    }

    /// As 8-bit sRGB, three bytes per pixel.
    pub fn to_srgb8(&self) -> Vec<u8> {
        let encoder = &*ENCODER;
        self.rgb
            .iter()
            .flatten()
            .map(|&v| encoder.code(v))
            .collect()
    }

    /// Luma of the 8-bit sRGB values (Rec. 601 weights, as image-quality literature uses), 0 to 255.
    pub fn to_luma(&self) -> Vec<f64> {
        let encoder = &*ENCODER;
        let grey = |c: &[f32; 3]| {
            let [r, g, b] = c.map(|v| f64::from(encoder.code(v)));
            0.299 * r + 0.587 * g + 0.114 * b
        };
        self.rgb.iter().map(grey).collect()
    }
}

/// The nearest 8-bit sRGB value (IEC 61966-2-1) of a linear one; clamps, NaN becomes 0.
///
/// Rounds at the exact mid-points between code values, so it is the same on every machine.
pub fn srgb8_from_linear(linear: f32) -> u8 {
    ENCODER.code(linear)
}

static ENCODER: LazyLock<Encoder> = LazyLock::new(Encoder::new);

/// Values below have code 0: the first mid-point is 1.5 · 10⁻⁴.
const LEAST: f32 = 1.0 / 8192.0;
/// A value's bucket is its bits without the last 16 of its fraction's 23.
const SHIFT: u32 = 16;
const FIRST: usize = (LEAST.to_bits() >> SHIFT) as usize;
const BUCKETS: usize = (1f32.to_bits() >> SHIFT) as usize - FIRST;

/// Finds codes by table. The buckets between [`LEAST`] and 1 are 2⁻⁷ of their binade wide; mid-points
/// lie at least 2.4/255/1.055 = 0.0089 of their value apart (the slope of the curve at 1, its least
/// relative one), so a bucket holds at most one, and one comparison settles the code.
struct Encoder {
    /// Code at the beginning of each bucket.
    start: [u8; BUCKETS],
    /// Least value whose code is greater than the index.
    midpoints: [f32; 256],
}

impl Encoder {
    fn new() -> Self {
        let midpoints = std::array::from_fn(|code| match code {
            255 => f32::INFINITY,
            _ => linear_from_srgb((code as f64 + 0.5) / 255.0) as f32,
        });
        let start = std::array::from_fn(|bucket| {
            let begin = f32::from_bits(((FIRST + bucket) as u32) << SHIFT);
            midpoints.partition_point(|&t| begin >= t) as u8
        });
        Self { start, midpoints }
    }

    #[inline]
    fn code(&self, linear: f32) -> u8 {
        if linear >= 1.0 {
            return 255;
        }
        if linear >= LEAST {
            let start = self.start[(linear.to_bits() >> SHIFT) as usize - FIRST];
            return start + u8::from(linear >= self.midpoints[usize::from(start)]);
        }
        // Below, negative, or not a number.
        0
    }
}

/// Linear light of an sRGB value, both 0 to 1 (IEC 61966-2-1).
pub fn linear_from_srgb(srgb: f64) -> f64 {
    if srgb <= 0.040_45 {
        srgb / 12.92
    } else {
        math::pow((srgb + 0.055) / 1.055, 2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_value_survives_the_round_trip() {
        for code in 0..=255u8 {
            let linear = linear_from_srgb(f64::from(code) / 255.0) as f32;
            assert_eq!(srgb8_from_linear(linear), code);
        }
        assert_eq!(srgb8_from_linear(-1.0), 0);
        assert_eq!(srgb8_from_linear(f32::NAN), 0);
        assert_eq!(srgb8_from_linear(f32::INFINITY), 255);
    }

    /// The specification: the number of mid-points at or below the value.
    fn by_search(linear: f32) -> u8 {
        let midpoint = |code: u8| linear_from_srgb((f64::from(code) + 0.5) / 255.0) as f32;
        (0..255).filter(|&code| linear >= midpoint(code)).count() as u8
    }

    #[test]
    fn the_table_gives_what_the_search_gives() {
        let special = [
            0.0,
            -0.0,
            -1.0,
            -1e-30,
            f32::MIN_POSITIVE,
            f32::from_bits(1),
            LEAST,
            1.0,
            2.0,
            f32::MAX,
            f32::MIN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::NAN,
            -f32::NAN,
        ];
        let near = |v: f32| [v.next_down(), v, v.next_up()];
        let midpoints = (0..255).map(|c| linear_from_srgb((f64::from(c) + 0.5) / 255.0) as f32);
        let buckets = (0..=BUCKETS).map(|b| f32::from_bits(((FIRST + b) as u32) << SHIFT));
        let edges = special
            .into_iter()
            .chain(midpoints)
            .chain(buckets)
            .flat_map(near);
        // All exponents and signs, 61 places of each binade.
        let sample = (0..=u32::MAX).step_by((1 << 23) / 61).map(f32::from_bits);
        let dense = (0..=50_000u32).map(|k| k as f32 / 49_999.0);
        for v in edges.chain(sample).chain(dense) {
            assert_eq!(
                srgb8_from_linear(v),
                by_search(v),
                "{v:e} {:#x}",
                v.to_bits()
            );
        }
    }

    #[test]
    fn pictures_are_encoded_like_single_values() {
        let rgb = (0..100).map(|k| [0.01 * k as f32, 1.0 - 0.01 * k as f32, f32::NAN]);
        let image = Image {
            size: UVec2::new(10, 10),
            rgb: rgb.collect(),
        };
        let codes: Vec<u8> = image.rgb.iter().flatten().map(|&v| by_search(v)).collect();
        assert_eq!(image.to_srgb8(), codes);
        let grey =
            |c: &[u8]| 0.299 * f64::from(c[0]) + 0.587 * f64::from(c[1]) + 0.114 * f64::from(c[2]);
        let luma: Vec<f64> = codes.chunks(3).map(grey).collect();
        assert_eq!(image.to_luma(), luma);
    }
}
