//! Friston, Ritschel & Steed, *Perceptual Rasterization for Head-mounted Display Image Synthesis*, ACM TOG 38(4),
//! 2019: its comparisons, measured.

mod age;
mod foveated;
mod head;
mod page;
mod paper;
mod place;
mod published;
mod rolling;
mod scaling;
mod shadow;
mod strength;
mod timing;

pub use foveated::{FoveatedRow, FoveatedWay};
pub use head::HeadRow;
pub use rolling::{RollingRow, RollingWay};
pub use scaling::ResolutionRow;
pub use shadow::ShadowRow;
pub use strength::{Family, StrengthRow};

use std::time::Duration;

use foveasim_assets::GeneratedScene;
use foveasim_models::Image;
use foveasim_render::Bound;
use glam::UVec2;

use super::{ReproduceError, check};
use place::Place;
use rolling::Scanned;

/// Friston et al. 2019 reproduced: what is measured, and how much of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Friston2019 {
    /// Pixels of the image, 90° across.
    pub size: UVec2,
    /// What is drawn.
    pub scenes: Vec<GeneratedScene>,
    /// By how much the head turns in the rows of Fig. 12 \[deg\], within a scan of 1/90 s.
    pub turn_deg: f64,
    /// By how much it turns in Fig. 13 \[deg\].
    pub turns_deg: Vec<f64>,
    /// How often each time is taken.
    pub rounds: u32,
    /// Samples along each side of a pixel of the foveal reference.
    pub reference_samples: u32,
    /// Of the scenes.
    pub seed: u64,
}

/// What a [`Friston2019`] found.
#[derive(Debug, Clone, PartialEq)]
pub struct Friston2019Outcome {
    /// What was asked.
    pub asked: Friston2019,
    /// Fig. 14: likeness, time and memory over the strength of foveation.
    pub strengths: Vec<StrengthRow>,
    /// Fig. 12, the rows of foveation: times, efficiency and likeness.
    pub foveated: Vec<FoveatedRow>,
    /// Fig. 12, the rows of rolling displays.
    pub rolling: Vec<RollingRow>,
    /// Fig. 12, the rows of both.
    pub both: Vec<RollingRow>,
    /// Fig. 12, foveated shadows: everything lit, with one map and with a second one where the eye looks.
    pub shadows: Vec<ShadowRow>,
    /// Fig. 13 over the turn of the head, of the first scene.
    pub turns: Vec<RollingRow>,
    /// Fig. 13 over the size of the image, of the first scene.
    pub resolutions: Vec<ResolutionRow>,
    /// Fig. 8: of each scene, drawn at the start of a scan, warped, rolling.
    pub pictures: Vec<[Image; 3]>,
    /// Fig. 15: the share of tests that hit, by bound, of the first scene.
    pub efficiency: Vec<(Bound, Image)>,
    /// §5.2: how far head pose is predicted wrongly.
    pub head: Vec<HeadRow>,
    /// Fig. 16: how old the last row of a picture that does not roll is when it lights, at best \[ms\].
    pub oldest_row_ms: f64,
}

/// Pixels along each side of the fovea that is judged (§5.2: "the 64 × 64 foveal pixels").
const FOVEA_PX: u32 = 64;

impl Default for Friston2019 {
    /// Images of 1024 × 1024 pixels, as the paper's, of all scenes.
    fn default() -> Self {
        Self {
            size: UVec2::splat(1024),
            scenes: vec![
                GeneratedScene::Study,
                GeneratedScene::Hairball { strands: 4000 },
                // 16° within a scan: its linear vertices shrink the rotor by 1 %.
                GeneratedScene::Machine { rpm: 240.0 },
                GeneratedScene::Room { bars: 160 },
            ],
            turn_deg: 3.0,
            turns_deg: vec![0.0, 0.5, 1.0, 2.0, 4.0, 8.0],
            rounds: 5,
            reference_samples: 8,
            seed: 1,
        }
    }
}

impl Friston2019 {
    /// Small pictures of two small scenes: seconds, and times that mean little.
    pub fn quick() -> Self {
        Self {
            size: UVec2::splat(160),
            scenes: vec![
                GeneratedScene::Hairball { strands: 300 },
                GeneratedScene::Room { bars: 60 },
            ],
            turns_deg: vec![0.0, 2.0],
            rounds: 1,
            reference_samples: 4,
            ..Self::default()
        }
    }

    /// Measures everything. `clock` tells the time since some moment of its own; `progress` hears what is being done, and
    /// how much of all is done (0 to 1).
    ///
    /// Times depend on the machine; all else depends on nothing but what is asked.
    ///
    /// # Errors
    /// If the image is smaller than the fovea or too large, there are no scenes or rounds or too many, or something cannot
    /// be drawn.
    pub fn run(
        &self,
        clock: &mut dyn FnMut() -> Duration,
        progress: &dyn Fn(&str, f64),
    ) -> Result<Friston2019Outcome, ReproduceError> {
        check("rounds", self.rounds, 1..=1000, "from 1 to 1000")?;
        let scenes = self.scenes.len().try_into().unwrap_or(u32::MAX);
        check("scenes", scenes, 1..=100, "from 1 to 100")?;
        for side in self.size.to_array() {
            check(
                "pixels along a side",
                side,
                FOVEA_PX..=4096,
                "from 64 to 4096",
            )?;
        }
        progress("scenes", 0.0);
        let places = self.scenes.iter().map(|scene| Place::new(*scene, self));
        let places = places.collect::<Result<Vec<_>, _>>()?;
        let of = |from: f64, to: f64| move |done: f64| from + (to - from) * done;
        let strengths = strength::measure(&places, self.rounds, clock, &|done| {
            progress("Fig. 14", of(0.05, 0.4)(done));
        })?;
        let foveated = foveated::measure(&places, &strengths, self.rounds, clock, &|done| {
            progress("Fig. 12, foveated", of(0.4, 0.6)(done));
        })?;
        let (mut rolling, mut both, mut pictures) = (Vec::new(), Vec::new(), Vec::new());
        for (k, place) in places.iter().enumerate() {
            progress(
                "Fig. 12, rolling",
                of(0.6, 0.8)(k as f64 / places.len() as f64),
            );
            let scanned = Scanned::new(place, self.turn_deg)?;
            rolling.extend(scanned.measure(&RollingWay::ALL, self.rounds, clock)?);
            let magnified = place.as_many_samples(Family::Radial, foveated::STRENGTH)?;
            both.extend(scanned.measure_magnified(
                magnified,
                self.rounds,
                clock,
                self.reference_samples,
            )?);
            pictures.push(scanned.pictures()?);
        }
        progress("Fig. 12, shadows", 0.8);
        let shadows = shadow::measure(&places, self.rounds, clock)?;
        progress("Fig. 13", 0.85);
        let mut turns = Vec::new();
        for &turn_deg in &self.turns_deg {
            let scanned = Scanned::new(&places[0], turn_deg)?;
            turns.extend(scanned.measure(&RollingWay::FEW, self.rounds, clock)?);
        }
        let resolutions = scaling::measure(self, clock)?;
        progress("Fig. 15", 0.95);
        let efficiency = Scanned::new(&places[0], self.turn_deg)?.efficiency()?;
        Ok(Friston2019Outcome {
            asked: self.clone(),
            strengths,
            foveated,
            rolling,
            both,
            shadows,
            turns,
            resolutions,
            pictures,
            efficiency,
            head: head::rows(self.seed)?,
            oldest_row_ms: age::of_last_row_ms()?,
        })
    }
}

#[cfg(test)]
mod tests;
