//! VTK's XML image data (VTK File Formats, "XML File Formats"): one piece, one number for each point.

use base64::Engine;
use base64::engine::general_purpose::GeneralPurpose;
use base64::engine::{DecodePaddingMode, GeneralPurposeConfig};
use glam::{DMat3, DVec3};

use super::fields::{after, numbers, shown};
use super::inflate::unzlib;
use super::xml::{Tag, tags};
use super::{Draft, Element, affine};
use crate::load::{Flaw, Warnings};
use crate::volume::{Frame, Volume};

const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// How numbers that are not text are written.
struct Coding {
    big_endian: bool,
    /// Bytes of a count of bytes.
    count_bytes: usize,
    compressed: bool,
}

pub(super) fn load(bytes: &[u8], warnings: &mut Warnings) -> Result<Volume, Flaw> {
    let tags = tags(bytes)?;
    let find = |name: &str| tags.iter().find(|t| t.name == name);
    let need = |name: &str| {
        find(name).ok_or_else(|| Flaw::new("whole file", format_args!("has no <{name}>")))
    };
    let file = need("VTKFile")?;
    let kind = file.required("type")?;
    if kind != "ImageData" {
        let problem = format_args!("{}: must be ImageData", shown(kind));
        return Err(Flaw::new(file.place("type"), problem));
    }
    let coding = coding(file)?;
    let image = need("ImageData")?;
    if tags.iter().filter(|t| t.name == "Piece").count() > 1 {
        return Err(Flaw::new("<Piece>", "there are several: only one is read"));
    }
    if let Some(piece) = find("Piece")
        && let Some(own) = piece.get("Extent")
    {
        let extent = |tag: &Tag<'_>, name, text| numbers::<i64, 6>(&tag.place(name), text);
        let whole = extent(image, "WholeExtent", image.required("WholeExtent")?)?;
        if extent(piece, "Extent", own)? != whole {
            let problem = format_args!("{}: must be the WholeExtent", shown(own));
            return Err(Flaw::new(piece.place("Extent"), problem));
        }
    }
    let array = scalars(&tags)?;
    let draft = describe(image, array, coding.big_endian)?;
    let size = draft.bytes()?;
    match array.required("format")? {
        "ascii" => {
            let count = size / draft.element.bytes();
            let (voxels, more) = draft.element.parse(array.text, count)?;
            if more {
                draft.say_more("numbers", warnings);
            }
            draft.build(voxels)
        }
        "binary" => draft.finish(&coded(array.text, &coding, true, size)?, warnings),
        "appended" => {
            let appended = need("AppendedData")?;
            let place = array.place("offset");
            let [offset] = numbers::<usize, 1>(&place, array.required("offset")?)?;
            let base64 = appended.required("encoding")? == "base64";
            let start = appended.text.iter().position(|b| *b == b'_');
            let text = start.map_or(&[][..], |s| &appended.text[s + 1..]);
            let data = coded(after(text, offset), &coding, base64, size)?;
            draft.finish(&data, warnings)
        }
        other => {
            let problem = format_args!("{}: must be ascii, binary or appended", shown(other));
            Err(Flaw::new(array.place("format"), problem))
        }
    }
}

fn coding(file: &Tag<'_>) -> Result<Coding, Flaw> {
    let big_endian = match file.get("byte_order") {
        Some("BigEndian") => true,
        None | Some("LittleEndian") => false,
        Some(other) => {
            let problem = format_args!("{}: must be LittleEndian or BigEndian", shown(other));
            return Err(Flaw::new(file.place("byte_order"), problem));
        }
    };
    let count_bytes = match file.get("header_type") {
        None | Some("UInt32") => 4,
        Some("UInt64") => 8,
        Some(other) => {
            let problem = format_args!("{}: must be UInt32 or UInt64", shown(other));
            return Err(Flaw::new(file.place("header_type"), problem));
        }
    };
    let compressed = match file.get("compressor") {
        None | Some("") => false,
        Some("vtkZLibDataCompressor") => true,
        Some(other) => {
            let problem = format_args!("{}: must be vtkZLibDataCompressor", shown(other));
            return Err(Flaw::new(file.place("compressor"), problem));
        }
    };
    Ok(Coding {
        big_endian,
        count_bytes,
        compressed,
    })
}

