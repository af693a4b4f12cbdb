use crate::{Cell, ReportError, Table};

impl Table {
    /// The table that [`Table::csv`] wrote, at most `most_rows` of it. Cells that read as a number are one. `origin`
    /// names the text in errors.
    ///
    /// # Errors
    /// Names the line if it has another number of cells than the header, or there are too many rows.
    pub fn from_csv(text: &str, origin: &str, most_rows: usize) -> Result<Self, ReportError> {
        let fail = |line: u64, why: String| ReportError::Csv {
            origin: origin.to_owned(),
            line,
            why,
        };
        let wrong = |error: csv::Error| {
            let line = error.position().map_or(1, csv::Position::line);
            let why = match error.kind() {
                csv::ErrorKind::UnequalLengths {
                    expected_len, len, ..
                } => format!("{len} cells; the header has {expected_len}"),
                _ => error.to_string(),
            };
            fail(line, why)
        };
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let columns = reader.headers().map_err(wrong)?.clone();
        if columns.is_empty() {
            return Err(fail(1, "no header".into()));
        }
        let mut table = Self::new(columns.iter());
        for row in reader.records() {
            let row = row.map_err(wrong)?;
            if table.rows().len() == most_rows {
                let line = row.position().map_or(0, csv::Position::line);
                return Err(fail(line, format!("more than {most_rows} rows")));
            }
            table.push(row.iter().map(read).collect());
        }
        Ok(table)
    }
}

fn read(text: &str) -> Cell {
    if text.is_empty() {
        return Cell::Empty;
    }
    if let Ok(whole) = text.parse() {
        return Cell::Int(whole);
    }
    match text.parse() {
        Ok(number) => Cell::Float(number),
        Err(_) => Cell::Text(text.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_back() {
        let mut table = Table::new(["name", "a_ms", "n"]);
        table.push(vec!["a, \"b\"\nc".into(), 0.1.into(), Cell::Int(3)]);
        table.push(vec![Cell::Empty, (-1e-300).into(), Cell::Empty]);
        let back = Table::from_csv(&table.csv(), "t.csv", 2).unwrap();
        assert_eq!(back, table);
    }

    #[test]
    fn what_is_no_table_is_refused() {
        for (text, most, expect) in [
            ("", 9, "t.csv:1: no header"),
            ("a,b\n1,2\n3\n", 9, "t.csv:3: 1 cells; the header has 2"),
            ("a\n1\n2\n3\n", 2, "t.csv:4: more than 2 rows"),
        ] {
            let error = Table::from_csv(text, "t.csv", most).unwrap_err();
            assert_eq!(error.to_string(), expect);
        }
    }
}
