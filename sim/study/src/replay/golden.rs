use std::fmt;

use foveasim_reports::{Cell, Table, TableDigest, csv_line};

/// What a replay should give: the digest of its table, or the whole table as CSV.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Golden {
    /// 64 hexadecimal digits, as printed by `replay --digest`.
    Digest(String),
    /// Lines of a CSV file, header first, as printed by `replay --format csv`.
    Csv(Vec<String>),
}

/// Where a table first differs from its golden one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// Where: a row and a column, or what about the whole.
    pub place: String,
    /// What the golden file says.
    pub expected: String,
    /// What the replay gives.
    pub got: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: expected {}, got {}",
            self.place, self.expected, self.got
        )
    }
}

impl Golden {
    /// Reads a golden file; `None` if the text is neither a digest nor a CSV of a replay.
    pub fn parse(text: &str) -> Option<Self> {
        let trimmed = text.trim();
        if trimmed.len() == 64 && trimmed.bytes().all(|b| b.is_ascii_hexdigit()) {
            return Some(Self::Digest(trimmed.to_ascii_lowercase()));
        }
        // The first column is enough to know one; other columns are a difference, not an error.
        trimmed
            .starts_with("scan,")
            .then(|| Self::Csv(trimmed.lines().map(str::to_owned).collect()))
    }

    /// The first difference between this and `table`.
    pub fn difference(&self, table: &Table) -> Option<Difference> {
        let mut check = GoldenCheck::new(self, table.columns());
        table.rows().iter().for_each(|row| check.row(row));
        check.finish()
    }
}

/// Compares a table with its golden one row by row.
#[derive(Debug)]
pub struct GoldenCheck<'a> {
    golden: &'a Golden,
    columns: Vec<String>,
    digest: TableDigest,
    /// Lines compared so far, the header's among them.
    lines: usize,
    found: Option<Difference>,
}

impl<'a> GoldenCheck<'a> {
    /// Begins with the header of a table of these columns.
    pub fn new<S: AsRef<str>>(golden: &'a Golden, columns: &[S]) -> Self {
        let columns: Vec<String> = columns.iter().map(|c| c.as_ref().to_owned()).collect();
        let mut check = Self {
            golden,
            digest: TableDigest::new(&columns),
            columns,
            lines: 0,
            found: None,
        };
        let header: Vec<Cell> = check.columns.iter().map(|c| c.as_str().into()).collect();
        check.line(&header);
        check
    }

    /// Compares the next row.
    pub fn row(&mut self, row: &[Cell]) {
        match self.golden {
            Golden::Digest(_) => self.digest.row(row),
            Golden::Csv(_) => self.line(row),
        }
    }

    fn line(&mut self, row: &[Cell]) {
        let Golden::Csv(expected) = self.golden else {
            return;
        };
        let i = self.lines;
        self.lines += 1;
        let (None, Some(want)) = (&self.found, expected.get(i)) else {
            return;
        };
        let have = csv_line(row);
        let (mut want, mut have) = (want.split(','), have.trim_end_matches('\n').split(','));
        let quoted = |cell: Option<&str>| cell.map_or("nothing".into(), |text| format!("`{text}`"));
        for c in 0.. {
            let (a, b) = (want.next(), have.next());
            if a != b {
                let column = self
                    .columns
                    .get(c)
                    .map_or("beyond the last", String::as_str);
                let place = match i {
                    0 => format!("header, column {}", c + 1),
                    _ => format!("row {i}, column {column}"),
                };
                self.found = Some(Difference {
                    place,
                    expected: quoted(a),
                    got: quoted(b),
                });
                return;
            }
            if a.is_none() {
                return;
            }
        }
    }

    /// The first difference, if there is any.
    pub fn finish(self) -> Option<Difference> {
        match self.golden {
            Golden::Digest(expected) => {
                let got = self.digest.finish();
                (got != *expected).then(|| Difference {
                    place: "digest".into(),
                    expected: expected.clone(),
                    got,
                })
            }
            Golden::Csv(expected) => self.found.or_else(|| {
                (expected.len() != self.lines).then(|| Difference {
                    place: "number of rows".into(),
                    expected: (expected.len() - 1).to_string(),
                    got: (self.lines - 1).to_string(),
                })
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let mut table = Table::new(["scan", "x"]);
        table.push(vec![0u32.into(), 1.5.into()]);
        table.push(vec![1u32.into(), Cell::Empty]);
        table
    }

    #[test]
    fn the_first_difference_is_named() {
        let t = table();
        let say = |text: &str| {
            Golden::parse(text)
                .unwrap()
                .difference(&t)
                .map(|d| d.to_string())
        };
        assert_eq!(say(&t.digest()), None);
        assert_eq!(say(&t.csv()), None);
        assert_eq!(say(&t.csv().replace('\n', "\r\n")), None);
        assert_eq!(
            say("scan,x\n0,1.25\n").unwrap(),
            "row 1, column x: expected `1.25`, got `1.5`"
        );
        assert_eq!(
            say("scan,y\n").unwrap(),
            "header, column 2: expected `y`, got `x`"
        );
        assert_eq!(
            say("scan,x\n0,1.5\n").unwrap(),
            "number of rows: expected 1, got 2"
        );
        assert_eq!(
            say("scan,x\n0,1.5,7\n1,").unwrap(),
            "row 1, column beyond the last: expected `7`, got nothing"
        );
        assert!(
            say(&"0".repeat(64))
                .unwrap()
                .starts_with("digest: expected 000")
        );
        assert_eq!(Golden::parse(""), None);
        assert_eq!(Golden::parse("not a golden file"), None);
    }
}
