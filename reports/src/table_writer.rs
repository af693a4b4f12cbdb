use std::io::{self, Write};

use sha2::{Digest, Sha256};

use crate::Cell;
use crate::table::{exact, readable};

/// How wide the columns of a table are as text, and which of them hold numbers alone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextLayout {
    widths: Vec<usize>,
    numeric: Vec<bool>,
}

impl TextLayout {
    /// Of a table without rows.
    pub fn new<S: AsRef<str>>(columns: &[S]) -> Self {
        Self {
            widths: columns.iter().map(|c| c.as_ref().chars().count()).collect(),
            numeric: vec![true; columns.len()],
        }
    }

    /// Makes room for a row.
    pub fn add(&mut self, row: &[Cell]) {
        let columns = self.widths.iter_mut().zip(&mut self.numeric);
        for ((width, numeric), cell) in columns.zip(row) {
            *width = (*width).max(readable(cell, TEXT_DIGITS).chars().count());
            *numeric &= !matches!(cell, Cell::Text(_));
        }
    }

    fn line(&self, cells: impl Iterator<Item = String>) -> String {
        let padded = cells.zip(&self.widths).zip(&self.numeric);
        let padded = padded.map(|((cell, &w), &right)| match right {
            true => format!("{cell:>w$}"),
            false => format!("{cell:<w$}"),
        });
        format!("{}\n", padded.collect::<Vec<_>>().join("  ").trim_end())
    }
}

/// Significant digits of numbers in text.
const TEXT_DIGITS: usize = 6;

/// Writes a table row by row, with the bytes that [`Table`](crate::Table) gives for all of it at once.
///
/// The header is written with the first row, so that nothing is where nothing came about.
#[derive(Debug)]
pub struct TableWriter<W> {
    out: W,
    columns: Vec<String>,
    form: Form,
    rows: u64,
}

#[derive(Debug)]
enum Form {
    Text(TextLayout),
    Csv,
    Json,
}

impl<W: Write> TableWriter<W> {
    /// As aligned columns for people. `layout` has seen all rows: text cannot be aligned otherwise.
    pub fn text<S: Into<String>>(
        out: W,
        columns: impl IntoIterator<Item = S>,
        layout: TextLayout,
    ) -> Self {
        Self::new(out, columns, Form::Text(layout))
    }

    /// As CSV.
    pub fn csv<S: Into<String>>(out: W, columns: impl IntoIterator<Item = S>) -> Self {
        Self::new(out, columns, Form::Csv)
    }

    /// As a JSON array of objects.
    pub fn json<S: Into<String>>(out: W, columns: impl IntoIterator<Item = S>) -> Self {
        Self::new(out, columns, Form::Json)
    }

    fn new<S: Into<String>>(out: W, columns: impl IntoIterator<Item = S>, form: Form) -> Self {
        Self {
            out,
            columns: columns.into_iter().map(Into::into).collect(),
            form,
            rows: 0,
        }
    }

    /// Writes a row.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn row(&mut self, row: &[Cell]) -> io::Result<()> {
        if self.rows == 0 {
            self.header()?;
        }
        match &self.form {
            Form::Text(layout) => {
                let line = layout.line(row.iter().map(|cell| readable(cell, TEXT_DIGITS)));
                self.out.write_all(line.as_bytes())?;
            }
            Form::Csv => record(&mut self.out, row.iter().map(exact))?,
            Form::Json => {
                let fields = self.columns.iter().cloned();
                let fields = fields.zip(row.iter().map(Cell::to_json)).collect();
                let object = serde_json::to_string_pretty(&serde_json::Value::Object(fields))
                    .expect("plain values");
                let comma = if self.rows > 0 { "," } else { "" };
                write!(self.out, "{comma}\n  {}", object.replace('\n', "\n  "))?;
            }
        }
        self.rows += 1;
        Ok(())
    }

    /// Writes what follows the last row, and gives the output back.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> io::Result<W> {
        if self.rows == 0 {
            self.header()?;
        }
        if matches!(self.form, Form::Json) {
            let end: &[u8] = if self.rows > 0 { b"\n]\n" } else { b"]\n" };
            self.out.write_all(end)?;
        }
        self.out.flush()?;
        Ok(self.out)
    }

    fn header(&mut self) -> io::Result<()> {
        match &self.form {
            Form::Text(layout) => {
                let line = layout.line(self.columns.iter().cloned());
                self.out.write_all(line.as_bytes())
            }
            Form::Csv => record(&mut self.out, self.columns.iter().cloned()),
            Form::Json => self.out.write_all(b"["),
        }
    }
}

/// A row as CSV, with its line feed.
pub fn csv_line(row: &[Cell]) -> String {
    let mut line = Vec::new();
    record(&mut line, row.iter().map(exact)).expect("writing to memory");
    String::from_utf8(line).expect("cells are UTF-8")
}

fn record(out: &mut impl Write, fields: impl Iterator<Item = String>) -> io::Result<()> {
    let mut writer = csv::WriterBuilder::new()
        .buffer_capacity(512)
        .from_writer(out);
    writer.write_record(fields)?;
    writer.flush()
}

/// The digest of a table, row by row: [`Table::digest`](crate::Table::digest).
#[derive(Debug, Clone)]
pub struct TableDigest(Sha256);

impl TableDigest {
    /// Of a table with these columns.
    pub fn new<S: AsRef<str>>(columns: &[S]) -> Self {
        let mut digest = Self(Sha256::new());
        for column in columns {
            digest.field(0, column.as_ref().as_bytes());
        }
        digest
    }

    /// Takes a row.
    pub fn row(&mut self, row: &[Cell]) {
        for cell in row {
            match cell {
                Cell::Text(s) => self.field(1, s.as_bytes()),
                Cell::Int(i) => self.field(2, &i.to_le_bytes()),
                Cell::Float(f) => self.field(3, &f.to_bits().to_le_bytes()),
                Cell::Empty => self.field(4, &[]),
            }
        }
    }

    fn field(&mut self, tag: u8, bytes: &[u8]) {
        self.0.update([tag]);
        self.0.update((bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
    }

    /// 64 hexadecimal digits.
    pub fn finish(self) -> String {
        let hash = self.0.finalize();
        hash.iter().map(|b| format!("{b:02x}")).collect()
    }
}
