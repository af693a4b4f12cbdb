use std::str::FromStr;

use crate::load::Flaw;

/// A word of somebody's file as it may stand in a message: short, and printable.
pub(super) fn shown(word: &str) -> String {
    let short: String = word.chars().take(40).collect();
    format!("{short:?}")
}

/// So many numbers, with white space, commas or brackets between.
pub(super) fn numbers<T: FromStr, const N: usize>(place: &str, text: &str) -> Result<[T; N], Flaw> {
    let words = text
        .split(|c: char| c.is_whitespace() || matches!(c, ',' | '(' | ')'))
        .filter(|w| !w.is_empty());
    let mut all = Vec::with_capacity(N);
    for word in words {
        let refused = |_| Flaw::new(place, format_args!("{}: must be a number", shown(word)));
        all.push(word.parse().map_err(refused)?);
        if all.len() > N {
            break;
        }
    }
    let count = all.len();
    all.try_into().map_err(|_| {
        let problem = format_args!("{}: must be {N} numbers, not {count}", shown(text));
        Flaw::new(place, problem)
    })
}

/// The rest of a file that stands behind another one's header, after so many bytes.
pub(super) fn after(bytes: &[u8], skip: usize) -> &[u8] {
    bytes.get(skip..).unwrap_or(&[])
}
