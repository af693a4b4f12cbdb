//! Bruder et al., *Voronoi-Based Foveated Volume Rendering*, EuroVis 2019: its Table 1's protocol, and what the paper leaves
//! out: error.

mod errors;
mod frame;
mod paper;
mod protocol;
mod published;
mod report;
mod times;

use std::time::Duration;

use foveasim_assets::{TransferFunction, Volume};
use foveasim_mask::{Mask, StepLaw};
use foveasim_models::{Image, Viewport};
use foveasim_volume::{CastOptions, Caster, Prepared};
use glam::UVec2;

pub use errors::{BruderErrors, BruderRing};
pub use times::{BruderRow, BruderTimes};

use super::{ReproduceError, check, stepper};
use protocol::Camera;

/// Bruder et al. 2019 reproduced: what is measured, and how much of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bruder2019 {
    /// Cameras: directions all around the volume, and distances.
    pub cameras: u32,
    /// Gazes for each camera, anywhere on the image.
    pub gazes: u32,
    /// Frames for each gaze, of which the median counts.
    pub frames: u32,
    /// How steps along rays follow the mask.
    pub step: StepLaw,
    /// Seed of cameras and gazes.
    pub seed: u64,
}

/// A volume to measure, and how it is shown.
#[derive(Debug)]
pub struct BruderVolume {
    /// Its name.
    pub name: String,
    /// The data.
    pub volume: Volume,
    /// How it is shown.
    pub transfer: TransferFunction,
}

/// The masks that are measured, of one display.
#[derive(Debug)]
pub struct BruderMasks {
    /// Of one specification but for their interpolation, in the order of [`foveasim_mask::Interpolation::ALL`].
    pub masks: [Mask; 3],
    /// Of the paper's density, for its errors beside theirs; natural.
    pub gaussian: Mask,
}

/// What a [`Bruder2019`] found.
#[derive(Debug, Clone, PartialEq)]
pub struct Bruder2019Outcome {
    /// What was asked.
    pub asked: Bruder2019,
    /// Pixels of the image.
    pub size: UVec2,
    /// Rays of the mask.
    pub mask_rays: usize,
    /// One of each volume.
    pub volumes: Vec<BruderFound>,
}

/// What was found of one volume.
#[derive(Debug, Clone, PartialEq)]
pub struct BruderFound {
    /// Its name.
    pub name: String,
    /// Voxels along each axis.
    pub dims: [u32; 3],
    /// How long it took to make it ready for rays \[ms\].
    pub prepare_ms: f64,
    /// What is kept of it.
    pub prepared: Prepared,
    /// Times and work.
    pub times: BruderTimes,
    /// Error by ring, of every way to draw.
    pub errors: BruderErrors,
    /// The first camera's full image, foveated one and the order in which they come: full, then foveated.
    pub pictures: [Image; 2],
}

impl Default for Bruder2019 {
    /// Six cameras and four gazes, three frames each: the paper's 256 × 256 and five take days here.
    fn default() -> Self {
        Self {
            cameras: 6,
            gazes: 4,
            frames: 3,
            step: Self::STEP,
            seed: 1,
        }
    }
}

impl Bruder2019 {
    /// The step law that is measured by default: as far as rays are apart, at most four base steps.
    pub const STEP: StepLaw = StepLaw::Spacing {
        scale: 1.0,
        most: 4.0,
    };

    /// Two cameras, two gazes, one frame: what a test can wait for.
    pub fn quick() -> Self {
        Self {
            cameras: 2,
            gazes: 2,
            frames: 1,
            ..Self::default()
        }
    }

    /// The image plane: as wide as on the paper's 24-inch display of 1920 × 1080 seen from 60 cm, with `size` pixels.
    ///
    /// # Errors
    /// If there are none, or too many.
    pub fn viewport(size: UVec2) -> Result<Viewport, ReproduceError> {
        Ok(Viewport::symmetric(size, paper::HALF_WIDTH_TAN)?)
    }

    /// Measures all volumes. `clock` tells the time since whenever; `progress` hears how far it is.
    ///
    /// # Errors
    /// If counts are out of range, or an image cannot be drawn or compared.
    pub fn run(
        &self,
        volumes: &[BruderVolume],
        masks: &BruderMasks,
        clock: &mut dyn FnMut() -> Duration,
        progress: &dyn Fn(&str, f64),
    ) -> Result<Bruder2019Outcome, ReproduceError> {
        check("cameras", self.cameras, 1..=256, "from 1 to 256")?;
        check("gazes", self.gazes, 1..=256, "from 1 to 256")?;
        check("frames", self.frames, 1..=101, "from 1 to 101")?;
        let size = masks.natural().spec().display_px;
        let viewport = Self::viewport(size)?;
        let mut found = Vec::new();
        for (k, volume) in volumes.iter().enumerate() {
            let share = |part: f64| (k as f64 + part) / volumes.len() as f64;
            let span = [share(0.0), share(1.0)];
            found.push(self.one(volume, masks, &viewport, clock, &|done| {
                progress(&volume.name, span[0] + done * (span[1] - span[0]));
            })?);
        }
        Ok(Bruder2019Outcome {
            asked: *self,
            size,
            mask_rays: masks.natural().sites().len(),
            volumes: found,
        })
    }

    fn one(
        &self,
        volume: &BruderVolume,
        masks: &BruderMasks,
        viewport: &Viewport,
        clock: &mut dyn FnMut() -> Duration,
        progress: &dyn Fn(f64),
    ) -> Result<BruderFound, ReproduceError> {
        let began = clock();
        let caster = Caster::new(&volume.volume, &volume.transfer, &CastOptions::default())?;
        let prepare_ms = ms(clock() - began);
        let cameras = Camera::draw(self, volume.volume.bounds(), viewport);
        let tell = |_: &str, done: f64| progress(done);
        let steps = f64::from(self.cameras * self.gazes);
        let mut step = stepper(&tell, "", [0.0, 0.7], steps);
        let times =
            BruderTimes::measure(self, &caster, masks.natural(), &cameras, clock, &mut step)?;
        let mut step = stepper(&tell, "", [0.7, 1.0], cameras.len() as f64);
        let (errors, pictures) = BruderErrors::measure(self, &caster, masks, &cameras, &mut step)?;
        Ok(BruderFound {
            name: volume.name.clone(),
            dims: volume.volume.dims().to_array(),
            prepare_ms,
            prepared: caster.prepared(),
            times,
            errors,
            pictures,
        })
    }
}

impl BruderMasks {
    /// The one with natural neighbours.
    pub fn natural(&self) -> &Mask {
        &self.masks[2]
    }
}

/// Milliseconds of a time.
fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests;
