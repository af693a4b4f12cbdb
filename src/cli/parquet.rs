//! Tables as Apache Parquet, where that is built in.

use foveasim_reports::Table;

use super::Failure;

/// Columns that hold text, and those that hold whole numbers; all others hold numbers.
pub(crate) struct Columns<'a> {
    pub(crate) text: &'a [&'a str],
    pub(crate) whole: &'a [&'a str],
}

/// Whether this is built in.
///
/// # Errors
/// If not: how to get it.
pub(crate) fn check() -> Result<(), Failure> {
    match cfg!(feature = "parquet") {
        true => Ok(()),
        false => Err(Failure::bad_input(
            "--format parquet: not built in; build with `--features parquet` to have it",
        )),
    }
}

/// A table as a file; without `columns`, by what is in each.
///
/// # Errors
/// As [`check`].
#[cfg(feature = "parquet")]
pub(crate) fn file(table: &Table, columns: Option<Columns<'_>>) -> Result<Vec<u8>, Failure> {
    use foveasim_reports::ColumnType;
    let Some(Columns { text, whole }) = columns else {
        return Ok(table.parquet(&table.column_types()));
    };
    let column = |name: &String| match name.as_str() {
        name if text.contains(&name) => ColumnType::Text,
        name if whole.contains(&name) => ColumnType::Whole,
        _ => ColumnType::Number,
    };
    let types: Vec<ColumnType> = table.columns().iter().map(column).collect();
    Ok(table.parquet(&types))
}

#[cfg(not(feature = "parquet"))]
pub(crate) fn file(_: &Table, columns: Option<Columns<'_>>) -> Result<Vec<u8>, Failure> {
    if let Some(Columns { text, whole }) = columns {
        let _ = (text, whole);
    }
    check().map(|()| Vec::new())
}
