use foveasim_models::foveation::{Method, Request};
use foveasim_models::math::{exp, quantile_sorted};
use foveasim_models::{Acuity, Display, ModelError};
use foveasim_reports::{Cell, Table};

use super::{GazePhase, GazePhases, GazeState, Replay, ReplayFrame, Suppression};

/// The percentiles that a margin is asked to cover.
const COVERED: [f64; 2] = [0.95, 0.99];

/// The widest margin that methods are planned for \[deg\].
const WIDEST_DEG: f64 = 90.0;

/// What margins are counted for, and when jumps of the picture are not seen.
#[derive(Debug, Clone, Copy)]
pub struct PhaseSpec<'a> {
    /// Whose samples are counted.
    pub display: &'a Display,
    /// How they are placed; the gaze is straight ahead.
    pub method: Method,
    /// How sharply the viewer sees.
    pub acuity: Acuity,
    /// When jumps are not seen.
    pub suppression: Suppression,
}

/// A margin: what it covers, costs and leaves to be seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margin {
    /// How much wider the sharp region is: the angle that the fraction of displayed frames asked for does not
    /// exceed \[deg\].
    pub margin_deg: f64,
    /// Samples shaded with it over without; `None` for margins that no method is planned for (over 90°).
    pub sample_factor: Option<f64>,
    /// Displayed frames whose fovea jumped by more than the margin where that is seen.
    pub pops: u64,
    /// Those in a minute of known gaze.
    pub pops_per_minute: f64,
}

impl Margin {
    /// The chance that at least one pop is seen within a minute, if they come independently of each
    /// other: 1 − exp(−rate).
    pub fn pop_chance_per_minute(&self) -> f64 {
        1.0 - exp(-self.pops_per_minute)
    }
}

/// One phase, or all of them, of a [`PhaseStudy`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseRow {
    /// Which; `None` for all together.
    pub phase: Option<GazePhase>,
    /// Displayed frames whose true gaze is known and whose light fell in it.
    pub frames: u64,
    /// Their share of all whose true gaze is known.
    pub share: f64,
    /// The angle between the eye and the fovea shown, at its light: median \[deg\]; `None` of no frames,
    /// like all that follows.
    pub p50_deg: Option<f64>,
    /// The largest \[deg\].
    pub max_deg: Option<f64>,
    /// The margins that cover 95 % and 99 % of the phase: the percentiles of the angle.
    pub margins: Option<[Margin; 2]>,
}

/// The angle between where the eye was when light came out and where the fovea of the picture was drawn (as
/// warped), split by what the eye did then, with the margin that covers it.
///
/// Every displayed frame whose true gaze is known counts once, from the first on that knew a gaze, also those
/// that hold or have lost it later.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseStudy {
    /// All frames, then each of [`GazePhase::ALL`].
    pub rows: Vec<PhaseRow>,
}

impl PhaseStudy {
    /// Splits a replay.
    ///
    /// # Errors
    /// If the method cannot be planned on the display.
    pub fn new(
        replay: &Replay,
        phases: &GazePhases,
        spec: &PhaseSpec<'_>,
    ) -> Result<Self, ModelError> {
        let mut angles: Vec<(GazePhase, f64)> = since_first_gaze(replay)
            .iter()
            .filter_map(|f| Some((phases.at(f.lit), f.gaze_error_deg()?)))
            .collect();
        angles.sort_by(|a, b| a.1.total_cmp(&b.1));
        let jumps = seen_jumps(replay, phases, spec.suppression);
        let minutes = angles.len() as f64 * spec.display.scan.rate.period().as_secs() / 60.0;
        let bare = shadings(spec, 0.0)?;
        let margin = |margin_deg: f64| {
            let factor = |margin| Ok(shadings(spec, margin)? as f64 / bare as f64);
            let planned = (margin_deg <= WIDEST_DEG).then_some(margin_deg);
            let pops = (jumps.len() - jumps.partition_point(|j| *j <= margin_deg)) as u64;
            Ok(Margin {
                margin_deg,
                sample_factor: planned.map(factor).transpose()?,
                pops,
                pops_per_minute: pops as f64 / minutes,
            })
        };
        let row = |phase: Option<GazePhase>| {
            let within = |of: &GazePhase| phase.is_none_or(|p| p == *of);
            let sorted: Vec<f64> = angles
                .iter()
                .filter_map(|(of, angle)| within(of).then_some(*angle))
                .collect();
            let [p95, p99] = COVERED.map(|q| quantile_sorted(&sorted, q));
            let any = !sorted.is_empty();
            let margins = || Ok::<_, ModelError>([margin(p95)?, margin(p99)?]);
            Ok(PhaseRow {
                phase,
                frames: sorted.len() as u64,
                share: sorted.len() as f64 / angles.len().max(1) as f64,
                p50_deg: any.then(|| quantile_sorted(&sorted, 0.5)),
                max_deg: sorted.last().copied(),
                margins: any.then(margins).transpose()?,
            })
        };
        let all = std::iter::once(None).chain(GazePhase::ALL.map(Some));
        Ok(Self {
            rows: all.map(row).collect::<Result<_, ModelError>>()?,
        })
    }

