//! Guenter et al., *Foveated 3D Graphics*, SIGGRAPH Asia 2012: its tables and figures.

mod antialiasing;
mod latency;
mod page;
mod paper;
mod payoff;
mod predicted;
mod published;
mod quality;
mod quality_charts;
mod shooter;
mod table1;

use std::time::Duration;

use foveasim_assets::{StudyContent, study_scene};
use foveasim_models::foveation::Method;
use foveasim_models::{Acuity, Geometry, ModelError, Viewport, presets};
use foveasim_quality::WINDOW;
use foveasim_reports::Table;
use glam::UVec2;

pub use latency::{LatencyBars, LatencyRow};
pub use paper::Column;
pub use payoff::{Payoff, PayoffRow};
pub use predicted::{Predicted, PredictedRow};
pub use quality::{QualityRow, QualitySweep, TimeFit};
pub use shooter::{Antialiasing, Times};
pub use table1::{Table1, Table1Cell};

use super::{Published, ReproduceError, Reproduction, check, stepper};
use crate::TemporalQuality;
use paper::COLUMNS;
use shooter::Flight;

/// Guenter et al. 2012 reproduced: what is measured, and how much of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Guenter2012 {
    /// Pixels of the image; the field of view stays that of the study's display.
    pub size: UVec2,
    /// Moments of the fly-through at which each time of Table 1 is measured; those of Figs 10 and 11 at
    /// a third of as many.
    pub moments: u32,
    /// Consecutive frames on which antialiasing is judged; 0 leaves that out.
    pub antialiasing_frames: u32,
    /// Pixels of the images on which antialiasing is judged.
    pub antialiasing_size: UVec2,
    /// Seed of the scene.
    pub seed: u64,
}

/// What a [`Guenter2012`] found.
#[derive(Debug, Clone, PartialEq)]
pub struct Guenter2012Outcome {
    /// What was asked.
    pub asked: Guenter2012,
    /// Table 1.
    pub table_1: Table1,
    /// Figs 10 and 11.
    pub quality: QualitySweep,
    /// Figs 12 and 13.
    pub predicted: Predicted,
    /// Fig. 5.
    pub latency: LatencyBars,
    /// §4.2: flicker and likeness with each part of the antialiasing on and off.
    pub antialiasing: Vec<TemporalQuality>,
    /// The quality index that column I stands for here: where layers save 15 times the pixels.
    pub informal_index: f64,
    /// Printed numbers that have nothing to do with this machine, beside ours.
    pub computed: Vec<Published>,
}

/// What is written of antialiasing, if it was judged.
const ANTIALIASING_FILES: [&str; 4] = [
    "antialiasing.csv",
    "antialiasing-flicker.svg",
    "antialiasing-pixels.svg",
    "antialiasing-ssim.svg",
];

impl Default for Guenter2012 {
    /// The study's 1920 × 1080 pixels at 8 moments; antialiasing on 12 frames of half that size.
    fn default() -> Self {
        Self {
            size: UVec2::new(1920, 1080),
            moments: 8,
            antialiasing_frames: 12,
            antialiasing_size: UVec2::new(960, 540),
            seed: 1,
        }
    }
}

/// The method of the paper's measurements: three layers, all radii optimised.
fn layers() -> Result<Method, ModelError> {
    "layers:3".parse()
}

impl Guenter2012 {
    /// Everything there is to see, within seconds: small pictures of one moment. Its times mean
    /// little.
    pub fn quick() -> Self {
        Self {
            size: UVec2::new(256, 144),
            moments: 1,
            antialiasing_frames: 3,
            antialiasing_size: UVec2::new(64, 36),
            ..Self::default()
        }
    }

    /// Measures and computes everything. `clock` tells the time since some moment of its own;
    /// `progress` hears what is being done, and how much of all is done (0 to 1).
    ///
    /// Times depend on the machine; all else depends on nothing but what is asked.
    ///
    /// # Errors
    /// If there are no moments or too many, or the image cannot be drawn.
    pub fn run(
        &self,
        clock: &mut dyn FnMut() -> Duration,
        progress: &dyn Fn(&str, f64),
    ) -> Result<Guenter2012Outcome, ReproduceError> {
        check("moments", self.moments, 1..=1000, "from 1 to 1000")?;
        let frames = self.antialiasing_frames;
        check("antialiasing frames", frames, 0..=1000, "from 0 to 1000")?;
        if frames > 0 {
            let side = self.antialiasing_size.min_element();
            let valid = "at least 11 pixels: the window of SSIM";
            check(
                "side of antialiasing frames",
                side,
                (WINDOW as u32)..=u32::MAX,
                valid,
            )?;
        }
        let flight = self.flight(self.size)?;
        let judged = self.flight(self.antialiasing_size)?;
        let moments = shooter::moments(self.moments);

        progress("predicting", 0.0);
        let predicted = Predicted::new()?;
        let latency = LatencyBars::new()?;
        let informal_index = quality::informal_index(&flight)?;
        let computed = published::computed(&predicted)?;
        let informal = Acuity::from_quality_index(informal_index)?;

        let cells = (StudyContent::ALL.len() * COLUMNS.len() * moments.len()) as f64;
        let mut step = stepper(progress, "Table 1", [0.02, 0.4], cells);
        let table_1 = Table1::measure(&flight, informal, &moments, clock, &mut step)?;

        let scene = study_scene(self.seed);
        // A third of the moments: there are 19 qualities, and five ways to draw each.
        let moments = shooter::moments(self.moments.div_ceil(3));
        let cells = ((1 + quality::INDICES.count() * quality::SHOOTERS) * moments.len()) as f64;
        let mut step = stepper(progress, "Figs 10 and 11", [0.4, 0.75], cells);
        let quality = QualitySweep::measure(&flight, &scene, &moments, clock, &mut step)?;

        let mut step = stepper(progress, "antialiasing", [0.75, 1.0], f64::from(frames));
        let antialiasing = match frames {
            0 => Vec::new(),
            _ => antialiasing::antialiasing(&judged, &scene, frames, &mut step)?,
        };
        Ok(Guenter2012Outcome {
            asked: *self,
            table_1,
            quality,
            predicted,
            latency,
            antialiasing,
            informal_index,
            computed,
        })
    }