/// The points' scalars: the array that `<PointData Scalars>` names, or else the first.
fn scalars<'a, 'b>(tags: &'b [Tag<'a>]) -> Result<&'b Tag<'a>, Flaw> {
    let start = tags.iter().position(|t| t.name == "PointData");
    let Some(start) = start else {
        return Err(Flaw::new(
            "whole file",
            "has no <PointData>: only points are read, not cells",
        ));
    };
    let named = tags[start].get("Scalars");
    let arrays = || {
        tags[start + 1..]
            .iter()
            .take_while(|t| t.name == "DataArray")
    };
    let found = arrays().find(|t| named.is_some() && t.get("Name") == named);
    found
        .or_else(|| arrays().next())
        .ok_or_else(|| Flaw::new("<PointData>", "has no <DataArray>"))
}

fn describe(image: &Tag<'_>, array: &Tag<'_>, big_endian: bool) -> Result<Draft, Flaw> {
    let extent = image.required("WholeExtent")?;
    let extent = numbers::<i64, 6>(&image.place("WholeExtent"), extent)?;
    let vector = |name: &str, default: DVec3| match image.get(name) {
        Some(text) => numbers::<f64, 3>(&image.place(name), text).map(DVec3::from),
        None => Ok(default),
    };
    let (origin, spacing) = (
        vector("Origin", DVec3::ZERO)?,
        vector("Spacing", DVec3::ONE)?,
    );
    let direction = match image.get("Direction") {
        // Row by row.
        Some(text) => {
            DMat3::from_cols_array(&numbers::<f64, 9>(&image.place("Direction"), text)?).transpose()
        }
        None => DMat3::IDENTITY,
    };
    if let Some(count) = array.get("NumberOfComponents")
        && count.trim() != "1"
    {
        let problem = format_args!("{}: must be 1", shown(count));
        return Err(Flaw::new(array.place("NumberOfComponents"), problem));
    }
    let kind = array.required("type")?;
    let element = match kind {
        "UInt8" => Element::U8,
        "Int8" => Element::I8,
        "UInt16" => Element::U16,
        "Int16" => Element::I16,
        "UInt32" => Element::U32,
        "Int32" => Element::I32,
        "UInt64" => Element::U64,
        "Int64" => Element::I64,
        "Float32" => Element::F32,
        "Float64" => Element::F64,
        _ => {
            let problem = format_args!("{}: must be Int, UInt or Float with its bits", shown(kind));
            return Err(Flaw::new(array.place("type"), problem));
        }
    };
    placed(extent, origin, spacing, direction, element, big_endian)
}

/// What image data of VTK say of a volume; `extent` are the first and last index along each axis.
pub(super) fn placed(
    extent: [i64; 6],
    origin: DVec3,
    spacing: DVec3,
    direction: DMat3,
    element: Element,
    big_endian: bool,
) -> Result<Draft, Flaw> {
    let mut dims = [0; 3];
    for (k, side) in dims.iter_mut().enumerate() {
        let [first, last] = [extent[2 * k], extent[2 * k + 1]];
        let length = last.checked_sub(first).and_then(|n| n.checked_add(1));
        *side = length.and_then(|n| u64::try_from(n).ok()).ok_or_else(|| {
            let problem = format_args!("{first} to {last}: must not end before it begins");
            Flaw::new("extent", problem)
        })?;
    }
    let steps = [
        direction.x_axis * spacing.x,
        direction.y_axis * spacing.y,
        direction.z_axis * spacing.z,
    ];
    let first = DVec3::new(extent[0] as f64, extent[2] as f64, extent[4] as f64);
    let origin = origin + direction * (spacing * first);
    Ok(Draft {
        dims,
        element,
        big_endian,
        slope: 1.0,
        intercept: 0.0,
        world_from_index: affine(steps, origin),
        frame: Frame::Plain,
    })
}

