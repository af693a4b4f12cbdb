use foveasim_models::{
    Durations, Emission, FixedCost, FrameCost, FrameInput, GazeDirection, GazeSeries, Nanos,
    PixelResponse, Provenance, Rate, Sample, ScanClock, Series, Tracker,
};
use proptest::prelude::*;

use crate::*;

mod poses;

/// A tracker of 250 Hz: exposes for 2 ms, delivers 1 ms later.
fn tracker(processing: [i64; 2]) -> Tracker {
    Tracker {
        name: "t".into(),
        title: String::new(),
        rate: Rate::from_hz("f", 250.0).unwrap(),
        exposure: Nanos(2_000_000),
        processing: Durations::uniform("p", processing.map(|t| Nanos(t).as_ms())).unwrap(),
        transport: Durations::ZERO,
        bias_deg: 0.0,
        precision_deg: 0.0,
        slippage_deg_per_sqrt_min: 0.0,
        bias_map: None,
        dropouts: None,
        blinks: None,
    }
}

/// 100 Hz, 100 rows, 9 ms of picture and 1 ms of blanking, 3 ms to switch.
fn panel(emission: Emission) -> (ScanClock, PixelResponse) {
    let rate = Rate::from_hz("f", 100.0).unwrap();
    let clock = ScanClock::new(rate, 100, [9, 10]);
    (
        clock,
        PixelResponse {
            settle: Nanos(3_000_000),
            emission,
            ..PixelResponse::default()
        },
    )
}

const fn ms(x: i64) -> Nanos {
    Nanos(x * 1_000_000)
}

fn record(setup: &Setup<'_>, end: Nanos) -> Recorder {
    let mut recorder = Recorder::default();
    Pipeline::new().run(setup, Nanos::ZERO, end, &mut recorder);
    recorder
}

/// ```text
///  ms       0     2  3 4     6  7 8     10 11        16        20           26       30
///  tracker  [exp─]p  d [exp─]p  d [exp─]p  d …    (every 4 ms: deliveries at 3, 7, 11, 15, 19 …)
///  vblank   │                            │                     │                     │
///  render   [F0, knows nothing]          [F1, knows 7]         [F2, knows 19]        [F3, knows 27]
///  shown    (dark)                       [F0                   [F1                   [F2
/// ```
#[test]
fn exact_times_of_a_blocked_host() {
    let (scan, response) = panel(Emission::Rolling);
    let tracker = tracker([1_000_000; 2]);
    let cost = FixedCost(ms(6));
    let mut setup = Setup::new(scan, response, &tracker, SyncMode::Vsync, &cost);
    setup.gaze = GazeInput::Constant(GazeDirection::AHEAD);
    let r = record(&setup, ms(40));

    let times: Vec<_> = r
        .delivered
        .iter()
        .map(|g| (g.exposure_start, g.delivered))
        .collect();
    assert_eq!(
        times[..3],
        [(ms(0), ms(3)), (ms(4), ms(7)), (ms(8), ms(11))]
    );

    let frames: Vec<_> = r.rendered.iter().map(|f| (f.id, f.start, f.end)).collect();
    assert_eq!(
        frames,
        [
            (0, ms(0), ms(6)),
            (1, ms(10), ms(16)),
            (2, ms(20), ms(26)),
            (3, ms(30), ms(36)),
        ]
    );
    let knew: Vec<_> = r
        .rendered
        .iter()
        .map(|f| f.gaze.map(|g| g.delivered))
        .collect();
    assert_eq!(knew, [None, Some(ms(7)), Some(ms(19)), Some(ms(27))]);

    let shown: Vec<_> = r
        .displayed
        .iter()
        .map(|d| (d.vblank, d.at_row(50).map(|s| s.frame.id)))
        .collect();
    assert_eq!(
        shown,
        [
            (ms(0), None),
            (ms(10), Some(0)),
            (ms(20), Some(1)),
            (ms(30), Some(2))
        ]
    );
    let d = &r.displayed[2];
    assert_eq!(
        (d.next_vblank, d.scanned(50), d.lit(50)),
        (ms(30), Nanos(24_500_000), Nanos(27_500_000))
    );
    let s = d.at_row(50).unwrap();
    let gaze = s.frame.gaze.unwrap();
    let stages = Stages::of_gaze(ms(3), &gaze, &s.frame, s, d, 50);
    let basic = STAGES.iter().filter(|x| x.is_basic());
    let parts: Vec<_> = basic.map(|x| stages.get(*x)).collect();
    // wait 1, expose 2, process 1, wait for the frame 3, render 6, for the flip 4, for the row 4.5, switch 3
    assert_eq!(
        parts,
        [
            ms(1),
            ms(2),
            ms(1),
            ms(3),
            ms(6),
            ms(4),
            Nanos(4_500_000),
            ms(3)
        ]
    );
    assert_eq!(stages.total(), d.lit(50) - ms(3));
}

