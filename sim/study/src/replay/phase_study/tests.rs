use foveasim_models::{
    FixedCost, GazeDirection, Nanos, Provenance, Rate, Recording, Sample, Series, Tracker, presets,
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

fn after(window: Nanos) -> Suppression {
    Suppression {
        before: Nanos::ZERO,
        after: window,
    }
}

fn spec(display: &Display, suppression: Suppression) -> PhaseSpec<'_> {
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
    let study = PhaseStudy::new(&out, &phases, &spec(&display, Suppression::default())).unwrap();
    let row = |phase| study.rows.iter().find(|r| r.phase == phase).unwrap();
    let (all, parts) = study.rows.split_first().unwrap();
    assert_eq!(parts.iter().map(|r| r.frames).sum::<u64>(), all.frames);
    assert!((parts.iter().map(|r| r.share).sum::<f64>() - 1.0).abs() < 1e-12);
    let p95 = out.summary().gaze_error_deg.unwrap().p95;
    let all_p95 = all.p95_deg().unwrap();
    assert!(
        (all_p95 - p95).abs() <= 0.001,
        "all is what the summary says, to its bin"
    );
    // From the motion alone: each frame shows the eye as it was at the middle of its exposure.
    let moved = |f: &ReplayFrame| {
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
    let spec = spec(&display, Suppression::default());
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
    let all = seen_jumps(&out, &none, after(Nanos::ZERO));
    assert!(
        (total(&all) - 10.0 * SACCADES as f64).abs() < 1e-6,
        "{all:?}"
    );
    assert!(all.is_sorted());
    let late = seen_jumps(&out, &phases, after(Nanos::ZERO));
    assert!(total(&late) > 0.0 && total(&late) < total(&all));
    let wide = seen_jumps(&out, &phases, after(Nanos::from_ms(300.0)));
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
    assert!(seen_jumps(&out, &phases, after(Nanos::ZERO)).is_empty());
}

#[test]
fn pops_are_counted_by_the_minute() {
    let (display, out, phases) = played(&recording());
    let study = PhaseStudy::new(&out, &phases, &spec(&display, after(Nanos::ZERO))).unwrap();
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
        PhaseStudy::new(&out, &phases, &spec(&display, Suppression::default())).unwrap()
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

#[test]
fn what_is_shown_before_any_gaze_is_no_error_of_the_chain() {
    // The eye rests 9° aside from the start; until the first sample arrives, the fovea is at the middle.
    let sample = |ms: i64| Sample {
        t: Nanos(ms * 1_000_000),
        value: Some(GazeDirection::new(9.0, 0.0)),
    };
    let rest = Recording {
        gaze: Some(Series::new((0..500).map(sample).collect(), Provenance::Truth).unwrap()),
        ..Recording::default()
    };
    let (display, out, phases) = played(&rest);
    let first = &out.frames[0];
    assert_eq!(first.state, GazeState::Lost);
    assert!(first.gaze_error_deg().unwrap() > 8.9);
    let study = PhaseStudy::new(&out, &phases, &spec(&display, Suppression::default())).unwrap();
    assert!(study.rows[0].frames > 40);
    assert!(study.rows[0].max_deg.unwrap() < 1e-9, "{:?}", study.rows[0]);
}

#[test]
fn a_window_before_saccades_hides_what_falls_in_it() {
    let (_, out, phases) = played(&recording());
    let [start, _] = phases.saccades().next().unwrap();
    // A picture that jumps 20 ms before the eye does.
    let mut out = out;
    let at = start - Nanos::from_ms(20.0);
    let k = out.frames.partition_point(|f| f.lit < at);
    out.frames[k].fovea = GazeDirection::new(5.0, 0.0);
    let visible = |before: f64| {
        let window = Suppression {
            before: Nanos::from_ms(before),
            ..after(Nanos::from_ms(80.0))
        };
        seen_jumps(&out, &phases, window)
            .iter()
            .filter(|j| **j > 1.0)
            .count()
    };
    assert_eq!((visible(0.0), visible(50.0)), (2, 0));
}
