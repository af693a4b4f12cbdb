//! NRRD (Kindlmann, teem.sourceforge.net/nrrd/format.html), versions 1 to 5, three axes.

use std::borrow::Cow;

use glam::{DAffine3, DVec3};

use super::fields::{after, numbers, shown};
use super::inflate::gunzip;
use super::{Draft, Element, affine};
use crate::load::{Flaw, SideFiles, Warnings};
use crate::volume::{Frame, Volume};

/// A header's lines.
#[derive(Default)]
struct Fields {
    /// Name in lower case, value, number of the line.
    all: Vec<(String, String, usize)>,
}

impl Fields {
    fn get(&self, name: &str) -> Option<(&str, String)> {
        let found = self.all.iter().find(|(n, ..)| n == name);
        found.map(|(n, v, line)| (v.as_str(), format!("line {line}: {n}")))
    }

    fn required(&self, name: &str) -> Result<(&str, String), Flaw> {
        self.get(name)
            .ok_or_else(|| Flaw::new("header", format_args!("has no field `{name}:`")))
    }
}

pub(super) fn load(
    bytes: &[u8],
    files: &dyn SideFiles,
    warnings: &mut Warnings,
) -> Result<Volume, Flaw> {
    let (fields, attached) = header(bytes)?;
    let draft = describe(&fields)?;
    let need = draft.bytes()?;
    let data: Cow<'_, [u8]> = match fields.get("data file").or(fields.get("datafile")) {
        None => Cow::Borrowed(attached),
        Some((name, place)) if name.starts_with("LIST") || name.contains('%') => {
            let problem = format_args!("{}: only one data file is read", shown(name));
            return Err(Flaw::new(place, problem));
        }
        Some((name, place)) => {
            let refused = |e| Flaw::new(place, format_args!("{}: {e}", shown(name)));
            Cow::Owned(files.read(name).map_err(refused)?)
        }
    };
    let skip = |name: &str| -> Result<i64, Flaw> {
        let Some((text, place)) = fields.get(name) else {
            return Ok(0);
        };
        numbers::<i64, 1>(&place, text).map(|[n]| n)
    };
    let (lines, skipped) = (skip("line skip")?.max(0), skip("byte skip")?);
    let mut data: &[u8] = &data;
    for _ in 0..lines {
        let end = data.iter().position(|b| *b == b'\n');
        let Some(end) = end else { break };
        data = &data[end + 1..];
    }
    let (encoding, place) = fields.required("encoding")?;
    match encoding.to_ascii_lowercase().as_str() {
        // −1: the numbers are the end of the file.
        "raw" if skipped < 0 => {
            draft.finish(after(data, data.len().saturating_sub(need)), warnings)
        }
        "raw" => draft.finish(after(data, skipped as usize), warnings),
        "gzip" | "gz" => {
            let skipped = usize::try_from(skipped).unwrap_or(0);
            let most = need.saturating_add(skipped.min(1 << 31));
            draft.finish(after(&gunzip(data, most)?, skipped), warnings)
        }
        "ascii" | "text" | "txt" => {
            let count = need / draft.element.bytes();
            let (voxels, more) = draft
                .element
                .parse(after(data, skipped.max(0) as usize), count)?;
            if more {
                draft.say_more("numbers", warnings);
            }
            draft.build(voxels)
        }
        other => {
            let problem = format_args!("{}: must be raw, gzip or ascii", shown(other));
            Err(Flaw::new(place, problem))
        }
    }
}

/// The header's lines and what follows the empty line after them.
fn header(bytes: &[u8]) -> Result<(Fields, &[u8]), Flaw> {
    let mut fields = Fields::default();
    let (mut rest, mut line) = (bytes, 0);
    loop {
        let end = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        let text = String::from_utf8_lossy(&rest[..end]);
        let text = text.trim();
        rest = after(rest, end + 1);
        line += 1;
        if text.is_empty() {
            return Ok((fields, rest));
        }
        // The magic, comments and key/value pairs (`key:=value`) are no fields.
        if line > 1
            && !text.starts_with('#')
            && !text.contains(":=")
            && let Some((name, value)) = text.split_once(':')
        {
            let name = name.trim().to_ascii_lowercase();
            fields.all.push((name, value.trim().to_owned(), line));
        }
        if line > 4096 {
            let problem = "more than 4096 lines without an empty one: the header does not end";
            return Err(Flaw::new("header", problem));
        }
    }
}

