use std::ops::Range;

use crate::{ReadOptions, TraceError};

/// Chooses one of the sessions that are joined in a file: the one asked for, or the first of the
/// longest, with a note where there are several.
///
/// `starts` are the indices at which sessions begin, the first of them 0; `noun` is what is counted.
pub(super) fn choose(
    file: &str,
    starts: &[usize],
    total: usize,
    noun: &str,
    options: &ReadOptions,
) -> Result<(Range<usize>, Option<String>), TraceError> {
    let ends = starts.iter().skip(1).copied().chain([total]);
    let ranges: Vec<_> = starts
        .iter()
        .copied()
        .zip(ends)
        .map(|(a, b)| a..b)
        .collect();
    let segments = ranges.len();
    let chosen = match options.segment {
        Some(n) if (1..=segments).contains(&n) => n - 1,
        Some(wanted) => {
            return Err(TraceError::NoSuchSegment {
                file: file.to_owned(),
                wanted,
                segments,
            });
        }
        None => (0..segments)
            .rev()
            .max_by_key(|&i| ranges[i].len())
            .unwrap_or(0),
    };
    let note = (segments > 1).then(|| {
        const LISTED: usize = 6;
        let mut sizes: Vec<_> = ranges
            .iter()
            .take(LISTED)
            .map(|r| r.len().to_string())
            .collect();
        if segments > LISTED {
            sizes.push("…".to_owned());
        }
        let why = if options.segment.is_some() {
            "as asked"
        } else {
            "the longest; --segment chooses"
        };
        format!(
            "{segments} sessions joined in one file ({} {noun}s); segment {} is read, {why}",
            sizes.join(" and "),
            chosen + 1
        )
    });
    Ok((ranges[chosen].clone(), note))
}
