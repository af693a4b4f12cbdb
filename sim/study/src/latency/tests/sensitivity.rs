use foveasim_pipeline::FrameStart;

use super::*;

fn found(study: &LatencyStudy) -> (LatencyResult, Vec<Sensitivity>) {
    let result = run(study, 40_000);
    let sensitivities = study.sensitivities(&result, 40_000, 1, &|_| ()).unwrap();
    (result, sensitivities)
}

fn of(list: &[Sensitivity], knob: Knob) -> Sensitivity {
    *list.iter().find(|s| s.knob == knob).unwrap()
}

#[test]
fn what_a_millisecond_buys() {
    // Tearing: what takes a fixed time costs just that; a wait that is uniform costs half of its
    // period on average. The mean of 40,000 runs with common clocks is good to a few per cent.
    let (_, list) = found(&study(SyncMode::Tearing));
    for (knob, mean) in [
        (Knob::Exposure, 1.0),
        (Knob::PixelResponse, 1.0),
        (Knob::TrackerPeriod, 0.5),
        (Knob::HostPeriod, 0.0), // the frames are as long as the period
        (Knob::GazeLatch, 1.0),
    ] {
        let s = of(&list, knob);
        assert!((s.gaze_mean - mean).abs() < 0.06, "{s:?}");
    }
    assert!(
        of(&list, Knob::Exposure).motion_mean.abs() < 1e-9,
        "the head's way has no exposure"
    );
    let (pose, gaze) = (of(&list, Knob::PoseLatch), of(&list, Knob::GazeLatch));
    assert!(
        pose.gaze_mean == 0.0 && pose.gaze_p95 == 0.0 && gaze.motion_mean == 0.0,
        "when one is read is nothing to the other: {pose:?} {gaze:?}"
    );
    assert!((of(&list, Knob::PixelResponse).motion_p95 - 1.0).abs() < 0.01);
    assert!(
        list.iter().all(|s| s.knob != Knob::Transport),
        "there is none"
    );
}

#[test]
fn a_blocked_host_gains_nothing_by_rendering_faster_one_in_time_does() {
    let blocked = study(SyncMode::Vsync);
    let (_, list) = found(&blocked);
    let render = of(&list, Knob::Render);
    assert!(
        render.gaze_mean.abs() < 1e-9 && render.gaze_p95.abs() < 1e-9,
        "{render:?}"
    );
    let mut in_time = blocked;
    let reserve = in_time.chain.render.max();
    in_time.chain.runtime.start = FrameStart::JustInTime { reserve };
    let (_, list) = found(&in_time);
    let render = of(&list, Knob::Render);
    assert!((render.gaze_mean - 1.0).abs() < 0.05, "{render:?}");
}

#[test]
fn a_budget_names_what_to_shorten() {
    let study = study(SyncMode::Vsync);
    let (result, list) = found(&study);
    let p95 = result
        .histogram(Quantity::Gaze(Rows::Gaze))
        .quantile_ms(0.95);
    assert_eq!(result.budget(50.0, &list), Ok(p95));
    let budget = result.budget(30.0, &list).unwrap_err();
    assert_eq!((budget.p95_ms, budget.budget_ms), (p95, 30.0));
    let shorten = budget.shorten.unwrap();
    // Not rendering: blocked on the swap, that buys nothing.
    assert!(
        shorten.knob != Knob::Render && shorten.gaze_p95 > 0.5,
        "{shorten:?}"
    );
    assert_eq!(result.budget(30.0, &[]).unwrap_err().shorten, None);
}
