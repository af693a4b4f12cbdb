//! NIfTI-1 (Cox et al. 2004; field offsets are those of its C header, nifti1.h).

use glam::{DAffine3, DQuat, DVec3};

use super::inflate::{beginning, plain};
use super::{Draft, Element, affine};
use crate::load::{Flaw, Warnings};
use crate::volume::{Frame, Volume};

/// Bytes of the header.
const HEADER: usize = 348;

/// Whether a file begins with such a header, gzipped or not, of either byte order.
pub(super) fn is_header(start: &[u8]) -> bool {
    let head = match beginning(start, HEADER) {
        Ok(head) => head,
        Err(_) => return false,
    };
    let size = head.get(..4).and_then(|b| b.try_into().ok());
    size.is_some_and(|b: [u8; 4]| {
        [i32::from_le_bytes(b), i32::from_be_bytes(b)].contains(&(HEADER as i32))
            && head
                .get(344..347)
                .is_some_and(|m| m == b"n+1" || m == b"ni1")
    })
}

/// The header's fields.
struct Header<'a> {
    bytes: &'a [u8],
    big_endian: bool,
}

impl Header<'_> {
    fn i16(&self, at: usize) -> i16 {
        let b = [self.bytes[at], self.bytes[at + 1]];
        if self.big_endian {
            i16::from_be_bytes(b)
        } else {
            i16::from_le_bytes(b)
        }
    }

    fn f32(&self, at: usize) -> f64 {
        let b = std::array::from_fn(|k| self.bytes[at + k]);
        f64::from(if self.big_endian {
            f32::from_be_bytes(b)
        } else {
            f32::from_le_bytes(b)
        })
    }

    fn vector(&self, at: usize) -> DVec3 {
        DVec3::new(self.f32(at), self.f32(at + 4), self.f32(at + 8))
    }
}

pub(super) fn load(bytes: &[u8], frame: usize, warnings: &mut Warnings) -> Result<Volume, Flaw> {
    let head = beginning(bytes, HEADER)?;
    if head.len() < HEADER {
        let problem = format_args!("{} bytes: a header is {HEADER}", head.len());
        return Err(Flaw::new("header", problem));
    }
    let big_endian = match (i32_at(&head, false), i32_at(&head, true)) {
        (348, _) => false,
        (_, 348) => true,
        (540, _) | (_, 540) => {
            return Err(Flaw::new("header", "NIfTI-2 is not read: only NIfTI-1"));
        }
        (size, _) => {
            let problem = format_args!("sizeof_hdr = {size}: must be 348, in either byte order");
            return Err(Flaw::new("header", problem));
        }
    };
    if &head[344..347] != b"n+1" {
        let magic = String::from_utf8_lossy(&head[344..347]).into_owned();
        let problem = format_args!("magic {magic:?}: only NIfTI-1 in one file (n+1) is read");
        return Err(Flaw::new("byte 344", problem));
    }
    let header = Header {
        bytes: &head,
        big_endian,
    };
    let (draft, frames) = describe(&header)?;
    if frame >= frames {
        let problem = format_args!("{frame}: there are {frames}, from 0");
        return Err(Flaw::new("volume in time", problem));
    }
    if frames > 1 {
        warnings.add(format_args!(
            "{frames} volumes in time: number {frame} is read"
        ));
    }
    let offset = header.f32(108);
    if !(HEADER as f64..=1e9).contains(&offset) {
        let problem = format_args!("vox_offset = {offset}: must be {HEADER} to 1e9");
        return Err(Flaw::new("byte 108", problem));
    }
    let each = draft.bytes()?;
    let skip = (offset as usize)
        .checked_add(frame.saturating_mul(each))
        .filter(|s| *s <= 1 << 36)
        .ok_or_else(|| {
            Flaw::new(
                "volume in time",
                format_args!("{frame}: too far in the file"),
            )
        })?;
    let all = plain(bytes, skip + each)?;
    let own = all.get(skip..).unwrap_or(&[]);
    // Volumes in time that come later are known of.
    let later = (frames - 1 - frame).saturating_mul(each);
    let more = own.len().saturating_sub(each.saturating_add(later));
    draft.finish(&own[..own.len().min(each.saturating_add(more))], warnings)
}

fn i32_at(head: &[u8], big_endian: bool) -> i32 {
    let b = [head[0], head[1], head[2], head[3]];
    if big_endian {
        i32::from_be_bytes(b)
    } else {
        i32::from_le_bytes(b)
    }
}

