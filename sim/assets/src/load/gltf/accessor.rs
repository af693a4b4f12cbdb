use super::super::error::Flaw;
use super::super::text::shown;
use super::container::Document;
use super::get;
use super::json;

/// Type of a number in a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

/// Numbers in a buffer, read one by one: nothing is copied, whatever count is claimed.
pub(super) struct Accessor<'a> {
    base: Option<Strided<'a>>,
    sparse: Option<Sparse<'a>>,
    component: Component,
    normalized: bool,
    /// Elements.
    pub(super) count: usize,
}

/// Elements that replace others: which, in increasing order, and by what.
struct Sparse<'a> {
    indices: Strided<'a>,
    kind: Component,
    values: Strided<'a>,
}

/// Elements at even distances, all within the bytes.
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
}

impl Component {
    fn of(code: u32, place: &str) -> Result<Self, Flaw> {
        Ok(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => {
                let valid = "5120, 5121, 5122, 5123, 5125 or 5126";
                let problem = format!("componentType {code}: must be {valid}");
                return Err(Flaw::new(place, problem));
            }
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    fn read(self, b: &[u8]) -> f64 {
        match self {
            Self::I8 => f64::from(b[0] as i8),
            Self::U8 => f64::from(b[0]),
            Self::I16 => f64::from(i16::from_le_bytes([b[0], b[1]])),
            Self::U16 => f64::from(u16::from_le_bytes([b[0], b[1]])),
            Self::U32 => f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Self::F32 => f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        }
    }

    /// Value of the code that stands for 1, where codes are normalized (§3.6.2.2).
    fn one(self) -> f64 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32767.0,
            Self::U16 => 65535.0,
            Self::U32 | Self::F32 => 1.0,
        }
    }
}

impl<'a> Strided<'a> {
    fn new(
        document: &'a Document<'_>,
        view: usize,
        offset: u64,
        count: u64,
        element: usize,
        place: &str,
    ) -> Result<Self, Flaw> {
        let (bytes, stride) = document.view(view, place)?;
        let stride = stride.unwrap_or(element as u64);
        if stride < element as u64 {
            let problem = format!("byteStride {stride}: its elements have {element} bytes");
            return Err(Flaw::new(format_args!("bufferViews[{view}]"), problem));
        }
        let last = count.saturating_sub(1).checked_mul(stride);
        let length = if count == 0 { 0 } else { element as u64 };
        let end = last.and_then(|l| l.checked_add(length)?.checked_add(offset));
        if end.is_none_or(|end| end > bytes.len() as u64) {
            let there = bytes.len();
            let problem = format!(
                "claims {count} elements of {element} bytes, {stride} apart, from byte {offset} on; bufferViews[{view}] has {there} bytes"
            );
            return Err(Flaw::new(place, problem));
        }
        Ok(Self {
            bytes: &bytes[offset as usize..],
            stride: stride as usize,
            count: count as usize,
        })
    }

    fn element(&self, index: usize) -> &'a [u8] {
        &self.bytes[index * self.stride..]
    }
}

impl<'a> Sparse<'a> {
    /// What replaces element `index`.
    fn value(&self, index: usize) -> Option<&'a [u8]> {
        let (mut low, mut high) = (0, self.indices.count);
        while low < high {
            let middle = low.midpoint(high);
            let at = self.kind.read(self.indices.element(middle)) as usize;
            match at.cmp(&index) {
                std::cmp::Ordering::Equal => return Some(self.values.element(middle)),
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Greater => high = middle,
            }
        }
        None
    }
}

impl<'a> Accessor<'a> {
    /// Accessor `index`, whose type must be `shape`: SCALAR, VEC2, VEC3 or VEC4.
    pub(super) fn new(
        document: &'a Document<'_>,
        index: usize,
        shape: &str,
        from: &str,
    ) -> Result<Self, Flaw> {
        let a = get(&document.root.accessors, index, "accessor", from)?;
        let place = format!("accessors[{index}]");
        if a.shape != shape {
            let given = shown(&a.shape);
            let problem = format!("type {given}: must be {shape} for {from}");
            return Err(Flaw::new(place, problem));
        }
        let width = match shape {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        let component = Component::of(a.component_type, &place)?;
        let element = width * component.bytes();
        let base = match a.buffer_view {
            Some(view) => Some(Strided::new(
                document,
                view,
                a.byte_offset,
                a.count,
                element,
                &place,
            )?),
            None => None,
        };
        let sparse = match &a.sparse {
            Some(s) => Some(Self::sparse(document, s, a.count, element, &place)?),
            None => None,
        };
        Ok(Self {
            base,
            sparse,
            component,
            normalized: a.normalized,
            count: usize::try_from(a.count).unwrap_or(usize::MAX),
        })
    }

    /// Indices and values that replace some elements (§3.6.2.3).
    fn sparse(
        document: &'a Document<'_>,
        s: &json::Sparse,
        count: u64,
        element: usize,
        place: &str,
    ) -> Result<Sparse<'a>, Flaw> {
        let kind = Component::of(s.indices.component_type.unwrap_or(0), place)?;
        let part = |p: &json::SparsePart, element| {
            Strided::new(
                document,
                p.buffer_view,
                p.byte_offset,
                s.count,
                element,
                place,
            )
        };
        let indices = part(&s.indices, kind.bytes())?;
        let values = part(&s.values, element)?;
        let mut before = -1.0;
        for i in 0..indices.count {
            let index = kind.read(indices.element(i));
            if !(index > before && index < count as f64) {
                let problem = format!(
                    "sparse index {index} after {before}: must increase, and be below {count}"
                );
                return Err(Flaw::new(place, problem));
            }
            before = index;
        }
        Ok(Sparse {
            indices,
            kind,
            values,
        })
    }

    /// Element `index`, which must be below [`Self::count`].
    pub(super) fn element<const N: usize>(&self, index: usize) -> [f64; N] {
        let size = self.component.bytes();
        let replaced = self.sparse.as_ref().and_then(|s| s.value(index));
        let bytes = match replaced {
            Some(bytes) => bytes,
            None => match &self.base {
                Some(base) => base.element(index),
                None => return [0.0; N],
            },
        };
        std::array::from_fn(|k| {
            let value = self.component.read(&bytes[k * size..]);
            if self.normalized {
                // The most negative code stands for −1, too.
                (value / self.component.one()).max(-1.0)
            } else {
                value
            }
        })
    }
}
