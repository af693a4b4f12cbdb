use std::borrow::Cow;
use std::io::Read;

use flate2::read::{MultiGzDecoder, ZlibDecoder};

use crate::load::Flaw;

/// Whether `bytes` are gzipped.
pub(super) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// What is read behind the bytes that are asked for: as far as checksums and what a header does not mention are looked for.
pub(super) const BEYOND: usize = 1 << 20;

/// What is gzipped: the first `most` bytes and up to [`BEYOND`] more, which show that there is more and, where they end,
/// that the checksum is right. Memory grows with what is there, not with what is claimed.
pub(super) fn gunzip(bytes: &[u8], most: usize) -> Result<Vec<u8>, Flaw> {
    read(MultiGzDecoder::new(bytes), most.saturating_add(BEYOND))
}

/// As [`gunzip`], for zlib's own container.
pub(super) fn unzlib(bytes: &[u8], most: usize) -> Result<Vec<u8>, Flaw> {
    read(ZlibDecoder::new(bytes), most.saturating_add(BEYOND))
}

/// As [`gunzip`], of what is gzipped or not.
pub(super) fn plain(bytes: &[u8], most: usize) -> Result<Cow<'_, [u8]>, Flaw> {
    Ok(if is_gzip(bytes) {
        Cow::Owned(gunzip(bytes, most)?)
    } else {
        Cow::Borrowed(bytes)
    })
}

/// The first `most` bytes of what is gzipped or not, whatever is behind them.
pub(super) fn beginning(bytes: &[u8], most: usize) -> Result<Cow<'_, [u8]>, Flaw> {
    Ok(if is_gzip(bytes) {
        Cow::Owned(read(MultiGzDecoder::new(bytes), most)?)
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
