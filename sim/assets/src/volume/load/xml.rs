//! As much of XML as VTK's files need: elements, their attributes and text, from the first to the last.

use crate::load::Flaw;

/// An element's beginning.
#[derive(Debug)]
pub(super) struct Tag<'a> {
    pub(super) name: &'a str,
    attributes: &'a str,
    /// What follows it, up to the next tag.
    pub(super) text: &'a [u8],
}

impl<'a> Tag<'a> {
    /// The value of an attribute.
    pub(super) fn get(&self, name: &str) -> Option<&'a str> {
        let mut rest = self.attributes;
        loop {
            let (key, after) = rest.split_once('=')?;
            let after = after.trim_start();
            let quote = after.chars().next().filter(|c| matches!(c, '"' | '\''))?;
            let (value, next) = after[1..].split_once(quote)?;
            if key.trim() == name {
                return Some(value);
            }
            rest = next;
        }
    }

    /// The value of an attribute that must be there.
    pub(super) fn required(&self, name: &str) -> Result<&'a str, Flaw> {
        let missing = || {
            Flaw::new(
                format_args!("<{}>", self.name),
                format_args!("has no {name}"),
            )
        };
        self.get(name).ok_or_else(missing)
    }

    /// Its name and an attribute's, as a place in the file.
    pub(super) fn place(&self, attribute: &str) -> String {
        format!("<{} {attribute}>", self.name)
    }
}

/// The beginnings of all elements up to `<AppendedData`, whose content is not XML.
pub(super) fn tags(bytes: &[u8]) -> Result<Vec<Tag<'_>>, Flaw> {
    /// More than any file needs.
    const MOST: usize = 4096;
    let mut all: Vec<Tag<'_>> = Vec::new();
    let mut at = 0;
    while let Some(open) = bytes[at..].iter().position(|b| *b == b'<') {
        let from = at + open + 1;
        let comment = bytes[from..].starts_with(b"!--");
        let end: &[u8] = if comment { b"-->" } else { b">" };
        let close = bytes[from..].windows(end.len()).position(|w| w == end);
        let Some(close) = close else {
            return Err(Flaw::new(format_args!("byte {at}"), "a tag does not end"));
        };
        at = from + close + end.len();
        let inside = &bytes[from..from + close];
        if comment || inside.starts_with(b"/") || inside.starts_with(b"?") {
            continue;
        }
        let inside = std::str::from_utf8(inside)
            .map_err(|e| Flaw::new(format_args!("byte {from}"), format_args!("not text: {e}")))?;
        let inside = inside.trim_end_matches('/');
        let split = inside.find(char::is_whitespace).unwrap_or(inside.len());
        let (name, attributes) = inside.split_at(split);
        let next = bytes[at..].iter().position(|b| *b == b'<');
        let appended = name == "AppendedData";
        let end = match next {
            Some(n) if !appended => at + n,
            _ => bytes.len(),
        };
        all.push(Tag {
            name,
            attributes,
            text: &bytes[at..end],
        });
        if appended || all.len() > MOST {
            break;
        }
    }
    Ok(all)
}
