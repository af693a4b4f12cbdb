use std::collections::HashMap;

use glam::DVec3;

use super::error::Flaw;
use super::soup::{Corner, LARGEST, NONE, Soup};
use super::text::{Words, lines, shown};
use super::{Draft, Warnings};
use crate::Textured;

/// Bytes before the first triangle of a binary file: a comment of 80 and the count.
const HEADER: usize = 84;
/// Bytes of a triangle: normal, three corners, two bytes of anything.
const TRIANGLE: usize = 50;

fn claimed(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(80..HEADER)?;
    Some(u64::from(u32::from_le_bytes(count.try_into().ok()?)))
}

/// Whether the length is what a binary file of its count has: text that begins with `solid` tells
/// nothing, since binary files often do, too.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    claimed(bytes).is_some_and(|n| bytes.len() as u64 == HEADER as u64 + n * TRIANGLE as u64)
}

/// Whether it begins as text does.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(4096)];
    let word = start.trim_ascii_start().starts_with(b"solid");
    word && start.windows(5).any(|w| w == b"facet" || w == b"endso")
}

/// STL, text or binary: loose triangles. Corners at exactly the same position are made one, so that
/// normals can be computed; the file's own ones, one per triangle, are not used.
pub(super) fn load(bytes: &[u8], warnings: &mut Warnings) -> Result<Draft, Flaw> {
    let mut soup = Soup::default();
    let mut welded = HashMap::new();
    if is_text(bytes) && !is_binary(bytes) {
        text(bytes, &mut soup, &mut welded)?;
    } else {
        binary(bytes, &mut soup, &mut welded, warnings)?;
    }
    Draft::of_soup(soup, vec![Textured::default()], warnings)
}

type Welded = HashMap<[u64; 3], u32>;

/// The corner at `p`.
fn weld(p: DVec3, soup: &mut Soup, welded: &mut Welded) -> Corner {
    // −0 and 0 are one place.
    let key = (p + 0.0).to_array().map(f64::to_bits);
    let position = *welded.entry(key).or_insert_with(|| {
        soup.positions.push(p);
        soup.positions.len() as u32 - 1
    });
    Corner {
        position,
        uv: NONE,
        normal: NONE,
    }
}

fn binary(
    bytes: &[u8],
    soup: &mut Soup,
    welded: &mut Welded,
    warnings: &mut Warnings,
) -> Result<(), Flaw> {
    let count = claimed(bytes).ok_or_else(|| {
        let problem = format!("{} bytes: a binary STL has at least {HEADER}", bytes.len());
        Flaw::new("header", problem)
    })?;
    let there = (bytes.len() - HEADER) / TRIANGLE;
    if count > there as u64 {
        let problem = format!("claims {count} triangles of {TRIANGLE} bytes; {there} are there");
        return Err(Flaw::new("byte 80", problem));
    }
    let end = HEADER + count as usize * TRIANGLE;
    if bytes.len() > end {
        let extra = bytes.len() - end;
        warnings.add(format_args!(
            "{extra} bytes after the last triangle are not read"
        ));
    }
    for (i, triangle) in bytes[HEADER..end].chunks_exact(TRIANGLE).enumerate() {
        let value = |at: usize| {
            let b = &triangle[at..at + 4];
            f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        };
        let corners = [0, 1, 2].map(|k| {
            let at = 12 + 12 * k;
            DVec3::new(value(at), value(at + 4), value(at + 8))
        });
        for p in &corners {
            if !p.to_array().iter().all(|c| c.abs() <= LARGEST) {
                let place = format!("triangle {i} at byte {}", HEADER + i * TRIANGLE);
                let problem = format!("corner at {p}: must be three numbers within ±1e6");
                return Err(Flaw::new(place, problem));
            }
        }
        let corners = corners.map(|p| weld(p, soup, welded));
        soup.triangles.push(corners);
    }
    Ok(())
}

fn text(bytes: &[u8], soup: &mut Soup, welded: &mut Welded) -> Result<(), Flaw> {
    let mut corners = Vec::with_capacity(3);
    let mut open = None;
    let mut last = 1;
    for (line, text) in lines(bytes) {
        last = line;
        let mut words = Words::new(line, &text);
        match words.next() {
            None | Some("solid" | "endsolid" | "outer" | "endloop") => {}
            Some("facet") => {
                if let Some(begun) = open.replace(line) {
                    let problem = format!("facet before endfacet of the one in line {begun}");
                    return Err(Flaw::line(line, problem));
                }
            }
            Some("vertex") => {
                let p = DVec3::from_array(words.coordinates("vertex")?);
                corners.push(weld(p, soup, welded));
            }
            Some("endfacet") => {
                open = None;
                let Ok(triangle) = <[Corner; 3]>::try_from(corners.as_slice()) else {
                    let problem = format!("a facet of {} vertices: needs 3", corners.len());
                    return Err(Flaw::line(line, problem));
                };
                soup.triangles.push(triangle);
                corners.clear();
            }
            Some(word) => {
                let want = "solid, facet, outer loop, vertex, endloop, endfacet or endsolid";
                return Err(Flaw::line(
                    line,
                    format_args!("{}: must be {want}", shown(word)),
                ));
            }
        }
    }
    match open {
        Some(begun) => {
            let problem = format!("the file ends within the facet of line {begun}");
            Err(Flaw::line(last, problem))
        }
        None => Ok(()),
    }
}
