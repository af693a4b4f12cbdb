use std::time::Duration;

use foveasim_models::foveation::{KernelForm, Method};
use foveasim_models::{Eye, ModelError, SamplePlan};
use foveasim_render::{Bound, RenderOptions, trace};
use foveasim_reports::{Cell, Table};

use super::place::Place;
use super::strength::{Family, StrengthRow, best};
use super::timing::{FrameTime, pair};
use super::{Friston2019Outcome, ReproduceError};
use crate::kernel::median;

/// One way to draw a foveated frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FoveatedWay {
    /// Full resolution by common rasterization.
    Common,
    /// Three layers (Guenter 2012), all radii optimised.
    Layers,
    /// Lens-matched shading at its best strength.
    LensMatched,
    /// Kernel foveated rendering as published, at its best strength: visibility at full resolution.
    Kernel,
    /// The same with visibility found at its samples.
    KernelDirect,
    /// A buffer that magnifies the fovea with k = 2.
    Perceptual,
    /// The same by moving triangles, as where something moves, with one of their bounds.
    Bounded(Bound),
    /// Full resolution by casting rays; visibility alone, building its tree included.
    Traced,
}

/// One way on one scene.
#[derive(Debug, Clone, PartialEq)]
pub struct FoveatedRow {
    /// The scene.
    pub scene: String,
    /// The way.
    pub way: FoveatedWay,
    /// The method as drawn.
    pub method: Method,
    /// Samples shaded.
    pub samples: u64,
    /// Time of visibility and reconstruction \[ms\].
    pub raster_ms: f64,
    /// Time of shading \[ms\]; `None` where nothing is shaded.
    pub shading_ms: Option<f64>,
    /// Time of a frame over that of common rasterization, the median of paired rounds.
    pub over_common: f64,
    /// Samples covered over samples tested.
    pub efficiency: Option<f64>,
    /// SSIM of the fovea.
    pub ssim: Option<f64>,
}

impl FoveatedWay {
    /// All of them, in the order of the figure; the first is what times are compared with.
    pub const ALL: [Self; 11] = [
        Self::Common,
        Self::Layers,
        Self::LensMatched,
        Self::Kernel,
        Self::KernelDirect,
        Self::Perceptual,
        Self::Bounded(Bound::Box),
        Self::Bounded(Bound::Simple),
        Self::Bounded(Bound::Adaptive),
        Self::Bounded(Bound::Conservative),
        Self::Traced,
    ];

    /// Its name.
    pub fn name(self) -> String {
        match self {
            Self::Common => "common".into(),
            Self::Layers => "layers".into(),
            Self::LensMatched => "lens-matched".into(),
            Self::Kernel => "kernel, published".into(),
            Self::KernelDirect => "kernel, direct".into(),
            Self::Perceptual => "perceptual".into(),
            Self::Bounded(bound) => format!("perceptual, {}", bound.name()),
            Self::Traced => "ray-traced".into(),
        }
    }

    fn method(self, place: &Place, rows: &[StrengthRow]) -> Result<Method, ModelError> {
        let of = |family: Family| {
            let strength = best(rows, family);
            place.as_many_samples(family, strength)
        };
        match self {
            Self::Common | Self::Traced => Ok(Method::Full),
            Self::Layers => "layers:3".parse(),
            Self::Perceptual | Self::Bounded(_) => place.as_many_samples(Family::Radial, STRENGTH),
            Self::LensMatched => of(Family::LensMatched),
            Self::KernelDirect => of(Family::LogPolar),
            Self::Kernel => match of(Family::LogPolar)? {
                Method::Kfr(mut settings) => {
                    settings.form = KernelForm::Published;
                    Ok(Method::Kfr(settings))
                }
                other => Ok(other),
            },
        }
    }
}

/// The exponent that the paper uses.
pub(super) const STRENGTH: f64 = 2.0;

/// What the rounds of one way have found.
struct Found {
    method: Method,
    plan: SamplePlan,
    times: Vec<FrameTime>,
    samples: u64,
    efficiency: Option<f64>,
    ssim: Option<f64>,
}

