use super::*;

fn gaze(t_ms: f64, az: Option<f64>) -> Sample<GazeDirection> {
    Sample {
        t: Nanos::from_ms(t_ms),
        value: az.map(|a| GazeDirection::new(a, 0.0)),
    }
}

#[test]
fn interpolates_but_never_across_what_is_missing() {
    let s = Series::new(
        vec![
            gaze(0.0, Some(0.0)),
            gaze(10.0, Some(1.0)),
            gaze(20.0, None),
            gaze(90.0, Some(3.0)),
            gaze(190.0, Some(4.0)),
        ],
        Provenance::Truth,
    )
    .unwrap();
    let gap = Nanos::from_ms(50.0);
    assert_eq!(s.at(Nanos::from_ms(5.0), gap).unwrap().azimuth_deg, 0.5);
    assert_eq!(s.at(Nanos::from_ms(10.0), gap).unwrap().azimuth_deg, 1.0);
    assert_eq!(
        s.at(Nanos::from_ms(15.0), gap),
        None,
        "next sample is missing"
    );
    assert_eq!(s.at(Nanos::from_ms(100.0), gap), None, "hole of 100 ms");
    assert_eq!(s.at(Nanos::from_ms(-1.0), gap), None);
    assert_eq!(s.at(Nanos::from_ms(200.0), gap), None);
    assert_eq!(
        s.latest(Nanos::from_ms(25.0), gap).unwrap().0,
        Nanos::from_ms(10.0)
    );
    assert_eq!(s.latest(Nanos::from_ms(70.0), gap), None);
}

#[test]
fn between_two_samples() {
    let gap = Nanos::from_ms(10.0);
    let (first, next) = (gaze(0.0, Some(1.0)), gaze(10.0, Some(3.0)));
    let at = |next, ms, gap| {
        let value = first.towards(next, Nanos::from_ms(ms), gap);
        value.map(|g| g.azimuth_deg)
    };
    assert_eq!(at(Some(&next), 5.0, gap), Some(2.0));
    assert_eq!(at(Some(&next), 5.0, gap - Nanos(1)), None);
    let lost = gaze(10.0, None);
    assert_eq!(at(Some(&lost), 5.0, gap), None);
    assert_eq!(at(None, 5.0, gap), None);
    assert_eq!(at(None, 0.0, gap), Some(1.0), "its own time needs no other");
    assert_eq!(gaze(0.0, None).towards(Some(&next), Nanos::ZERO, gap), None);
}

#[test]
fn provenance_has_a_text_form() {
    for text in ["truth", "tracker:12.5"] {
        assert_eq!(text.parse::<Provenance>().unwrap().to_string(), text);
    }
    assert_eq!(
        "tracker:8ms".parse::<Provenance>().unwrap().to_string(),
        "tracker:8"
    );
    for bad in ["", "tracker:", "tracker:-1", "tracker:nan", "lies"] {
        assert!(bad.parse::<Provenance>().is_err(), "{bad}");
    }
}

#[test]
fn reversed_time_is_refused() {
    let e = Series::new(vec![gaze(1.0, None), gaze(0.0, None)], Provenance::Truth);
    assert!(matches!(e, Err(SeriesError::TimeReversed { index: 1, .. })));
    assert_eq!(
        Series::<Pose>::new(vec![], Provenance::Truth),
        Err(SeriesError::Empty)
    );
}