fn describe(fields: &Fields) -> Result<Draft, Flaw> {
    let (text, place) = fields.required("dimension")?;
    let [rank] = numbers::<u32, 1>(&place, text)?;
    if rank != 3 {
        return Err(Flaw::new(place, format_args!("{rank}: must be 3 axes")));
    }
    let (text, place) = fields.required("sizes")?;
    let dims = numbers::<u64, 3>(&place, text)?;
    let (text, place) = fields.required("type")?;
    let element = element(text).ok_or_else(|| {
        let problem = format_args!("{}: must be a whole or floating number", shown(text));
        Flaw::new(place, problem)
    })?;
    let (encoding, _) = fields.required("encoding")?;
    let binary = ["raw", "gzip", "gz"].contains(&encoding.to_ascii_lowercase().as_str());
    let big_endian = match fields.get("endian") {
        Some((text, place)) => match text.to_ascii_lowercase().as_str() {
            "little" => false,
            "big" => true,
            _ => {
                let problem = format_args!("{}: must be little or big", shown(text));
                return Err(Flaw::new(place, problem));
            }
        },
        None if element.bytes() > 1 && binary => {
            let problem = format_args!("has no field `endian:`, which {element} needs");
            return Err(Flaw::new("header", problem));
        }
        None => false,
    };
    let (world_from_index, frame) = orientation(fields)?;
    Ok(Draft {
        dims,
        element,
        big_endian,
        slope: 1.0,
        intercept: 0.0,
        world_from_index,
        frame,
    })
}

fn element(text: &str) -> Option<Element> {
    Some(match text {
        "signed char" | "int8" | "int8_t" => Element::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Element::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => {
            Element::I16
        }
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Element::U16,
        "int" | "signed int" | "int32" | "int32_t" => Element::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Element::U32,
        "longlong" | "long long" | "long long int" | "signed long long" | "int64" | "int64_t" => {
            Element::I64
        }
        "ulonglong" | "unsigned long long" | "uint64" | "uint64_t" => Element::U64,
        "float" => Element::F32,
        "double" => Element::F64,
        _ => return None,
    })
}

