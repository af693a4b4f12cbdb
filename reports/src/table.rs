use foveasim_models::math::log10;

use crate::{TableDigest, TableWriter, TextLayout};

/// One value of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Text.
    Text(String),
    /// A whole number.
    Int(i64),
    /// A number; CSV and JSON carry all its digits, text a readable few.
    Float(f64),
    /// Nothing: not measured, not applicable, missing.
    Empty,
}

/// Rows under named columns; units are in the names (`mean_ms`).
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// An empty table.
    pub fn new<S: Into<String>>(columns: impl IntoIterator<Item = S>) -> Self {
        Self {
            columns: columns.into_iter().map(Into::into).collect(),
            rows: Vec::new(),
        }
    }

    /// Appends a row.
    ///
    /// # Panics
    /// If it does not have one cell per column.
    pub fn push(&mut self, row: Vec<Cell>) {
        assert_eq!(
            row.len(),
            self.columns.len(),
            "cells per row of {:?}",
            self.columns
        );
        self.rows.push(row);
    }

    /// Column names.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Rows.
    pub fn rows(&self) -> &[Vec<Cell>] {
        &self.rows
    }

    /// As CSV with a header line; floats in the shortest form that reads back to the same bits.
    pub fn csv(&self) -> String {
        self.written(TableWriter::csv(Vec::new(), self.columns.iter()))
    }

    /// As a JSON array of objects; missing and non-finite values are `null`.
    pub fn json(&self) -> String {
        self.written(TableWriter::json(Vec::new(), self.columns.iter()))
    }

    /// As aligned columns for people.
    pub fn text(&self) -> String {
        let mut layout = TextLayout::new(&self.columns);
        self.rows.iter().for_each(|row| layout.add(row));
        self.written(TableWriter::text(Vec::new(), self.columns.iter(), layout))
    }

    fn written(&self, mut writer: TableWriter<Vec<u8>>) -> String {
        let rows = self.rows.iter().try_for_each(|row| writer.row(row));
        let bytes = rows.and_then(|()| writer.finish());
        String::from_utf8(bytes.expect("writing to memory")).expect("cells are UTF-8")
    }

    /// SHA-256 of the column names and values (not of any file form), as 64 hexadecimal digits.
    pub fn digest(&self) -> String {
        let mut digest = TableDigest::new(&self.columns);
        self.rows.iter().for_each(|row| digest.row(row));
        digest.finish()
    }
}

pub(crate) fn exact(cell: &Cell) -> String {
    match cell {
        Cell::Text(s) => s.clone(),
        Cell::Int(i) => i.to_string(),
        Cell::Float(f) => f.to_string(),
        Cell::Empty => String::new(),
    }
}

/// `digits` significant digits, without an exponent where that stays short.
pub(crate) fn readable(cell: &Cell, digits: usize) -> String {
    match cell {
        Cell::Float(f) if f.is_finite() && *f != 0.0 => {
            let magnitude = log10(f.abs()).floor();
            if !(-4.0..9.0).contains(&magnitude) {
                return format!("{f:.1e}");
            }
            let decimals = (digits as f64 - 1.0 - magnitude).clamp(0.0, 6.0) as usize;
            let text = format!("{f:.decimals$}");
            if text.contains('.') {
                text.trim_end_matches('0').trim_end_matches('.').to_owned()
            } else {
                text
            }
        }
        other => exact(other),
    }
}

impl Cell {
    /// As JSON; missing and non-finite values are `null`.
    pub(crate) fn to_json(&self) -> serde_json::Value {
        match self {
            Self::Text(s) => serde_json::Value::from(s.as_str()),
            Self::Int(i) => (*i).into(),
            Self::Float(f) => serde_json::Number::from_f64(*f).into(),
            Self::Empty => serde_json::Value::Null,
        }
    }
}

impl From<&str> for Cell {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}

impl From<String> for Cell {
    fn from(value: String) -> Self {
        Self::Text(value)
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Float(value)
    }
}

impl From<i64> for Cell {
    fn from(value: i64) -> Self {
        Self::Int(value)
    }
}

impl From<u32> for Cell {
    fn from(value: u32) -> Self {
        Self::Int(value.into())
    }
}

impl From<u64> for Cell {
    /// Saturates at 2⁶³ − 1.
    fn from(value: u64) -> Self {
        Self::Int(i64::try_from(value).unwrap_or(i64::MAX))
    }
}

impl From<usize> for Cell {
    fn from(value: usize) -> Self {
        Self::from(value as u64)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Empty, Into::into)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Table {
        let mut table = Table::new(["stage", "mean_ms", "n"]);
        table.push(vec!["a,b".into(), 1.25.into(), 3u64.into()]);
        table.push(vec!["c".into(), f64::NAN.into(), Cell::Empty]);
        table
    }

    #[test]
    fn three_forms() {
        assert_eq!(sample().csv(), "stage,mean_ms,n\n\"a,b\",1.25,3\nc,NaN,\n");
        assert_eq!(
            sample().text(),
            "stage  mean_ms  n\na,b       1.25  3\nc          NaN\n"
        );
        assert!(sample().json().contains("\"mean_ms\": null"));
    }

    #[test]
    fn json_is_laid_out_as_the_whole_would_be() {
        let rows: serde_json::Value = serde_json::from_str(&sample().json()).unwrap();
        let whole = serde_json::to_string_pretty(&rows).unwrap() + "\n";
        assert_eq!(sample().json(), whole);
        let none = Table::new(["a", "b"]);
        assert_eq!((none.json(), none.csv()), ("[]\n".into(), "a,b\n".into()));
        assert_eq!(none.text(), "a  b\n");
    }

    #[test]
    fn digest_sees_every_value() {
        let mut other = sample();
        other.rows[0][1] = 1.250_000_000_000_000_2.into();
        assert_ne!(sample().digest(), other.digest());
        assert_eq!(sample().digest(), sample().digest());
    }
}