/// ```text
///  ms       0 1         5         9  10 11        15        19
///  render     [F0, 4 ms ]            │  [F1, 4 ms ]
///  scan     [ dark      │ F0      ]  [ F0         │ F1      ]
///                       row 55.6                  row 55.6
/// ```
#[test]
fn exact_times_of_a_torn_picture() {
    let (scan, response) = panel(Emission::Rolling);
    let tracker = tracker([1_000_000; 2]);
    let cost = FixedCost(ms(4));
    let mut setup = Setup::new(scan, response, &tracker, SyncMode::Tearing, &cost);
    setup.phases.host = ms(1);
    let r = record(&setup, ms(30));
    let parts = |i: usize| {
        let id = |s: &Segment| (s.from, s.shown.map(|s| s.frame.id));
        r.displayed[i].segments.iter().map(id).collect::<Vec<_>>()
    };
    assert_eq!(parts(0), [(ms(0), None), (ms(5), Some(0))]);
    assert_eq!(parts(1), [(ms(0), Some(0)), (ms(5), Some(1))]);
    // 5 ms into the scan the beam is 55.6 rows down: row 55 is still the old frame's.
    let id = |row| r.displayed[1].at_row(row).unwrap().frame.id;
    assert_eq!((id(55), id(56)), (0, 1));
    assert_eq!(r.displayed[1].at_row(56).unwrap().flipped, ms(15));
}

#[test]
fn a_flip_in_blanking_is_seen_by_the_next_scan() {
    let (scan, response) = panel(Emission::Rolling);
    let tracker = tracker([1_000_000; 2]);
    for (end, first) in [
        (8_999_999, 2),
        (9_000_000, 1),
        (9_500_000, 1),
        (10_000_000, 1),
    ] {
        let cost = FixedCost(Nanos(end));
        let setup = Setup::new(scan, response, &tracker, SyncMode::Tearing, &cost);
        let r = record(&setup, ms(20));
        assert_eq!(r.displayed[0].segments.len(), first, "flip at {end} ns");
        assert_eq!(
            r.displayed[1].at_row(0).unwrap().frame.id,
            0,
            "flip at {end} ns"
        );
        assert_eq!(r.displayed[1].at_row(0).unwrap().flipped, Nanos(end));
    }
}

#[test]
fn a_frame_that_ends_on_the_blank_is_on_time() {
    let (scan, response) = panel(Emission::Global);
    let tracker = tracker([1_000_000; 2]);
    for sync in [SyncMode::Vsync, SyncMode::VsyncFree] {
        for (render, scan_of_first) in [(0, 1), (9_999_999, 1), (10_000_000, 1), (10_000_001, 2)] {
            let cost = FixedCost(Nanos(render));
            let setup = Setup::new(scan, response, &tracker, sync, &cost);
            let r = record(&setup, ms(60));
            let first = r.displayed.iter().find(|d| d.at_row(0).is_some()).unwrap();
            assert_eq!(first.scan, scan_of_first, "{sync} {render} ns");
            // Global emission: every row with the last one.
            assert_eq!(
                (first.lit(0), first.lit(100)),
                (first.lit(50), first.vblank + ms(12))
            );
        }
    }
}