fn orientation(fields: &Fields) -> Result<(DAffine3, Frame), Flaw> {
    let steps = match (fields.get("space directions"), fields.get("spacings")) {
        (Some((text, place)), _) => {
            let all = numbers::<f64, 9>(&place, text)?;
            [0, 3, 6].map(|k| DVec3::from_slice(&all[k..k + 3]))
        }
        (None, Some((text, place))) => {
            let s = numbers::<f64, 3>(&place, text)?;
            // Not known: written as NaN.
            let s = s.map(|v| if v.is_nan() { 1.0 } else { v });
            [DVec3::X * s[0], DVec3::Y * s[1], DVec3::Z * s[2]]
        }
        (None, None) => [DVec3::X, DVec3::Y, DVec3::Z],
    };
    let origin = match fields.get("space origin") {
        Some((text, place)) => DVec3::from(numbers::<f64, 3>(&place, text)?),
        None => DVec3::ZERO,
    };
    let map = affine(steps, origin);
    // What must be turned so that +x is right, +y front, +z head.
    let flip = match fields
        .get("space")
        .map(|(text, _)| text.to_ascii_lowercase())
    {
        Some(s) if s == "right-anterior-superior" || s == "ras" => [1.0, 1.0, 1.0],
        Some(s) if s == "left-anterior-superior" || s == "las" => [-1.0, 1.0, 1.0],
        Some(s) if s == "left-posterior-superior" || s == "lps" => [-1.0, -1.0, 1.0],
        _ => return Ok((map, Frame::Plain)),
    };
    Ok((DAffine3::from_scale(flip.into()) * map, Frame::Anatomical))
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use glam::UVec3;

    use super::*;
    use crate::load::NoSideFiles;
    use crate::volume::load_volume_bytes;

    const HEAD: &str = "NRRD0004\n# made by hand\ntype: short\ndimension: 3\nsizes: 2 3 4\nspace: \
                        left-posterior-superior\nspace directions: (0,2,0) (3,0,0) (0,0,1.5)\nspace \
                        origin: (1,2,3)\nkind:=of test\n";

    struct Beside(Vec<u8>);

    impl SideFiles for Beside {
        fn read(&self, name: &str) -> std::io::Result<Vec<u8>> {
            assert_eq!(name, "data.raw");
            Ok(self.0.clone())
        }
    }

    fn numbers_of(big: bool) -> Vec<u8> {
        let bytes = |v: i16| {
            if big {
                v.to_be_bytes()
            } else {
                v.to_le_bytes()
            }
        };
        (0..24i16).flat_map(|k| bytes(100 * k - 300)).collect()
    }

    fn read(head: &str, data: &[u8], files: &dyn SideFiles) -> Result<Volume, String> {
        let bytes = [head.as_bytes(), data].concat();
        let loaded = load_volume_bytes(&bytes, "a.nrrd", 0, files);
        loaded.map(|l| l.volume).map_err(|e| e.to_string())
    }

    #[test]
    fn all_encodings_give_the_same() {
        let raw = read(
            &format!("{HEAD}encoding: raw\nendian: little\n\n"),
            &numbers_of(false),
            &NoSideFiles,
        )
        .unwrap();
        assert_eq!(raw.value(UVec3::new(1, 2, 3)), 2000.0);
        // Left and back become right and front.
        let at = raw.world_from_index().transform_point3(DVec3::ONE);
        assert_eq!(at, DVec3::new(-4.0, -4.0, 4.5));
        assert_eq!(raw.frame(), Frame::Anatomical);
        let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gz.write_all(&numbers_of(true)).unwrap();
        let head = format!("{HEAD}encoding: gzip\nendian: big\n\n");
        assert_eq!(
            read(&head, &gz.finish().unwrap(), &NoSideFiles).unwrap(),
            raw
        );
        let text: Vec<String> = (0..24).map(|k| (100 * k - 300).to_string()).collect();
        let head = format!("{HEAD}encoding: ascii\n\n");
        assert_eq!(
            read(&head, text.join(" ").as_bytes(), &NoSideFiles).unwrap(),
            raw
        );
        let head =
            format!("{HEAD}encoding: raw\nendian: big\nbyte skip: -1\ndata file: data.raw\n");
        let beside = Beside([&[7u8; 13], numbers_of(true).as_slice()].concat());
        assert_eq!(read(&head, &[], &beside).unwrap(), raw);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let head = format!("{HEAD}encoding: raw\nendian: little\n\n");
        let error = |head: &str, data: &[u8]| read(head, data, &NoSideFiles).unwrap_err();
        let text = error(&head, &numbers_of(false)[..40]);
        assert!(
            text.contains("40 bytes, but 2 x 3 x 4 voxels of i16 take 48"),
            "{text}"
        );
        let text = error(&head.replace("2 3 4", "2 x 4"), &[]);
        assert!(
            text.contains("a.nrrd: line 5: sizes: \"x\": must be a number"),
            "{text}"
        );
        assert!(error(&head.replace("2 3 4", "20000 20000 20000"), &[]).contains("2 to 4096"));
        assert!(error(&head.replace("short", "block"), &[]).contains("\"block\""));
        assert!(error(&head.replace("raw", "bzip2"), &[]).contains("raw, gzip or ascii"));
        assert!(error(&head.replace("endian: little\n", ""), &[]).contains("endian"));
        assert!(error(&head.replace("(0,2,0)", "none"), &[]).contains("\"none\""));
        assert!(error(&head.replace("raw", "gzip"), b"\x1f\x8b\x08broken").contains("damaged"));
        assert!(error(&head.replace("raw", "ascii"), b"1 2 3").contains("cannot hold 24"));
    }
}
