use super::*;

#[test]
fn refresh_rates_that_no_display_has() {
    let spec = |refresh_hz| ScanSpec {
        refresh_hz,
        response_fraction: 0.9,
        ..ScanSpec::default()
    };
    for hz in [1.0, 10_000.0] {
        assert!(spec(hz).build([1920, 1080], 1).is_ok(), "{hz}");
    }
    for hz in [0.0, 0.001, 0.999, 10_000.1, -60.0, f64::NAN, f64::INFINITY] {
        let error = spec(hz).build([1920, 1080], 1).unwrap_err().to_string();
        let want = format!("scan.refresh_hz = {hz}: must be a number from 1 to 10000");
        assert_eq!(error, want);
    }
}

fn clock(change: &dyn Fn(&mut ScanSpec)) -> Result<(ScanClock, PixelResponse), ModelError> {
    let mut spec = ScanSpec {
        refresh_hz: 100.0,
        lines: Some([80, 100]),
        response_fraction: 0.9,
        ..ScanSpec::default()
    };
    change(&mut spec);
    spec.build([200, 100], 2)
}

fn offsets(change: &dyn Fn(&mut ScanSpec), rows: [u32; 3]) -> [f64; 3] {
    rows.map(|r| clock(change).unwrap().0.row_offset(r).as_ms())
}

#[test]
fn directions_and_blanking() {
    assert_eq!(offsets(&|_| (), [0, 50, 100]), [0.0, 4.0, 8.0]);
    let up = |s: &mut ScanSpec| s.direction = ScanDirection::Up;
    assert_eq!(offsets(&up, [0, 50, 100]), [8.0, 4.0, 0.0]);
    assert_eq!(clock(&up).unwrap().0.active().as_ms(), 8.0);
    let left = |s: &mut ScanSpec| {
        (s.direction, s.lines_before) = (ScanDirection::Left, 10);
    };
    assert_eq!(offsets(&left, [0, 100, 200]), [9.0, 5.0, 1.0]);
    assert!(clock(&|s| s.lines_before = 21).is_err());
}

#[test]
fn rows_of_a_stated_time() {
    let timed = |s: &mut ScanSpec| (s.lines, s.row_us) = (None, Some(70.0));
    assert_eq!(offsets(&timed, [0, 50, 100]), [0.0, 3.5, 7.0]);
    for bad in [0.0, -1.0, 100.1, f64::NAN] {
        assert!(
            clock(&|s| (s.lines, s.row_us) = (None, Some(bad))).is_err(),
            "{bad}"
        );
    }
    assert!(clock(&|s| s.row_us = Some(70.0)).is_err(), "beside lines");
}

#[test]
fn eyes_in_sequence_share_the_time() {
    let sequence = |s: &mut ScanSpec| s.eyes = EyeOrder::Sequence;
    let (left, _) = clock(&sequence).unwrap();
    let right = left.of_eye(1, EyeOrder::Sequence);
    let ms = |c: ScanClock| [0, 50, 100].map(|r| c.row_offset(r).as_ms());
    assert_eq!((ms(left), ms(right)), ([0.0, 2.0, 4.0], [4.0, 6.0, 8.0]));
    assert_eq!(
        (left.picture_end(), right.picture_end()),
        (right.active(), right.active())
    );
    assert_eq!(left.of_eye(1, EyeOrder::Together), left);
    let planar = ScanSpec {
        refresh_hz: 60.0,
        eyes: EyeOrder::Sequence,
        response_fraction: 0.9,
        ..ScanSpec::default()
    };
    assert!(planar.build([10, 10], 1).is_err());
}

#[test]
fn a_pixel_switches_along_its_curve() {
    let settle = |fraction| {
        let curve = vec![[0.0, 0.0], [2.0, 0.5], [4.0, 0.9], [20.0, 1.0]];
        let spec = |s: &mut ScanSpec| {
            (s.response_curve, s.response_fraction) = (curve.clone(), fraction);
        };
        clock(&spec).map(|(_, response)| response.settle.as_ms())
    };
    let got = [0.25, 0.5, 0.7, 0.9, 1.0].map(|f| settle(f).unwrap());
    assert_eq!(got, [1.0, 2.0, 3.0, 4.0, 20.0]);
    for bad in [0.0, -0.1, 1.01, f64::NAN] {
        assert!(settle(bad).is_err(), "{bad}");
    }
    let wrong = |curve: Vec<[f64; 2]>| clock(&|s| s.response_curve = curve.clone()).is_err();
    assert!(wrong(vec![[0.0, 0.0]]) && wrong(vec![[0.0, 0.1], [1.0, 1.0]]));
    assert!(wrong(vec![[0.0, 0.0], [1.0, 1.0], [1.0, 1.0]]));
    assert!(wrong(vec![[0.0, 0.0], [f64::NAN, 1.0]]));
    // Without a curve there is nothing that it would be a fraction of.
    assert!(clock(&|s| s.response_fraction = 0.5).is_err());
}

#[test]
fn the_middle_of_the_light_needs_its_duration() {
    let middle = |ms| {
        clock(&|s| (s.light, s.persistence_ms) = (LightAt::Middle, ms))
            .map(|(_, r)| r.to_counted_light.as_ms())
    };
    assert_eq!(middle(3.0).unwrap(), 1.5);
    assert!(middle(0.0).is_err());
    assert!(clock(&|s| s.strobe_delay_ms = 1.0).is_err(), "rolling");
}
