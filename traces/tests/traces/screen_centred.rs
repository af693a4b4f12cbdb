use foveasim_models::Nanos;
use foveasim_traces::{ReadOptions, ScreenSpec, read};

use crate::{error, noted, parse};

#[test]
fn pixels_become_degrees() {
    let options = ReadOptions {
        screen: ScreenSpec {
            size_px: Some([1000.0, 500.0]),
            size_mm: Some([500.0, 500.0]),
            distance_mm: Some(500.0),
        },
        ..ReadOptions::default()
    };
    // 1000 px are 500 mm to the side: 45°. 250 px of 1 mm upwards: atan(250/500).
    let text = "timestamp\tleft_x\tleft_y\n0.0015\t1000\t0\n1\t0\t-250\n";
    let r = read(text.as_bytes(), "f", &options).unwrap();
    let samples = r.gaze.as_ref().unwrap().samples();
    let (a, b) = (samples[0].value.unwrap(), samples[1].value.unwrap());
    assert_eq!(samples[0].t, Nanos(1_500));
    assert!(
        (a.azimuth_deg - 45.0).abs() < 1e-12 && a.elevation_deg == 0.0,
        "{a:?}"
    );
    assert!(
        (b.elevation_deg - 26.565_051_177_077_99).abs() < 1e-12,
        "y is down, elevation up: {b:?}"
    );
    assert!(noted(&r, "1000x500 px, 500x500 mm at 500 mm") && noted(&r, "left eye alone"));
}

#[test]
fn both_eyes_one_or_none() {
    let r = parse(
        "trial\ttimestamp\tright_x\tright_y\tleft_y\tleft_x\n1\t1.5\t20\t0\t0\t10\n\
         1\t2\t20\t0\tnan\tnan\n1\t3\tnan\tnan\t0\t10\n1\t4\tnan\t0\t0\tnan\n1\t4\t0\t0\t\t\n",
    )
    .unwrap();
    let samples = r.gaze.as_ref().unwrap().samples();
    let px = |i: usize| {
        let deg = samples[i].value.unwrap().azimuth_deg;
        deg.to_radians().tan() * 650.0 * 1920.0 / 528.0
    };
    assert!(
        (px(0) - 15.0).abs() < 1e-9 && (px(1) - 20.0).abs() < 1e-9 && (px(2) - 10.0).abs() < 1e-9
    );
    assert_eq!(samples[3].value, None, "half a position is none");
    assert!(noted(&r, "3 samples of one eye alone"));
    assert!(noted(&r, "1 sample with the time of the sample before"));
    assert!(noted(&r, "columns not used: trial"));
}

#[test]
fn what_is_wrong_is_named() {
    assert!(
        error("timestamp\tleft_x\tright_y\n1\t1\t1\n").contains("one coordinate of each eye alone")
    );
    assert!(error("timestamp\tleft_x\tleft_y\n1\t1e9\t1\n").contains("left_x = `1e9`"));
    assert!(
        error("timestamp\tleft_x\tleft_y\nnan\t1\t1\n")
            .contains("timestamp = `nan`: must be a time [ms]")
    );
    assert!(
        error("timestamp\tleft_x\tleft_y\n2\t1\t1\n1\t1\t1\n").contains("line 3: time goes back")
    );
    assert!(
        error("timestamp\tleft_x\tleft_y\n1\t1\n2\t1\t1\n").contains("line 2: 2 fields; want 3")
    );
    assert!(error("timestamp\tleft_x\tleft_y\tleft_x\n").contains("`left_x` stands twice"));
}

#[test]
fn provenance_as_given() {
    let delay = Nanos(12_000_000);
    let provenance = foveasim_models::Provenance::TrackerOutput { delay };
    let options = ReadOptions {
        provenance: Some(provenance),
        ..ReadOptions::default()
    };
    let text = "timestamp\tleft_x\tleft_y\n1\t2\t3\n";
    let r = read(text.as_bytes(), "f", &options).unwrap();
    assert_eq!(r.gaze.as_ref().unwrap().provenance(), provenance);
    assert!(!noted(&r, "taken as the truth") && noted(&r, "provenance as given: tracker:12"));
    let r = parse(text).unwrap();
    assert_eq!(
        r.gaze.as_ref().unwrap().provenance(),
        foveasim_models::Provenance::Truth
    );
    assert!(noted(&r, "taken as the truth"));
}
