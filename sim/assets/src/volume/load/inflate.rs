use std::borrow::Cow;
use std::io::Read;

use flate2::read::{MultiGzDecoder, ZlibDecoder};

use crate::load::Flaw;

/// Whether `bytes` are gzipped.
pub(super) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// The first `most` bytes of what is gzipped, or all if there are fewer. Memory grows with what is there, not
/// with what is claimed.
pub(super) fn gunzip(bytes: &[u8], most: usize) -> Result<Vec<u8>, Flaw> {
    read(MultiGzDecoder::new(bytes), most)
}

/// As [`gunzip`], for zlib's own container.
pub(super) fn unzlib(bytes: &[u8], most: usize) -> Result<Vec<u8>, Flaw> {
    read(ZlibDecoder::new(bytes), most)
}

/// The first `most` bytes of what is gzipped or not.
pub(super) fn plain(bytes: &[u8], most: usize) -> Result<Cow<'_, [u8]>, Flaw> {
    Ok(if is_gzip(bytes) {
        Cow::Owned(gunzip(bytes, most)?)
    } else {
        Cow::Borrowed(bytes)
    })
}

fn read(stream: impl Read, most: usize) -> Result<Vec<u8>, Flaw> {
    let mut out = Vec::new();
    let read = stream.take(most as u64).read_to_end(&mut out);
    read.map_err(|e| {
        let problem = format_args!("damaged after {} bytes of content: {e}", out.len());
        Flaw::new("compressed data", problem)
    })?;
    Ok(out)
}
