use foveasim_models::{Rate, presets};
use foveasim_pipeline::STAGES;

use super::*;

mod chains;
mod guenter;
mod properties;
mod rounding;
mod search;
mod sensitivity;

fn study(sync: SyncMode) -> LatencyStudy {
    let display = presets::display("lg-w2363d").unwrap();
    let tracker = presets::tracker("tx300").unwrap();
    LatencyStudy::new(display, tracker, sync, None, None).unwrap()
}

fn run(study: &LatencyStudy, runs: u64) -> LatencyResult {
    study.run(runs, 1, &|_| ()).unwrap()
}

fn bound(study: &LatencyStudy, quantity: Quantity) -> (f64, f64) {
    let b = study.bounds()[quantity.index()];
    (b.min.as_ms(), b.max.as_ms())
}

/// min, p5, p50, mean, p95, p99, max \[ms\].
type Row = [f64; 7];

/// Guenter 2012, §4.1, unrounded: exact distributions by an independent computation.
const TABLE: [(SyncMode, Quantity, Row); 5] = [
    (
        SyncMode::Tearing,
        Quantity::Gaze(Rows::Gaze),
        [
            18.966_667, 24.017_713, 29.966_667, 29.966_667, 35.915_621, 37.701_427, 40.966_667,
        ],
    ),
    (
        SyncMode::Tearing,
        Quantity::Gaze(Rows::Last),
        [20.51, 25.56, 31.39, 31.37, 37.03, 38.61, 40.97],
    ),
    (
        SyncMode::Tearing,
        Quantity::Gaze(Rows::CompletePass),
        [
            20.509_877, 25.560_922, 31.509_877, 31.509_877, 37.458_831, 39.244_637, 42.509_877,
        ],
    ),
    (
        SyncMode::VsyncFree,
        Quantity::Gaze(Rows::Last),
        [
            23.904_938, 28.955_984, 34.904_938, 34.904_938, 40.853_892, 42.639_699, 45.904_938,
        ],
    ),
    (
        SyncMode::Vsync,
        Quantity::Gaze(Rows::Last),
        [23.90, 26.47, 30.74, 30.74, 35.01, 36.08, 37.57],
    ),
];

/// To 0.05 ms at a million runs.
#[test]
fn quantiles_and_means_of_the_study() {
    for mode in SyncMode::ALL {
        let study = study(mode);
        let result = run(&study, 1_000_000);
        for (_, quantity, row) in TABLE.into_iter().filter(|(sync, ..)| *sync == mode) {
            let [min, p5, p50, mean, p95, p99, max] = row;
            let h = result.histogram(quantity);
            let quantiles = [(0.05, p5), (0.5, p50), (0.95, p95), (0.99, p99)];
            let got = quantiles.map(|(q, want)| (h.quantile_ms(q), want));
            for (got, want) in got.into_iter().chain([(h.mean_ms(), mean)]) {
                let off = (got - want).abs();
                assert!(off < 0.05, "{mode} {quantity:?}: {got} {want}");
            }
            let (low, high) = bound(&study, quantity);
            assert!(
                (low - min).abs() < 0.006 && (high - max).abs() < 0.006,
                "{low} {high}"
            );
        }
    }
}

#[test]
fn bounds_of_the_study_are_the_exact_extremes() {
    let close = |got: (f64, f64), want: (f64, f64)| {
        assert!(
            (got.0 - want.0).abs() < 1e-3 && (got.1 - want.1).abs() < 1e-3,
            "{got:?} {want:?}"
        );
    };
    let (tearing, free, vsync) = (
        study(SyncMode::Tearing),
        study(SyncMode::VsyncFree),
        study(SyncMode::Vsync),
    );
    close(
        bound(&tearing, Quantity::Gaze(Rows::Gaze)),
        (18.966_667, 40.966_667),
    );
    close(
        bound(&tearing, Quantity::Gaze(Rows::Last)),
        (20.509_877, 40.966_667),
    );
    close(
        bound(&tearing, Quantity::Gaze(Rows::CompletePass)),
        (20.509_877, 42.509_877),
    );
    // The beam inside the layer renews a row at once; from just below, the top is 880 rows away.
    close(
        bound(&tearing, Quantity::Gaze(Rows::First)),
        (18.966_667, 39.423_457),
    );
    close(
        bound(&free, Quantity::Gaze(Rows::Last)),
        (23.904_938, 45.904_938),
    );
    close(
        bound(&vsync, Quantity::Gaze(Rows::Last)),
        (23.904_938, 37.571_605),
    );
    close(
        bound(&vsync, Quantity::Gaze(Rows::Gaze)),
        (23.133_333, 36.8),
    );
}

