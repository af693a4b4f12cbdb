use crate::TraceError;

/// The names in a header line, whatever separates them.
pub(crate) fn names(header: &str) -> Vec<&str> {
    header.split(separator(header)).map(unquoted).collect()
}

/// Tab, semicolon or comma: the first of these that the header has.
fn separator(header: &str) -> char {
    ['\t', ';']
        .into_iter()
        .find(|&c| header.contains(c))
        .unwrap_or(',')
}

/// Whether a column that is wanted as `a` or `a|b` has this name.
pub(crate) fn called(wanted: &str, name: &str) -> bool {
    wanted.split('|').any(|w| w.eq_ignore_ascii_case(name))
}

fn unquoted(field: &str) -> &str {
    // What begins and ends with a digit or a letter has neither spaces nor quotes around it.
    if let [first, .., last] = field.as_bytes()
        && first.is_ascii_alphanumeric()
        && last.is_ascii_alphanumeric()
    {
        return field;
    }
    let field = field.trim();
    field
        .strip_prefix('"')
        .and_then(|f| f.strip_suffix('"'))
        .unwrap_or(field)
}

/// Where the `N` columns that a reader wants stand in each row.
///
/// Columns are matched by name, in any order and letter case, `a|b` standing for either name; others are
/// tolerated. Each row must have as many fields as the header.
#[derive(Debug)]
pub(crate) struct Columns<const N: usize> {
    separator: char,
    /// For each field of a row, which wanted column it is.
    slots: Vec<Option<usize>>,
    present: [bool; N],
    extra: Vec<String>,
}

impl<const N: usize> Columns<N> {
    pub(crate) fn new(
        file: &str,
        (line, header): &(usize, String),
        wanted: [&str; N],
    ) -> Result<Self, TraceError> {
        let mut columns = Self {
            separator: separator(header),
            slots: Vec::new(),
            present: [false; N],
            extra: Vec::new(),
        };
        for name in names(header) {
            // An empty name is what a trailing separator leaves, or a slot that is not used.
            let is = |w: &&str| !name.is_empty() && called(w, name);
            let slot = wanted.iter().position(is);
            match slot {
                Some(i) if columns.present[i] => {
                    let what = format!("column `{name}` stands twice; each may stand once");
                    return Err(TraceError::Header {
                        file: file.to_owned(),
                        line: *line,
                        what,
                    });
                }
                Some(i) => columns.present[i] = true,
                // A name that is empty is what a trailing separator leaves.
                None if !name.is_empty() => columns.extra.push(name.to_owned()),
                None => {}
            }
            columns.slots.push(slot);
        }
        Ok(columns)
    }

    /// Whether column `i` of those wanted is there.
    pub(crate) fn has(&self, i: usize) -> bool {
        self.present[i]
    }

    /// Names of columns that nobody asked for.
    pub(crate) fn extra(&self) -> &[String] {
        &self.extra
    }

    /// What stands between fields.
    pub(crate) fn separator(&self) -> char {
        self.separator
    }

    /// Where fields are not separated by commas, a comma may be the decimal sign.
    pub(crate) fn decimal_comma(&self) -> bool {
        self.separator != ','
    }

    /// The fields of a row in the order wanted, absent columns empty; the number of fields where it is
    /// not the header's.
    pub(crate) fn pick<'a>(&self, row: &'a str) -> Result<[&'a str; N], usize> {
        let mut picked = [""; N];
        let mut found = 0;
        let mut rest = Some(row);
        while let Some(text) = rest {
            let end = memchr::memchr(self.separator as u8, text.as_bytes());
            if let Some(Some(slot)) = self.slots.get(found) {
                picked[*slot] = unquoted(&text[..end.unwrap_or(text.len())]);
            }
            found += 1;
            rest = end.map(|end| &text[end + 1..]);
        }
        if found == self.slots.len() {
            Ok(picked)
        } else {
            Err(found)
        }
    }

    /// How many fields a row has.
    pub(crate) fn width(&self) -> usize {
        self.slots.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_order_and_extra_columns() {
        let header = (1, "x; B ;\"a\"".to_owned());
        let columns = Columns::new("f", &header, ["a", "b", "c"]).unwrap();
        assert_eq!(columns.pick("1;2,5; 3 "), Ok(["3", "2,5", ""]));
        assert_eq!(columns.pick("1;2"), Err(2));
        assert_eq!(columns.pick("1;2;3;4"), Err(4));
        assert_eq!(columns.extra(), ["x"]);
        assert!(!columns.has(2) && columns.decimal_comma());
        let twice = (1, "a,A".to_owned());
        assert!(
            Columns::new("f", &twice, ["a"])
                .unwrap_err()
                .to_string()
                .contains("twice")
        );
    }
}