/// The first `size` bytes of an array: a count of bytes and the bytes; or, compressed, the number of blocks,
/// their size, that of the last, what each takes compressed, and the blocks.
fn coded(text: &[u8], coding: &Coding, base64: bool, size: usize) -> Result<Vec<u8>, Flaw> {
    let mut source = Source {
        text: if base64 {
            text.trim_ascii_start()
        } else {
            text
        },
        base64,
    };
    let width = coding.count_bytes;
    if !coding.compressed {
        // Count and bytes are one piece of base64.
        let all = source.take(width.saturating_add(size))?;
        states(coding.count(&all, 0)?, size)?;
        return Ok(after(&all, width).to_vec());
    }
    let head = source.peek(3 * width)?;
    let blocks = coding.count(&head, 0)?;
    let length = coding.count(&head, width)?;
    let last = coding.count(&head, 2 * width)?;
    if blocks as u128 > source.text.len() as u128 || length == 0 && blocks > 0 {
        let problem =
            format_args!("{blocks} blocks of {length} bytes: more than there is room for");
        return Err(Flaw::new("compressed data", problem));
    }
    // A last block that is whole is written as 0.
    let whole = blocks - u64::from(last > 0 && blocks > 0);
    states(whole.saturating_mul(length).saturating_add(last), size)?;
    let blocks = blocks as usize;
    let head = source.take((3 + blocks) * width)?;
    let mut sizes = Vec::with_capacity(blocks);
    for k in 0..blocks {
        sizes.push(coding.count(&head, (3 + k) * width)?);
    }
    let all: u64 = sizes.iter().fold(0, |sum: u64, n| sum.saturating_add(*n));
    let data = source.take(usize::try_from(all).unwrap_or(usize::MAX))?;
    let (mut out, mut at) = (Vec::new(), 0);
    for (k, packed) in sizes.into_iter().enumerate() {
        let end = at + packed as usize;
        let partial = k + 1 == blocks && last > 0;
        let most = (if partial { last } else { length }).min((size - out.len()) as u64);
        let block = data.get(at..end).unwrap_or(&[]);
        let within = |f: Flaw| f.within(&format!("block {k}"));
        let block = unzlib(block, most as usize).map_err(within)?;
        if block.len() as u64 != most {
            let problem = format_args!("{} bytes or more: {most} are stated", block.len());
            return Err(within(Flaw::new("compressed data", problem)));
        }
        out.extend_from_slice(&block);
        at = end;
        if out.len() >= size {
            break;
        }
    }
    Ok(out)
}

/// Refuses another count of bytes than the array takes.
fn states(count: u64, size: usize) -> Result<(), Flaw> {
    if count == size as u64 {
        return Ok(());
    }
    let problem = format_args!("states {count} bytes, but its voxels take {size}");
    Err(Flaw::new("binary data", problem))
}

/// Bytes as they lie, or in base64.
struct Source<'a> {
    text: &'a [u8],
    base64: bool,
}

impl Source<'_> {
    /// The next `count` bytes, or what there is.
    fn take(&mut self, count: usize) -> Result<Vec<u8>, Flaw> {
        let letters = if self.base64 {
            count.div_ceil(3).saturating_mul(4)
        } else {
            count
        };
        let out = self.peek(count)?;
        self.text = after(self.text, letters);
        Ok(out)
    }

    fn peek(&self, count: usize) -> Result<Vec<u8>, Flaw> {
        if !self.base64 {
            return Ok(self.text[..count.min(self.text.len())].to_vec());
        }
        let letters = count.div_ceil(3).saturating_mul(4).min(self.text.len());
        // What ends before has the closing tag's white space behind it.
        let part = self.text[..letters].trim_ascii_end();
        let mut out = BASE64
            .decode(part)
            .map_err(|e| Flaw::new("base64 data", e))?;
        out.truncate(count);
        Ok(out)
    }
}

impl Coding {
    /// The count at a byte of a header.
    fn count(&self, head: &[u8], at: usize) -> Result<u64, Flaw> {
        let Some(bytes) = head.get(at..at + self.count_bytes) else {
            let problem = format_args!("{} bytes: ends within its header", head.len());
            return Err(Flaw::new("binary data", problem));
        };
        let fold = |sum: u64, b: &u8| sum << 8 | u64::from(*b);
        Ok(if self.big_endian {
            bytes.iter().fold(0, fold)
        } else {
            bytes.iter().rev().fold(0, fold)
        })
    }
}