    /// The fly-through on the study's display with `size` pixels.
    fn flight(&self, size: UVec2) -> Result<Flight, ReproduceError> {
        let display = presets::display("lg-w2363d")?;
        debug_assert!(matches!(display.geometry, Geometry::Planar { .. }));
        let [_, right, ..] = display.primary().viewport.tan;
        let viewport = Viewport::symmetric(size, right)?;
        Ok(Flight::new(viewport, self.seed))
    }
}

impl Guenter2012Outcome {
    /// Ours beside the paper's in a few numbers, for the terminal.
    pub fn summary(&self) -> Table {
        let mut table = Table::new(["quantity", "ours", "paper"]);
        let mut row = |name: String, ours: f64, paper: f64| {
            table.push(vec![name.into(), ours.into(), paper.into()]);
        };
        for mark in paper::MARKS {
            let name = mark.column.name();
            let [time, _] = self.table_1.speedup(StudyContent::Full, mark.column);
            if let Some(quality) = mark.j.and_then(|j| self.quality.at(j)) {
                row(
                    format!("{name}: speedup by pixels"),
                    quality.pixels_speedup,
                    mark.pixels,
                );
            }
            row(format!("{name}: speedup by time"), time, mark.time);
        }
        if let Some(at) = self.predicted.at("A", "n = 4", 70.0) {
            row(
                "predicted at 70 degrees, foveal sharpness".into(),
                at.speedup(),
                100.0,
            );
        }
        if let Some(total) = self.latency.rows.last() {
            row(
                "latency, best [ms]".into(),
                total.ours_ms[0],
                total.paper_ms[0],
            );
            row(
                "latency, worst [ms]".into(),
                total.ours_ms[1],
                total.paper_ms[1],
            );
        }
        table
    }

    /// Tables, charts and the page.
    pub fn reproduction(&self) -> Reproduction {
        let mut out = Reproduction {
            page: Some(page::page(self)),
            summary: vec![("", self.summary())],
            published: self.published(),
            ..Reproduction::default()
        };
        out.add_table("table1.csv", self.table_1.table());
        out.add_table("fig5.csv", self.latency.table());
        out.add_table("fig10-11.csv", self.quality.table());
        out.add_table("fig12-13.csv", self.predicted.table());
        if self.antialiasing.is_empty() {
            // An earlier run's must not stand beside a report that does not speak of them.
            out.retired.extend(ANTIALIASING_FILES);
        } else {
            let table = TemporalQuality::table(&self.antialiasing);
            out.add_table(ANTIALIASING_FILES[0], table);
        }
        for (name, svg) in self.charts() {
            out.add_chart(&format!("{name}.svg"), svg);
        }
        out
    }

    /// Every chart by the name of its file.
    fn charts(&self) -> Vec<(&'static str, String)> {
        let [pixels, times] = self.quality.layer_charts();
        let [full, foveated] = self.predicted.cost_charts();
        let mut charts = vec![
            ("fig5", self.latency.chart().svg()),
            (
                "fig10",
                self.quality.speedup_chart(self.informal_index).svg(),
            ),
            ("fig11-pixels", pixels.svg()),
            ("fig11-time", times.svg()),
            ("fig12-a", self.predicted.speedup_chart("A").svg()),
            ("fig12-b", self.predicted.speedup_chart("B").svg()),
            ("fig13-a", full.svg()),
            ("fig13-b", foveated.svg()),
        ];
        if !self.antialiasing.is_empty() {
            let [followed, flicker, likeness] = TemporalQuality::charts(&self.antialiasing);
            charts.push(("antialiasing-flicker", followed.svg()));
            charts.push(("antialiasing-pixels", flicker.svg()));
            charts.push(("antialiasing-ssim", likeness.svg()));
        }
        charts
    }
}

#[cfg(test)]
mod tests;
