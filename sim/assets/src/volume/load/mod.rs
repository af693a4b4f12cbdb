//! Files of volumes, each format in its own file; the same rules for all of them, which are those of meshes:
//! what a file claims is compared with its length before memory is asked for, what makes a picture wrong is
//! an error that names file, place and value, what is put right is a warning.

mod element;
mod fields;
mod inflate;
mod meta;
mod nifti;
mod nrrd;
mod raw;
mod vti;
mod vtk_js;
mod xml;

#[cfg(test)]
mod tests;

use std::fmt;
use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use super::values::check_dims;
use super::{Frame, Volume, VolumeParts};
use crate::load::{Flaw, Folder, LoadError, SideFiles, Warnings, whole};
use element::Element;

/// A format of volume files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum VolumeFormat {
    /// NIfTI-1, one file, perhaps gzipped.
    Nifti,
    /// Nearly raw raster data, attached or detached.
    Nrrd,
    /// MetaImage.
    MetaImage,
    /// VTK's XML image data.
    Vti,
    /// A folder of vtk.js, with `index.json` and gzipped arrays.
    VtkJs,
    /// Raw numbers beside a TOML file that describes them.
    Raw,
}

/// A file as a volume.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedVolume {
    /// The volume; a file's unit is taken as the metre.
    pub volume: Volume,
    /// What format the file was.
    pub format: VolumeFormat,
    /// What was left out or replaced, one line each, naming the file.
    pub warnings: Vec<String>,
}

/// What a file says of a volume, before its numbers are read.
#[derive(Debug)]
struct Draft {
    dims: [u64; 3],
    element: Element,
    big_endian: bool,
    slope: f64,
    intercept: f64,
    world_from_index: DAffine3,
    frame: Frame,
}

impl Draft {
    /// Checks the sides and how many bytes they take.
    fn bytes(&self) -> Result<usize, Flaw> {
        let each = self.element.bytes() as u64;
        let (_, count) = check_dims(self.dims, each).map_err(|e| Flaw::new("dimensions", e))?;
        Ok(count * each as usize)
    }

    /// The volume of these numbers, which must be as many bytes as it takes; that there are more is said.
    fn finish(self, bytes: &[u8], warnings: &mut Warnings) -> Result<Volume, Flaw> {
        let need = self.bytes()?;
        let [x, y, z] = self.dims;
        if bytes.len() < need {
            return Err(Flaw::new(
                "voxels",
                format_args!(
                    "{} bytes, but {x} x {y} x {z} voxels of {} take {need}",
                    bytes.len(),
                    self.element
                ),
            ));
        }
        if bytes.len() > need {
            let more = bytes.len() - need;
            self.say_more(format_args!("{more} bytes or more"), warnings);
        }
        let voxels = self.element.decode(&bytes[..need], self.big_endian);
        self.build(voxels)
    }

    /// Says that the header speaks of less than there is.
    fn say_more(&self, more: impl fmt::Display, warnings: &mut Warnings) {
        let ([x, y, z], element) = (self.dims, self.element);
        warnings.add(format_args!(
            "{more} follow the {x} x {y} x {z} voxels of {element} that the header speaks of: they are not read"
        ));
    }

    fn build(self, voxels: super::Voxels) -> Result<Volume, Flaw> {
        let (dims, _) = check_dims(self.dims, 1).map_err(|e| Flaw::new("dimensions", e))?;
        let parts = VolumeParts {
            dims,
            voxels,
            slope: self.slope,
            intercept: self.intercept,
            world_from_index: self.world_from_index,
            frame: self.frame,
        };
        Volume::build(parts).map_err(|e| Flaw::new("whole file", e))
    }
}

/// The affine map with these columns: steps along x, y and z, and where the first voxel is.
fn affine(steps: [DVec3; 3], origin: DVec3) -> DAffine3 {
    let [x, y, z] = steps;
    DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), origin)
}

/// Turns left-posterior-superior to right-anterior-superior, or back.
fn half_turn(map: DAffine3) -> DAffine3 {
    DAffine3::from_scale(DVec3::new(-1.0, -1.0, 1.0)) * map
}