#[test]
fn no_sample_leaves_its_bounds() {
    let ms = Nanos::from_ms;
    for display in ["lg-w2363d", "quest-3", "fove-0"] {
        for tracker in ["tx300", "quest-pro", "spectrum"] {
            for sync in SyncMode::ALL {
                for render in [
                    None,
                    Some(ms(0.0)),
                    Some(ms(3.0)),
                    Some(ms(8.333_334)),
                    Some(ms(20.0)),
                ] {
                    let study = LatencyStudy::new(
                        presets::display(display).unwrap(),
                        presets::tracker(tracker).unwrap(),
                        sync,
                        render,
                        None,
                    )
                    .unwrap();
                    let outside = run(&study, 4000).outside_bounds();
                    assert_eq!(outside, None, "{display} {tracker} {sync} {render:?}");
                }
            }
        }
    }
}

/// The clocks that make every wait as short or as long as can be, for a flip `at` after a blank.
fn extreme(study: &LatencyStudy, longest: bool, at: Nanos) -> (LatencyStudy, RunStart) {
    let mut study = study.clone();
    let t = &mut study.chain.tracker;
    let one = Nanos(1);
    let processing = if longest {
        t.processing.max()
    } else {
        t.processing.min()
    };
    t.processing = Durations::fixed(processing);
    // An exposure starts with the movement, or one nanosecond before it.
    let exposure = if longest { -one } else { Nanos::ZERO };
    let seen = if longest {
        exposure + t.rate.period()
    } else {
        exposure
    };
    let delivered = seen + t.exposure + processing;
    // A frame starts with the delivery, or one nanosecond before it.
    let refresh = study.chain.display.scan.rate.period();
    let start = if longest {
        delivered - one + refresh
    } else {
        delivered
    };
    let host = start;
    let end = start + study.chain.render.max();
    let vblank = match study.chain.sync {
        SyncMode::Tearing => end - at,
        SyncMode::VsyncFree if longest => end - one,
        SyncMode::VsyncFree => end,
        SyncMode::Vsync => start,
    };
    (
        study,
        RunStart {
            phases: Phases {
                exposure,
                host,
                vblank,
                ..Phases::default()
            },
            begin: -refresh * 3,
            head_wait: Nanos::ZERO,
            behind: Nanos::ZERO,
        },
    )
}

#[test]
fn bounds_are_attained_to_a_microsecond() {
    let one = Nanos(1);
    for sync in SyncMode::ALL {
        let study = study(sync);
        let edges = study.edges();
        for quantity in [
            Quantity::Gaze(Rows::First),
            Quantity::Gaze(Rows::Gaze),
            Quantity::Gaze(Rows::Last),
            Quantity::Gaze(Rows::CompletePass),
        ] {
            for longest in [false, true] {
                // Where the beam must be at the flip, if the picture tears.
                let at = match (quantity, longest) {
                    (Quantity::Gaze(Rows::First), true) => edges.last,
                    (Quantity::Gaze(Rows::Gaze), true) => edges.gaze + one,
                    (_, true) => edges.first + one,
                    (Quantity::Gaze(Rows::Gaze), false) => edges.gaze,
                    (_, false) => edges.first,
                };
                let (study_at, start) = extreme(&study, longest, at);
                let (sample, _) = study_at.simulate(&mut Pipeline::new(), 0, 0, start);
                let got = sample[quantity.index()];
                let bound = study.bounds()[quantity.index()];
                let want = if longest { bound.max } else { bound.min };
                assert!(bound.contains(got), "{sync} {quantity:?}: {got} outside");
                assert!(
                    (got - want).0.abs() < 1000,
                    "{sync} {quantity:?}: {got}, bound {want}"
                );
            }
        }
    }
}

