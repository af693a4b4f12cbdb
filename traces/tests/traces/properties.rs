use foveasim_models::{GazeDirection, Nanos, Pose, Provenance, Recording, Sample, Series};
use foveasim_traces::{ReadOptions, info, read, resample, write};
use glam::{DQuat, DVec3};
use proptest::prelude::*;

const HEADERS: [&str; 5] = [
    "",
    "# foveasim-trace 1\nt_ns,gaze_azimuth_deg,gaze_elevation_deg\n",
    "timestamp\tleft_x\tleft_y\tright_x\tright_y\n",
    "0 0 0 0 0 0 0 1\n",
    "ViewIndex,PositionX,PositionY,PositionZ,QuaternionX,QuaternionY,QuaternionZ,QuaternionW,\
     GazePosX,GazePosY,GazePosZ,GazeQX,GazeQY,GazeQZ,GazeQW,Timestamp\n",
];

fn provenance() -> impl Strategy<Value = Provenance> {
    prop_oneof![
        Just(Provenance::Truth),
        (0i64..600_000_000_000).prop_map(|ns| Provenance::TrackerOutput { delay: Nanos(ns) })
    ]
}

fn series<T: std::fmt::Debug + Clone + foveasim_models::Interpolate>(
    value: impl Strategy<Value = T>,
) -> impl Strategy<Value = Option<Series<T>>> {
    let sample = (-1_000i64..1_000, proptest::option::weighted(0.8, value));
    (proptest::collection::vec(sample, 0..12), provenance()).prop_map(
        |(mut samples, provenance)| {
            samples.sort_by_key(|(t, _)| *t);
            let samples = samples
                .into_iter()
                .map(|(t, value)| Sample { t: Nanos(t), value })
                .collect();
            Series::new(samples, provenance).ok()
        },
    )
}

fn gaze() -> impl Strategy<Value = GazeDirection> {
    (-180.0f64..=180.0, -90.0f64..=90.0).prop_map(|(a, e)| GazeDirection::new(a, e))
}

fn pose() -> impl Strategy<Value = Pose> {
    let q = [-1.0f64..1.0, -1.0..1.0, -1.0..1.0, 0.1..1.0];
    ([-1e6f64..=1e6, -1.0..=1.0, -1e-9..=1e-9], q)
        .prop_map(|(p, q)| Pose::new(DVec3::from_array(p), DQuat::from_array(q).normalize()))
}

proptest! {
    #[test]
    fn arbitrary_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let _ = read(bytes.as_slice(), "f", &ReadOptions::default());
    }

    #[test]
    fn arbitrary_rows_never_panic(
        header in 0..HEADERS.len(),
        rows in "([-+0-9.,eEna/;\t \r]{0,40}\n){0,6}",
    ) {
        let text = format!("{}{rows}", HEADERS[header]);
        if let Ok(r) = read(text.as_bytes(), "f", &ReadOptions::default()) {
            info(&r);
        }
    }

    #[test]
    fn numeric_rows_never_panic(
        header in 1..HEADERS.len(),
        rows in proptest::collection::vec(proptest::collection::vec(
            prop_oneof![Just("0"), Just("1"), Just("-1"), Just("0.707"), Just("nan"), Just(""), Just("n/a"),
                        Just("4600000000000000000"), Just("-4.6e18"), Just("1e300"), Just("1e-300")],
            16), 0..5),
    ) {
        let separator = [",", ",", "\t", " ", ","][header];
        let width = [0, 3, 5, 8, 16][header];
        let rows: String = rows.iter().map(|r| r[..width].join(separator) + "\n").collect();
        if let Ok(r) = read(format!("{}{rows}", HEADERS[header]).as_bytes(), "f", &ReadOptions::default()) {
            info(&r);
        }
    }

    #[test]
    fn own_format_is_exact(gaze in series(gaze()), pose in series(pose())) {
        prop_assume!(gaze.is_some() || pose.is_some());
        let r = Recording { gaze, pose, ..Recording::default() };
        let mut bytes = Vec::new();
        write(&r, &mut bytes).unwrap();
        let back = read(bytes.as_slice(), "f", &ReadOptions::default()).unwrap();
        prop_assert_eq!(back.gaze, r.gaze);
        prop_assert_eq!(back.pose, r.pose);
    }

    #[test]
    fn resampling_stays_between_neighbours(hz in 1e5f64..1e6, series in series(gaze())) {
        prop_assume!(series.is_some());
        let series = series.unwrap();
        let rate = foveasim_models::Rate::from_hz("hz", hz).unwrap();
        let again = resample(&series, rate, Nanos(100)).unwrap();
        prop_assert_eq!(again.start(), series.start());
        prop_assert!(again.end() <= series.end());
        for s in again.samples() {
            prop_assert_eq!(s.value, series.at(s.t, Nanos(100)));
        }
    }
}