#[test]
fn a_frame_that_overruns_delays_the_next() {
    let (scan, response) = panel(Emission::Rolling);
    let tracker = tracker([1_000_000; 2]);
    /// The second frame takes 13 ms, the others 4 ms.
    struct Uneven;
    impl FrameCost for Uneven {
        fn duration(&self, frame: &FrameInput) -> Nanos {
            if frame.id == 1 { ms(13) } else { ms(4) }
        }
    }
    let starts = |sync| {
        let setup = Setup::new(scan, response, &tracker, sync, &Uneven);
        record(&setup, ms(50))
            .rendered
            .iter()
            .map(|f| f.start)
            .collect::<Vec<_>>()
    };
    // Free: at once when it ends, then back on the host's grid. Blocked: with its flip.
    assert_eq!(starts(SyncMode::Tearing), [0, 10, 23, 30, 40].map(ms));
    assert_eq!(starts(SyncMode::VsyncFree), [0, 10, 23, 30, 40].map(ms));
    assert_eq!(starts(SyncMode::Vsync), [0, 10, 30, 40].map(ms));
}

#[test]
fn a_frame_that_takes_no_time_is_started_once() {
    let (scan, response) = panel(Emission::Rolling);
    let tracker = tracker([1_000_000; 2]);
    /// The first frame ends exactly on the host's tick after next, the others at once.
    struct Uneven;
    impl FrameCost for Uneven {
        fn duration(&self, frame: &FrameInput) -> Nanos {
            if frame.id == 0 { ms(20) } else { Nanos::ZERO }
        }
    }
    let starts = |sync| {
        let setup = Setup::new(scan, response, &tracker, sync, &Uneven);
        let frames = record(&setup, ms(45)).rendered;
        frames.iter().map(|f| f.start).collect::<Vec<_>>()
    };
    for sync in SyncMode::ALL {
        assert_eq!(starts(sync), [0, 20, 30, 40].map(ms), "{sync}");
    }
}

#[test]
fn recorded_output_is_delivered_once_and_as_old_as_it_says() {
    let (scan, response) = panel(Emission::Rolling);
    let tracker = tracker([1_000_000; 2]);
    let cost = FixedCost(ms(4));
    let sample = |t, az: Option<f64>| Sample {
        t: ms(t),
        value: az.map(|a| GazeDirection::new(a, 0.0)),
    };
    let samples = vec![
        sample(2, Some(1.0)),
        sample(5, None),
        sample(9, Some(3.0)),
        sample(10, Some(4.0)),
    ];
    let delay = ms(15);
    let series: GazeSeries = Series::new(samples, Provenance::TrackerOutput { delay }).unwrap();
    let mut setup = Setup::new(scan, response, &tracker, SyncMode::Vsync, &cost);
    setup.gaze = GazeInput::Recorded((&series).into());
    let r = record(&setup, ms(30));
    let got: Vec<_> = r
        .delivered
        .iter()
        .map(|g| (g.delivered, g.middle(), g.value.azimuth_deg))
        .collect();
    assert_eq!(
        got,
        [
            (ms(2), ms(-13), 1.0),
            (ms(9), ms(-6), 3.0),
            (ms(10), ms(-5), 4.0)
        ]
    );
    // A sample delivered at the very start of a frame is known to it.
    assert_eq!(r.rendered[1].gaze.unwrap().value.azimuth_deg, 4.0);
}

