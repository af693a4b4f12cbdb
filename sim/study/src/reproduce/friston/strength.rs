use std::time::Duration;

use foveasim_models::foveation::{KernelSettings, LensMatchedSettings, Method, RadialSettings};
use foveasim_models::{Interpolation, ModelError};
use foveasim_render::RenderOptions;
use foveasim_reports::{LineChart, LineSeries, Table};

use super::place::Place;
use super::timing::timed;
use super::{Friston2019Outcome, ReproduceError};
use crate::kernel::median;

/// A way to spread samples that has a strength.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Family {
    /// A buffer that magnifies the fovea: the exponent k.
    Radial,
    /// Lens-matched shading: the growth A = B of w to the image's edges.
    LensMatched,
    /// Kernel foveated rendering: the exponent α, visibility found at its own samples.
    LogPolar,
}

/// One strength of one family on one scene, at as many samples as there are pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct StrengthRow {
    /// The scene.
    pub scene: String,
    /// The family.
    pub family: Family,
    /// Its strength.
    pub strength: f64,
    /// The method as drawn.
    pub method: Method,
    /// Samples drawn.
    pub samples: u64,
    /// Samples that buffers have room for, all passes together.
    pub buffer_samples: u64,
    /// SSIM of the fovea against its reference.
    pub ssim: f64,
    /// Time of a frame \[ms\].
    pub frame_ms: f64,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Radial, Self::LensMatched, Self::LogPolar];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Radial => "radial",
            Self::LensMatched => "lens-matched",
            Self::LogPolar => "log-polar",
        }
    }

    /// What its strength is called.
    pub fn parameter(self) -> &'static str {
        match self {
            Self::Radial => "k",
            Self::LensMatched => "A = B",
            Self::LogPolar => "alpha",
        }
    }

    /// The strengths that are measured, from none, or nearly none, on.
    fn strengths(self) -> &'static [f64] {
        match self {
            Self::Radial => &[1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0],
            Self::LensMatched => &[0.0, 0.5, 1.0, 2.0, 3.0, 4.0],
            Self::LogPolar => &[0.25, 0.35, 0.5, 0.7, 1.0, 2.0, 4.0],
        }
    }

    /// Lattice steps to the pixel that it may have.
    pub(super) fn scales(self) -> [f64; 2] {
        match self {
            Self::LensMatched => [0.3, 8.0],
            Self::Radial | Self::LogPolar => [0.3, 4.0],
        }
    }

    /// The method of a strength with so many lattice steps to the pixel; each is read with the filters that suit it.
    pub(super) fn method(self, strength: f64, scale: f64) -> Result<Method, ModelError> {
        Ok(match self {
            Self::Radial => {
                let mut settings = RadialSettings::new(strength)?.with_scale(scale)?;
                (settings.interpolation, settings.mips) = (Interpolation::Cubic, true);
                Method::Radial(settings)
            }
            Self::LensMatched => {
                let mut settings =
                    LensMatchedSettings::new(strength, strength)?.with_scale(scale)?;
                (settings.interpolation, settings.mips) = (Interpolation::Cubic, true);
                Method::Lms(settings)
            }
            Self::LogPolar => {
                let mut settings = KernelSettings::new((1e4 / scale).round() / 1e4, strength)?;
                (settings.interpolation, settings.mips) = (Interpolation::Cubic, true);
                Method::Kfr(settings)
            }
        })
    }
}

/// Every strength of every family on every scene.
pub(super) fn measure(
    places: &[Place],
    rounds: u32,
    clock: &mut dyn FnMut() -> Duration,
    progress: &dyn Fn(f64),
) -> Result<Vec<StrengthRow>, ReproduceError> {
    let mut rows = Vec::new();
    for (k, place) in places.iter().enumerate() {
        for family in Family::ALL {
            progress(k as f64 / places.len() as f64);
            for &strength in family.strengths() {
                rows.push(measure_one(place, family, strength, rounds, clock)?);
            }
        }
    }
    Ok(rows)
}

fn measure_one(
    place: &Place,
    family: Family,
    strength: f64,
    rounds: u32,
    clock: &mut dyn FnMut() -> Duration,
) -> Result<StrengthRow, ReproduceError> {
    let method = place.as_many_samples(family, strength)?;
    let plan = place.plan(method)?;
    let options = RenderOptions::default();
    let (mut times, mut last) = (Vec::new(), None);
    for _ in 0..rounds {
        let (frame, ms) = timed(&place.world, &place.view, &plan, &options, clock)?;
        times.push(ms);
        last = Some(frame);
    }
    let ssim = match &last {
        Some(frame) => place.likeness(&frame.image)?,
        None => f64::NAN,
    };
    Ok(StrengthRow {
        scene: place.scene.to_string(),
        family,
        strength,
        method,
        samples: plan.passes.iter().map(|p| p.live()).sum(),
        buffer_samples: plan.passes.iter().map(|p| p.lattice.samples()).sum(),
        ssim,
        frame_ms: median(times),
    })
}

/// The strength of a family with the greatest mean likeness over all scenes.
pub(super) fn best(rows: &[StrengthRow], family: Family) -> f64 {
    let likeness = |strength: f64| {
        let of = rows
            .iter()
            .filter(|r| r.family == family && r.strength == strength);
        of.map(|r| r.ssim).sum::<f64>()
    };
    let strengths = family.strengths().iter().copied();
    strengths
        .max_by(|a, b| likeness(*a).total_cmp(&likeness(*b)))
        .unwrap_or_default()
}

impl Friston2019Outcome {
    /// Fig. 14 as a table.
    pub fn strength_table(&self) -> Table {
        let mut table = Table::new([
            "scene",
            "family",
            "parameter",
            "strength",
            "method",
            "samples",
            "buffer_samples",
            "ssim_fovea",
            "frame_ms",
        ]);
        for r in &self.strengths {
            table.push(vec![
                r.scene.as_str().into(),
                r.family.name().into(),
                r.family.parameter().into(),
                r.strength.into(),
                r.method.to_string().into(),
                r.samples.into(),
                r.buffer_samples.into(),
                r.ssim.into(),
                r.frame_ms.into(),
            ]);
        }
        table
    }

    /// Fig. 14 of one family: likeness over strength, a line per scene.
    pub fn strength_chart(&self, family: Family) -> LineChart {
        let mut series: Vec<LineSeries> = Vec::new();
        for row in self.strengths.iter().filter(|r| r.family == family) {
            if series.last().is_none_or(|s| s.label != row.scene) {
                series.push(LineSeries {
                    label: row.scene.clone(),
                    points: Vec::new(),
                });
            }
            if let Some(line) = series.last_mut() {
                line.points.push([row.strength, row.ssim]);
            }
        }
        LineChart {
            title: format!("Likeness of the fovea: {}", family.name()),
            x_label: format!("strength ({})", family.parameter()),
            y_label: "SSIM of 64 x 64 pixels".into(),
            series,
            ..LineChart::default()
        }
    }
}
