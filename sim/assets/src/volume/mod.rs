//! Volumes: scalar values on a lattice in space, how they look, and where they come from.

mod generate;
mod histogram;
mod load;

mod transfer;
mod values;
mod voxels;

pub use generate::{GeneratedVolume, volume_named};
pub use histogram::ValueHistogram;
pub use load::{LoadedVolume, VolumeFormat, load_volume, load_volume_bytes};

pub use transfer::{TransferError, TransferFunction, TransferPoint};
pub use values::{Frame, Volume, VolumeError, VolumeParts};
pub use voxels::Voxels;
