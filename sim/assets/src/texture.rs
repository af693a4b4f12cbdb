use std::sync::LazyLock;

use foveasim_models::{linear_from_srgb, srgb8_from_linear};
use thiserror::Error;

/// What lies beyond the edges of a [`Texture`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The texture again.
    Repeat,
    /// The texture mirrored, then again.
    Mirror,
    /// The texels of the edge.
    Clamp,
}

/// What the bytes of a texel mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// A colour: sRGB (IEC 61966-2-1), so that 8 bits are enough.
    Srgb,
    /// A quantity: byte ÷ 255.
    Linear,
}

/// A picture to be laid on surfaces, with its mip chain down to one texel.
///
/// Each level averages the whole one above by area in linear light (also where a side is odd), and is
/// stored in 8 bits a channel: 4 bytes a texel, a third more for the chain. Rows run from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    wrap: [Wrap; 2],
    encoding: Encoding,
    levels: Vec<MipLevel>,
    texels: Vec<[u8; 4]>,
}

/// One level of a mip chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MipLevel {
    /// Texels, width × height.
    pub size: [u32; 2],
    /// Index of its top left texel among [`Texture::texels`].
    pub first: u32,
}

/// Why texels are not a texture.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum TextureError {
    /// No texels, or too many.
    #[error("a texture of {0} x {1} texels: each side must have 1 to {LARGEST_SIDE}")]
    Size(u32, u32),
    /// The texels do not fill the sides.
    #[error("{given} texels for {wanted} places")]
    Count {
        /// Texels given.
        given: usize,
        /// Width × height.
        wanted: usize,
    },
}

/// Longest side of a texture \[texels\]: its positions keep 10 binary places in single precision.
pub const LARGEST_SIDE: u32 = 8192;

impl Encoding {
    /// The linear value of each byte.
    pub fn table(self) -> &'static [f32; 256] {
        static TABLES: LazyLock<[[f32; 256]; 2]> = LazyLock::new(|| {
            let value = |i: usize| i as f64 / 255.0;
            [
                std::array::from_fn(|i| linear_from_srgb(value(i)) as f32),
                std::array::from_fn(|i| value(i) as f32),
            ]
        });
        match self {
            Self::Srgb => &TABLES[0],
            Self::Linear => &TABLES[1],
        }
    }

    fn encode(self, linear: f32) -> u8 {
        match self {
            Self::Srgb => srgb8_from_linear(linear),
            Self::Linear => linear_code(linear),
        }
    }
}

fn linear_code(v: f32) -> u8 {
    // Saturates; the values come from bytes, so there is no NaN.
    (v * 255.0 + 0.5) as u8
}

impl Texture {
    /// A texture of `size` texels, row by row from the top left: red, green, blue, alpha. Alpha is
    /// never gamma-encoded.
    ///
    /// # Errors
    /// If a side has no texel or more than [`LARGEST_SIDE`], or `texels` has another length.
    pub fn new(
        size: [u32; 2],
        texels: Vec<[u8; 4]>,
        encoding: Encoding,
        wrap: [Wrap; 2],
    ) -> Result<Self, TextureError> {
        if size.iter().any(|s| !(1..=LARGEST_SIDE).contains(s)) {
            return Err(TextureError::Size(size[0], size[1]));
        }
        let wanted = size[0] as usize * size[1] as usize;
        if texels.len() != wanted {
            return Err(TextureError::Count {
                given: texels.len(),
                wanted,
            });
        }
        let mut texture = Self {
            wrap,
            encoding,
            levels: vec![MipLevel { size, first: 0 }],
            texels,
        };
        texture.build_chain();
        Ok(texture)
    }

    fn build_chain(&mut self) {
        self.texels.reserve_exact(self.texels.len() / 3 + 64);
        let table = self.encoding.table();
        let decode = |t: [u8; 4]| {
            let [r, g, b] = [t[0], t[1], t[2]].map(|c| table[usize::from(c)]);
            [r, g, b, f32::from(t[3]) / 255.0]
        };
        let mut size = self.levels[0].size;
        // Kept unrounded from level to level, so that roundings do not add up.
        let mut linear: Option<Vec<[f32; 4]>> = None;
        while size != [1, 1] {
            let smaller = match &linear {
                // The first level is decoded as it is read: in full it would take four times as much.
                None => halve(size, |i| decode(self.texels[i])),
                Some(above) => halve(size, |i| above[i]),
            };
            size = halved(size);
            self.levels.push(MipLevel {
                size,
                first: self.texels.len() as u32,
            });
            let encoding = self.encoding;
            self.texels.extend(smaller.iter().map(|&[r, g, b, a]| {
                let [r, g, b] = [r, g, b].map(|v| encoding.encode(v));
                [r, g, b, linear_code(a)]
            }));
            linear = Some(smaller);
        }
    }

