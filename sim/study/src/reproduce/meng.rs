//! Meng, Du & Varshney, *Eye-dominance-guided Foveated Rendering*, IEEE TVCG 26 (2020): its theory, and what
//! its published rates say of it.

mod fit;
mod paper;
mod published;
mod report;

pub use fit::{DominanceFit, UserSigmas};
pub use paper::Fig7User;

use foveasim_models::foveation::{KernelSettings, Method, Request, dominance_speedup};
use foveasim_models::math::mean;
use foveasim_models::{Eye, ModelError, Viewport};
use foveasim_reports::{Cell, LineChart, LineSeries, Table};
use glam::UVec2;

use super::ReproduceError;
use paper::{CAPTION, FIG_7};

/// Pixels of each eye's image (§4.1).
pub(super) const EYE_PX: UVec2 = UVec2::new(1280, 1440);

/// σ at which kernel foveated rendering is compared with full resolution.
const SIGMAS: [f64; 5] = [1.2, 1.8, 2.0, 2.4, 3.0];

/// σ of the other eye: up to the coarsest of the user studies (§4.3), and one step beyond.
const OTHER_SIGMAS: [f64; 5] = [1.8, 2.0, 2.4, 3.0, 4.0];

/// What the paper's equations say, and what follows from its Fig. 7; nothing here is measured.
///
/// Fig. 7 gives frames per second in whole numbers for 11 users. Frame times are taken to be
/// t₀ + k/σ² for each eye, as Eqs 6 and 7 have it but for t₀, which holds everything that σ does not change
/// (the visibility pass, the inverse map, the driver): RR = t₀ + 2k, KFR = t₀ + 2k/σ_d²,
/// EFR = t₀ + k/σ_d² + k/σ_nd². The users' σ are not published.
#[derive(Debug, Clone, PartialEq)]
pub struct Meng2020 {
    /// Fits to the published rates.
    pub fits: Vec<DominanceFit>,
    /// The largest t₀ for which every user's σ_nd is at most 4 \[ms\].
    pub most_fixed_ms: f64,
    /// Samples of one eye at each of [`Meng2020::sigmas`], gaze in the middle: σ, α, all the buffer has, and those on the display.
    buffers: Vec<[f64; 4]>,
}

impl Meng2020 {
    /// Computes everything.
    ///
    /// # Errors
    /// None that the paper's numbers can cause.
    pub fn new() -> Result<Self, ReproduceError> {
        let mut buffers = Vec::new();
        for alpha in [KernelSettings::PUBLISHED_ALPHA, 0.25] {
            for sigma in SIGMAS {
                buffers.push(buffer(sigma, alpha)?);
            }
        }
        Ok(Self {
            fits: fit::fits(),
            most_fixed_ms: fit::most_fixed_ms(),
            buffers,
        })
    }

