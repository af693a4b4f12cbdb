//! Tables as Apache Parquet, which DuckDB, Polars and Spark read.

use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::properties::{WriterProperties, WriterVersion};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::{Cell, Table};

/// What a column of a file holds; any value may be missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnType {
    /// UTF-8 text.
    Text,
    /// Whole numbers of 64 bits, with a sign.
    Whole,
    /// Numbers of double precision.
    Number,
}

/// Rows that are written together: what a reader takes at once.
const GROUP: usize = 1 << 17;

impl Table {
    /// The type of each column by what is in it: text if anything is, else numbers, whole if all are; numbers if
    /// there is nothing.
    pub fn column_types(&self) -> Vec<ColumnType> {
        let of = |column: usize| {
            let cells = || self.rows().iter().map(|row| &row[column]);
            let whole = cells().any(|c| matches!(c, Cell::Int(_)));
            if cells().any(|c| matches!(c, Cell::Text(_))) {
                ColumnType::Text
            } else if whole && cells().all(|c| matches!(c, Cell::Int(_) | Cell::Empty)) {
                ColumnType::Whole
            } else {
                ColumnType::Number
            }
        };
        (0..self.columns().len()).map(of).collect()
    }

    /// As a Parquet file with columns of these types, uncompressed; the same bytes for the same table. A cell
    /// that its column's type does not hold is told as text, or missing if the column is of numbers.
    ///
    /// # Panics
    /// If there is not one type for each column.
    pub fn parquet(&self, types: &[ColumnType]) -> Vec<u8> {
        assert_eq!(types.len(), self.columns().len(), "a type for each column");
        self.write_parquet(types)
            .expect("a table in memory has columns of one length")
    }

    fn write_parquet(&self, types: &[ColumnType]) -> Result<Vec<u8>, ParquetError> {
        let fields = self.columns().iter().zip(types);
        let fields = fields
            .map(|(name, column)| Ok(Arc::new(column.field(name)?)))
            .collect::<Result<Vec<_>, ParquetError>>()?;
        let schema = Type::group_type_builder("foveasim").with_fields(fields);
        let properties = WriterProperties::builder()
            .set_created_by(concat!("foveasim ", env!("CARGO_PKG_VERSION")).to_owned())
            .set_writer_version(WriterVersion::PARQUET_1_0)
            .set_compression(Compression::UNCOMPRESSED);
        let mut writer = SerializedFileWriter::new(
            Vec::new(),
            Arc::new(schema.build()?),
            Arc::new(properties.build()),
        )?;
        for rows in self.rows().chunks(GROUP) {
            let mut group = writer.next_row_group()?;
            for (place, column) in types.iter().enumerate() {
                let mut writer = group.next_column()?.expect("a writer for each column");
                column.write(writer.untyped(), rows.iter().map(|row| &row[place]))?;
                writer.close()?;
            }
            group.close()?;
        }
        writer.into_inner()
    }
}

impl ColumnType {
    fn field(self, name: &str) -> Result<Type, ParquetError> {
        let (physical, logical) = match self {
            Self::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            Self::Whole => (Physical::INT64, None),
            Self::Number => (Physical::DOUBLE, None),
        };
        Type::primitive_type_builder(name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical)
            .build()
    }

    fn write<'a>(
        self,
        writer: &mut ColumnWriter<'_>,
        cells: impl Iterator<Item = &'a Cell>,
    ) -> Result<(), ParquetError> {
        match writer {
            ColumnWriter::ByteArrayColumnWriter(writer) => {
                let text = |c: &Cell| match c {
                    Cell::Empty => None,
                    other => Some(ByteArray::from(crate::table::exact(other).as_str())),
                };
                let (values, present) = present(cells.map(text));
                writer.write_batch(&values, Some(&present), None)?;
            }
            ColumnWriter::Int64ColumnWriter(writer) => {
                let whole = |c: &Cell| match c {
                    Cell::Int(i) => Some(*i),
                    _ => None,
                };
                let (values, present) = present(cells.map(whole));
                writer.write_batch(&values, Some(&present), None)?;
            }
            ColumnWriter::DoubleColumnWriter(writer) => {
                let number = |c: &Cell| match c {
                    Cell::Int(i) => Some(*i as f64),
                    Cell::Float(f) => Some(*f),
                    _ => None,
                };
                let (values, present) = present(cells.map(number));
                writer.write_batch(&values, Some(&present), None)?;
            }
            _ => unreachable!("no field has another physical type"),
        }
        Ok(())
    }
}

/// What there is, and for each cell 1 if it is or 0.
fn present<T>(cells: impl Iterator<Item = Option<T>>) -> (Vec<T>, Vec<i16>) {
    let (mut values, mut present) = (Vec::new(), Vec::new());
    for cell in cells {
        present.push(i16::from(cell.is_some()));
        values.extend(cell);
    }
    (values, present)
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    use super::*;

    /// What a file holds, as cells.
    fn read(bytes: Vec<u8>) -> Table {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&bytes).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let schema = reader.metadata().file_metadata().schema_descr_ptr();
        let mut table = Table::new(schema.columns().iter().map(|c| c.name().to_owned()));
        for row in reader.get_row_iter(None).unwrap() {
            let cell = |(_, field): (&String, &Field)| match field {
                Field::Str(text) => Cell::Text(text.clone()),
                Field::Long(i) => Cell::Int(*i),
                Field::Double(f) => Cell::Float(*f),
                Field::Null => Cell::Empty,
                other => panic!("{other:?}"),
            };
            table.push(row.unwrap().get_column_iter().map(cell).collect());
        }
        table
    }

    #[test]
    fn a_file_reads_back_as_the_table_it_was() {
        let mut table = Table::new(["method", "mean_ms", "n", "rest_ms"]);
        // More than a group, so that there are two.
        for i in 0..GROUP + 5 {
            table.push(vec![
                ["a,b", "µ", ""][i % 3].into(),
                match i % 7 {
                    0 => Cell::Empty,
                    1 => f64::NEG_INFINITY.into(),
                    _ => (1.0 / i as f64).into(),
                },
                (i % 2 == 0).then_some(i).into(),
                Cell::Empty,
            ]);
        }
        let types = table.column_types();
        use ColumnType::{Number, Text, Whole};
        assert_eq!(types, [Text, Number, Whole, Number]);
        let bytes = table.parquet(&types);
        assert_eq!(bytes, table.parquet(&types));
        let back = read(bytes);
        assert_eq!(back.columns(), table.columns());
        assert_eq!(back.csv(), table.csv());
    }

    #[test]
    fn types_that_are_given_hold() {
        let mut table = Table::new(["a", "b", "c"]);
        table.push(vec![3u32.into(), 3u32.into(), 1.5.into()]);
        use ColumnType::{Number, Text, Whole};
        let back = read(table.parquet(&[Number, Text, Whole]));
        assert_eq!(back.rows()[0], [3.0.into(), "3".into(), Cell::Empty]);
        let none = Table::new(["a"]);
        assert_eq!(read(none.parquet(&[Whole])), none);
    }
}
