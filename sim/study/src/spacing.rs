//! How far apart samples lie as the eye sees it, for every method, and which settings of those that have
//! them given need the fewest.

mod curve;
mod row;

pub use curve::{CurvePoint, SpacingCurve};
pub use row::SpacingRow;

use foveasim_models::foveation::{
    FloorDensity, FoundKernel, FoundLens, KernelSearch, KernelSettings, LensSearch, Method,
    Request, Screen, ideal_samples,
};
use foveasim_models::math::sqrt;
use foveasim_models::{Lattice, ModelError, SamplePlan, Shading};
use foveasim_reports::{LineChart, LineSeries, Table};
use glam::UVec2;
use rayon::prelude::*;

/// Kernels that are shown beside the best one: Meng's, the one between, and that of the paper's co-author's
/// program.
const ALPHAS: [f64; 3] = [4.0, 1.0, 0.25];

/// One image for one eye, and where that may look: what keeps to the acuity line, and what it costs.
#[derive(Debug, Clone, PartialEq)]
pub struct SpacingStudy {
    /// The image, acuity, gaze and margin.
    pub request: Request,
    /// Whether settings must hold wherever on the image the eye looks, instead of for the request's gaze.
    pub any_gaze: bool,
    /// Methods beside those that are found.
    pub methods: Vec<Method>,
}

/// What a [`SpacingStudy`] found.
#[derive(Debug, Clone, PartialEq)]
pub struct SpacingOutcome {
    /// The kernel with the fewest samples; `None` if none keeps to the line.
    pub kernel: Option<FoundKernel>,
    /// The best coefficients of lens-matched shading.
    pub lens: FoundLens,
    /// Every method: those asked for, then lens-matched shading, then kernels.
    pub rows: Vec<SpacingRow>,
    /// Samples of the continuous falloff, for the gaze that takes most.
    pub ideal_samples: f64,
    /// Pixels of the image.
    pub display_pixels: u64,
    /// The acuity line, display and floor: what the methods are compared with.
    pub limit: SpacingCurve,
    rates: Vec<RateShare>,
}

/// How much of an image a shading rate has.
#[derive(Debug, Clone, PartialEq)]
struct RateShare {
    method: Method,
    rate: [u32; 2],
    pixels: u64,
}

/// One gaze of this many is drawn: those along a diagonal of 13 × 13.
const STRIDE: usize = 14;

impl SpacingStudy {
    /// Searches, plans and measures.
    ///
    /// # Errors
    /// If the gaze is not finite or the margin not from 0 to 90 degrees.
    pub fn run(&self) -> Result<SpacingOutcome, ModelError> {
        let searched = self.gazes();
        // Those along a diagonal are enough for what is drawn, and for lenses, which hold many places for each.
        let drawn: Vec<Request> = searched.iter().step_by(STRIDE).cloned().collect();
        let (kernels, lens) = rayon::join(
            || KernelSearch::new(&searched).map(|search| found_kernels(&search)),
            || LensSearch::new(&drawn).and_then(|search| search.best()),
        );
        let ((best, given), lens) = (kernels?, lens?);
        let others = self.methods.iter().map(|&m| (m.to_string(), m));
        let lenses = ("lms, best".to_owned(), Method::Lms(lens.settings));
        let kernels = given.iter().zip(ALPHAS).map(|(found, alpha)| {
            let (label, settings) = match (found, best) {
                (Some(found), _) => (format!("kfr, α = {alpha}"), found.settings),
                // None keeps to the line: then for as many samples as the best one has.
                (None, Some(best)) => {
                    let label = format!("kfr, α = {alpha}, as many samples");
                    (label, self.as_many_samples(best, alpha)?)
                }
                (None, None) => return Ok(None),
            };
            Ok(Some((label, Method::Kfr(settings))))
        });
        let kernels = kernels.collect::<Result<Vec<_>, ModelError>>()?;
        let best_of_all = best.map(|k| ("kfr, best".to_owned(), Method::Kfr(k.settings)));
        let named: Vec<(String, Method)> = others
            .chain([lenses])
            .chain(kernels.into_iter().flatten())
            .chain(best_of_all)
            .collect();
        let ideal = drawn.iter().map(|request| {
            let screen = Screen::from(&request.viewport);
            let density = FloorDensity::PerSolidAngle;
            ideal_samples(
                &screen,
                request.acuity,
                request.gaze,
                request.margin_deg,
                density,
            )
        });
        let ideal = ideal.collect::<Result<Vec<f64>, _>>()?;
        let rows = named.par_iter().map(|(label, method)| {
            let plans = plans(*method, &drawn)?;
            Ok(SpacingRow::new(label.clone(), *method, &drawn, &plans))
        });
        let first = &drawn[0];
        let rates = self.methods.iter().filter(|m| matches!(m, Method::Vrs(_)));
        let rates = rates.map(|m| Ok(rate_shares(*m, &m.plan(first)?)));
        let rates = rates.collect::<Result<Vec<_>, ModelError>>()?;
        let size = self.request.viewport.size;
        Ok(SpacingOutcome {
            kernel: best,
            lens,
            rows: rows.collect::<Result<_, ModelError>>()?,
            ideal_samples: ideal.into_iter().fold(0.0, f64::max),
            display_pixels: u64::from(size.x) * u64::from(size.y),
            limit: SpacingCurve::of_limits(&drawn),
            rates: rates.into_iter().flatten().collect(),
        })
    }