/// What the header says, and how many volumes in time there are.
fn describe(header: &Header<'_>) -> Result<(Draft, usize), Flaw> {
    let dim: [i16; 8] = std::array::from_fn(|k| header.i16(40 + 2 * k));
    let rank = dim[0];
    if !(3..=7).contains(&rank) {
        let problem = format_args!("dim[0] = {rank}: must be 3 to 7");
        return Err(Flaw::new("byte 40", problem));
    }
    let side = |k: usize| {
        u64::try_from(dim[k]).map_err(|_| {
            let problem = format_args!("dim[{k}] = {}: must not be negative", dim[k]);
            Flaw::new(format_args!("byte {}", 40 + 2 * k), problem)
        })
    };
    let dims = [side(1)?, side(2)?, side(3)?];
    let mut frames = 1usize;
    for k in 4..=rank as usize {
        // Some writers leave the sides that are not used at 0.
        frames = frames.saturating_mul(side(k)?.max(1) as usize);
    }
    let element = match header.i16(70) {
        2 => Element::U8,
        4 => Element::I16,
        8 => Element::I32,
        16 => Element::F32,
        64 => Element::F64,
        256 => Element::I8,
        512 => Element::U16,
        768 => Element::U32,
        1024 => Element::I64,
        1280 => Element::U64,
        other => {
            let problem = format_args!(
                "datatype {other}: must be 2, 4, 8, 16, 64, 256, 512, 768, 1024 or 1280 (one number)"
            );
            return Err(Flaw::new("byte 70", problem));
        }
    };
    // Some writers leave it at 0.
    let bits = header.i16(72);
    if bits != 0 && i64::from(bits) != 8 * element.bytes() as i64 {
        let problem = format_args!(
            "bitpix = {bits}: must be {}, of {element} (datatype {})",
            8 * element.bytes(),
            header.i16(70)
        );
        return Err(Flaw::new("byte 72", problem));
    }
    let (slope, intercept) = (header.f32(112), header.f32(116));
    // Not scaled.
    let (slope, intercept) = if slope == 0.0 || !slope.is_finite() {
        (1.0, 0.0)
    } else {
        (
            slope,
            if intercept.is_finite() {
                intercept
            } else {
                0.0
            },
        )
    };
    let draft = Draft {
        dims,
        element,
        big_endian: header.big_endian,
        slope,
        intercept,
        world_from_index: orientation(header),
        frame: Frame::Anatomical,
    };
    Ok((draft, frames))
}