    /// Fig. 7 as printed.
    pub fn users() -> &'static [Fig7User] {
        &FIG_7
    }

    /// σ at which kernel foveated rendering is compared with full resolution.
    pub fn sigmas() -> &'static [f64] {
        &SIGMAS
    }

    /// Fig. 7: its rates, its speedups recomputed, and each user's σ_d and σ_nd if nothing is fixed and if as
    /// much is as can be.
    pub fn fig_7(&self) -> Table {
        let columns = [
            "user",
            "RR_fps",
            "KFR_fps",
            "EFR_fps",
            "KFR_over_RR",
            "EFR_over_RR",
            "EFR_over_KFR",
            "sigma_d",
            "sigma_nd",
            "sigma_d_most_fixed",
            "sigma_nd_most_fixed",
        ];
        let mut table = Table::new(columns);
        for (k, user) in FIG_7.iter().enumerate() {
            let [none, most] = [0.0, self.most_fixed_ms].map(|t| fit::sigmas(user, t));
            let row: Vec<Cell> = vec![
                (k + 1).into(),
                user.rr_fps.into(),
                user.kfr_fps.into(),
                user.efr_fps.into(),
                user.kfr_over_rr().into(),
                user.efr_over_rr().into(),
                user.efr_over_kfr().into(),
                none.dominant.into(),
                none.other.into(),
                most.dominant.into(),
                most.other.into(),
            ];
            table.push(row);
        }
        table
    }

    /// The averages of Fig. 7's columns beside its caption's: the mean of the rows' ratios, the least and the
    /// most it can be with rates that are rounded to whole frames, and what the caption says.
    pub fn caption(&self) -> Table {
        let mut table = Table::new([
            "speedup",
            "mean_of_rows",
            "least_unrounded",
            "most_unrounded",
            "caption",
            "caption_possible",
        ]);
        // A printed rate stands for half a frame to either side.
        let of = |ratio: fn([f64; 3]) -> f64, up: fn(f64) -> [f64; 3]| {
            let values: Vec<f64> = FIG_7
                .iter()
                .map(|user| {
                    let [rr, kfr, efr] = user.rates();
                    let [a, b, c] = up(0.5);
                    ratio([rr + a, kfr + b, efr + c])
                })
                .collect();
            mean(&values)
        };
        type Ratio = fn([f64; 3]) -> f64;
        let efr_over_rr: Ratio = |[rr, _, efr]| efr / rr;
        let efr_over_kfr: Ratio = |[_, kfr, efr]| efr / kfr;
        for (name, ratio, printed) in [
            ("EFR over RR", efr_over_rr, Some(CAPTION.efr_over_rr)),
            ("EFR over KFR", efr_over_kfr, Some(CAPTION.efr_over_kfr)),
        ] {
            let middle = of(ratio, |_| [0.0; 3]);
            let least = of(ratio, |h| [h, h, -h]);
            let most = of(ratio, |h| [-h, -h, h]);
            let possible = printed.map(|p| p >= least - 0.005 && p <= most + 0.005);
            table.push(vec![
                name.into(),
                middle.into(),
                least.into(),
                most.into(),
                printed.into(),
                possible.map(|p| if p { "yes" } else { "no" }).into(),
            ]);
        }
        table
    }

    /// The fits of Fig. 7, with what each says of the three rates.
    pub fn fits_table(&self) -> Table {
        let mut table = Table::new([
            "fit",
            "sigma_d",
            "sigma_nd",
            "t0_ms",
            "k_ms",
            "rms_ms",
            "RR_fps",
            "KFR_fps",
            "EFR_fps",
            "EFR_over_RR",
            "EFR_over_KFR",
        ]);
        for fit in &self.fits {
            let [rr, kfr, efr] = fit.times_ms().map(|t| 1e3 / t);
            table.push(vec![
                fit.name.into(),
                fit.sigmas[0].into(),
                fit.sigmas[1].into(),
                fit.fixed_ms.into(),
                fit.eye_ms.into(),
                fit.rms_ms.into(),
                rr.into(),
                kfr.into(),
                efr.into(),
                (efr / rr).into(),
                (efr / kfr).into(),
            ]);
        }
        table
    }

    /// σ² beside what the buffer really has: W/σ × H/σ samples, less those beyond the display.
    pub fn buffers(&self) -> Table {
        let mut table = Table::new([
            "alpha",
            "sigma",
            "sigma_squared",
            "buffer",
            "drawn",
            "pixels_over_drawn",
        ]);
        let pixels = f64::from(EYE_PX.x) * f64::from(EYE_PX.y);
        for [sigma, alpha, all, drawn] in &self.buffers {
            table.push(vec![
                (*alpha).into(),
                (*sigma).into(),
                (sigma * sigma).into(),
                (*all as u64).into(),
                (*drawn as u64).into(),
                (pixels / drawn).into(),
            ]);
        }
        table
    }

    /// Eq. 9 for pairs of σ.
    pub fn dominance(&self) -> Table {
        let mut table = Table::new(["sigma_d", "sigma_nd", "efr_over_kfr", "efr_over_rr"]);
        for (d, nd) in pairs() {
            let speedup = dominance_speedup(d, nd);
            table.push(vec![
                d.into(),
                nd.into(),
                speedup.into(),
                (speedup * d * d).into(),
            ]);
        }
        table
    }

    /// Eq. 9 as curves over σ_nd.
    pub fn dominance_chart(&self) -> LineChart {
        let curve = |d: &f64| LineSeries {
            label: format!("σ_d = {d}"),
            points: (0..=56)
                .map(|k| 1.2 + 0.05 * f64::from(k))
                .filter(|nd| *nd >= *d - 1e-9)
                .map(|nd| [nd, dominance_speedup(*d, nd)])
                .collect(),
        };
        LineChart {
            title: "Eq. 9: eye dominance over the same kernel for both eyes".into(),
            x_label: "σ of the other eye".into(),
            y_label: "speedup".into(),
            series: [1.2, 1.8, 2.0, 2.4].iter().map(curve).collect(),
            ..LineChart::default()
        }
    }
}

fn pairs() -> impl Iterator<Item = (f64, f64)> {
    let dominant = [1.2, 1.8, 2.0, 2.4].into_iter();
    dominant.flat_map(|d| {
        let others = OTHER_SIGMAS.into_iter().filter(move |nd| *nd >= d);
        others.map(move |nd| (d, nd))
    })
}

/// σ, α, samples of the whole buffer and those that are drawn, gaze in the middle.
fn buffer(sigma: f64, alpha: f64) -> Result<[f64; 4], ModelError> {
    let viewport = Viewport::symmetric(EYE_PX, 1.0)?;
    let gaze = viewport.gaze_at(viewport.centre_px());
    let plan = Method::Kfr(KernelSettings::new(sigma, alpha)?).plan(&Request {
        eye: Eye::Cyclopean,
        viewport,
        acuity: foveasim_models::Acuity::default(),
        gaze,
        ahead: gaze,
        margin_deg: 0.0,
    })?;
    let all = plan.passes[0].lattice.samples();
    Ok([sigma, alpha, all as f64, plan.count().samples() as f64])
}

#[cfg(test)]
mod tests;
