//! Our own format: its rules, and that what is written reads back to the bit.

use foveasim_models::{GazeDirection, Nanos, Pose, Provenance, Recording, Sample, Series};
use foveasim_traces::{ReadOptions, SynthSpec, read, rebase, slice, synth, write};

use crate::{error, noted, parse};

fn text(recording: &Recording) -> String {
    let mut bytes = Vec::new();
    write(recording, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

#[test]
fn every_kind_of_field() {
    let r = parse(
        "# foveasim-trace 1\n# gaze_provenance: tracker_output delay_ns=12000000\n# note: hello\n\
         t_ns,gaze_azimuth_deg,gaze_elevation_deg,position_x_m,position_y_m,position_z_m,\
         orientation_x,orientation_y,orientation_z,orientation_w\n\
         -5,1.5e1,-3,0,1.6,0,0,0,0,1\n0,,,n/a,n/a,n/a,n/a,n/a,n/a,n/a\n5,nan,NaN,,,,,,,\n",
    )
    .unwrap();
    let gaze = r.gaze.as_ref().unwrap();
    let ms12 = Nanos(12_000_000);
    assert_eq!(gaze.provenance(), Provenance::TrackerOutput { delay: ms12 });
    let values: Vec<_> = gaze.samples().iter().map(|s| (s.t.0, s.value)).collect();
    let first = Some(GazeDirection::new(15.0, -3.0));
    assert_eq!(values, [(-5, first), (0, None), (5, None)]);
    let poses = r.pose.as_ref().unwrap();
    assert_eq!(poses.provenance(), Provenance::Truth);
    assert_eq!(poses.samples().len(), 2);
    assert_eq!(poses.samples()[1].value, None);
    assert!(noted(&r, "hello"));
}

#[test]
fn semicolons_decimal_commas_crlf_and_a_byte_order_mark() {
    let r = parse("\u{feff}gaze_elevation_deg;t_ns;gaze_azimuth_deg\r\n0,5;1;2,25\r\n\r\n;2; \r\n")
        .unwrap();
    let samples = r.gaze.as_ref().unwrap().samples();
    assert_eq!(samples[0].value, Some(GazeDirection::new(2.25, 0.5)));
    assert_eq!(samples[1].value, None);
    assert!(noted(&r, "taken as the truth"));
}

#[test]
fn what_is_wrong_is_named() {
    let gaze = "t_ns,gaze_azimuth_deg,gaze_elevation_deg\n";
    let row = |row: &str| error(&format!("{gaze}{row}\n"));
    assert_eq!(
        row("1,inf,0"),
        "f: line 2: gaze_azimuth_deg = `inf`: must be a number from -180 to 180"
    );
    assert!(row("1,0,91").contains("gaze_elevation_deg = `91`: must be a number from -90 to 90"));
    assert!(row("1,0,").contains("gaze_elevation_deg = ``: must be a number like the others"));
    assert!(row("x,0,0").contains("t_ns = `x`: must be a time [ns]"));
    assert!(row("9300000000000000000,0,0").contains("must be a time [ns]"));
    assert!(row("1,0,0,0").contains("4 fields; want 3"));
    assert!(
        error("t_ns,gaze_azimuth_deg\n1,2\n")
            .contains("want all of gaze_azimuth_deg, gaze_elevation_deg")
    );
    assert!(error("t_ns,gaze_azimut_deg\n1,2\n").contains("did you mean `gaze_azimuth_deg`?"));
    assert!(error("t_ns\n1\n").contains("no gaze columns and no pose columns"));
    assert!(error("# foveasim-trace 1\ngaze_azimuth_deg\n").contains("no column t_ns"));
    assert!(error(&format!("# foveasim-trace 2\n{gaze}1,2,3\n")).contains("line 1: version `2`"));
    let provenance = error(&format!("# provenance: tracker\n{gaze}1,2,3\n"));
    assert!(
        provenance.contains("line 1: provenance `tracker`: want `truth` or"),
        "{provenance}"
    );
    let pose = "t_ns,position_x_m,position_y_m,position_z_m,orientation_x,orientation_y,orientation_z,orientation_w\n";
    assert!(error(&format!("{pose}1,0,0,0,0,0,0,0.5\n")).contains("a quaternion of length 1"));
    assert!(error(&format!("{pose}1,0,0,1e7,0,0,0,1\n")).contains("position_z_m = `1e7`"));
}

#[test]
fn written_and_read_again_it_is_the_same() {
    let mut r = synth(&SynthSpec {
        duration: Nanos(2_000_000_000),
        ..SynthSpec::default()
    })
    .unwrap();
    let delay = Nanos(7);
    r.pose = r
        .pose
        .map(|p| p.with_provenance(Provenance::TrackerOutput { delay }));
    let back = parse(&text(&r)).unwrap();
    assert_eq!((&back.gaze, &back.pose), (&r.gaze, &r.pose));
    assert_eq!(
        text(&back),
        text(&parse(&text(&back)).unwrap()),
        "a second trip changes nothing"
    );
}

const BOTH: &str = "t_ns,gaze_azimuth_deg,gaze_elevation_deg,position_x_m,position_y_m,position_z_m,\
    orientation_x,orientation_y,orientation_z,orientation_w\n0,1,2,0,0,0,0,0,0,1\n";

#[test]
fn an_assumption_is_not_written_as_a_statement() {
    for (stated, gaze, pose) in [
        ("", true, true),
        ("# gaze_provenance: truth\n", false, true),
        ("# pose_provenance: truth\n", true, false),
        ("# provenance: truth\n", false, false),
    ] {
        let first = parse(&format!("{stated}{BOTH}")).unwrap();
        let written = text(&first);
        for r in [&first, &parse(&written).unwrap()] {
            assert_eq!(noted(r, "gaze taken as the truth"), gaze, "{stated}");
            assert_eq!(noted(r, "head pose taken as the truth"), pose, "{stated}");
            assert_eq!(r.notes, first.notes);
        }
        assert!(!written.contains("taken as the truth"), "{written}");
        assert_ne!(written.contains("# gaze_provenance: truth"), gaze);
        assert_ne!(written.contains("# pose_provenance: truth"), pose);
    }
}

#[test]
fn a_provenance_given_is_that_of_gaze() {
    let delay = Nanos(12_000_000);
    let given = Provenance::TrackerOutput { delay };
    let options = ReadOptions {
        provenance: Some(given),
        ..ReadOptions::default()
    };
    let said = Provenance::TrackerOutput { delay: Nanos(7) };
    for (stated, pose_is) in [
        ("", Provenance::Truth),
        ("# provenance: tracker_output delay_ns=7\n", said),
    ] {
        let r = read(format!("{stated}{BOTH}").as_bytes(), "f", &options).unwrap();
        assert_eq!(r.gaze.as_ref().unwrap().provenance(), given);
        assert_eq!(r.pose.as_ref().unwrap().provenance(), pose_is);
        assert!(noted(&r, "gaze provenance as given: tracker:12"));
        assert!(!noted(&r, "gaze taken as the truth"));
        assert_eq!(noted(&r, "head pose taken as the truth"), stated.is_empty());
        let written = text(&r);
        assert!(written.contains("# gaze_provenance: tracker_output delay_ns=12000000\n"));
        assert_eq!(
            written.contains("# pose_provenance"),
            !stated.is_empty(),
            "{written}"
        );
    }
    let head_alone = read("1 0 0 0 0 0 0 1\n".as_bytes(), "f", &options).unwrap();
    assert_eq!(
        head_alone.pose.as_ref().unwrap().provenance(),
        Provenance::Truth
    );
    assert!(noted(&head_alone, "there is none here to apply it to"));
}

#[test]
fn equal_times_and_series_of_their_own_keep_their_order() {
    let g = |t, az| Sample {
        t: Nanos(t),
        value: Some(GazeDirection::new(az, 0.0)),
    };
    let p = |t| Sample {
        t: Nanos(t),
        value: Some(Pose::IDENTITY),
    };
    let r = Recording {
        gaze: Series::new(vec![g(1, 1.0), g(1, 2.0), g(4, -0.0)], Provenance::Truth).ok(),
        pose: Series::new(vec![p(0), p(1), p(3)], Provenance::Truth).ok(),
        notes: vec!["line\nbreak".into()],
        ..Recording::default()
    };
    let back = parse(&text(&r)).unwrap();
    assert_eq!((&back.gaze, &back.pose), (&r.gaze, &r.pose));
    assert_eq!(back.notes, ["line break"]);
}

#[test]
fn slices_and_rebasing() {
    let r =
        parse("t_ns,gaze_azimuth_deg,gaze_elevation_deg\n1000,0,0\n2000,1,0\n3000,2,0\n").unwrap();
    let part = slice(&r, Nanos(500), Nanos(2000)).unwrap();
    let times = |r: &Recording| {
        r.gaze
            .as_ref()
            .unwrap()
            .samples()
            .iter()
            .map(|s| s.t.0)
            .collect::<Vec<_>>()
    };
    assert_eq!(times(&part), [2000], "the end is not included");
    assert_eq!(times(&rebase(&part)), [0]);
    assert!(
        slice(&r, Nanos(5000), Nanos(6000))
            .unwrap_err()
            .to_string()
            .contains("slice")
    );
    assert_eq!(
        times(&slice(&r, Nanos(0), Nanos::MAX).unwrap()),
        [1000, 2000, 3000]
    );
}
