//! What is no recording, or a damaged one: one error that names the file, the line and the value.

use foveasim_traces::{
    Format, ReadOptions, ScreenSpec, TraceError, detect, read, read_path, require_gaze,
};

use crate::{error, parse};

#[test]
fn not_a_recording() {
    assert_eq!(
        error(""),
        "f: no samples (the file is empty); a recording has at least one row of data"
    );
    assert!(error("\r\n  \n").contains("the file is empty"));
    assert!(error("# a\n# b\n").contains("comments alone"));
    assert!(error("t_ns,gaze_azimuth_deg,gaze_elevation_deg\n").contains("a header alone"));
    assert!(error("\u{feff}Scene_Name,Scale\ntruck,0.76\n").starts_with(
        "f: not a recording in a known format (it begins `Scene_Name,Scale`); known: eyenavgs, screen-centred, eyelink,"
    ));
    assert!(error("1 2 3 4 5 6 7\n").contains("not a recording in a known format"));
    assert!(error("1 2 3 4 5 6 7 x\n").contains("not a recording in a known format"));
    let binary = read(&b"\x1f\x8b\x08\0\0"[..], "f.gz", &ReadOptions::default());
    assert!(matches!(binary, Err(TraceError::Io { .. })), "{binary:?}");
    assert_eq!(
        read(&b"\x00\x01"[..], "f", &ReadOptions::default())
            .unwrap_err()
            .to_string(),
        "f: line 1: not a text recording (it has a NUL byte)"
    );
    let latin1 = read(
        &b"timestamp\tleft_x\tleft_y\n1\t2\t\xb5\n"[..],
        "f",
        &ReadOptions::default(),
    );
    assert!(matches!(latin1, Err(TraceError::NotText { line: 2, .. })));
}

#[test]
fn paths() {
    let dir = tempfile::tempdir().unwrap();
    let missing = read_path(&dir.path().join("none.csv"), &ReadOptions::default()).unwrap_err();
    assert!(missing.to_string().contains("none.csv: "), "{missing}");
    let folder = read_path(dir.path(), &ReadOptions::default()).unwrap_err();
    assert!(folder.to_string().contains("is a folder"), "{folder}");
    let path = dir.path().join("gaze.wrong-extension");
    std::fs::write(&path, "timestamp\tleft_x\tleft_y\n1\t2\t3\n").unwrap();
    let recording = read_path(&path, &ReadOptions::default()).unwrap();
    assert_eq!(
        recording.format, "screen-centred",
        "the name of a file says nothing"
    );
    assert_eq!(recording.source, path.display().to_string());
}

#[test]
fn formats_are_found_by_content() {
    let of = |text: &str| detect(text.as_bytes(), "f").unwrap();
    assert_eq!(of("# x\n# y\n1.5 0 0 0 0 0 0 1\n"), Format::Tum);
    assert_eq!(of("# foveasim-trace 1\nt_ns\n"), Format::Foveasim);
    assert_eq!(of("gaze_azimuth_deg,T_NS\n"), Format::Foveasim);
    assert_eq!(
        of("tar_x\tright_y\tright_x\ttimestamp\n"),
        Format::ScreenCentred
    );
    assert_eq!(of("** CONVERTED FROM x.edf\n"), Format::EyeLink);
    assert_eq!(
        of("{\"type\":\"gaze\",\"timestamp\":0}\n"),
        Format::Glasses3
    );
    assert_eq!(
        of("#timestamp [ns],p_RS_R_x [m],q_RS_w []\n"),
        Format::Euroc
    );
    assert_eq!(
        of("Timestamp,GazeQX,QuaternionX,ViewIndex\n"),
        Format::EyeNavGs
    );
}