/// The volume in the file (or vtk.js folder) at `path`, whose format is told by its content, or else by
/// its name. Of several volumes in time, the one numbered `frame` is read, from 0.
///
/// # Errors
/// If the file or one that it names cannot be read, is not of a known format, or is malformed: has sides that
/// do not fit its length, a type that is not read, axes that span no space, or no finite number.
pub fn load_volume(path: &Path, frame: usize) -> Result<LoadedVolume, LoadError> {
    if path.is_dir() {
        let index = path.join("index.json");
        let bytes = whole(&index)?;
        let files = Folder(path.to_owned());
        return load_volume_bytes(&bytes, &index.to_string_lossy(), frame, &files);
    }
    let bytes = whole(path)?;
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    load_volume_bytes(&bytes, &path.to_string_lossy(), frame, &Folder(folder))
}

/// The volume in `bytes`, the content of a file that is called `name`; see [`load_volume`].
///
/// # Errors
/// As [`load_volume`].
pub fn load_volume_bytes(
    bytes: &[u8],
    name: &str,
    frame: usize,
    files: &dyn SideFiles,
) -> Result<LoadedVolume, LoadError> {
    let format = VolumeFormat::of(bytes, name)
        .ok_or_else(|| LoadError::VolumeFormat { file: name.into() })?;
    let mut warnings = Warnings::new(name);
    if frame > 0 && format != VolumeFormat::Nifti {
        let problem = format!("{frame}: {format} files have one volume here, number 0");
        return Err(Flaw::new("volume in time", problem).of(name));
    }
    let volume = match format {
        VolumeFormat::Nifti => nifti::load(bytes, frame, &mut warnings),
        VolumeFormat::Nrrd => nrrd::load(bytes, files, &mut warnings),
        VolumeFormat::MetaImage => meta::load(bytes, files, &mut warnings),
        VolumeFormat::Vti => vti::load(bytes, &mut warnings),
        VolumeFormat::VtkJs => vtk_js::load(bytes, files, &mut warnings),
        VolumeFormat::Raw => raw::load(bytes, name, files, &mut warnings),
    };
    let volume = volume.map_err(|flaw| flaw.of(name))?;
    if volume.replaced() > 0 {
        warnings.add(format_args!(
            "{} voxels are not finite: they count as 0, or as what is nearest to it",
            volume.replaced()
        ));
    }
    Ok(LoadedVolume {
        volume,
        format,
        warnings: warnings.finish(),
    })
}

impl VolumeFormat {
    /// The format of `bytes`, or else the one that `name` ends in.
    fn of(bytes: &[u8], name: &str) -> Option<Self> {
        let start = &bytes[..bytes.len().min(4096)];
        let has = |what: &[u8]| start.windows(what.len()).any(|w| w == what);
        if start.starts_with(b"NRRD") {
            return Some(Self::Nrrd);
        }
        if has(b"<VTKFile") {
            return Some(Self::Vti);
        }
        if nifti::is_header(start) {
            return Some(Self::Nifti);
        }
        let name = name.to_ascii_lowercase();
        let ends = |list: &[&str]| list.iter().any(|e| name.ends_with(e));
        if start.trim_ascii_start().starts_with(b"{") && has(b"vtk") || ends(&["index.json"]) {
            return Some(Self::VtkJs);
        }
        if ends(&[".nii", ".nii.gz"]) {
            Some(Self::Nifti)
        } else if ends(&[".nrrd", ".nhdr"]) {
            Some(Self::Nrrd)
        } else if ends(&[".mhd", ".mha"]) || has(b"ElementDataFile") {
            Some(Self::MetaImage)
        } else if ends(&[".vti"]) {
            Some(Self::Vti)
        } else if ends(&[".toml"]) {
            Some(Self::Raw)
        } else {
            None
        }
    }

    /// Whether a file of this name is a volume's: by its ending, or a folder of vtk.js.
    pub fn is_named(path: &Path) -> bool {
        let name = path.to_string_lossy().to_ascii_lowercase();
        let endings = [
            ".nii",
            ".nii.gz",
            ".nrrd",
            ".nhdr",
            ".mhd",
            ".mha",
            ".vti",
            ".toml",
            "index.json",
        ];
        endings.iter().any(|e| name.ends_with(e)) || path.join("index.json").is_file()
    }
}

impl fmt::Display for VolumeFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Nifti => "NIfTI",
            Self::Nrrd => "NRRD",
            Self::MetaImage => "MetaImage",
            Self::Vti => "VTK image data",
            Self::VtkJs => "vtk.js",
            Self::Raw => "raw",
        })
    }
}
