use std::borrow::Cow;
use std::ops::RangeInclusive;

use foveasim_models::Nanos;
use glam::{DQuat, DVec3};

use super::columns::Columns;
use crate::TraceError;
use crate::lines::Line;

/// Times kept: those whose differences always fit; up to the year 2115 as Unix time.
const MAX_NANOS: i128 = 4_600_000_000_000_000_000;

/// Where a field stands, for errors, and how numbers are written there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row<'a> {
    pub(crate) file: &'a str,
    pub(crate) line: usize,
    pub(crate) complete: bool,
    pub(crate) decimal_comma: bool,
}

impl<'a> Row<'a> {
    pub(crate) fn new(file: &'a str, line: &Line<'_>, decimal_comma: bool) -> Self {
        Self {
            file,
            line: line.number,
            complete: line.complete,
            decimal_comma,
        }
    }

    /// The wanted fields of a row.
    pub(crate) fn pick<'t, const N: usize>(
        &self,
        columns: &Columns<N>,
        text: &'t str,
    ) -> Result<[&'t str; N], TraceError> {
        columns
            .pick(text)
            .map_err(|found| self.field_count(found, columns.width()))
    }

    /// The error for a row of the wrong width: the last one may have been cut off.
    pub(crate) fn field_count(&self, found: usize, expected: usize) -> TraceError {
        let (file, line) = (self.file.to_owned(), self.line);
        if found < expected && !self.complete {
            return TraceError::Truncated { file, line };
        }
        TraceError::FieldCount {
            file,
            line,
            found,
            expected,
        }
    }

    /// The error for a field that cannot be what its column says.
    pub(crate) fn bad(&self, field: &str, value: &str, valid: impl Into<String>) -> TraceError {
        const SHOWN: usize = 40;
        let mut shown: String = value.chars().take(SHOWN).collect();
        if value.chars().nth(SHOWN).is_some() {
            shown.push('…');
        }
        TraceError::Field {
            file: self.file.to_owned(),
            line: self.line,
            field: field.to_owned(),
            value: shown,
            valid: valid.into(),
        }
    }

    /// A number in `range`, which NaN and the infinities never are.
    pub(crate) fn number(
        &self,
        field: &str,
        text: &str,
        range: RangeInclusive<f64>,
    ) -> Result<f64, TraceError> {
        match self.point(text).parse::<f64>() {
            Ok(value) if range.contains(&value) => Ok(value),
            _ => {
                let valid = format!("a number from {} to {}", range.start(), range.end());
                Err(self.bad(field, text, valid))
            }
        }
    }

    /// As [`Row::number`]; `None` for an empty field or `nan`.
    pub(crate) fn optional(
        &self,
        field: &str,
        text: &str,
        range: RangeInclusive<f64>,
    ) -> Result<Option<f64>, TraceError> {
        if text.is_empty() || text.eq_ignore_ascii_case("nan") {
            return Ok(None);
        }
        self.number(field, text, range).map(Some)
    }

    /// A time in units of 10^`exponent` s (0: seconds, −3: milliseconds, −9: nanoseconds), exactly.
    pub(crate) fn time(&self, field: &str, text: &str, exponent: i32) -> Result<Nanos, TraceError> {
        decimal_nanos(&self.point(text), exponent).ok_or_else(|| {
            let unit = match exponent {
                0 => "s",
                -3 => "ms",
                -6 => "us",
                -7 => "100 ns",
                _ => "ns",
            };
            self.bad(field, text, format!("a time [{unit}] within ±4.6e18 ns"))
        })
    }

    /// A whole number of units of 10^`exponent` s since `epoch`, as a time since then: counts from the
    /// year 1 are too large for nanoseconds, and for the digits of a float.
    pub(crate) fn ticks(
        &self,
        field: &str,
        text: &str,
        exponent: i32,
        epoch: i64,
    ) -> Result<Nanos, TraceError> {
        let units = 10i128.pow((exponent + 9).unsigned_abs());
        let since = text
            .parse::<i64>()
            .ok()
            .map(|n| (i128::from(n) - i128::from(epoch)) * units);
        match since.filter(|ns| ns.abs() <= MAX_NANOS) {
            Some(ns) => Ok(Nanos(ns as i64)),
            None => {
                let valid = format!("a whole number within 4.6e18 ns of {epoch}");
                Err(self.bad(field, text, valid))
            }
        }
    }

    /// A unit quaternion kept with few decimals, x y z w; renormalised. `None` where its length is
    /// beyond what rounding does to 1.
    pub(crate) fn rotation(&self, q: [f64; 4]) -> Option<DQuat> {
        const ROUNDING: f64 = 0.02;
        let q = DQuat::from_xyzw(q[0], q[1], q[2], q[3]);
        let length = q.length();
        // What was written by us comes back to the bit.
        if (length - 1.0).abs() < 1e-14 {
            return Some(q);
        }
        ((length - 1.0).abs() <= ROUNDING).then(|| q / length)
    }

    /// Four fields as a rotation.
    pub(crate) fn quaternion(
        &self,
        fields: [&str; 4],
        texts: [&str; 4],
    ) -> Result<DQuat, TraceError> {
        let mut q = [0.0; 4];
        for ((q, field), text) in q.iter_mut().zip(fields).zip(texts) {
            *q = self.number(field, text, -1.1..=1.1)?;
        }
        self.rotation(q).ok_or_else(|| {
            let names = fields.join(",");
            self.bad(
                &names,
                &texts.join(","),
                "a quaternion of length 1 (within 0.02)",
            )
        })
    }

    /// Three fields as a vector, each at most a million either way.
    pub(crate) fn vector(&self, fields: [&str; 3], texts: [&str; 3]) -> Result<DVec3, TraceError> {
        let mut v = [0.0; 3];
        for ((v, field), text) in v.iter_mut().zip(fields).zip(texts) {
            *v = self.number(field, text, -1e6..=1e6)?;
        }
        Ok(DVec3::from_array(v))
    }

    fn point<'t>(&self, text: &'t str) -> Cow<'t, str> {
        if self.decimal_comma && text.contains(',') {
            Cow::Owned(text.replacen(',', ".", 1))
        } else {
            Cow::Borrowed(text)
        }
    }
}

