use std::borrow::Cow;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::super::error::Flaw;
use super::super::files::SideFiles;
use super::super::text::shown;
use super::get;
use super::json::Root;

/// Longest JSON that is read \[bytes\]: parsed, it takes some fifty times as much.
const LONGEST_JSON: usize = 32 << 20;

const JSON_CHUNK: &[u8] = b"JSON";
const BINARY_CHUNK: &[u8] = b"BIN\0";

/// The JSON part of a file, and the bytes that it speaks of.
pub(super) struct Document<'a> {
    pub(super) root: Root,
    buffers: Vec<Cow<'a, [u8]>>,
}

impl<'a> Document<'a> {
    pub(super) fn read(bytes: &'a [u8], files: &dyn SideFiles) -> Result<Self, Flaw> {
        let (json, binary) = if bytes.starts_with(b"glTF") {
            chunks(bytes)?
        } else {
            (bytes, None)
        };
        if json.len() > LONGEST_JSON {
            let problem = format!(
                "{} bytes of JSON: at most {LONGEST_JSON} are read",
                json.len()
            );
            return Err(Flaw::new("JSON", problem));
        }
        let root: Root = serde_json::from_slice(json).map_err(|e| Flaw::new("JSON", e))?;
        let mut buffers = Vec::new();
        for (i, buffer) in root.buffers.iter().enumerate() {
            let place = format!("buffers[{i}]");
            let content: Cow<'_, [u8]> = match (&buffer.uri, binary) {
                (Some(uri), _) => Cow::Owned(resolve(uri, files, &place)?),
                (None, Some(binary)) if i == 0 => Cow::Borrowed(binary),
                _ => {
                    let problem = "has no uri, and the file no binary chunk for it";
                    return Err(Flaw::new(place, problem));
                }
            };
            let (claimed, there) = (buffer.byte_length, content.len());
            if claimed > there as u64 {
                let problem = format!("claims {claimed} bytes; {there} are there");
                return Err(Flaw::new(place, problem));
            }
            buffers.push(content);
        }
        Ok(Self { root, buffers })
    }

    /// All bytes of all buffers: the measure of what a file may ask for.
    pub(super) fn bytes(&self) -> usize {
        self.buffers.iter().map(|b| b.len()).sum()
    }

    /// The bytes of a view, and the distance between its elements if it names one.
    pub(super) fn view(&self, index: usize, from: &str) -> Result<(&[u8], Option<u64>), Flaw> {
        let view = get(&self.root.buffer_views, index, "bufferView", from)?;
        let place = format!("bufferViews[{index}]");
        let buffer = get(&self.buffers, view.buffer, "buffer", &place)?;
        let (start, length) = (view.byte_offset, view.byte_length);
        let end = start
            .checked_add(length)
            .filter(|&e| e <= buffer.len() as u64);
        let Some(end) = end else {
            let there = buffer.len();
            let problem = format!("claims {length} bytes from {start} on; {there} are there");
            return Err(Flaw::new(place, problem));
        };
        Ok((&buffer[start as usize..end as usize], view.byte_stride))
    }
}

type Chunks<'a> = (&'a [u8], Option<&'a [u8]>);

/// The JSON and the binary chunk of a GLB file (§4.4).
fn chunks(bytes: &[u8]) -> Result<Chunks<'_>, Flaw> {
    let word = |at: usize| {
        let b = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(Flaw::new("header", "a GLB file has at least 12 bytes"));
    };
    if version != 2 {
        return Err(Flaw::new(
            "byte 4",
            format_args!("GLB version {version}: must be 2"),
        ));
    }
    if u64::from(length) > bytes.len() as u64 {
        let problem = format!("claims {length} bytes; {} are there", bytes.len());
        return Err(Flaw::new("byte 8", problem));
    }
    let mut at = 12;
    let (mut json, mut binary) = (None, None);
    while let (Some(claimed), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) {
        let rest = &bytes[at + 8..];
        let Some(content) = rest.get(..claimed as usize) else {
            let problem = format!("chunk claims {claimed} bytes; {} are left", rest.len());
            return Err(Flaw::new(format_args!("byte {at}"), problem));
        };
        match kind {
            JSON_CHUNK if json.is_none() => json = Some(content),
            BINARY_CHUNK if binary.is_none() => binary = Some(content),
            // Unknown chunks are to be passed over.
            _ => {}
        }
        at += 8 + content.len();
    }
    match json {
        Some(json) => Ok((json, binary)),
        None => Err(Flaw::new("byte 12", "there is no JSON chunk")),
    }
}

/// What a URI stands for: base64 data, or a file beside the scene's.
pub(super) fn resolve(uri: &str, files: &dyn SideFiles, place: &str) -> Result<Vec<u8>, Flaw> {
    let wrong = |problem: String| Flaw::new(place, problem);
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((_, text)) = data.split_once(";base64,") else {
            return Err(wrong("a data URI that is not base64".into()));
        };
        return STANDARD
            .decode(text)
            .map_err(|e| wrong(format!("base64 data: {e}")));
    }
    if uri.contains("://") {
        let uri = shown(uri);
        return Err(wrong(format!(
            "{uri}: only files beside the scene's are read"
        )));
    }
    let name = unescape(uri);
    let content = files.read(&name);
    content.map_err(|e| wrong(format!("file {}: {e}", shown(&name))))
}

/// `%20` and the like as what they stand for.
fn unescape(uri: &str) -> String {
    let mut out = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, after @ ..] = rest {
        let hex = after.get(..2).and_then(|h| std::str::from_utf8(h).ok());
        let code = hex.and_then(|h| u8::from_str_radix(h, 16).ok());
        (rest, _) = match code {
            Some(code) if *first == b'%' => (&after[2..], out.push(code)),
            _ => (after, out.push(*first)),
        };
    }
    String::from_utf8_lossy(&out).into_owned()
}
