use std::borrow::Cow;

use super::error::Flaw;
use super::soup::coordinate;

/// The words of one line.
#[derive(Debug, Clone)]
pub(super) struct Words<'a> {
    /// From 1.
    pub(super) line: usize,
    rest: std::str::SplitWhitespace<'a>,
}

impl<'a> Words<'a> {
    pub(super) fn new(line: usize, text: &'a str) -> Self {
        Self {
            line,
            rest: text.split_whitespace(),
        }
    }

    /// The next word is a coordinate called `what`.
    pub(super) fn coordinate(&mut self, what: &str) -> Result<f64, Flaw> {
        let Some(word) = self.rest.next() else {
            return Err(Flaw::line(self.line, format_args!("{what} is missing")));
        };
        number(word, what).map_err(|problem| Flaw::line(self.line, problem))
    }

    /// The next words are so many coordinates.
    pub(super) fn coordinates<const N: usize>(&mut self, what: &str) -> Result<[f64; N], Flaw> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.coordinate(what)?;
        }
        Ok(values)
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        self.rest.next()
    }
}

/// `word` as a coordinate.
pub(super) fn number(word: &str, what: &str) -> Result<f64, String> {
    match word.parse() {
        Ok(value) => coordinate(value, what),
        Err(_) => Err(format!("{what} = {}: must be a number", shown(word))),
    }
}

/// A word of somebody's file as it may stand in a message: short, and printable.
pub(super) fn shown(word: &str) -> String {
    let short: String = word.chars().take(40).collect();
    format!("{short:?}")
}

/// Lines with their numbers from 1, without comments that begin with `#`; a line that ends in a
/// backslash goes on in the next. Bytes that are not UTF-8 (in old comments and names) are replaced.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut raw = bytes.split(|&b| b == b'\n').enumerate();
    std::iter::from_fn(move || {
        let (at, first) = raw.next()?;
        let mut line = uncommented(first);
        while line.trim_end().ends_with('\\') {
            let mut joined = line.trim_end().trim_end_matches('\\').to_owned();
            joined.push(' ');
            let more = raw.next().map(|(_, next)| uncommented(next));
            joined.push_str(more.as_deref().unwrap_or(""));
            line = Cow::Owned(joined);
        }
        Some((at + 1, line))
    })
}

fn uncommented(line: &[u8]) -> Cow<'_, str> {
    let end = line.iter().position(|&b| b == b'#').unwrap_or(line.len());
    String::from_utf8_lossy(&line[..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_go_on_and_comments_end() {
        let text = b"a b # c\n\nf 1 \\\r\n2 \\\n3\nlast \\";
        let got: Vec<_> = lines(text).map(|(n, l)| (n, l.trim().to_owned())).collect();
        let want = [(1, "a b"), (2, ""), (3, "f 1  2  3"), (6, "last")];
        assert_eq!(got, want.map(|(n, l)| (n, l.to_owned())));
    }
}