#[test]
fn a_file_that_was_cut_off() {
    let whole = "t_ns,gaze_azimuth_deg,gaze_elevation_deg\n100,1,2\n200,1,2\n";
    assert_eq!(
        parse(whole.trim_end())
            .unwrap()
            .gaze
            .unwrap()
            .samples()
            .len(),
        2
    );
    for cut in ["300", "300,1", "30,1,2"] {
        let text = error(&format!("{whole}{cut}"));
        assert!(text.starts_with("f: line 4: truncated"), "{cut}: {text}");
    }
    // With its line feed the row is complete, and wrong.
    assert_eq!(
        error(&format!("{whole}300\n")),
        "f: line 4: 1 fields; want 3"
    );
    let text = error(&format!("{whole}30,1,2\n"));
    assert_eq!(
        text,
        "f: line 4: time goes back from 0.0002 ms to 0.00003 ms; rows must be in order of time"
    );
}

#[test]
fn a_last_line_without_an_end_is_told() {
    let whole = "t_ns,gaze_azimuth_deg,gaze_elevation_deg\n100,1,2\n200,1,2\n";
    let note = "the last line has no end: it may have been cut".to_owned();
    assert!(!parse(whole).unwrap().notes.contains(&note));
    assert!(!parse(&format!("{whole}\n")).unwrap().notes.contains(&note));
    // Digits of the last field are missing, and nothing else says so.
    let cut = parse(&format!("{whole}300,1,2.34")).unwrap();
    assert!(cut.notes.contains(&note), "{:?}", cut.notes);
    // A field that may be empty is not where the file ends in it.
    let targets = "timestamp\tleft_x\tleft_y\tright_x\tright_y\n1\t2\t3\t4\t5\n";
    parse(&format!("{targets}2\t2\t3\t4\t\n")).unwrap();
    let text = error(&format!("{targets}2\t2\t3\t4\t"));
    assert!(text.starts_with("f: line 3: truncated"), "{text}");
}

#[test]
fn options_out_of_range_are_named() {
    let with = |options: ReadOptions| {
        read(&b"timestamp\tleft_x\tleft_y\n1\t2\t3\n"[..], "f", &options)
            .unwrap_err()
            .to_string()
    };
    let screen = |screen| {
        with(ReadOptions {
            screen,
            ..ReadOptions::default()
        })
    };
    assert!(
        screen(ScreenSpec {
            distance_mm: Some(f64::NAN),
            ..ScreenSpec::default()
        })
        .starts_with("distance_mm = NaN")
    );
    assert!(
        screen(ScreenSpec {
            size_px: Some([0.0, 1.0]),
            ..ScreenSpec::default()
        })
        .starts_with("screen_px = 0")
    );
    assert!(
        screen(ScreenSpec {
            size_mm: Some([1.0, -1.0]),
            ..ScreenSpec::default()
        })
        .starts_with("screen_mm = -1")
    );
    assert!(
        with(ReadOptions {
            scale: Some(0.0),
            ..ReadOptions::default()
        })
        .starts_with("scale = 0")
    );
    assert!(
        with(ReadOptions {
            segment: Some(0),
            ..ReadOptions::default()
        })
        .starts_with("segment = 0")
    );
    let two = with(ReadOptions {
        segment: Some(2),
        ..ReadOptions::default()
    });
    assert_eq!(two, "f: segment 2: must be 1 to 1");
    let scaled = with(ReadOptions {
        scale: Some(2.0),
        ..ReadOptions::default()
    });
    assert!(
        scaled.starts_with("scale = 2: must be absent: f is "),
        "{scaled}"
    );
}

#[test]
fn gaze_that_is_never_there() {
    let lost = parse("timestamp\tleft_x\tleft_y\n1\tnan\tnan\n2\tnan\tnan\n").unwrap();
    let text = require_gaze(&lost).unwrap_err().to_string();
    assert_eq!(
        text,
        "f: no valid gaze sample (all 2 samples are lost); this needs a recording with gaze"
    );
    let none = parse("0 0 0 0 0 0 0 1\n").unwrap();
    assert!(
        require_gaze(&none)
            .unwrap_err()
            .to_string()
            .contains("(the recording has none)")
    );
    let last = parse("timestamp\tleft_x\tleft_y\n1\tnan\tnan\n2\t0\t0\n").unwrap();
    assert!(require_gaze(&last).is_ok());
}
