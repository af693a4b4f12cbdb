use foveasim_models::math::sqrt;

use super::paper::{CAPTION, FIG_7, Fig7User};

/// Frame times t₀ + k/σ² for each eye, fitted to Fig. 7 or a part of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DominanceFit {
    /// To what.
    pub name: &'static str,
    /// σ_d and σ_nd that are assumed for every user.
    pub sigmas: [f64; 2],
    /// t₀: what σ does not change \[ms\].
    pub fixed_ms: f64,
    /// k: one eye at full resolution \[ms\].
    pub eye_ms: f64,
    /// Root mean square of what is left over \[ms\]; `None` for a fit that is exact.
    pub rms_ms: Option<f64>,
}

/// What a user's rates say of σ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UserSigmas {
    /// σ_d.
    pub dominant: f64,
    /// σ_nd; `None` if EFR is so fast that no σ_nd explains it.
    pub other: Option<f64>,
}

/// σ_d and σ_nd of the paper's example (§3.2).
const SIGMAS: [f64; 2] = [2.0, 3.0];
/// The coarsest σ_nd that is thought possible: the studies offered up to 3.
const MOST_OTHER_SIGMA: f64 = 4.0;

/// How much of 2k the frames of RR, KFR and EFR take, each over 2.
fn shares([dominant, other]: [f64; 2]) -> [f64; 3] {
    let [d, nd] = [dominant, other].map(|s| 1.0 / (s * s));
    [2.0, 2.0 * d, d + nd]
}

pub(super) fn fits() -> Vec<DominanceFit> {
    vec![
        least_squares("RR, KFR and EFR, least squares", &[0, 1, 2]),
        least_squares("KFR and EFR, least squares", &[1, 2]),
        exact("RR and the caption's EFR over RR", CAPTION.efr_over_rr),
        exact("RR and the table's EFR over RR", {
            let ratios: Vec<f64> = FIG_7.iter().map(Fig7User::efr_over_rr).collect();
            foveasim_models::math::mean(&ratios)
        }),
    ]
}

/// To some of RR, KFR and EFR of all users.
fn least_squares(name: &'static str, rates: &[usize]) -> DominanceFit {
    let shares = shares(SIGMAS);
    let points: Vec<[f64; 2]> = FIG_7
        .iter()
        .flat_map(|user| rates.iter().map(|&r| [shares[r], user.times_ms()[r]]))
        .collect();
    let n = points.len() as f64;
    let middle = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / n;
    let (x, y) = (middle(0), middle(1));
    let along: f64 = points.iter().map(|p| (p[0] - x) * (p[0] - x)).sum();
    let both: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    let eye_ms = both / along;
    let fixed_ms = y - eye_ms * x;
    let left = |p: &[f64; 2]| p[1] - fixed_ms - eye_ms * p[0];
    let squares: f64 = points.iter().map(|p| left(p) * left(p)).sum();
    DominanceFit {
        name,
        sigmas: SIGMAS,
        fixed_ms,
        eye_ms,
        rms_ms: Some(sqrt(squares / n)),
    }
}

/// To RR and one average speedup of EFR over it.
fn exact(name: &'static str, efr_over_rr: f64) -> DominanceFit {
    let [full, _, efr] = shares(SIGMAS);
    let [rr_ms, ..] = FIG_7[0].times_ms();
    let efr_ms = rr_ms / efr_over_rr;
    let eye_ms = (rr_ms - efr_ms) / (full - efr);
    DominanceFit {
        name,
        sigmas: SIGMAS,
        fixed_ms: rr_ms - full * eye_ms,
        eye_ms,
        rms_ms: None,
    }
}

impl DominanceFit {
    /// Frame times of RR, KFR and EFR that it predicts \[ms\].
    pub fn times_ms(&self) -> [f64; 3] {
        shares(self.sigmas).map(|share| self.fixed_ms + share * self.eye_ms)
    }
}

/// A user's σ if `fixed_ms` of every frame is fixed.
pub(super) fn sigmas(user: &Fig7User, fixed_ms: f64) -> UserSigmas {
    let [rr, kfr, efr] = user.times_ms().map(|t| t - fixed_ms);
    let dominant = rr / kfr;
    // Both eyes' 1/σ² add up to 2·EFR/RR.
    let other = 2.0 * efr / rr - kfr / rr;
    UserSigmas {
        dominant: sqrt(dominant),
        other: (other > 0.0).then(|| 1.0 / sqrt(other)),
    }
}

/// The largest t₀ for which no user's σ_nd is above [`MOST_OTHER_SIGMA`]: of
/// 2·(EFR − t₀) − (KFR − t₀) = (RR − t₀)/σ_nd².
pub(super) fn most_fixed_ms() -> f64 {
    let share = 1.0 / (MOST_OTHER_SIGMA * MOST_OTHER_SIGMA);
    let bound = |user: &Fig7User| {
        let [rr, kfr, efr] = user.times_ms();
        (2.0 * efr - kfr - rr * share) / (1.0 - share)
    };
    FIG_7.iter().map(bound).fold(f64::INFINITY, f64::min)
}
