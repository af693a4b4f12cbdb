use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use super::LoadError;

/// Longest file that is read \[bytes\]: positions in it fit 32 bits.
const LONGEST: u64 = 1 << 31;

/// The files that lie beside a scene: material libraries, textures, buffers.
pub trait SideFiles {
    /// The content of the file that the scene calls `name`.
    ///
    /// # Errors
    /// If there is none, or it cannot be read.
    fn read(&self, name: &str) -> io::Result<Vec<u8>>;
}

/// No file beside it.
#[derive(Debug, Clone, Copy)]
pub struct NoSideFiles;

impl SideFiles for NoSideFiles {
    fn read(&self, _: &str) -> io::Result<Vec<u8>> {
        Err(io::Error::from(io::ErrorKind::NotFound))
    }
}

/// Files in the scene's own folder and those below it.
#[derive(Debug)]
pub(crate) struct Folder(pub(crate) PathBuf);

impl SideFiles for Folder {
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        // Files written on Windows name folders so.
        let name = name.replace('\\', "/");
        let path = Path::new(&name);
        let inside = |c: Component<'_>| matches!(c, Component::Normal(_) | Component::CurDir);
        if !path.components().all(inside) {
            let text = "only files in the scene's own folder and below are read";
            return Err(io::Error::other(text));
        }
        read(&self.0.join(path))
    }
}

/// The whole of a file of reasonable length.
pub(crate) fn whole(path: &Path) -> Result<Vec<u8>, LoadError> {
    read(path).map_err(|source| {
        let path = path.to_owned();
        match (source.kind(), fs::metadata(&path)) {
            (io::ErrorKind::FileTooLarge, Ok(data)) => LoadError::TooLarge {
                path,
                bytes: data.len(),
                most: LONGEST,
            },
            _ => LoadError::Read { path, source },
        }
    })
}

fn read(path: &Path) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let data = file.metadata()?;
    if data.is_dir() {
        return Err(io::Error::from(io::ErrorKind::IsADirectory));
    }
    if data.len() > LONGEST {
        return Err(io::Error::from(io::ErrorKind::FileTooLarge));
    }
    let mut bytes = Vec::with_capacity(data.len() as usize);
    // What is not a plain file has no length, and may have no end.
    file.take(LONGEST).read_to_end(&mut bytes)?;
    Ok(bytes)
}
