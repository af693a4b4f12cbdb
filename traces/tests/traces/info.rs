use foveasim_models::Nanos;
use foveasim_traces::info;

use crate::parse;

#[test]
fn rate_jitter_gaps_losses_and_range() {
    // 1 ms apart, one sample 2 ms late, a hole of 10 ms, three samples lost in a row, one duplicate.
    let rows = [
        (0, "0,0"),
        (1, "0.5,0"),
        (2, ","),
        (3, ","),
        (4, ","),
        (5, "1,-2"),
        (7, "1,-2"),
        (8, "1,-1"),
        (8, "1,-1"),
        (18, "1,-1"),
        (19, "1.25,-1"),
    ];
    let rows: String = rows
        .iter()
        .map(|(ms, g)| format!("{}000000,{g}\n", ms))
        .collect();
    let r = parse(&format!("t_ns,gaze_azimuth_deg,gaze_elevation_deg\n{rows}")).unwrap();
    let about = info(&r).gaze.unwrap();
    assert_eq!((about.samples, about.missing, about.duplicates), (11, 3, 1));
    assert_eq!((about.rate_hz, about.duration), (1000.0, Nanos(19_000_000)));
    assert_eq!((about.gaps, about.longest_gap), (1, Nanos(10_000_000)));
    assert_eq!(
        about.longest_loss,
        Nanos(4_000_000),
        "from the last value to the next"
    );
    assert_eq!(
        about.extents,
        [("azimuth_deg", 0.0, 1.25), ("elevation_deg", -2.0, 0.0)]
    );
    // Eight intervals count: seven of 1 ms and one of 2 ms, whose mean is 1.125 ms.
    assert!(
        (about.interval_sd_ms - 0.330_718_913_883).abs() < 1e-9,
        "{}",
        about.interval_sd_ms
    );
    assert_eq!(about.interval_iqr_ms, 0.0);
    // Steps of 0.5°, 1° and 0.25° (on the sphere a little less): the 1 % quantile lies near the least.
    assert!(
        (about.angle_step_deg - 0.255).abs() < 0.001,
        "{}",
        about.angle_step_deg
    );
}

#[test]
fn one_sample_has_no_rate() {
    let about = info(&parse("0 0 0 0 0 0 0 1\n").unwrap());
    assert!(about.gaze.is_none());
    let pose = about.pose.unwrap();
    assert!(pose.rate_hz.is_nan() && pose.angle_step_deg.is_nan());
    assert_eq!(
        (pose.samples, pose.gaps, pose.longest_gap),
        (1, 0, Nanos(0))
    );
}
