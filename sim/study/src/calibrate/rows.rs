use foveasim_models::{FrameWork, ModelError, unknown_name};

/// A frame whose work and time were measured.
#[derive(Debug, Clone, PartialEq)]
pub struct CostRow {
    /// What it is, for people.
    pub name: String,
    /// What it belongs to: a scene, a user.
    pub group: String,
    /// What was done.
    pub work: FrameWork,
    /// What it took \[ms\], above 0.
    pub time_ms: f64,
}

/// Measured frames.
#[derive(Debug, Clone, PartialEq)]
pub struct CostRows {
    /// The frames.
    pub rows: Vec<CostRow>,
    /// The parts of work that are given, by their place in [`FrameWork::TERMS`].
    pub terms: Vec<usize>,
}

/// The most rows that are read.
const MOST_ROWS: usize = 100_000;

impl CostRows {
    /// Reads CSV with a header: `time_ms`, at least one column of [`FrameWork::TERMS`], and `name` and `group`
    /// where there are such; lines that begin with `#` are comments. `origin` names the text in errors.
    ///
    /// # Errors
    /// Names the line, the column, the value and what would be valid.
    pub fn parse(text: &str, origin: &str) -> Result<Self, ModelError> {
        let fail =
            |line: usize, what: String| Err(ModelError::Syntax(format!("{origin}:{line}: {what}")));
        let lines = text.lines().zip(1..);
        let mut lines = lines.filter(|(l, _)| !l.trim().is_empty() && !l.starts_with('#'));
        let Some((header, _)) = lines.next() else {
            return fail(1, "no header: want time_ms and columns of work".into());
        };
        let columns: Vec<&str> = header.split(',').map(str::trim).collect();
        let mut known = vec!["time_ms", "name", "group"];
        known.extend(FrameWork::TERMS);
        for (i, column) in columns.iter().enumerate() {
            if !known.contains(column) {
                return Err(ModelError::Syntax(format!(
                    "{origin}:1: {}",
                    unknown_name("column", column, &known)
                )));
            }
            if columns[..i].contains(column) {
                return fail(1, format!("column `{column}` twice"));
            }
        }
        let place = |name: &str| columns.iter().position(|c| *c == name);
        let Some(time) = place("time_ms") else {
            return fail(1, "no column `time_ms`".into());
        };
        let terms: Vec<usize> = (0..FrameWork::TERMS.len())
            .filter(|&k| place(FrameWork::TERMS[k]).is_some())
            .collect();
        if terms.is_empty() {
            let names = FrameWork::TERMS.join(", ");
            return fail(1, format!("no column of work: want one of {names}"));
        }
        let mut rows = Vec::new();
        for (line, number) in lines {
            if rows.len() == MOST_ROWS {
                return fail(number, format!("more than {MOST_ROWS} rows"));
            }
            let cells: Vec<&str> = line.split(',').map(str::trim).collect();
            if cells.len() != columns.len() {
                let (n, m) = (cells.len(), columns.len());
                return fail(number, format!("{n} cells; the header has {m}"));
            }
            let value = |i: usize, least: f64| match cells[i].parse::<f64>() {
                Ok(v) if (least..=1e15).contains(&v) => Ok(v),
                _ => {
                    let (column, cell) = (columns[i], cells[i]);
                    let text = format!("{column} = `{cell}`: want a number from {least} to 1e15");
                    Err(ModelError::Syntax(format!("{origin}:{number}: {text}")))
                }
            };
            let time_ms = value(time, 1e-9)?;
            let mut work = [0.0; FrameWork::TERMS.len()];
            for &k in &terms {
                let i = place(FrameWork::TERMS[k]).expect("a column that is there");
                work[k] = value(i, 0.0)?;
            }
            let text = |name: &str| place(name).map_or_else(String::new, |i| cells[i].to_owned());
            rows.push(CostRow {
                name: text("name"),
                group: text("group"),
                work: work.into(),
                time_ms,
            });
        }
        Ok(Self { rows, terms })
    }

    /// The rows of one group.
    ///
    /// # Errors
    /// If there is none; the error names the nearest group.
    pub fn of_group(self, group: &str) -> Result<Self, ModelError> {
        let mut names: Vec<&str> = self.rows.iter().map(|r| r.group.as_str()).collect();
        names.dedup();
        if !names.contains(&group) {
            return Err(unknown_name("group", group, &names));
        }
        let rows = self.rows.into_iter().filter(|r| r.group == group);
        Ok(Self {
            rows: rows.collect(),
            terms: self.terms,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_and_what_is_wrong_is_named() {
        let text = "# measured\nname,time_ms,samples_shaded,passes\nfull, 20.5 ,2073600,1\n\nlayers,4,156000,2\n";
        let read = CostRows::parse(text, "x.csv").unwrap();
        assert_eq!(read.terms, [0, 3]);
        assert_eq!(
            (read.rows[0].time_ms, read.rows[1].work.passes),
            (20.5, 2.0)
        );
        for (text, expect) in [
            ("", "x.csv:1: no header"),
            ("time_ms\n1\n", "no column of work"),
            ("samples,passes\n1,1\n", "no column `time_ms`"),
            ("time_ms,sample\n1,1\n", "did you mean `samples`"),
            ("time_ms,samples,samples\n1,1,1\n", "twice"),
            ("time_ms,samples\n1\n", "x.csv:2: 1 cells; the header has 2"),
            ("time_ms,samples\n0,1\n", "x.csv:2: time_ms = `0`"),
            ("time_ms,samples\n1,nan\n", "samples = `nan`"),
            ("time_ms,samples\n1,-1\n", "samples = `-1`"),
        ] {
            let error = CostRows::parse(text, "x.csv").unwrap_err().to_string();
            assert!(error.contains(expect), "{text:?}: {error}");
        }
        let error = read.of_group("a").unwrap_err().to_string();
        assert!(error.contains("group"), "{error}");
    }
}
