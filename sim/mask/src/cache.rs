use std::path::{Path, PathBuf};

use crate::lbg::LbgIteration;
use crate::{Mask, MaskError, MaskSpec};

/// A folder of masks, each in a file named by what it was built from.
#[derive(Debug, Clone)]
pub struct Cache {
    folder: PathBuf,
}

/// A mask from a [`Cache`], and how it came.
#[derive(Debug)]
pub struct Cached {
    /// The mask.
    pub mask: Mask,
    /// Whether it was there.
    pub loaded: bool,
    /// What was wrong with the file that was there but had to be made anew.
    pub replaced: Option<MaskError>,
    /// Why the mask could not be kept: it is still good.
    pub not_kept: Option<MaskError>,
}

impl Cache {
    /// In `folder`, which is made when a mask is kept.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
        }
    }

    /// The file of the mask of `spec`.
    pub fn path(&self, spec: &MaskSpec) -> PathBuf {
        self.folder.join(format!("mask-{}.bin", &spec.key()[..32]))
    }

    /// The mask of `spec`: loaded if it is there and sound, else built and kept.
    ///
    /// # Errors
    /// If there is none to load and none can be built.
    pub fn get(
        &self,
        spec: &MaskSpec,
        progress: &dyn Fn(&LbgIteration),
    ) -> Result<Cached, MaskError> {
        spec.check()?;
        let path = self.path(spec);
        let replaced = match Mask::load(&path, spec) {
            Ok(mask) => {
                return Ok(Cached {
                    mask,
                    loaded: true,
                    replaced: None,
                    not_kept: None,
                });
            }
            Err(MaskError::File { source, .. })
                if source.kind() == std::io::ErrorKind::NotFound =>
            {
                None
            }
            Err(error) => Some(error),
        };
        let mask = Mask::build(spec, progress)?;
        let not_kept = make_folder(&self.folder)
            .and_then(|()| mask.save(&path))
            .err();
        Ok(Cached {
            mask,
            loaded: false,
            replaced,
            not_kept,
        })
    }
}

fn make_folder(folder: &Path) -> Result<(), MaskError> {
    std::fs::create_dir_all(folder).map_err(|source| MaskError::File {
        path: folder.to_owned(),
        source,
    })
}
