use super::super::error::Flaw;
use super::super::text::shown;

/// How the values after the header are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// Type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// Type of the length, for a list.
    pub(super) list: Option<Kind>,
}

#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Where the values begin \[bytes\].
    pub(super) end: usize,
    /// Lines of the header.
    pub(super) lines: usize,
}

impl Kind {
    fn named(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Length in a binary file \[bytes\].
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

impl Element {
    /// Least bytes that one of them takes.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> u64 {
        let of = |p: &Property| match encoding {
            // A digit; what separates it may be missing at the end of the file.
            Encoding::Text => 1,
            _ => p.list.unwrap_or(p.kind).bytes() as u64,
        };
        self.properties.iter().map(of).sum()
    }
}

impl Header {
    pub(super) fn read(bytes: &[u8]) -> Result<Self, Flaw> {
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let (mut at, mut line) = (0, 0);
        loop {
            let rest = &bytes[at..];
            line += 1;
            // A line ends in \n, \r\n or, in old files, \r.
            let Some(length) = rest.iter().position(|&b| b == b'\n' || b == b'\r') else {
                return Err(Flaw::line(line, "the header has no end_header"));
            };
            let text = String::from_utf8_lossy(&rest[..length]);
            at += length + 1 + usize::from(rest[length..].starts_with(b"\r\n"));
            let words: Vec<&str> = text.split_whitespace().collect();
            let wrong = |problem: String| Err(Flaw::line(line, problem));
            match words[..] {
                ["ply"] | [] | ["comment" | "obj_info", ..] => {}
                ["end_header"] => break,
                ["format", name, version] => {
                    encoding = match (name, version) {
                        ("ascii", "1.0") => Some(Encoding::Text),
                        ("binary_little_endian", "1.0") => Some(Encoding::LittleEndian),
                        ("binary_big_endian", "1.0") => Some(Encoding::BigEndian),
                        _ => {
                            let valid = "ascii, binary_little_endian or binary_big_endian, 1.0";
                            let given = shown(&format!("{name} {version}"));
                            return wrong(format!("format {given}: must be {valid}"));
                        }
                    };
                }
                ["element", name, count] => {
                    let Ok(number) = count.parse() else {
                        let count = shown(count);
                        return wrong(format!("element count {count}: must be a whole number"));
                    };
                    elements.push(Element {
                        name: name.into(),
                        count: number,
                        properties: Vec::new(),
                    });
                }
                ["property", ref rest @ ..] => {
                    let Some(property) = Property::read(rest) else {
                        let given = shown(&rest.join(" "));
                        let valid = "TYPE NAME or list TYPE TYPE NAME, where TYPE is char, uchar, \
                                     short, ushort, int, uint, float or double";
                        return wrong(format!("property {given}: must be {valid}"));
                    };
                    let Some(element) = elements.last_mut() else {
                        return wrong("property before any element".into());
                    };
                    element.properties.push(property);
                }
                _ => {
                    let given = shown(&text);
                    let valid = "format, comment, obj_info, element, property or end_header";
                    return wrong(format!("{given}: must be {valid}"));
                }
            }
        }
        let Some(encoding) = encoding else {
            return Err(Flaw::line(line, "the header has no format"));
        };
        Ok(Self {
            encoding,
            elements,
            end: at,
            lines: line,
        })
    }
}

impl Property {
    fn read(words: &[&str]) -> Option<Self> {
        let whole = |k: &Kind| !matches!(k, Kind::F32 | Kind::F64);
        let (list, kind, name) = match *words {
            ["list", length, kind, name] => (Some(Kind::named(length).filter(whole)?), kind, name),
            [kind, name] => (None, kind, name),
            _ => return None,
        };
        Some(Self {
            name: name.into(),
            kind: Kind::named(kind)?,
            list,
        })
    }
}
