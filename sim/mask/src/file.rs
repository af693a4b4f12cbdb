//! Masks as files: a text line, sizes, then arrays of little-endian numbers, and a checksum of all of it.

use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;

use crc32fast::Hasher;
use glam::DVec2;

use crate::lbg::{Convergence, LbgIteration};
use crate::spec::SUBPIXELS;
use crate::{Mask, MaskError, MaskSpec, Weights};

/// Begins every file; its number changes with the layout.
const MAGIC: &[u8; 16] = b"foveasim mask 1\n";

/// Bytes read or written at a time.
const CHUNK: usize = 1 << 18;

/// Most iterations that a file may have.
const MOST_ITERATIONS: u64 = 1 << 16;
/// Most bytes of weights per pixel that a file may have: 255 entries, and as many sites.
const MOST_PER_PIXEL: u64 = 255;

impl Mask {
    /// Writes it to `path`, whole or not at all.
    ///
    /// # Errors
    /// If that cannot be done.
    pub fn save(&self, path: &Path) -> Result<(), MaskError> {
        let failed = |source| MaskError::File {
            path: path.to_owned(),
            source,
        };
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
        let file = tempfile::Builder::new()
            .prefix(".mask-")
            .tempfile_in(folder.unwrap_or(Path::new(".")))
            .map_err(failed)?;
        let mut out = Checked {
            stream: file,
            hash: Hasher::new(),
            buffer: Vec::with_capacity(CHUNK),
        };
        self.write(&mut out).map_err(failed)?;
        out.stream
            .persist(path)
            .map_err(|error| failed(error.error))?;
        Ok(())
    }

    fn write(&self, out: &mut Checked<impl Write>) -> std::io::Result<()> {
        let w = &self.weights;
        out.bytes(MAGIC)?;
        out.bytes(self.spec.key().as_bytes())?;
        let rows = &self.convergence.iterations;
        for length in [
            self.sites.len(),
            rows.len(),
            w.begins.len(),
            w.sites.len(),
            w.counts.len(),
            w.entries.len(),
        ] {
            out.word64(length as u64)?;
        }
        for site in &self.sites {
            out.word32((site.x * SUBPIXELS) as u32)?;
            out.word32((site.y * SUBPIXELS) as u32)?;
        }
        for spacing in &self.spacing {
            out.word32(spacing.to_bits())?;
        }
        out.word64(self.convergence.integral.to_bits())?;
        for row in rows {
            let [least, most] = row.share;
            for whole in [u64::from(row.iteration), row.sites, row.split, row.merged] {
                out.word64(whole)?;
            }
            for number in [row.width, least, most, row.moved_px, row.total] {
                out.word64(number.to_bits())?;
            }
        }
        for &[site, entry] in &w.begins {
            out.word32(site)?;
            out.word32(entry)?;
        }
        for &word in w.sites.iter().chain(&w.entries) {
            out.word32(word)?;
        }
        out.bytes(&w.counts)?;
        out.end()
    }

