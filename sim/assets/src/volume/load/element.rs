use std::fmt;

use super::super::Voxels;
use crate::load::Flaw;

/// The type of stored numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Element {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl Element {
    /// Bytes of one.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// All whole ones among `bytes`. Whole numbers of 64 bits become double precision.
    pub(super) fn decode(self, bytes: &[u8], big_endian: bool) -> Voxels {
        macro_rules! read {
            ($t:ty) => {{
                let chunks = bytes.chunks_exact(size_of::<$t>());
                let number = |c: &[u8]| {
                    let c = c.try_into().expect("chunks are as long as asked for");
                    if big_endian {
                        <$t>::from_be_bytes(c)
                    } else {
                        <$t>::from_le_bytes(c)
                    }
                };
                chunks.map(number)
            }};
        }
        match self {
            Self::U8 => Voxels::U8(bytes.to_vec()),
            Self::I8 => Voxels::I8(read!(i8).collect()),
            Self::U16 => Voxels::U16(read!(u16).collect()),
            Self::I16 => Voxels::I16(read!(i16).collect()),
            Self::U32 => Voxels::U32(read!(u32).collect()),
            Self::I32 => Voxels::I32(read!(i32).collect()),
            Self::U64 => Voxels::F64(read!(u64).map(|v| v as f64).collect()),
            Self::I64 => Voxels::F64(read!(i64).map(|v| v as f64).collect()),
            Self::F32 => Voxels::F32(read!(f32).collect()),
            Self::F64 => Voxels::F64(read!(f64).collect()),
        }
    }

    /// Numbers written as text, of this type; `count` of them must be there. And whether more follow.
    pub(super) fn parse(self, text: &[u8], count: usize) -> Result<(Voxels, bool), Flaw> {
        // A number and what parts it from the next take two characters or more.
        if text.len() / 2 + 1 < count {
            let problem = format_args!("{} characters cannot hold {count} numbers", text.len());
            return Err(Flaw::new("voxels", problem));
        }
        let text = std::str::from_utf8(text)
            .map_err(|e| Flaw::new("voxels", format_args!("not text: {e}")))?;
        macro_rules! read {
            ($t:ty, $voxels:ident) => {{
                let mut all: Vec<$t> = Vec::with_capacity(count);
                let mut words = text.split_ascii_whitespace();
                for word in words.by_ref().take(count) {
                    let number = word.parse().map_err(|_| {
                        let word: String = word.chars().take(40).collect();
                        let place = format!("voxel {}", all.len());
                        Flaw::new(place, format_args!("{word:?}: must be of type {self}"))
                    })?;
                    all.push(number);
                }
                if all.len() < count {
                    let problem = format_args!("{} numbers: must be {count}", all.len());
                    return Err(Flaw::new("voxels", problem));
                }
                (Voxels::$voxels(all), words.next().is_some())
            }};
        }
        Ok(match self {
            Self::U8 => read!(u8, U8),
            Self::I8 => read!(i8, I8),
            Self::U16 => read!(u16, U16),
            Self::I16 => read!(i16, I16),
            Self::U32 => read!(u32, U32),
            Self::I32 => read!(i32, I32),
            Self::F32 => read!(f32, F32),
            Self::U64 | Self::I64 | Self::F64 => read!(f64, F64),
        })
    }
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::U64 => "u64",
            Self::I64 => "i64",
            Self::F32 => "f32",
            Self::F64 => "f64",
        })
    }
}
