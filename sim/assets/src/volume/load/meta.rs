//! MetaImage (Insight Toolkit, MetaIO): `key = value` lines, numbers behind them or in another file.

use std::borrow::Cow;

use glam::DVec3;

use super::fields::{after, numbers, shown};
use super::inflate::{gunzip, is_gzip, unzlib};
use super::{Draft, Element, affine, half_turn};
use crate::load::{Flaw, SideFiles, Warnings};
use crate::volume::{Frame, Volume};

struct Fields {
    all: Vec<(String, String, usize)>,
}

impl Fields {
    /// The value of the first of these keys that is there, and its place.
    fn get(&self, keys: &[&str]) -> Option<(&str, String)> {
        let found = |key: &&str| self.all.iter().find(|(k, ..)| k == key);
        keys.iter()
            .find_map(found)
            .map(|(k, v, line)| (v.as_str(), format!("line {line}: {k}")))
    }

    fn required(&self, key: &str) -> Result<(&str, String), Flaw> {
        self.get(&[key])
            .ok_or_else(|| Flaw::new("header", format_args!("has no line `{key} = …`")))
    }

    fn is_true(&self, keys: &[&str]) -> bool {
        self.get(keys)
            .is_some_and(|(v, _)| v.eq_ignore_ascii_case("true") || v == "1")
    }

    fn vector(&self, keys: &[&str], default: DVec3) -> Result<DVec3, Flaw> {
        match self.get(keys) {
            Some((text, place)) => Ok(DVec3::from(numbers::<f64, 3>(&place, text)?)),
            None => Ok(default),
        }
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
    let (name, place) = fields.required("ElementDataFile")?;
    let data: Cow<'_, [u8]> = match name {
        "LOCAL" | "Local" | "local" => Cow::Borrowed(attached),
        _ if name.starts_with("LIST") || name.contains('%') => {
            let problem = format_args!("{}: only one data file is read", shown(name));
            return Err(Flaw::new(place, problem));
        }
        _ => {
            let refused = |e| Flaw::new(place, format_args!("{}: {e}", shown(name)));
            Cow::Owned(files.read(name).map_err(refused)?)
        }
    };
    let mut data: &[u8] = &data;
    if let Some((text, place)) = fields.get(&["HeaderSize"]) {
        let [skip] = numbers::<i64, 1>(&place, text)?;
        // −1: the numbers are the end of the file.
        let skip = usize::try_from(skip).unwrap_or(data.len().saturating_sub(need));
        data = after(data, skip);
    }
    if fields.is_true(&["CompressedData"]) {
        let plain = if is_gzip(data) {
            gunzip(data, need)?
        } else {
            unzlib(data, need)?
        };
        return draft.finish(&plain, warnings);
    }
    // Numbers are text if the file says that they are not binary.
    let text = fields.get(&["BinaryData"]).is_some() && !fields.is_true(&["BinaryData"]);
    if text {
        let count = need / draft.element.bytes();
        let (voxels, more) = draft.element.parse(data, count)?;
        if more {
            draft.say_more("numbers", warnings);
        }
        return draft.build(voxels);
    }
    draft.finish(data, warnings)
}

/// The header's lines up to `ElementDataFile`, and what follows.
fn header(bytes: &[u8]) -> Result<(Fields, &[u8]), Flaw> {
    let mut all = Vec::new();
    let (mut rest, mut line) = (bytes, 0);
    while !rest.is_empty() && line < 4096 {
        let end = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        let text = String::from_utf8_lossy(&rest[..end]).into_owned();
        rest = after(rest, end + 1);
        line += 1;
        let Some((key, value)) = text.split_once('=') else {
            if text.trim().is_empty() {
                continue;
            }
            let problem = format_args!("{}: must be `key = value`", shown(text.trim()));
            return Err(Flaw::line(line, problem));
        };
        let key = key.trim().to_owned();
        let last = key == "ElementDataFile";
        all.push((key, value.trim().to_owned(), line));
        if last {
            return Ok((Fields { all }, rest));
        }
    }
    Err(Flaw::new("header", "has no line `ElementDataFile = …`"))
}

