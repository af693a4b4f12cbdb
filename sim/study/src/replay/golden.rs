use std::fmt;

use foveasim_reports::Table;

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
        let quoted = |cell: Option<&str>| cell.map_or("nothing".into(), |text| format!("`{text}`"));
        match self {
            Self::Digest(expected) => {
                let got = table.digest();
                let place = "digest".into();
                (got != *expected).then(|| Difference {
                    place,
                    expected: expected.clone(),
                    got,
                })
            }
            Self::Csv(expected) => {
                let got = table.csv();
                let got: Vec<&str> = got.lines().collect();
                let columns = table.columns();
                for (i, (want, have)) in expected.iter().zip(&got).enumerate() {
                    let (mut want, mut have) = (want.split(','), have.split(','));
                    for c in 0.. {
                        let (a, b) = (want.next(), have.next());
                        if a != b {
                            let column = columns.get(c).map_or("beyond the last", String::as_str);
                            let place = match i {
                                0 => format!("header, column {}", c + 1),
                                _ => format!("row {i}, column {column}"),
                            };
                            return Some(Difference {
                                place,
                                expected: quoted(a),
                                got: quoted(b),
                            });
                        }
                        if a.is_none() {
                            break;
                        }
                    }
                }
                (expected.len() != got.len()).then(|| Difference {
                    place: "number of rows".into(),
                    expected: (expected.len() - 1).to_string(),
                    got: (got.len() - 1).to_string(),
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let mut table = Table::new(["scan", "x"]);
        table.push(vec![0u32.into(), 1.5.into()]);
        table.push(vec![1u32.into(), foveasim_reports::Cell::Empty]);
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