    /// Reads the mask of `spec` from `path`.
    ///
    /// # Errors
    /// If the file cannot be read, is of another version or specification, or damaged.
    pub fn load(path: &Path, spec: &MaskSpec) -> Result<Self, MaskError> {
        let failed = |source: std::io::Error| match source.kind() {
            std::io::ErrorKind::UnexpectedEof => damaged(path, "ends early"),
            _ => MaskError::File {
                path: path.to_owned(),
                source,
            },
        };
        spec.check()?;
        let file = File::open(path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        let mut input = Checked {
            stream: file,
            hash: Hasher::new(),
            buffer: Vec::new(),
        };
        let mask = read(&mut input, path, spec, length, &failed)?;
        let sum = input.hash.clone().finalize();
        if input.read32().map_err(failed)? != sum {
            return Err(damaged(path, "its checksum does not fit"));
        }
        if !mask.weights.is_sound(mask.sites.len()) {
            return Err(damaged(path, "its weights do not fit together"));
        }
        Ok(mask)
    }
}

fn damaged(path: &Path, reason: &str) -> MaskError {
    MaskError::Damaged {
        path: path.to_owned(),
        reason: reason.to_owned(),
    }
}

/// All but the checksum.
fn read(
    input: &mut Checked<File>,
    path: &Path,
    spec: &MaskSpec,
    length: u64,
    failed: &dyn Fn(std::io::Error) -> MaskError,
) -> Result<Mask, MaskError> {
    let mut magic = [0; MAGIC.len()];
    input.fill(&mut magic).map_err(failed)?;
    if &magic != MAGIC {
        return Err(damaged(path, "is no mask of this version"));
    }
    let mut key = [0; 64];
    input.fill(&mut key).map_err(failed)?;
    if key != *spec.key().as_bytes() {
        return Err(damaged(path, "is a mask of another specification"));
    }
    let mut lengths = [0; 6];
    for length in &mut lengths {
        *length = input.read64().map_err(failed)?;
    }
    let [sites, rows, begins, tile_sites, counts, entries] = lengths;
    let size = spec.mask_px();
    let pixels = u64::from(size.x) * u64::from(size.y);
    let most = pixels * MOST_PER_PIXEL;
    let plausible = sites <= pixels
        && rows <= MOST_ITERATIONS
        && counts == pixels
        && [begins, tile_sites, entries].iter().all(|&n| n <= most);
    // Bounded by now, so nothing overflows; and what follows is as long as the file says.
    let bytes = || {
        (MAGIC.len() + key.len() + 8 * lengths.len()) as u64
            + 12 * sites
            + 8
            + 72 * rows
            + 8 * begins
            + 4 * (tile_sites + entries)
            + counts
            + 4
    };
    if !plausible || bytes() != length {
        return Err(damaged(path, "its length does not fit its contents"));
    }
    let places = input.words(2 * sites).map_err(failed)?;
    let spacing = input.words(sites).map_err(failed)?;
    let integral = f64::from_bits(input.read64().map_err(failed)?);
    let iterations = (0..rows).map(|_| row(input)).collect::<Result<_, _>>();
    let begins = input.words(2 * begins).map_err(failed)?;
    let weights = Weights {
        size,
        begins: begins.as_chunks().0.to_vec(),
        sites: input.words(tile_sites).map_err(failed)?,
        entries: input.words(entries).map_err(failed)?,
        counts: {
            let mut all = vec![0; counts as usize];
            input.fill(&mut all).map_err(failed)?;
            all
        },
    };
    let place = |[x, y]: &[u32; 2]| DVec2::new(f64::from(*x), f64::from(*y)) / SUBPIXELS;
    Ok(Mask {
        spec: *spec,
        sites: places.as_chunks().0.iter().map(place).collect(),
        spacing: spacing.into_iter().map(f32::from_bits).collect(),
        weights,
        convergence: Convergence {
            iterations: iterations.map_err(failed)?,
            integral,
        },
    })
}

fn row(input: &mut Checked<File>) -> std::io::Result<LbgIteration> {
    let mut words = [0; 9];
    for word in &mut words {
        *word = input.read64()?;
    }
    let [iteration, sites, split, merged, numbers @ ..] = words;
    let [width, least, most, moved_px, total] = numbers.map(f64::from_bits);
    Ok(LbgIteration {
        iteration: iteration as u32,
        width,
        sites,
        split,
        merged,
        share: [least, most],
        moved_px,
        total,
    })
}

/// A stream of bytes and their checksum.
struct Checked<T> {
    stream: T,
    hash: Hasher,
    buffer: Vec<u8>,
}

impl<T: Write> Checked<T> {
    fn bytes(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        for chunk in bytes.chunks(CHUNK) {
            self.buffer.extend_from_slice(chunk);
            if self.buffer.len() >= CHUNK {
                self.flush()?;
            }
        }
        Ok(())
    }

    fn word32(&mut self, word: u32) -> std::io::Result<()> {
        self.bytes(&word.to_le_bytes())
    }

    fn word64(&mut self, word: u64) -> std::io::Result<()> {
        self.bytes(&word.to_le_bytes())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.hash.update(&self.buffer);
        self.stream.write_all(&self.buffer)?;
        self.buffer.clear();
        Ok(())
    }

    /// Writes the checksum of all before.
    fn end(&mut self) -> std::io::Result<()> {
        self.flush()?;
        let sum = self.hash.clone().finalize();
        self.stream.write_all(&sum.to_le_bytes())?;
        self.stream.flush()
    }
}

impl<T: Read> Checked<T> {
    fn fill(&mut self, out: &mut [u8]) -> std::io::Result<()> {
        for chunk in out.chunks_mut(CHUNK) {
            self.stream.read_exact(chunk)?;
            self.hash.update(chunk);
        }
        Ok(())
    }

    fn read32(&mut self) -> std::io::Result<u32> {
        let mut bytes = [0; 4];
        self.fill(&mut bytes)?;
        Ok(u32::from_le_bytes(bytes))
    }

    fn read64(&mut self) -> std::io::Result<u64> {
        let mut bytes = [0; 8];
        self.fill(&mut bytes)?;
        Ok(u64::from_le_bytes(bytes))
    }

    fn words(&mut self, count: u64) -> std::io::Result<Vec<u32>> {
        let mut words = Vec::with_capacity(count as usize);
        let mut buffer = vec![0; CHUNK];
        let mut left = 4 * count as usize;
        while left > 0 {
            let chunk = &mut buffer[..left.min(CHUNK)];
            self.fill(chunk)?;
            words.extend(chunk.as_chunks().0.iter().map(|&b| u32::from_le_bytes(b)));
            left -= chunk.len();
        }
        Ok(words)
    }
}
