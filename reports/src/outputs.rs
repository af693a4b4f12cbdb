use std::io::Write;
use std::path::{Path, PathBuf};

use crate::ReportError;

/// Files to be written together: they appear whole, each by rename, or not at all.
///
/// The folder is created and tried when the collection begins, so that a long run does not end with
/// nowhere to put its result.
#[derive(Debug)]
pub struct Outputs {
    dir: PathBuf,
    files: Vec<(String, Vec<u8>)>,
    retired: Vec<String>,
}

impl Outputs {
    /// A collection for `dir`, which is created if it is missing.
    ///
    /// # Errors
    /// If the folder cannot be created or written to.
    pub fn new(dir: impl Into<PathBuf>) -> Result<Self, ReportError> {
        let dir = dir.into();
        let error = |why| ReportError::Write {
            path: dir.clone(),
            why,
        };
        std::fs::create_dir_all(&dir).map_err(error)?;
        tempfile::NamedTempFile::new_in(&dir).map_err(error)?;
        Ok(Self {
            dir,
            files: Vec::new(),
            retired: Vec::new(),
        })
    }

    /// Adds a file; a later one of the same name replaces it.
    pub fn add(&mut self, name: impl Into<String>, bytes: impl Into<Vec<u8>>) {
        let name = name.into();
        self.files.retain(|(n, _)| *n != name);
        self.files.push((name, bytes.into()));
    }

    /// Removes `name`, if an earlier run of the same job left it, once the new files are in place.
    pub fn retire(&mut self, name: impl Into<String>) {
        self.retired.push(name.into());
    }

    /// Where `name` will be.
    pub fn path(&self, name: &str) -> PathBuf {
        self.dir.join(name)
    }

    /// The folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Writes all files: first all under temporary names, then all renamed.
    ///
    /// # Errors
    /// If one cannot be written; then none is renamed and no temporary file stays. (Should the last
    /// step, a rename, fail for one file, those before it are already in place, each of them whole.)
    pub fn commit(self) -> Result<Vec<PathBuf>, ReportError> {
        let mut staged = Vec::with_capacity(self.files.len());
        for (name, bytes) in &self.files {
            let path = self.dir.join(name);
            let error = |why| ReportError::Write {
                path: path.clone(),
                why,
            };
            if path.is_dir() {
                return Err(error(std::io::Error::other(
                    "a folder of that name is in the way",
                )));
            }
            let mut file = tempfile::Builder::new()
                .prefix(".foveasim-")
                .permissions_like_a_normal_file()
                .tempfile_in(&self.dir)
                .map_err(error)?;
            file.write_all(bytes).map_err(error)?;
            staged.push((file, path));
        }
        let mut paths = Vec::with_capacity(staged.len());
        for (file, path) in staged {
            file.persist(&path).map_err(|e| ReportError::Write {
                path: path.clone(),
                why: e.error,
            })?;
            paths.push(path);
        }
        for name in self.retired {
            // What cannot be removed was not in the way.
            let _ = std::fs::remove_file(self.dir.join(name));
        }
        Ok(paths)
    }
}

/// Temporary files are private by default; results are not.
trait NormalPermissions {
    fn permissions_like_a_normal_file(&mut self) -> &mut Self;
}

impl NormalPermissions for tempfile::Builder<'_, '_> {
    fn permissions_like_a_normal_file(&mut self) -> &mut Self {
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            self.permissions(std::fs::Permissions::from_mode(0o666));
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_or_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let mut out = Outputs::new(dir.path().join("a/b")).unwrap();
        out.add("x.csv", "1");
        out.add("x.csv", "2");
        out.add("y.csv", "3");
        std::fs::create_dir(out.path("y.csv")).unwrap();
        let blocked = out.path("y.csv");
        assert!(out.commit().is_err());
        let left: Vec<_> = std::fs::read_dir(dir.path().join("a/b"))
            .unwrap()
            .map(|e| e.unwrap().path())
            .collect();
        assert_eq!(left, [blocked], "nothing half-written");
    }

    #[test]
    fn a_file_in_the_way_is_an_error() {
        let file = tempfile::NamedTempFile::new().unwrap();
        assert!(Outputs::new(file.path().join("out")).is_err());
    }
}
