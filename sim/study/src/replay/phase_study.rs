use foveasim_models::foveation::{Method, Request};
use foveasim_models::math::{exp, quantile_sorted};
use foveasim_models::{Acuity, Display, ModelError, Nanos};
use foveasim_reports::{Cell, Table};

use super::{GazePhase, GazePhases, GazeState, Replay};

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
    /// How long after the end of a saccade a jump is not seen.
    pub suppression: Nanos,
}

/// Updates of the picture up to 60 ms after the end of an eye movement go unseen (Loschky & Wolverton
/// 2007).
pub const SUPPRESSION: Nanos = Nanos(60_000_000);

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
/// Every displayed frame whose true gaze is known counts once, also those that hold or have lost the
/// gaze.
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
        let mut angles: Vec<(GazePhase, f64)> = replay
            .frames
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

/// How far the fovea jumped from one displayed frame to the next \[deg\], in order of size, where the
/// gaze is known and nothing keeps the eye from seeing it.
fn seen_jumps(replay: &Replay, phases: &GazePhases, window: Nanos) -> Vec<f64> {
    // Until the tracker has seen the eye, the fovea rests at the middle: taking it up is no pop.
    let first = replay
        .frames
        .iter()
        .position(|f| f.state != GazeState::Lost);
    let pairs = replay.frames[first.unwrap_or(replay.frames.len())..].windows(2);
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
mod tests {
    use foveasim_models::{
        FixedCost, GazeDirection, Provenance, Rate, Recording, Sample, Series, Tracker, presets,
    };
    use foveasim_traces::{EventOptions, decimate_gaze};

    use super::*;
    use crate::{ReplayOptions, replay};

    /// Saccades of ten degrees, to and fro.
    const SACCADES: i64 = 12;
    const EVERY_MS: i64 = 400;
    const LASTS_MS: i64 = 40;

    /// Rests, and moves at a steady 250° a second for 40 ms from every 400 ms on.
    fn azimuth_deg(t_ms: f64) -> f64 {
        let k = (t_ms / EVERY_MS as f64).floor();
        let gone = ((t_ms - k * EVERY_MS as f64) / LASTS_MS as f64).min(1.0);
        let odd = k as i64 % 2 == 1;
        match k as i64 {
            ..=0 => 0.0,
            _ if odd => 10.0 * gone,
            _ => 10.0 - 10.0 * gone,
        }
    }

    fn recording() -> Recording {
        let sample = |ms: i64| Sample {
            t: Nanos(ms * 1_000_000),
            value: Some(GazeDirection::new(azimuth_deg(ms as f64), 0.0)),
        };
        let samples = (0..=(SACCADES + 1) * EVERY_MS - 1).map(sample).collect();
        Recording {
            source: "test".into(),
            gaze: Some(Series::new(samples, Provenance::Truth).unwrap()),
            ..Recording::default()
        }
    }

    fn played(recording: &Recording) -> (Display, Replay, GazePhases) {
        let display = presets::display("lg-w2363d").unwrap();
        let tracker = Tracker {
            bias_deg: 0.0,
            precision_deg: 0.0,
            exposure: Nanos::ZERO,
            ..presets::tracker("tx300").unwrap()
        };
        let cost = FixedCost(Nanos::from_ms(2.0));
        let options = ReplayOptions::default();
        let out = replay(recording, &display, &tracker, &cost, &options).unwrap();
        let phases = GazePhases::find(recording, &EventOptions::default()).unwrap();
        (display, out, phases)
    }

    fn spec(display: &Display, suppression: Nanos) -> PhaseSpec<'_> {
        PhaseSpec {
            display,
            method: "layers:3".parse().unwrap(),
            acuity: Acuity::default(),
            suppression,
        }
    }

    #[test]
    fn phases_hold_what_the_known_motion_says() {
        let (display, out, phases) = played(&recording());
        assert_eq!(phases.saccades().count() as i64, SACCADES);
        for (k, [start, end]) in phases.saccades().enumerate() {
            let onset = (k as i64 + 1) * EVERY_MS;
            // The window of the velocity reaches 5 ms to either side.
            assert!((start.as_ms() - onset as f64).abs() <= 6.0, "{start}");
            assert!((end.as_ms() - (onset + LASTS_MS) as f64).abs() <= 6.0);
        }
        let study = PhaseStudy::new(&out, &phases, &spec(&display, SUPPRESSION)).unwrap();
        let row = |phase| study.rows.iter().find(|r| r.phase == phase).unwrap();
        let (all, parts) = study.rows.split_first().unwrap();
        assert_eq!(parts.iter().map(|r| r.frames).sum::<u64>(), all.frames);
        assert!((parts.iter().map(|r| r.share).sum::<f64>() - 1.0).abs() < 1e-12);
        let p95 = out.summary().gaze_error_deg.unwrap().p95;
        assert_eq!(all.p95_deg(), Some(p95), "all is what the summary says");
        // From the motion alone: each frame shows the eye as it was at the middle of its exposure.
        let moved = |f: &crate::ReplayFrame| {
            let seen = f.frame.gaze.unwrap().middle();
            (azimuth_deg(f.lit.as_ms()) - azimuth_deg(seen.as_ms())).abs()
        };
        for phase in GazePhase::ALL.map(Some) {
            let tracked = out.frames.iter().filter(|f| f.true_gaze.is_some());
            let within = tracked.filter(|f| Some(phases.at(f.lit)) == phase);
            let mut want: Vec<f64> = within
                .filter(|f| f.frame.gaze.is_some())
                .map(moved)
                .collect();
            want.sort_by(f64::total_cmp);
            let found = row(phase);
            let Some(max) = found.max_deg else {
                assert!(want.is_empty());
                continue;
            };
            assert!((max - want.last().unwrap()).abs() < 1e-9, "{found:?}");
            assert!((found.p50_deg.unwrap() - quantile_sorted(&want, 0.5)).abs() < 1e-9);
        }
        // The picture follows within 50 ms: a fixation has no error, a landing up to the whole saccade.
        assert!(row(Some(GazePhase::Fixation)).max_deg.unwrap() < 1e-9);
        assert!(row(Some(GazePhase::Landing)).max_deg.unwrap() > 2.0);
        assert!(row(Some(GazePhase::Saccade)).max_deg.unwrap() <= 10.0 + 1e-9);
    }

    #[test]
    fn margins_cost_what_the_plan_counts() {
        let (display, out, phases) = played(&recording());
        let spec = spec(&display, SUPPRESSION);
        let study = PhaseStudy::new(&out, &phases, &spec).unwrap();
        let factor = |phase, k: usize| {
            let row = study.rows.iter().find(|r| r.phase == Some(phase)).unwrap();
            (row.margins.unwrap()[k], row)
        };
        let (still, _) = factor(GazePhase::Fixation, 0);
        assert!(
            (still.sample_factor.unwrap() - 1.0).abs() < 1e-3,
            "{still:?}"
        );
        let (wide, _) = factor(GazePhase::Saccade, 1);
        let request = |margin_deg| Request {
            margin_deg,
            ..Request::ahead(display.primary())
        };
        let count = |m| spec.method.plan(&request(m)).unwrap().count().samples() as f64;
        let want = count(wide.margin_deg) / count(0.0);
        assert!((wide.sample_factor.unwrap() - want).abs() < 1e-12);
        assert!(want > 1.2, "{want}");
    }

    #[test]
    fn every_jump_is_seen_but_where_the_eye_is_blind() {
        let (_, out, phases) = played(&recording());
        let none = GazePhases::new(
            foveasim_traces::GazeEvents {
                events: Vec::new(),
                limits: None,
                rate_hz: 1000.0,
                shapes_reliable: true,
            },
            Nanos::ZERO,
        );
        let total = |jumps: &[f64]| jumps.iter().sum::<f64>();
        // The fovea travels as far as the eye.
        let all = seen_jumps(&out, &none, Nanos::ZERO);
        assert!(
            (total(&all) - 10.0 * SACCADES as f64).abs() < 1e-6,
            "{all:?}"
        );
        assert!(all.is_sorted());
        let late = seen_jumps(&out, &phases, Nanos::ZERO);
        assert!(total(&late) > 0.0 && total(&late) < total(&all));
        let wide = seen_jumps(&out, &phases, Nanos::from_ms(300.0));
        assert!(wide.is_empty(), "{wide:?}");
    }

    #[test]
    fn taking_up_the_gaze_at_the_start_is_no_jump() {
        let mut aside = recording();
        let resting = (0..1000).map(|ms| Sample {
            t: Nanos(ms * 1_000_000),
            value: Some(GazeDirection::new(7.0, -3.0)),
        });
        aside.gaze = Some(Series::new(resting.collect(), Provenance::Truth).unwrap());
        let (_, out, phases) = played(&aside);
        assert_ne!(out.frames[0].fovea, out.frames.last().unwrap().fovea);
        assert!(seen_jumps(&out, &phases, Nanos::ZERO).is_empty());
    }

    #[test]
    fn pops_are_counted_by_the_minute() {
        let (display, out, phases) = played(&recording());
        let study = PhaseStudy::new(&out, &phases, &spec(&display, Nanos::ZERO)).unwrap();
        // At no margin every jump after a saccade is seen.
        let still = study
            .rows
            .iter()
            .find(|r| r.phase == Some(GazePhase::Fixation));
        let margin = still.unwrap().margins.unwrap()[0];
        assert!(margin.margin_deg < 1e-9 && margin.pops >= SACCADES as u64);
        let minutes = study.rows[0].frames as f64 * display.scan.rate.period().as_secs() / 60.0;
        assert!((margin.pops_per_minute * minutes - margin.pops as f64).abs() < 1e-9);
        let few = Margin {
            pops_per_minute: 0.5,
            ..margin
        };
        assert!((few.pop_chance_per_minute() - 0.393_469_340_287_366_6).abs() < 1e-15);
    }

    #[test]
    fn decimation_is_no_bias_where_gaze_is_straight_and_one_at_saccades() {
        let rate = Rate::from_hz("test", 72.0).unwrap();
        let gap = Nanos::from_ms(100.0);
        let study = |of: &Recording| {
            let (display, out, phases) = played(of);
            PhaseStudy::new(&out, &phases, &spec(&display, SUPPRESSION)).unwrap()
        };
        let bias = |of: &Recording| {
            let (fast, slow) = (study(of), study(&decimate_gaze(of, rate, gap).unwrap()));
            let table = fast.table(Some(&slow));
            assert_eq!(table.columns().last().unwrap(), "decimation_bias_p95_deg");
            assert_eq!(fast.table(None).columns().len() + 2, table.columns().len());
            slow.rows[0].p95_deg().unwrap() - fast.rows[0].p95_deg().unwrap()
        };
        let line = |ms: i64| Sample {
            t: Nanos(ms * 1_000_000),
            value: Some(GazeDirection::new(ms as f64 * 0.004 - 4.0, 0.0)),
        };
        let pursuit = Series::new((0..2000).map(line).collect(), Provenance::Truth).unwrap();
        let steady = Recording {
            gaze: Some(pursuit),
            ..recording()
        };
        // The last frames of the whole recording have no gaze in the decimated one, hence not to the bit.
        assert!(bias(&steady).abs() < 1e-3);
        assert!(bias(&recording()).abs() > 1e-2);
        for hz in [1000.0, 2000.0] {
            let rate = Rate::from_hz("test", hz).unwrap();
            assert!(decimate_gaze(&steady, rate, gap).is_err(), "{hz}");
        }
    }
}