#[test]
fn global_emission_lights_all_rows_together() {
    let mut study = study(SyncMode::Tearing);
    study.chain.display.response.emission = foveasim_models::Emission::Global;
    let result = run(&study, 20_000);
    assert_eq!(result.outside_bounds(), None);
    for (histogram, bound) in result.histograms.iter().zip(&result.bounds) {
        // 20,000 runs of four uniform waits come within a tenth of the range of both extremes.
        let slack = Nanos(bound.width().0 / 10 + 1);
        assert!(histogram.min() - bound.min <= slack && bound.max - histogram.max() <= slack);
    }
}

#[test]
fn stages_add_up_and_rows_are_in_order() {
    for sync in SyncMode::ALL {
        let study = study(sync);
        let mut pipeline = Pipeline::new();
        for i in 0..2000 {
            let (sample, _) = study.simulate(&mut pipeline, 3, i, study.draw(3, i));
            let get = |q: Quantity| sample[q.index()];
            let sum: i64 = STAGES.iter().map(|s| get(Quantity::Stage(*s)).0).sum();
            assert_eq!(sum, get(Quantity::Gaze(Rows::Gaze)).0);
            assert!(get(Quantity::Gaze(Rows::First)) <= get(Quantity::Gaze(Rows::Gaze)));
            assert!(get(Quantity::Gaze(Rows::Gaze)) <= get(Quantity::Gaze(Rows::Last)));
            assert!(get(Quantity::Gaze(Rows::Last)) <= get(Quantity::Gaze(Rows::CompletePass)));
        }
    }
}

#[test]
fn the_same_for_any_number_of_threads() {
    let study = study(SyncMode::Tearing);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| run(&study, 70_000))
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(7));
    assert_eq!(one.table().digest(), on(2).table().digest());
    assert_ne!(one, study.run(70_000, 2, &|_| ()).unwrap(), "another seed");
}

#[test]
fn a_slower_frame_is_never_faster_to_the_eye() {
    let p50 = |sync, ms: f64| {
        let s = study(sync);
        let render = Some(Nanos::from_ms(ms));
        let s = LatencyStudy::new(s.chain.display, s.chain.tracker, sync, render, None).unwrap();
        run(&s, 20_000)
            .histogram(Quantity::Gaze(Rows::Gaze))
            .mean_ms()
    };
    for sync in SyncMode::ALL {
        let means: Vec<f64> = [2.0, 6.0, 10.0, 18.0].map(|ms| p50(sync, ms)).into();
        assert!(means.is_sorted(), "{sync}: {means:?}");
    }
}

#[test]
fn bad_input_is_refused() {
    let s = study(SyncMode::Vsync);
    let with = |render, band| {
        LatencyStudy::new(
            s.chain.display.clone(),
            s.chain.tracker.clone(),
            s.chain.sync,
            render,
            band,
        )
        .is_err()
    };
    assert!(with(Some(Nanos(-1)), None));
    assert!(with(Some(Nanos::MAX), None));
    for (top, gaze, bottom) in [
        (5, 5, 5),
        (9, 9, 2),
        (0, 5, 1081),
        (10, 5, 20),
        (0, 4000, 9),
    ] {
        assert!(
            with(None, Some(Band { top, gaze, bottom })),
            "{top} {gaze} {bottom}"
        );
    }
    assert!(s.run(0, 1, &|_| ()).is_err() && s.run(MAX_RUNS + 1, 1, &|_| ()).is_err());
    assert_eq!(s.run(1, 1, &|_| ()).unwrap().histograms[0].len(), 1);
}
