use std::path::PathBuf;

use thiserror::Error;

use crate::SceneError;

/// Why a file does not give a scene.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The file cannot be read.
    #[error("{path}: cannot be read")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is larger than any that is read.
    #[error("{path}: {bytes} bytes: at most {most} are read")]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its length.
        bytes: u64,
        /// The longest that is read.
        most: u64,
    },
    /// The content is of no known format.
    #[error(
        "{file}: neither its content nor its name is that of a known format: OBJ, glTF, GLB, PLY or STL"
    )]
    Format {
        /// The file.
        file: String,
    },
    /// The content is of no known format of volumes.
    #[error(
        "{file}: neither its content nor its name is that of a known volume format: NIfTI, NRRD, MetaImage, \
         VTK image data, vtk.js or raw with TOML"
    )]
    VolumeFormat {
        /// The file.
        file: String,
    },
    /// Something in the file is wrong.
    #[error("{file}: {place}: {problem}")]
    Content {
        /// The file.
        file: String,
        /// Where: a line, a byte or an element.
        place: String,
        /// What is wrong, and what would be valid.
        problem: String,
    },
    /// The parts do not make a scene.
    #[error("{file}: its parts do not make a scene")]
    Scene {
        /// The file.
        file: String,
        /// What does not fit.
        source: SceneError,
    },
}

/// Something wrong in a file, before it is known which file that is.
#[derive(Debug)]
pub(crate) struct Flaw {
    place: String,
    problem: String,
}

impl Flaw {
    pub(crate) fn new(place: impl ToString, problem: impl ToString) -> Self {
        Self {
            place: place.to_string(),
            problem: problem.to_string(),
        }
    }

    pub(crate) fn line(line: usize, problem: impl ToString) -> Self {
        Self::new(format_args!("line {line}"), problem)
    }

    /// The same in another file, which the first one names.
    pub(crate) fn within(self, file: &str) -> Self {
        let place = format!("{file}: {}", self.place);
        Self { place, ..self }
    }

    /// What is wrong, without where.
    pub(crate) fn problem(&self) -> &str {
        &self.problem
    }

    pub(crate) fn of(self, file: &str) -> LoadError {
        LoadError::Content {
            file: file.into(),
            place: self.place,
            problem: self.problem,
        }
    }
}