    /// All levels, from the whole picture to one texel.
    pub fn levels(&self) -> &[MipLevel] {
        &self.levels
    }

    /// Texels of all levels: red, green, blue (in the texture's encoding), alpha (linear).
    pub fn texels(&self) -> &[[u8; 4]] {
        &self.texels
    }

    /// How bytes become values.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// What lies beyond the edges, along u and along v.
    pub fn wrap(&self) -> [Wrap; 2] {
        self.wrap
    }
}

fn halved(size: [u32; 2]) -> [u32; 2] {
    size.map(|s| (s / 2).max(1))
}

/// The average by area of each texel's share of the level above. A side of 2n + 1 becomes n, each of
/// which covers parts of three texels.
fn halve(size: [u32; 2], texel: impl Fn(usize) -> [f32; 4]) -> Vec<[f32; 4]> {
    let [columns, rows] = [0, 1].map(|axis| shares(size[axis], halved(size)[axis]));
    let mut out = Vec::with_capacity(columns.len() * rows.len());
    for row in &rows {
        for column in &columns {
            let mut sum = [0.0f32; 4];
            for (y, share_y) in row.iter() {
                for (x, share_x) in column.iter() {
                    let value = texel(y as usize * size[0] as usize + x as usize);
                    let share = share_x * share_y;
                    for (s, v) in sum.iter_mut().zip(value) {
                        *s += v * share;
                    }
                }
            }
            out.push(sum);
        }
    }
    out
}

/// Up to three neighbours and what each contributes.
struct Shares {
    first: u32,
    weights: [f32; 3],
}

impl Shares {
    fn iter(&self) -> impl Iterator<Item = (u32, f32)> {
        let first = self.first;
        let weights = self.weights.iter().enumerate();
        weights
            .filter(|(_, w)| **w > 0.0)
            .map(move |(k, &w)| (first + k as u32, w))
    }
}

/// What each of `to` equal parts of a line of `from` texels covers; exact, in units of 1/to texel.
fn shares(from: u32, to: u32) -> Vec<Shares> {
    (0..to)
        .map(|i| {
            let (start, end) = (i * from, (i + 1) * from);
            let first = start / to;
            let weights = [0, 1, 2].map(|k| {
                let low = ((first + k) * to).max(start);
                let high = ((first + k + 1) * to).min(end);
                high.saturating_sub(low) as f32 / from as f32
            });
            Shares { first, weights }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(size: [u32; 2], code: impl Fn(u32, u32) -> u8, encoding: Encoding) -> Texture {
        let places = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        let texels = places.map(|(x, y)| [code(x, y), code(x, y), code(x, y), 255]);
        Texture::new(size, texels.collect(), encoding, [Wrap::Repeat; 2]).unwrap()
    }

    #[test]
    fn every_level_keeps_the_mean_light_also_of_odd_sides() {
        for size in [[8, 8], [7, 5], [1, 9], [13, 1], [64, 3]] {
            let checker = |x, y| if (x * 7 + y * 3) % 5 < 2 { 255 } else { 10 };
            let texture = grey(size, checker, Encoding::Srgb);
            let table = Encoding::Srgb.table();
            let mean = |level: &MipLevel| {
                let count = (level.size[0] * level.size[1]) as usize;
                let all = &texture.texels()[level.first as usize..][..count];
                let sum: f64 = all
                    .iter()
                    .map(|t| f64::from(table[usize::from(t[0])]))
                    .sum();
                sum / count as f64
            };
            let whole = mean(&texture.levels()[0]);
            let last = texture.levels().last().unwrap();
            assert_eq!(last.size, [1, 1]);
            for level in texture.levels() {
                // A texel is rounded to a code: half of the widest step between codes.
                let error = (mean(level) - whole).abs();
                assert!(error < 0.5 * 0.009, "{size:?} {level:?}: {error}");
            }
        }
    }

    #[test]
    fn black_and_white_average_to_half_the_light_not_half_the_code() {
        let texture = grey([2, 2], |x, y| if x == y { 255 } else { 0 }, Encoding::Srgb);
        assert_eq!(texture.texels()[4], [188, 188, 188, 255]);
        let texture = grey(
            [2, 2],
            |x, y| if x == y { 255 } else { 0 },
            Encoding::Linear,
        );
        assert_eq!(texture.texels()[4], [128, 128, 128, 255]);
    }

    #[test]
    fn wrong_sizes_are_refused() {
        let make =
            |size, count| Texture::new(size, vec![[0; 4]; count], Encoding::Srgb, [Wrap::Clamp; 2]);
        assert_eq!(make([0, 4], 0), Err(TextureError::Size(0, 4)));
        assert_eq!(
            make([1, LARGEST_SIDE + 1], 1),
            Err(TextureError::Size(1, 8193))
        );
        assert!(matches!(make([2, 2], 3), Err(TextureError::Count { .. })));
    }
}