/// A decimal number times 10^`exponent` s in whole nanoseconds, rounded half away from zero, without
/// going through a float: seconds since 1970 have more digits than a float keeps.
fn decimal_nanos(text: &str, exponent: i32) -> Option<Nanos> {
    // Whole nanoseconds, as most of our own files have them: no digit can be lost.
    if exponent == -9 && text.len() <= 18 && text.bytes().all(|b| b.is_ascii_digit()) {
        return text.parse().ok().map(Nanos);
    }
    let (mantissa, power) = match text.split_once(['e', 'E']) {
        Some((mantissa, power)) => (mantissa, power.parse::<i16>().ok()?),
        None => (text, 0),
    };
    let (negative, digits) = match mantissa.as_bytes() {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        rest => (false, rest),
    };
    // `shift` is the power of ten that the digits read so far still lack.
    let mut shift = i32::from(power) + exponent + 9;
    let (mut value, mut any, mut fraction, mut dropped) = (0i128, false, false, 0i32);
    for &b in digits {
        match b {
            b'.' if !fraction => fraction = true,
            b'0'..=b'9' => {
                any = true;
                if value < 1i128 << 100 {
                    value = value * 10 + i128::from(b - b'0');
                    shift -= i32::from(fraction);
                } else {
                    // Far below a nanosecond or far beyond the range: the scale alone matters.
                    dropped += i32::from(!fraction);
                }
            }
            _ => return None,
        }
    }
    shift += dropped;
    if !any {
        return None;
    }
    if value != 0 {
        while shift > 0 {
            value = value.checked_mul(10).filter(|v| *v <= MAX_NANOS)?;
            shift -= 1;
        }
        let mut last = 0;
        while shift < 0 && value != 0 {
            last = value % 10;
            value /= 10;
            shift += 1;
        }
        // Whatever is left to shift away is below a tenth of a nanosecond.
        if shift == 0 && last >= 5 {
            value += 1;
        }
    }
    let value = if negative { -value } else { value };
    (value.abs() <= MAX_NANOS).then_some(Nanos(value as i64))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn decimals_are_exact() {
        let ns = |text, exponent| decimal_nanos(text, exponent).map(|n| n.0);
        assert_eq!(ns("1311868163.8697", 0), Some(1_311_868_163_869_700_000));
        assert_eq!(
            ns("1311868163.869700001", 0),
            Some(1_311_868_163_869_700_001)
        );
        assert_eq!(ns("4057250.486", -3), Some(4_057_250_486_000));
        assert_eq!(ns("-1.5e3", -3), Some(-1_500_000_000));
        assert_eq!(ns("+.5E-9", 0), Some(1));
        assert_eq!(ns("0.4999999999", -9), Some(0));
        assert_eq!(ns("9223372036854775807", -9), None);
        assert_eq!(ns("1e400", 0), None);
        assert_eq!(ns("1e-400", 0), Some(0));
        assert_eq!(ns("0e400", 0), Some(0));
        for bad in [
            "", "-", ".", "nan", "inf", "1.2.3", "1e", "0x10", "1 2", "１",
        ] {
            assert_eq!(ns(bad, 0), None, "{bad}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_a_time_or_an_error(text in "[-+0-9.eE]{0,60}", exponent in -9i32..=0) {
            if let Some(t) = decimal_nanos(&text, exponent) {
                prop_assert!(i128::from(t.0).abs() <= MAX_NANOS);
                let float = text.parse::<f64>().unwrap() * 10f64.powi(exponent + 9);
                prop_assert!((t.0 as f64 - float).abs() <= 0.5 + float.abs() * 1e-14);
            }
        }
    }
}
