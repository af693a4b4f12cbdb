use foveasim_lanes::Instructions;
use glam::DVec3;

use crate::CastError;

/// How rays are cast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CastOptions {
    /// Distance from sample to sample, in the volume's shortest voxel steps; a ray's own factor multiplies
    /// it. Half a voxel by default, as in Bruder et al. 2019, §5: twice the resolution of the data.
    pub step_voxels: f64,
    /// The length that opacities of the transfer function are of, in the volume's shortest voxel steps.
    pub unit_voxels: f64,
    /// How surfaces in the volume are lit; without, colours are those of the transfer function.
    pub phong: Option<Phong>,
    /// A ray ends where what lies behind could change no channel by as much as this (linear light); 0:
    /// never. Each pixel is within this of the picture without.
    pub terminate: f32,
    /// Whether parts of the volume that the transfer function does not show are left out. The picture is the
    /// same, bit for bit.
    pub skip_empty: bool,
    /// What is kept of the volume.
    pub storage: Storage,
    /// Seed by which each ray's samples are shifted by a part of a step, against rings; without, they lie at
    /// whole steps from the eye.
    pub jitter: Option<u64>,
    /// What is seen where nothing is: linear light, each part 0 to 1.
    pub background: [f32; 3],
    /// Which instructions are used; the picture is the same.
    pub instructions: Instructions,
}

impl Default for CastOptions {
    /// Half-voxel steps, opacity per voxel, a light at the eye, rays ended within 1/255, what is empty
    /// skipped, gradients computed beforehand, black behind.
    fn default() -> Self {
        Self {
            step_voxels: 0.5,
            unit_voxels: 1.0,
            phong: Some(Phong::default()),
            terminate: 1.0 / 255.0,
            skip_empty: true,
            storage: Storage::Gradients,
            jitter: None,
            background: [0.0; 3],
            instructions: Instructions::Auto,
        }
    }
}

/// What a caster keeps of a volume. Pictures are the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Storage {
    /// Value and gradient of each voxel that may be seen, in bricks and each beside the next along z: sixteen bytes, and
    /// more where bricks meet (20¼ where all is seen). If that is more than 4 GiB, [`Values`](Self::Values) instead.
    #[default]
    Gradients,
    /// Values alone, two bytes for each voxel; gradients are computed at each sample.
    Values,
}

/// Phong's model of light: colour · (ambient + diffuse · |n·l|) + specular · (r·v)ⁿ, the normal turned to
/// the side that is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phong {
    /// Share of light that comes from everywhere.
    pub ambient: f32,
    /// Share of light that is scattered.
    pub diffuse: f32,
    /// Share of light that is mirrored.
    pub specular: f32,
    /// How sharply, 1 to 128.
    pub shininess: u32,
    /// Where it comes from.
    pub light: Light,
}

/// Where light comes from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Light {
    /// From the eye.
    #[default]
    Head,
    /// From far away in this direction, world.
    Towards(DVec3),
}

impl Default for Phong {
    /// Shares 0.2, 0.7 and 0.3, shininess 20, a light at the eye.
    fn default() -> Self {
        Self {
            ambient: 0.2,
            diffuse: 0.7,
            specular: 0.3,
            shininess: 20,
            light: Light::Head,
        }
    }
}

impl CastOptions {
    /// Refuses numbers that cannot be used.
    pub(crate) fn check(&self) -> Result<(), CastError> {
        let lengths = [
            ("step_voxels", self.step_voxels),
            ("unit_voxels", self.unit_voxels),
        ];
        for (field, value) in lengths {
            if !(1.0 / 64.0..=64.0).contains(&value) {
                return Err(CastError::range(field, value, "1/64 to 64 voxels"));
            }
        }
        if !(0.0..1.0).contains(&self.terminate) {
            return Err(CastError::range(
                "terminate",
                self.terminate,
                "0 to below 1",
            ));
        }
        if let Some(part) = self.background.into_iter().find(|v| !unit(*v)) {
            return Err(CastError::range("background", part, "0 to 1"));
        }
        let Some(phong) = self.phong else {
            return Ok(());
        };
        let shares = [
            ("ambient", phong.ambient),
            ("diffuse", phong.diffuse),
            ("specular", phong.specular),
        ];
        if let Some((field, share)) = shares.into_iter().find(|(_, v)| !unit(*v)) {
            return Err(CastError::range(field, share, "0 to 1"));
        }
        if !(1..=128).contains(&phong.shininess) {
            return Err(CastError::range("shininess", phong.shininess, "1 to 128"));
        }
        match phong.light {
            Light::Towards(d) if d.try_normalize().is_none() => Err(CastError::range(
                "light",
                d,
                "a direction: finite, of some length",
            )),
            _ => Ok(()),
        }
    }
}

fn unit(v: f32) -> bool {
    (0.0..=1.0).contains(&v)
}
