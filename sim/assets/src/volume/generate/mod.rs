//! Volumes that are computed: six kinds of content, of any size, the same for the same seed.

mod shapes;
mod tubes;

use std::fmt;
use std::str::FromStr;

use foveasim_models::{ModelError, unknown_name};
use glam::{DAffine3, DVec3, UVec3};
use rayon::prelude::*;

use super::{Frame, Volume, VolumeParts, Voxels};

/// A kind of generated volume. All fill a cube of one metre's half side with values from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum GeneratedVolume {
    /// The test signal of Marschner and Lobb 1994 (Eq. 3, α = ¼, f_M = 6): smooth, hard to reconstruct,
    /// nowhere empty. The seed is not used.
    MarschnerLobb,
    /// A turbulent jet flame: thin wrinkled sheets about a core, as in simulations of combustion.
    Jet,
    /// An exploded shell: a wrinkled sphere with filaments inside and out, as in supernova remnants.
    Filaments,
    /// A cascade of vortex tubes, each generation half as thick and eight times as many.
    Vortices,
    /// A porous solid as computed tomography sees it: grains, pores, a round container, noise.
    Porous,
    /// A body of nested shells: skin, flesh and bone, as in scans of animals.
    Shells,
}

/// Size when none is named.
const USUAL_SIZE: u32 = 256;
/// Largest side that is generated: four bytes for each voxel are at most what a volume may have, 2 GiB.
const LARGEST_SIZE: u32 = 812;

impl GeneratedVolume {
    /// All kinds.
    pub const ALL: [Self; 6] = [
        Self::MarschnerLobb,
        Self::Jet,
        Self::Filaments,
        Self::Vortices,
        Self::Porous,
        Self::Shells,
    ];

    /// What users call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::MarschnerLobb => "marschner-lobb",
            Self::Jet => "jet",
            Self::Filaments => "filaments",
            Self::Vortices => "vortices",
            Self::Porous => "porous",
            Self::Shells => "shells",
        }
    }

    /// The volume, `size` voxels along each side, of single precision. It depends on nothing but the
    /// arguments.
    ///
    /// # Errors
    /// If the size is not 2 to 812.
    pub fn build(self, size: u32, seed: u64) -> Result<Volume, ModelError> {
        if !(2..=LARGEST_SIZE).contains(&size) {
            let valid = format!("2 to {LARGEST_SIZE} voxels a side");
            return Err(ModelError::range("volume size", size, valid));
        }
        let values = match self {
            Self::MarschnerLobb => by_slice(size, &shapes::marschner_lobb(size)),
            Self::Jet => by_slice(size, &shapes::jet(seed)),
            Self::Filaments => by_slice(size, &shapes::filaments(seed)),
            Self::Vortices => tubes::vortices(size, seed),
            Self::Porous => by_slice(size, &shapes::porous(seed)),
            Self::Shells => by_slice(size, &shapes::shells(seed)),
        };
        let step = DVec3::splat(2.0 / f64::from(size - 1));
        let parts = VolumeParts {
            dims: UVec3::splat(size),
            voxels: Voxels::F32(values),
            slope: 1.0,
            intercept: 0.0,
            world_from_index: DAffine3::from_scale_rotation_translation(
                step,
                glam::DQuat::IDENTITY,
                DVec3::NEG_ONE,
            ),
            frame: Frame::Plain,
        };
        Ok(Volume::build(parts).expect("a cube of finite values is a volume"))
    }
}

/// The voxels of a function on the cube from −1 to 1, slice by slice in parallel.
fn by_slice(size: u32, f: &(impl Fn([f64; 3]) -> f64 + Sync)) -> Vec<f32> {
    let n = size as usize;
    let place = |k: usize| 2.0 * k as f64 / (n - 1) as f64 - 1.0;
    let mut values = vec![0.0f32; n * n * n];
    values
        .par_chunks_mut(n * n)
        .enumerate()
        .for_each(|(z, slice)| {
            for (y, row) in slice.chunks_mut(n).enumerate() {
                for (x, value) in row.iter_mut().enumerate() {
                    *value = f([place(x), place(y), place(z)]).clamp(0.0, 1.0) as f32;
                }
            }
        });
    values
}

/// The generated volume that `text` names: a kind, and after a colon perhaps its size
/// (`marschner-lobb:128`; without, 256).
///
/// # Errors
/// If there is no such kind, or the size is not 2 to 812.
pub fn volume_named(text: &str, seed: u64) -> Result<Volume, ModelError> {
    let (kind, size) = match text.split_once(':') {
        None => (text, USUAL_SIZE),
        Some((kind, size)) => {
            let valid = format!("2 to {LARGEST_SIZE} voxels a side, as in {kind}:256");
            let refused = |_| ModelError::range("volume size", size, valid);
            (kind, size.parse().map_err(refused)?)
        }
    };
    kind.parse::<GeneratedVolume>()?.build(size, seed)
}

impl fmt::Display for GeneratedVolume {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for GeneratedVolume {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        let named = Self::ALL.into_iter().find(|k| k.name() == text);
        named.ok_or_else(|| unknown_name("volume", text, &Self::ALL.map(Self::name)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_kinds_are_there_seeded_and_not_uniform() {
        for kind in GeneratedVolume::ALL {
            let volume = volume_named(&format!("{kind}:24"), 3).unwrap();
            let [low, high] = volume.range();
            assert!(
                low >= 0.0 && high <= 1.0 && high - low > 0.4,
                "{kind}: {low} {high}"
            );
            assert_eq!(volume, kind.build(24, 3).unwrap());
            let other = kind.build(24, 4).unwrap();
            assert_eq!(
                volume == other,
                kind == GeneratedVolume::MarschnerLobb,
                "{kind}"
            );
        }
    }

    #[test]
    fn the_test_signal_is_that_of_the_paper() {
        let volume = GeneratedVolume::MarschnerLobb.build(41, 0).unwrap();
        // Marschner and Lobb 1994, Eq. 3, at (0.25, −0.5, 0.1).
        let (x, y, z) = (0.25f64, -0.5f64, 0.1f64);
        let pi = std::f64::consts::PI;
        let rho = (2.0 * pi * 6.0 * (pi * x.hypot(y) / 2.0).cos()).cos();
        let want = (1.0 - (pi * z / 2.0).sin() + 0.25 * (1.0 + rho)) / (2.0 * 1.25);
        assert!((volume.value(UVec3::new(25, 10, 22)) - want).abs() < 1e-6);
    }

    #[test]
    fn names_and_sizes_are_checked() {
        let error = |text: &str| volume_named(text, 1).unwrap_err().to_string();
        assert!(error("jett").contains("did you mean `jet`?"));
        assert!(error("jet:1").contains("2 to 812"));
        assert!(error("jet:100000").contains("2 to 812"));
        assert!(error("jet:x").contains("as in jet:256"));
        let fits = |n: u32| super::super::values::check_dims([u64::from(n); 3], 4).is_ok();
        assert!(fits(LARGEST_SIZE) && !fits(LARGEST_SIZE + 1));
    }
}