    /// The kernel α with as many samples for the request's gaze as the best one.
    fn as_many_samples(&self, best: FoundKernel, alpha: f64) -> Result<KernelSettings, ModelError> {
        let screen = Screen::from(&self.request.viewport);
        let samples = |settings: KernelSettings| {
            let (acuity, gaze) = (self.request.acuity, self.request.gaze);
            let estimate = Method::Kfr(settings).estimate(&screen, acuity, gaze, 0.0)?;
            Ok::<f64, ModelError>(estimate.samples())
        };
        let same_sigma = best.settings.with_alpha(alpha)?;
        // Samples go with 1/σ².
        let more = sqrt(samples(same_sigma)? / samples(best.settings)?);
        let sigma = (best.settings.sigma() * more * 1e4).round() / 1e4;
        same_sigma.with_sigma(sigma.clamp(0.25, 100.0))
    }

    /// The request's gaze, or those of [`Request::wherever`].
    fn gazes(&self) -> Vec<Request> {
        if self.any_gaze {
            self.request.wherever()
        } else {
            vec![self.request.clone()]
        }
    }
}

/// The best kernel, and those of given α.
fn found_kernels(search: &KernelSearch) -> (Option<FoundKernel>, [Option<FoundKernel>; 3]) {
    (search.best(), ALPHAS.map(|alpha| search.at_alpha(alpha)))
}

fn plans(method: Method, requests: &[Request]) -> Result<Vec<SamplePlan>, ModelError> {
    let Some(first) = requests.first() else {
        return Ok(Vec::new());
    };
    let prepared = method.prepare(first)?;
    requests.iter().map(|r| prepared.plan(r.gaze)).collect()
}

/// Pixels of each shading rate, coarsest last.
fn rate_shares(method: Method, plan: &SamplePlan) -> Vec<RateShare> {
    let (Shading::Coarse(rates), Lattice::Grid(size)) =
        (&plan.passes[0].shading, plan.passes[0].lattice)
    else {
        return Vec::new();
    };
    let mut found = std::collections::BTreeMap::new();
    for y in (0..size.y).step_by(rates.tile() as usize) {
        for x in (0..size.x).step_by(rates.tile() as usize) {
            let first = UVec2::new(x, y);
            let rate = rates.rate(first);
            let cut = (size - first).min(UVec2::splat(rates.tile()));
            let key = (rate.x * rate.y, rate.x, rate.y);
            *found.entry(key).or_insert(0) += u64::from(cut.x) * u64::from(cut.y);
        }
    }
    let share = |((_, x, y), pixels)| RateShare {
        method,
        rate: [x, y],
        pixels,
    };
    found.into_iter().map(share).collect()
}

impl SpacingOutcome {
    /// One line for each method: its settings, what it costs, and how it keeps to the line.
    pub fn table(&self) -> Table {
        let mut table = Table::new(row::COLUMNS);
        for row in &self.rows {
            table.push(row.cells(self));
        }
        table
    }

    /// Spacing over eccentricity, a line for each method and half degree.
    pub fn curves(&self) -> Table {
        let mut table = Table::new(curve::COLUMNS);
        let all = self.rows.iter().map(|row| (row.label.as_str(), &row.curve));
        for (label, curve) in all.chain([("acuity line or display", &self.limit)]) {
            curve
                .cells(label)
                .into_iter()
                .for_each(|row| table.push(row));
        }
        table
    }

    /// Which share of the image each shading rate has.
    pub fn rates(&self) -> Table {
        let mut table = Table::new(["method", "rate", "pixels", "share"]);
        for share in &self.rates {
            table.push(vec![
                share.method.to_string().into(),
                format!("{}x{}", share.rate[0], share.rate[1]).into(),
                share.pixels.into(),
                (share.pixels as f64 / self.display_pixels as f64).into(),
            ]);
        }
        table
    }

    /// Spacing over eccentricity as pictures: the whole image, and about the gaze.
    pub fn charts(&self) -> [(&'static str, LineChart); 2] {
        let chart = |title: &str, to_deg: f64| {
            let line = |label: String, points: Vec<[f64; 2]>| LineSeries {
                label,
                points: points.into_iter().filter(|p| p[0] <= to_deg).collect(),
            };
            let limits = &self.limit.points;
            let acuity = limits
                .iter()
                .map(|p| [p.eccentricity_deg, p.acuity_deg * 60.0]);
            let floor = limits
                .iter()
                .map(|p| [p.eccentricity_deg, p.longest_deg * 60.0]);
            // What is found comes first, in full lines.
            let rows = self.rows.iter().rev().map(|row| {
                let points = row.curve.points.iter();
                let points = points.map(|p| [p.eccentricity_deg, p.longest_deg * 60.0]);
                line(row.label.clone(), points.collect())
            });
            LineChart {
                title: title.into(),
                x_label: "eccentricity [deg]".into(),
                y_label: "distance between samples, where it is largest [arcmin]".into(),
                series: [
                    line("acuity line".into(), acuity.collect()),
                    line("ideal: acuity or pixel".into(), floor.collect()),
                ]
                .into_iter()
                .chain(rows)
                .collect(),
                ..LineChart::default()
            }
        };
        [
            (
                "spacing",
                chart("Spacing of samples over eccentricity", f64::INFINITY),
            ),
            (
                "spacing-centre",
                chart("Spacing of samples near the gaze", 12.0),
            ),
        ]
    }
}

#[cfg(test)]
mod tests;