fn describe(fields: &Fields) -> Result<Draft, Flaw> {
    let (text, place) = fields.required("NDims")?;
    let [rank] = numbers::<u32, 1>(&place, text)?;
    if rank != 3 {
        return Err(Flaw::new(place, format_args!("{rank}: must be 3")));
    }
    let (text, place) = fields.required("DimSize")?;
    let dims = numbers::<u64, 3>(&place, text)?;
    if let Some((text, place)) = fields.get(&["ElementNumberOfChannels"])
        && text != "1"
    {
        let problem = format_args!("{}: must be 1 number for each voxel", shown(text));
        return Err(Flaw::new(place, problem));
    }
    let (text, place) = fields.required("ElementType")?;
    let element = match text {
        "MET_UCHAR" => Element::U8,
        "MET_CHAR" => Element::I8,
        "MET_USHORT" => Element::U16,
        "MET_SHORT" => Element::I16,
        "MET_UINT" | "MET_ULONG" => Element::U32,
        "MET_INT" | "MET_LONG" => Element::I32,
        "MET_ULONG_LONG" => Element::U64,
        "MET_LONG_LONG" => Element::I64,
        "MET_FLOAT" => Element::F32,
        "MET_DOUBLE" => Element::F64,
        _ => {
            let problem = format_args!("{}: must be a whole or floating number", shown(text));
            return Err(Flaw::new(place, problem));
        }
    };
    let spacing = fields.vector(&["ElementSpacing", "ElementSize"], DVec3::ONE)?;
    let origin = fields.vector(&["Offset", "Position", "Origin"], DVec3::ZERO)?;
    let axes = match fields.get(&["TransformMatrix", "Orientation", "Rotation"]) {
        // One axis after the other.
        Some((text, place)) => {
            let all = numbers::<f64, 9>(&place, text)?;
            [0, 3, 6].map(|k| DVec3::from_slice(&all[k..k + 3]))
        }
        None => [DVec3::X, DVec3::Y, DVec3::Z],
    };
    let steps = std::array::from_fn(|k| axes[k] * spacing[k]);
    Ok(Draft {
        dims,
        element,
        big_endian: fields.is_true(&["BinaryDataByteOrderMSB", "ElementByteOrderMSB"]),
        slope: 1.0,
        intercept: 0.0,
        world_from_index: half_turn(affine(steps, origin)),
        frame: Frame::Anatomical,
    })
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use glam::UVec3;

    use super::*;
    use crate::load::NoSideFiles;
    use crate::volume::load_volume_bytes;

    const HEAD: &str = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = \
                        False\nTransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 1 2 3\nElementSpacing = 2 3 \
                        4\nDimSize = 2 3 4\nElementType = MET_USHORT\n";

    fn read(head: &str, data: &[u8]) -> Result<Volume, String> {
        let bytes = [head.as_bytes(), data].concat();
        let loaded = load_volume_bytes(&bytes, "a.mha", 0, &NoSideFiles);
        loaded.map(|l| l.volume).map_err(|e| e.to_string())
    }

    fn data() -> Vec<u8> {
        (0..24u16).flat_map(|k| (1000 * k).to_le_bytes()).collect()
    }

    #[test]
    fn attached_compressed_and_text_give_the_same() {
        let local = format!("{HEAD}ElementDataFile = LOCAL\n");
        let raw = read(&local, &data()).unwrap();
        assert_eq!(raw.value(UVec3::new(1, 2, 3)), 23_000.0);
        // The first axis points along +y, two long; then all is turned by half.
        let at = raw.world_from_index().transform_point3(DVec3::X);
        assert_eq!(at, DVec3::new(-1.0, -4.0, 3.0));
        let mut z = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        z.write_all(&data()).unwrap();
        let head = format!("{HEAD}CompressedData = True\nElementDataFile = LOCAL\n");
        assert_eq!(read(&head, &z.finish().unwrap()).unwrap(), raw);
        let text: Vec<String> = (0..24).map(|k| (1000 * k).to_string()).collect();
        let head = local.replace("BinaryData = True", "BinaryData = False");
        assert_eq!(read(&head, text.join("\n").as_bytes()).unwrap(), raw);
        let big: Vec<u8> = (0..24u16).flat_map(|k| (1000 * k).to_be_bytes()).collect();
        let head = local.replace("MSB = False", "MSB = True");
        assert_eq!(read(&head, &big).unwrap(), raw);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let local = format!("{HEAD}ElementDataFile = LOCAL\n");
        let error = |head: &str| read(head, &data()).unwrap_err();
        assert!(error(&local.replace("2 3 4\nE", "2 3 5\nE")).contains("take 60"));
        assert!(error(&local.replace("MET_USHORT", "MET_STRING")).contains("\"MET_STRING\""));
        assert!(read(HEAD, b"").unwrap_err().contains("ElementDataFile"));
        assert!(error(&local.replace("NDims = 3", "NDims = 2")).contains("must be 3"));
        assert!(error(&local.replace("LOCAL", "../x.raw")).contains("a.mha: line 10"));
        assert!(error("ElementType\n").contains("line 1"));
    }
}