/// The header's `sform` if it has one, else its `qform`, else voxel sizes alone (nifti1.h, methods 3, 2, 1).
fn orientation(header: &Header<'_>) -> DAffine3 {
    if header.i16(254) > 0 {
        let rows = [280, 296, 312].map(|at| (header.vector(at), header.f32(at + 12)));
        let column = |axis: usize| DVec3::new(rows[0].0[axis], rows[1].0[axis], rows[2].0[axis]);
        let origin = DVec3::new(rows[0].1, rows[1].1, rows[2].1);
        return affine([column(0), column(1), column(2)], origin);
    }
    let size = header.vector(80).abs();
    // Some writers leave sizes at 0.
    let size = DVec3::select(size.cmpgt(DVec3::ZERO), size, DVec3::ONE);
    if header.i16(252) > 0 {
        let v = header.vector(256);
        let w = foveasim_models::math::sqrt((1.0 - v.length_squared()).max(0.0));
        let turn = DQuat::from_xyzw(v.x, v.y, v.z, w).normalize();
        // qfac: −1 mirrors the third axis.
        let flip = if header.f32(76) < 0.0 { -1.0 } else { 1.0 };
        let steps = [
            turn * DVec3::X * size.x,
            turn * DVec3::Y * size.y,
            turn * DVec3::Z * (size.z * flip),
        ];
        return affine(steps, header.vector(268));
    }
    DAffine3::from_scale(size)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;
    use crate::load::NoSideFiles;
    use crate::volume::load_volume_bytes;
    use glam::UVec3;

    /// Puts a number at a byte of the header, as long as the third says (0: single precision).
    type Put<'a> = &'a mut dyn FnMut(usize, f64, usize);

    /// A header and 2 × 3 × 4 voxels of i16, counting up from −5.
    fn file(big: bool, change: impl Fn(Put<'_>)) -> Vec<u8> {
        let mut bytes = vec![0u8; 352];
        let mut put = |at: usize, value: f64, size: usize| {
            let le: Vec<u8> = match size {
                2 => (value as i16).to_le_bytes().to_vec(),
                4 => (value as i32).to_le_bytes().to_vec(),
                _ => (value as f32).to_le_bytes().to_vec(),
            };
            for (k, b) in le.iter().enumerate() {
                let k = if big { le.len() - 1 - k } else { k };
                bytes[at + k] = *b;
            }
        };
        put(0, 348.0, 4);
        for (k, n) in [3, 2, 3, 4].into_iter().enumerate() {
            put(40 + 2 * k, f64::from(n), 2);
        }
        put(70, 4.0, 2);
        for k in 1..4 {
            put(76 + 4 * k, k as f64, 0);
        }
        put(108, 352.0, 0);
        put(112, f64::NAN, 0);
        change(&mut put);
        bytes[344..348].copy_from_slice(b"n+1\0");
        for k in 0..24i16 {
            let v = k - 5;
            bytes.extend(if big {
                v.to_be_bytes()
            } else {
                v.to_le_bytes()
            });
        }
        bytes
    }

    fn read(bytes: &[u8]) -> Result<Volume, String> {
        let loaded = load_volume_bytes(bytes, "a.nii", 0, &NoSideFiles);
        loaded.map(|l| l.volume).map_err(|e| e.to_string())
    }

    #[test]
    fn bits_must_be_those_of_the_type() {
        assert!(read(&file(false, |put| put(72, 16.0, 2))).is_ok());
        let text = read(&file(false, |put| put(72, 8.0, 2))).unwrap_err();
        assert!(
            text.contains("bitpix = 8: must be 16") && text.contains("datatype 4"),
            "{text}"
        );
        // A later volume in time is spoken of; what is behind the last is not.
        let warnings = |bytes: &[u8]| {
            let loaded = load_volume_bytes(bytes, "a.nii", 0, &NoSideFiles);
            loaded.unwrap().warnings
        };
        let two = file(false, |put| {
            put(40, 4.0, 2);
            put(48, 2.0, 2);
        });
        let two = [&two[..], &[0; 48]].concat();
        assert_eq!(warnings(&two).len(), 1);
        assert_eq!(warnings(&[&two[..], b"more"].concat()).len(), 2);
    }

    #[test]
    fn both_byte_orders_gzipped_or_not() {
        let little = read(&file(false, |_| ())).unwrap();
        assert_eq!(little.value(UVec3::new(1, 2, 3)), 18.0);
        assert_eq!(little.range(), [-5.0, 18.0]);
        assert_eq!(read(&file(true, |_| ())).unwrap(), little);
        let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gz.write_all(&file(true, |_| ())).unwrap();
        assert_eq!(read(&gz.finish().unwrap()).unwrap(), little);
        assert_eq!(little.world_from_index().matrix3.z_axis, DVec3::Z * 3.0);
    }

    #[test]
    fn values_are_scaled_and_axes_are_those_of_the_header() {
        let v = read(&file(false, |put| {
            put(112, 0.5, 0);
            put(116, 10.0, 0);
            put(254, 1.0, 2);
            // x and y exchanged, mirrored.
            put(284, -2.0, 0);
            put(296, 3.0, 0);
            put(320, 1.5, 0);
            put(292, 7.0, 0);
        }))
        .unwrap();
        assert_eq!(v.value(UVec3::ZERO), 7.5);
        let m = v.world_from_index();
        assert_eq!(m.transform_point3(DVec3::ONE), DVec3::new(5.0, 3.0, 1.5));
        let q = read(&file(false, |put| {
            put(252, 1.0, 2);
            put(76, -1.0, 0);
            // A quarter turn about z.
            put(264, std::f64::consts::FRAC_1_SQRT_2, 0);
        }))
        .unwrap();
        let m = q.world_from_index().matrix3;
        assert!((m.x_axis - DVec3::Y).length() < 1e-6);
        assert!((m.z_axis + DVec3::Z * 3.0).length() < 1e-6);
    }

    #[test]
    fn lies_are_refused() {
        let error = |change: &dyn Fn(Put<'_>)| read(&file(false, change)).unwrap_err();
        let text = error(&|put| put(46, 5.0, 2));
        assert!(
            text.contains("a.nii: voxels: 48 bytes, but 2 x 3 x 5"),
            "{text}"
        );
        assert!(error(&|put| put(46, 32_000.0, 2)).contains("2 to 4096"));
        assert!(error(&|put| put(42, -3.0, 2)).contains("dim[1] = -3"));
        assert!(error(&|put| put(70, 128.0, 2)).contains("datatype 128"));
        assert!(error(&|put| put(108, f64::NAN, 0)).contains("vox_offset"));
        assert!(error(&|put| put(0, 540.0, 4)).contains("NIfTI-2"));
        assert!(error(&|put| put(40, 99.0, 2)).contains("dim[0] = 99"));
        assert!(error(&|put| put(254, 1.0, 2)).contains("axes"));
        let whole = file(false, |_| ());
        for cut in [0, 3, 100, 347, 351, 352, 399] {
            assert!(read(&whole[..cut]).is_err(), "{cut}");
        }
        // A file in time, of which there is one frame.
        let frames = file(false, |put| {
            put(40, 4.0, 2);
            put(48, 2.0, 2);
        });
        let get = |frame| load_volume_bytes(&frames, "a.nii", frame, &NoSideFiles);
        assert!(get(0).unwrap().warnings[0].contains("2 volumes in time"));
        assert!(get(1).unwrap_err().to_string().contains("0 bytes"));
        assert!(get(2).unwrap_err().to_string().contains("there are 2"));
    }
}
