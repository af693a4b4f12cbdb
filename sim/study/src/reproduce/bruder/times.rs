use std::time::Duration;

use foveasim_mask::{Mask, StepLaw};
use foveasim_models::math::{mean, quantile_sorted};
use foveasim_reports::{Cell, Table};
use foveasim_volume::{CastWork, Caster};
use glam::DVec2;

use super::frame::Foveated;
use super::protocol::Camera;
use super::{Bruder2019, ReproduceError, ms};

/// Times and work of one volume, camera by camera and gaze by gaze.
#[derive(Debug, Clone, PartialEq)]
pub struct BruderTimes {
    /// Every gaze of every camera.
    pub rows: Vec<BruderRow>,
}

/// What one gaze of one camera took: medians over its frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BruderRow {
    /// Which camera.
    pub camera: usize,
    /// To the right of +z, and above \[deg\].
    pub direction_deg: [f64; 2],
    /// Of that at which the whole volume is seen.
    pub distance: f64,
    /// The gaze.
    pub gaze_px: DVec2,
    /// A full frame \[ms\].
    pub full_ms: f64,
    /// What a foveated one casts, steps following the mask \[ms\].
    pub cast_ms: f64,
    /// What it takes to make an image of that \[ms\].
    pub reconstruct_ms: f64,
    /// What a foveated frame casts with the base step everywhere \[ms\].
    pub equal_cast_ms: f64,
    /// Work of the full frame, of the foveated one, and of the one with equal steps.
    pub work: [CastWork; 3],
}

impl BruderRow {
    /// A whole foveated frame \[ms\].
    pub fn foveated_ms(&self) -> f64 {
        self.cast_ms + self.reconstruct_ms
    }

    /// A whole foveated frame with equal steps \[ms\].
    pub fn equal_ms(&self) -> f64 {
        self.equal_cast_ms + self.reconstruct_ms
    }
}

impl BruderTimes {
    /// Every way is drawn in turn, so that whatever else the machine does meets all of them.
    pub(super) fn measure(
        asked: &Bruder2019,
        caster: &Caster,
        mask: &Mask,
        cameras: &[Camera],
        clock: &mut dyn FnMut() -> Duration,
        step: &mut dyn FnMut(),
    ) -> Result<Self, ReproduceError> {
        let background = caster.options().background;
        let mut rows = Vec::new();
        for (number, camera) in cameras.iter().enumerate() {
            for &gaze_px in &camera.gazes {
                let mut taken: [Vec<f64>; 4] = Default::default();
                let mut work = [CastWork::default(); 3];
                for _ in 0..asked.frames {
                    let began = clock();
                    work[0] = caster.full(&camera.view)?.work;
                    let full = clock();
                    let foveated = Foveated::cast(caster, &camera.view, mask, gaze_px, asked.step)?;
                    work[1] = foveated.work;
                    let cast = clock();
                    foveated.reconstruct(background)?;
                    let made = clock();
                    work[2] =
                        Foveated::cast(caster, &camera.view, mask, gaze_px, StepLaw::Equal)?.work;
                    let equal = clock();
                    let times = [full - began, cast - full, made - cast, equal - made];
                    for (all, time) in taken.iter_mut().zip(times) {
                        all.push(ms(time));
                    }
                }
                let [full_ms, cast_ms, reconstruct_ms, equal_cast_ms] =
                    taken.map(|times| median(&times));
                rows.push(BruderRow {
                    camera: number,
                    direction_deg: [camera.azimuth_deg, camera.elevation_deg],
                    distance: camera.distance,
                    gaze_px,
                    full_ms,
                    cast_ms,
                    reconstruct_ms,
                    equal_cast_ms,
                    work,
                });
                step();
            }
        }
        Ok(Self { rows })
    }

    /// The mean of a quantity over all gazes.
    pub fn mean(&self, of: impl Fn(&BruderRow) -> f64) -> f64 {
        mean(&self.rows.iter().map(of).collect::<Vec<_>>())
    }

    /// The median of a quantity over all gazes.
    pub fn median(&self, of: impl Fn(&BruderRow) -> f64) -> f64 {
        median(&self.rows.iter().map(of).collect::<Vec<_>>())
    }

    /// Every gaze, in the columns that [`BruderTimes::columns`] names after `volume`.
    pub(super) fn add_to(&self, volume: &str, table: &mut Table) {
        for row in &self.rows {
            let mut cells: Vec<Cell> = vec![
                volume.into(),
                row.camera.into(),
                row.direction_deg[0].into(),
                row.direction_deg[1].into(),
                row.distance.into(),
                row.gaze_px.x.into(),
                row.gaze_px.y.into(),
                row.full_ms.into(),
                row.cast_ms.into(),
                row.reconstruct_ms.into(),
                row.equal_cast_ms.into(),
            ];
            for work in &row.work {
                cells.extend([work.rays.into(), work.steps.into(), work.steps_seen.into()]);
            }
            table.push(cells);
        }
    }

    /// Names of the columns.
    pub(super) fn columns() -> Vec<String> {
        let mut names: Vec<String> = [
            "volume",
            "camera",
            "azimuth_deg",
            "elevation_deg",
            "distance",
            "gaze_x_px",
            "gaze_y_px",
            "full_ms",
            "cast_ms",
            "reconstruct_ms",
            "equal_steps_cast_ms",
        ]
        .map(String::from)
        .into();
        for of in ["full", "foveated", "equal_steps"] {
            for what in ["rays", "samples", "samples_seen"] {
                names.push(format!("{of}_{what}"));
            }
        }
        names
    }
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    quantile_sorted(&sorted, 0.5)
}