    /// One row for all frames, and one for each phase. With the study of the same recording `decimated`: its
    /// 95th percentile beside, and the bias, which is that less the one of the whole recording.
    pub fn table(&self, decimated: Option<&Self>) -> Table {
        let mut columns = vec![
            "phase",
            "frames",
            "frame_share",
            "p50_deg",
            "p95_deg",
            "p99_deg",
            "max_deg",
            "sample_factor_p95",
            "sample_factor_p99",
            "pops_per_minute_p95",
            "pops_per_minute_p99",
            "pop_chance_per_minute_p95",
            "pop_chance_per_minute_p99",
        ];
        if decimated.is_some() {
            columns.extend(["decimated_p95_deg", "decimation_bias_p95_deg"]);
        }
        let mut table = Table::new(columns);
        for (i, row) in self.rows.iter().enumerate() {
            let each = |value: fn(&Margin) -> Option<f64>| -> [Cell; 2] {
                let of = |k: usize| row.margins.as_ref().and_then(|m| value(&m[k])).into();
                [of(0), of(1)]
            };
            let mut cells = vec![
                row.name().into(),
                row.frames.into(),
                row.share.into(),
                row.p50_deg.into(),
            ];
            cells.extend(each(|m| Some(m.margin_deg)));
            cells.push(row.max_deg.into());
            cells.extend(each(|m| m.sample_factor));
            cells.extend(each(|m| Some(m.pops_per_minute)));
            cells.extend(each(|m| Some(m.pop_chance_per_minute())));
            if let Some(slow) = decimated {
                let p95 = slow.rows[i].p95_deg();
                cells.push(p95.into());
                cells.push(p95.zip(row.p95_deg()).map(|(slow, p)| slow - p).into());
            }
            table.push(cells);
        }
        table
    }
}

impl PhaseRow {
    /// The phase, or `all`.
    pub fn name(&self) -> &'static str {
        self.phase.map_or("all", GazePhase::name)
    }

    /// 95 % of its angles are at or below this \[deg\].
    pub fn p95_deg(&self) -> Option<f64> {
        self.margins.map(|m| m[0].margin_deg)
    }
}

/// The frames from the first on that knew a gaze. Until the tracker has seen the eye, the fovea rests at the
/// middle: how far the eye is from there says nothing of the chain, and taking it up is no pop.
fn since_first_gaze(replay: &Replay) -> &[ReplayFrame] {
    let frames = &replay.frames;
    let first = frames.iter().position(|f| f.state != GazeState::Lost);
    &frames[first.unwrap_or(frames.len())..]
}

/// How far the fovea jumped from one displayed frame to the next \[deg\], in order of size, where the
/// gaze is known and nothing keeps the eye from seeing it.
fn seen_jumps(replay: &Replay, phases: &GazePhases, window: Suppression) -> Vec<f64> {
    let pairs = since_first_gaze(replay).windows(2);
    let seen = pairs.filter(|w| w[1].true_gaze.is_some() && !phases.suppressed(w[1].lit, window));
    let mut jumps: Vec<f64> = seen
        .map(|w| w[0].fovea.angle_to_deg(w[1].fovea))
        .filter(|jump| *jump > 0.0)
        .collect();
    jumps.sort_by(f64::total_cmp);
    jumps
}

/// Samples shaded for all eyes with the gaze straight ahead.
fn shadings(spec: &PhaseSpec<'_>, margin_deg: f64) -> Result<u64, ModelError> {
    let of_eye = |panel| {
        let request = Request {
            acuity: spec.acuity,
            margin_deg,
            ..Request::ahead(panel)
        };
        Ok(spec.method.plan(&request)?.count().shadings())
    };
    spec.display.eyes.iter().map(of_eye).sum()
}

#[cfg(test)]
mod tests;