#[test]
fn what_is_missing_is_not_delivered() {
    let (scan, response) = panel(Emission::Rolling);
    let tracker = tracker([0, 3_000_000]);
    let cost = FixedCost(ms(4));
    let sample = |t: i64| Sample {
        t: ms(t),
        value: (!(100..200).contains(&t)).then(|| GazeDirection::new(t as f64, 0.0)),
    };
    let series = |gap| {
        let samples = (0..400)
            .filter(|t| gap || !(100..200).contains(t))
            .map(sample)
            .collect();
        GazeSeries::new(samples, Provenance::Truth).unwrap()
    };
    let delivered = |series: &GazeSeries| {
        let mut setup = Setup::new(scan, response, &tracker, SyncMode::Vsync, &cost);
        setup.gaze = GazeInput::Recorded(series.into());
        record(&setup, ms(390)).delivered
    };
    let explicit = delivered(&series(true));
    assert!(
        explicit
            .iter()
            .all(|g| !(ms(99)..ms(200)).contains(&g.middle()))
    );
    assert!(
        explicit
            .iter()
            .all(|g| (g.value.azimuth_deg - g.middle().as_ms()).abs() < 1e-9)
    );
    // A hole in the data is a loss too, and changes nothing afterwards.
    assert_eq!(explicit, delivered(&series(false)));
}

proptest! {
    #[test]
    fn records_keep_their_order(
        sync in prop::sample::select(SyncMode::ALL.to_vec()),
        phases in [0i64..10_000_000, 0..10_000_000, 0..10_000_000],
        render in 0i64..35_000_000,
        processing in [0i64..9_000_000, 0..9_000_000],
        host_hz in 20.0f64..400.0,
        lines in (1u32..100, 0u32..20),
    ) {
        let tracker = tracker([processing[0], processing[0] + processing[1]]);
        let rate = Rate::from_hz("f", 100.0).unwrap();
        let scan = ScanClock::new(rate, 37, [lines.0, lines.0 + lines.1]);
        let response = PixelResponse { settle: ms(3), ..PixelResponse::default() };
        let cost = FixedCost(Nanos(render));
        let mut setup = Setup::new(scan, response, &tracker, sync, &cost);
        let [exposure, host, vblank] = phases.map(Nanos);
        setup.phases = Phases {
            exposure,
            host,
            vblank,
            ..Phases::default()
        };
        setup.host_rate = Rate::from_hz("f", host_hz).unwrap();
        setup.gaze = GazeInput::Constant(GazeDirection::AHEAD);
        let r = record(&setup, ms(300));
        prop_assert_eq!(&r.delivered, &record(&setup, ms(300)).delivered, "same input, same records");

        prop_assert!(r.delivered.is_sorted_by_key(|g| g.delivered));
        prop_assert!(r.delivered.is_sorted_by_key(|g| g.exposure_start));
        for g in &r.delivered {
            let processed = g.delivered - g.exposure_end;
            prop_assert!(tracker.processing.min() <= processed && processed <= tracker.processing.max());
        }
        for pair in r.rendered.windows(2) {
            prop_assert!(pair[0].start < pair[1].start);
            prop_assert!(pair[0].end <= pair[1].start && pair[0].id + 1 == pair[1].id);
        }
        for frame in &r.rendered {
            // Exactly the newest gaze delivered by the start.
            let newest = r.delivered.iter().rev().find(|g| g.delivered <= frame.start);
            prop_assert_eq!(frame.gaze.as_ref(), newest);
        }
        let mut last = 0;
        for (i, d) in r.displayed.iter().enumerate() {
            prop_assert_eq!(d.scan, i as i64);
            prop_assert!(d.vblank + scan.active() <= d.next_vblank);
            prop_assert!(d.segments[0].from == Nanos::ZERO);
            prop_assert!(d.segments.windows(2).all(|w| w[0].from < w[1].from));
            for s in &d.segments {
                let Some(shown) = s.shown else { continue };
                prop_assert!(shown.frame.id >= last && shown.frame.end <= shown.flipped);
                prop_assert!(shown.flipped <= d.vblank + s.from && s.from <= scan.active());
                last = shown.frame.id;
            }
            prop_assert!(sync == SyncMode::Tearing || d.segments.len() == 1);
        }
    }
}