/// Every way on every scene.
pub(super) fn measure(
    places: &[Place],
    strengths: &[StrengthRow],
    rounds: u32,
    clock: &mut dyn FnMut() -> Duration,
    progress: &dyn Fn(f64),
) -> Result<Vec<FoveatedRow>, ReproduceError> {
    let mut rows = Vec::new();
    let steps = f64::from(rounds) * places.len() as f64;
    for (k, place) in places.iter().enumerate() {
        let mut all = Vec::new();
        for way in FoveatedWay::ALL {
            let method = way.method(place, strengths)?;
            all.push(Found {
                method,
                plan: place.plan(method)?,
                times: Vec::new(),
                samples: 0,
                efficiency: None,
                ssim: None,
            });
        }
        for round in 0..rounds {
            progress((k as f64 * f64::from(rounds) + f64::from(round)) / steps);
            for (way, found) in FoveatedWay::ALL.into_iter().zip(&mut all) {
                found.round(way, place, clock)?;
            }
        }
        let common = all[0].times.clone();
        rows.extend(FoveatedWay::ALL.into_iter().zip(&all).map(|(way, found)| {
            let ratios = found.times.iter().zip(&common);
            let shading = median(found.times.iter().map(|t| t.shading()));
            FoveatedRow {
                scene: place.scene.to_string(),
                way,
                method: found.method,
                samples: found.samples,
                raster_ms: median(found.times.iter().map(|t| t.bare)),
                shading_ms: (way != FoveatedWay::Traced).then_some(shading),
                over_common: match way {
                    FoveatedWay::Traced => median(ratios.map(|(t, c)| t.bare / c.bare)),
                    _ => median(ratios.map(|(t, c)| t.frame / c.frame)),
                },
                efficiency: found.efficiency,
                ssim: found.ssim,
            }
        }));
    }
    Ok(rows)
}

impl Found {
    /// Draws once more; the first time, looks at what was drawn, too.
    fn round(
        &mut self,
        way: FoveatedWay,
        place: &Place,
        clock: &mut dyn FnMut() -> Duration,
    ) -> Result<(), ReproduceError> {
        let options = RenderOptions {
            bound: match way {
                FoveatedWay::Bounded(bound) => Some(bound),
                _ => None,
            },
            ..RenderOptions::default()
        };
        if way == FoveatedWay::Traced {
            // Slow, and without shading: once is enough.
            let bare = match self.times.first() {
                Some(first) => first.bare,
                None => {
                    let began = clock();
                    let plan = SamplePlan::full(Eye::Cyclopean, place.view.optics.size);
                    let seen = trace(&place.world, &place.view, &plan, 0, 0, &options)?;
                    self.samples = seen.len() as u64;
                    clock().saturating_sub(began).as_secs_f64() * 1e3
                }
            };
            self.times.push(FrameTime { frame: bare, bare });
            return Ok(());
        }
        let (frame, time) = pair(
            [&place.world, &place.bare],
            &place.view,
            &self.plan,
            &options,
            clock,
        )?;
        if self.times.is_empty() {
            let work = &frame.work;
            self.samples = work.samples();
            self.efficiency = Some(work.samples_covered as f64 / work.samples_tested.max(1) as f64);
            self.ssim = Some(place.likeness(&frame.image)?);
        }
        self.times.push(time);
        Ok(())
    }
}

impl Friston2019Outcome {
    /// The rows of Fig. 12 that are of foveation.
    pub fn foveated_table(&self) -> Table {
        let mut table = Table::new([
            "scene",
            "way",
            "method",
            "samples",
            "raster_ms",
            "shading_ms",
            "total_ms",
            "over_common",
            "sample_test_efficiency",
            "ssim_fovea",
        ]);
        for r in &self.foveated {
            let optional = |v: Option<f64>| v.map_or(Cell::Empty, Cell::from);
            table.push(vec![
                r.scene.as_str().into(),
                r.way.name().into(),
                r.method.to_string().into(),
                r.samples.into(),
                r.raster_ms.into(),
                optional(r.shading_ms),
                (r.raster_ms + r.shading_ms.unwrap_or(0.0)).into(),
                r.over_common.into(),
                optional(r.efficiency),
                optional(r.ssim),
            ]);
        }
        table
    }
}
