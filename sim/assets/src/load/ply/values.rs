use super::super::error::Flaw;
use super::super::text::shown;
use super::header::{Encoding, Header, Kind, Property};

/// The numbers after the header, one after the other.
pub(super) struct Values<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
    /// Line of text, from 1.
    line: usize,
}

impl<'a> Values<'a> {
    pub(super) fn new(bytes: &'a [u8], header: &Header) -> Self {
        Self {
            bytes,
            at: header.end.min(bytes.len()),
            encoding: header.encoding,
            line: header.lines + 1,
        }
    }

    /// Bytes that are left.
    pub(super) fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Something wrong with what was read last.
    pub(super) fn flaw(&self, what: &str, index: u64, problem: impl std::fmt::Display) -> Flaw {
        Flaw::new(self.place(), format_args!("{what} {index}: {problem}"))
    }

    fn place(&self) -> String {
        match self.encoding {
            Encoding::Text => format!("line {}", self.line),
            _ => format!("before byte {}", self.at),
        }
    }

    /// The next number.
    pub(super) fn next(&mut self, kind: Kind) -> Result<f64, Flaw> {
        match self.encoding {
            Encoding::Text => self.word(),
            encoding => self.binary(kind, encoding == Encoding::BigEndian),
        }
    }

    /// The next list: calls `each` with each place and value, and gives the length.
    pub(super) fn list(
        &mut self,
        property: &Property,
        mut each: impl FnMut(u64, f64) -> Result<(), String>,
    ) -> Result<u64, Flaw> {
        let length = self.next(property.list.unwrap_or(Kind::U8))?;
        if !(length >= 0.0 && length <= self.remaining() as f64 && length.fract() == 0.0) {
            let problem = format!(
                "a list of {length} values: must be a whole number, and {} bytes are left",
                self.remaining()
            );
            return Err(Flaw::new(self.place(), problem));
        }
        let length = length as u64;
        for i in 0..length {
            let value = self.next(property.kind)?;
            each(i, value).map_err(|problem| Flaw::new(self.place(), problem))?;
        }
        Ok(length)
    }

    fn word(&mut self) -> Result<f64, Flaw> {
        while let Some(b) = self.bytes.get(self.at).filter(|b| b.is_ascii_whitespace()) {
            self.line += usize::from(*b == b'\n');
            self.at += 1;
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace);
        let word = &rest[..length.unwrap_or(rest.len())];
        if word.is_empty() {
            return Err(Flaw::new(
                self.place(),
                "the file ends before its last value",
            ));
        }
        self.at += word.len();
        let word = String::from_utf8_lossy(word);
        word.parse().map_err(|_| {
            Flaw::new(
                self.place(),
                format_args!("{}: must be a number", shown(&word)),
            )
        })
    }

    fn binary(&mut self, kind: Kind, big_endian: bool) -> Result<f64, Flaw> {
        let length = kind.bytes();
        let Some(value) = self.bytes.get(self.at..self.at + length) else {
            return Err(Flaw::new(
                self.place(),
                "the file ends before its last value",
            ));
        };
        self.at += length;
        let mut b = [0; 8];
        b[..length].copy_from_slice(value);
        if big_endian {
            b[..length].reverse();
        }
        let [b0, b1, b2, b3, ..] = b;
        Ok(match kind {
            Kind::I8 => f64::from(i8::from_le_bytes([b0])),
            Kind::U8 => f64::from(b0),
            Kind::I16 => f64::from(i16::from_le_bytes([b0, b1])),
            Kind::U16 => f64::from(u16::from_le_bytes([b0, b1])),
            Kind::I32 => f64::from(i32::from_le_bytes([b0, b1, b2, b3])),
            Kind::U32 => f64::from(u32::from_le_bytes([b0, b1, b2, b3])),
            Kind::F32 => f64::from(f32::from_le_bytes([b0, b1, b2, b3])),
            Kind::F64 => f64::from_le_bytes(b),
        })
    }
}
