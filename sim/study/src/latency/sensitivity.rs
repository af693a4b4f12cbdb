use foveasim_models::Nanos;
use foveasim_reports::Table;

use super::{KNOBS, Knob, LatencyError, LatencyResult, LatencyStudy, Quantity, Rows};

/// What a millisecond less of one part buys at the row gazed at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensitivity {
    /// Which part.
    pub knob: Knob,
    /// How much of it there is.
    pub length: Nanos,
    /// How much was taken away to find out.
    pub step: Nanos,
    /// Mean gaze-to-photon time saved per time taken away \[ms/ms\].
    pub gaze_mean: f64,
    /// 95th percentile of it saved \[ms/ms\].
    pub gaze_p95: f64,
    /// Mean motion-to-photon time saved \[ms/ms\].
    pub motion_mean: f64,
    /// 95th percentile of it saved \[ms/ms\].
    pub motion_p95: f64,
}

/// What a budget's check found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// The 95th percentile of gaze to photon in the gaze row \[ms\].
    pub p95_ms: f64,
    /// What it may be \[ms\].
    pub budget_ms: f64,
    /// The part that brings it down furthest, towards the budget, when shortened; where several do
    /// equally, the one that gains most by the millisecond. `None` if none does.
    pub shorten: Option<Sensitivity>,
}

impl LatencyStudy {
    /// What a millisecond less of each part buys, by finite differences between `result` and runs with
    /// the same clocks and draws (common random numbers). Parts that there is nothing of are left out.
    ///
    /// # Errors
    /// As [`LatencyStudy::run`].
    pub fn sensitivities(
        &self,
        result: &LatencyResult,
        runs: u64,
        seed: u64,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Vec<Sensitivity>, LatencyError> {
        let mut found = Vec::new();
        for knob in KNOBS {
            let step = knob.step(&self.chain);
            if step <= Nanos::ZERO {
                continue;
            }
            let less = Self {
                chain: knob.shortened(&self.chain, step),
                band: self.band,
            };
            let less = less.run(runs, seed, progress)?;
            let saved = |quantity, of: fn(&super::Histogram) -> f64| {
                (of(result.histogram(quantity)) - of(less.histogram(quantity))) / step.as_ms()
            };
            let (gaze, motion) = (Quantity::Gaze(Rows::Gaze), Quantity::Motion(Rows::Gaze));
            let p95: fn(&super::Histogram) -> f64 = |h| h.quantile_ms(0.95);
            found.push(Sensitivity {
                knob,
                length: knob.length(&self.chain),
                step,
                gaze_mean: saved(gaze, super::Histogram::mean_ms),
                gaze_p95: saved(gaze, p95),
                motion_mean: saved(motion, super::Histogram::mean_ms),
                motion_p95: saved(motion, p95),
            });
        }
        Ok(found)
    }
}

impl LatencyResult {
    /// Whether the 95th percentile of gaze to photon in the gaze row keeps `budget_ms`, and if not,
    /// what to shorten.
    pub fn budget(&self, budget_ms: f64, sensitivities: &[Sensitivity]) -> Result<f64, Budget> {
        let p95_ms = self.histogram(Quantity::Gaze(Rows::Gaze)).quantile_ms(0.95);
        if p95_ms <= budget_ms {
            return Ok(p95_ms);
        }
        let excess = p95_ms - budget_ms;
        let reach = |s: &Sensitivity| (s.gaze_p95 * s.length.as_ms()).min(excess);
        let better = |a: &Sensitivity, b: &Sensitivity| {
            let by_reach = reach(a).total_cmp(&reach(b));
            by_reach.then(a.gaze_p95.total_cmp(&b.gaze_p95))
        };
        // Gains below what a bin of the histograms resolves are none.
        let useful = sensitivities.iter().filter(|s| s.gaze_p95 > 0.01);
        let shorten = useful.copied().max_by(better);
        Err(Budget {
            p95_ms,
            budget_ms,
            shorten,
        })
    }
}

/// One row per part.
pub fn sensitivity_table(sensitivities: &[Sensitivity]) -> Table {
    let mut table = Table::new([
        "part",
        "length_ms",
        "step_ms",
        "gaze_mean_ms_per_ms",
        "gaze_p95_ms_per_ms",
        "motion_mean_ms_per_ms",
        "motion_p95_ms_per_ms",
    ]);
    for s in sensitivities {
        table.push(vec![
            s.knob.name().into(),
            s.length.as_ms().into(),
            s.step.as_ms().into(),
            s.gaze_mean.into(),
            s.gaze_p95.into(),
            s.motion_mean.into(),
            s.motion_p95.into(),
        ]);
    }
    table
}
