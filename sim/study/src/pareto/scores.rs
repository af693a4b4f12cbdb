use std::collections::BTreeMap;

use foveasim_models::ModelError;
use foveasim_models::foveation::Method;

/// Qualities that FovVideoVDP found of exported frames, in just-objectionable differences.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scores {
    jod: BTreeMap<(String, String), f64>,
}

/// The most rows that are read.
const MOST_ROWS: usize = 1_000_000;

impl Scores {
    /// Reads CSV with the header `clip,method,jod`, in any order of columns; lines that begin with `#` are comments.
    /// `origin` names the text in errors.
    ///
    /// # Errors
    /// Names the line, the column, the value and what would be valid.
    pub fn parse(text: &str, origin: &str) -> Result<Self, ModelError> {
        let fail =
            |line: usize, what: String| ModelError::Syntax(format!("{origin}:{line}: {what}"));
        let lines = text.lines().zip(1..);
        let mut lines = lines.filter(|(l, _)| !l.trim().is_empty() && !l.starts_with('#'));
        let header = lines.next().map_or("", |(header, _)| header);
        let columns: Vec<&str> = header.split(',').map(str::trim).collect();
        let place = |name: &str| {
            let found = columns.iter().position(|c| *c == name);
            found.ok_or_else(|| fail(1, format!("no column `{name}`: want clip,method,jod")))
        };
        let (clip, method, jod) = (place("clip")?, place("method")?, place("jod")?);
        let mut found = BTreeMap::new();
        for (line, number) in lines {
            if found.len() == MOST_ROWS {
                return Err(fail(number, format!("more than {MOST_ROWS} rows")));
            }
            let cells: Vec<&str> = line.split(',').map(str::trim).collect();
            if cells.len() != columns.len() {
                let (n, m) = (cells.len(), columns.len());
                return Err(fail(number, format!("{n} cells; the header has {m}")));
            }
            let value: f64 = match cells[jod].parse() {
                Ok(v) if (-100.0..=10.0).contains(&v) => v,
                _ => {
                    let text = format!("jod = `{}`: want a number from -100 to 10", cells[jod]);
                    return Err(fail(number, text));
                }
            };
            let named: Method = cells[method]
                .parse()
                .map_err(|e: ModelError| fail(number, e.to_string()))?;
            let name = (cells[clip].to_owned(), named.to_string());
            if found.insert(name, value).is_some() {
                let text = format!("{} on {} twice", cells[method], cells[clip]);
                return Err(fail(number, text));
            }
        }
        Ok(Self { jod: found })
    }

    /// The quality of a method on a clip.
    pub fn jod(&self, clip: &str, method: Method) -> Option<f64> {
        self.jod
            .get(&(clip.to_owned(), method.to_string()))
            .copied()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.jod.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.jod.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_are_read_and_what_is_wrong_is_named() {
        let text = "# FovVideoVDP v1.2\nmethod, clip, jod\nlayers:3:strict, study, 9.25\n";
        let read = Scores::parse(text, "s.csv").unwrap();
        let method = "layers:3:strict".parse().unwrap();
        assert_eq!((read.jod("study", method), read.len()), (Some(9.25), 1));
        assert_eq!(read.jod("room", method), None);
        for (text, expect) in [
            ("", "s.csv:1: no column `clip`"),
            ("clip,jod\n", "no column `method`"),
            (
                "clip,method,jod\nstudy,vrs\n",
                "s.csv:2: 2 cells; the header has 3",
            ),
            ("clip,method,jod\nstudy,vrs,nan\n", "s.csv:2: jod = `nan`"),
            ("clip,method,jod\nstudy,vrs,11\n", "from -100 to 10"),
            (
                "clip,method,jod\nstudy,vsr,9\n",
                "s.csv:2: unknown method `vsr`",
            ),
            ("clip,method,jod\na,vrs,9\na,vrs:tile=16,8\n", "twice"),
        ] {
            let error = Scores::parse(text, "s.csv").unwrap_err().to_string();
            assert!(error.contains(expect), "{text:?}: {error}");
        }
    }
}
