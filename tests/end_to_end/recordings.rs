//! `trace events` and `trace predict` as their users run them.

use crate::scratch::{Scratch, number, rows, shared};

#[test]
fn events_of_a_synthetic_recording() {
    let s = Scratch::new();
    let to = [
        "--to",
        "gaze.csv",
        "--blinks",
        "20",
        "--duration",
        "20s",
        "--gaze-rate",
        "500",
    ];
    s.ok(&[&["trace", "synth"][..], &to].concat());
    let said = s.ok(&[
        "trace", "events", "gaze.csv", "--out", "events", "--format", "csv",
    ]);
    let rows_of = rows(&said);
    let value = |part: &str, quantity: &str| {
        let row = rows_of
            .iter()
            .find(|r| r["part"] == part && r["quantity"] == quantity);
        number(row.unwrap_or_else(|| panic!("{part} {quantity}")), "value")
    };
    // Fixations of a quarter of a second to a third, and saccades between them.
    assert!((40.0..90.0).contains(&value("saccade", "count")), "{said}");
    assert!(value("blink", "count") >= 1.0, "{said}");
    assert!(
        (1.0..4.0).contains(&value("main sequence", "duration_ms_per_deg")),
        "{said}"
    );
    let events = rows(&s.read("events/events.csv"));
    assert!(
        events
            .windows(2)
            .all(|w| number(&w[0], "end_s") <= number(&w[1], "start_s"))
    );
    for chart in [
        "gaze_events",
        "main_sequence_peak",
        "main_sequence_duration",
    ] {
        assert!(s.read(&format!("events/{chart}.svg")).contains("<svg"));
    }
    let again = s.ok(&[
        "trace",
        "events",
        "gaze.csv",
        "--format",
        "csv",
        "--threads",
        "1",
    ]);
    assert_eq!(again, said);
    s.ok(&["trace", "events", "gaze.csv", "--method", "dispersion"]);
}

#[test]
fn prediction_of_a_synthetic_head() {
    let s = Scratch::new();
    s.ok(&["trace", "synth", "--to", "head.csv", "--duration", "10s"]);
    let words = [
        "trace",
        "predict",
        "head.csv",
        "--horizon-ms",
        "20",
        "--format",
        "csv",
        "--out",
        "out",
    ];
    let table = rows(&s.ok(&words));
    let names: Vec<_> = table.iter().map(|r| r["predictor"].as_str()).collect();
    assert_eq!(
        names,
        [
            "constant",
            "linear",
            "angular-velocity",
            "acceleration",
            "kalman",
            "double-exponential"
        ]
    );
    // Smooth motion is foreseen far better than not at all.
    assert!(
        number(&table[2], "rotation_over_constant") < 0.2,
        "{table:?}"
    );
    assert!(s.read("out/01_head_rotation.svg").contains("horizon [ms]"));
    let words = [
        "trace",
        "scanlines",
        "head.csv",
        "--refresh",
        "72",
        "--format",
        "csv",
        "--out",
        "rows",
    ];
    let table = rows(&s.ok(&words));
    let last = |image: &str| {
        let row = table
            .iter()
            .find(|r| r["image"] == image && r["row_share"] == "1");
        number(row.unwrap_or_else(|| panic!("{image}")), "rotation_rms_deg")
    };
    assert!(
        last("plain") > last("warped") && last("warped") > last("rolling"),
        "{table:?}"
    );
    assert!(
        s.read("rows/01_head_translation.svg")
            .contains("share of the scan-out")
    );
}

#[test]
fn what_cannot_be_done_is_said_in_one_line() {
    let s = Scratch::new();
    s.ok(&["trace", "synth", "--to", "t.csv", "--duration", "1s"]);
    s.write("head.txt", "0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n");
    s.write(
        "gaze.tsv",
        "timestamp\tleft_x\tleft_y\n0\t0\t0\n1\t0\t0\n2\t0\t0\n",
    );
    for (words, part) in [
        (
            &["trace", "events", "t.csv", "--method", "velocty"][..],
            "did you mean `velocity`",
        ),
        (
            &["trace", "events", "t.csv", "--half-window-ms", "nan"],
            "half_window_ms = NaN",
        ),
        (
            &["trace", "events", "t.csv", "--dispersion-deg", "2"],
            "--dispersion-deg = 2: must be absent",
        ),
        (
            &[
                "trace",
                "events",
                "t.csv",
                "--method",
                "dispersion",
                "--floor-deg-per-s",
                "50",
            ],
            "--floor-deg-per-s = 50: must be absent",
        ),
        (&["trace", "events", "head.txt"], "no valid gaze sample"),
        (&["trace", "predict", "gaze.tsv"], "no valid head pose"),
        (
            &["trace", "predict", "t.csv", "--predictor", "kalmann"],
            "did you mean `kalman`",
        ),
        (
            &["trace", "predict", "t.csv", "--horizon-ms", "-5"],
            "--horizon-ms -5",
        ),
        (
            &["trace", "scanlines", "t.csv", "--refresh", "0"],
            "1 to 1000",
        ),
        (
            &["trace", "predict", "t.csv", "--horizon-ms", "0..1000:0.1"],
            "at most 1000",
        ),
    ] {
        let ran = s.run(words);
        assert_eq!(ran.code, 2, "{words:?}: {}", ran.err);
        assert!(
            ran.err.contains(part) && ran.err.trim_end().lines().count() == 1,
            "{words:?}: {}",
            ran.err
        );
    }
}

#[test]
fn eyelink_reads_and_agrees() {
    let Some(path) = shared("gaze/eyelink_asc/both_eyes.asc") else {
        return;
    };
    let (s, path) = (Scratch::new(), path.display().to_string());
    let info = s.ok(&["trace", "info", &path, "--format", "csv"]);
    assert!(
        info.contains(",gaze,samples,70328") && info.contains(",gaze,rate_hz,500"),
        "{info}"
    );
    let table = rows(&s.ok(&["trace", "events", &path, "--format", "csv"]));
    let f1: Vec<_> = table
        .iter()
        .filter(|r| r["quantity"] == "f1")
        .map(|r| number(r, "value"))
        .collect();
    assert!(f1.len() == 6 && f1.iter().all(|f| *f > 0.94), "{f1:?}");
}

#[test]
fn a_replay_predicts_the_head_by_any_name() {
    let s = Scratch::new();
    s.ok(&["trace", "synth", "--to", "t.csv", "--duration", "4s"]);
    let replay = |more: &[&str]| {
        let display = ["--display", "quest-pro", "--tracker", "quest-pro"];
        let words = [&["replay", "t.csv", "--format", "csv"], &display[..], more].concat();
        s.ok(&words)
    };
    let rms = |csv: &str| {
        let errors: Vec<f64> = rows(csv)
            .iter()
            .skip(8)
            .filter(|r| !r["head_error_deg"].is_empty())
            .map(|r| number(r, "head_error_deg"))
            .collect();
        assert!(errors.len() > 200);
        (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
    };
    let named = |name| replay(&["--predict", name]);
    let constant = rms(&named("constant"));
    let mut seen = vec![constant];
    for name in [
        "linear",
        "components",
        "acceleration",
        "kalman",
        "double-exponential",
    ] {
        let error = rms(&named(name));
        assert!(error < 0.5 * constant, "{name}: {error}, held {constant}");
        assert!(seen.iter().all(|e| *e != error), "{name}: as another's");
        seen.push(error);
    }
    let linear = named("linear");
    assert_eq!(linear, named("angular-velocity"));
    assert_eq!(linear, replay(&[]));

    // An older head is predicted from further away; switched off, the delay is none.
    let late = ["--predict", "constant", "--head-delay-ms", "20"];
    assert!(rms(&replay(&late)) > 1.2 * constant);
    let off = replay(&[&late[..], &["--off", "head-delay"]].concat());
    assert_eq!(off, named("constant"));
    let slow = replay(&["--predict", "constant", "--head-hz", "40"]);
    assert!(rms(&slow) > 1.1 * constant);

    s.write("s.toml", "predict = \"kalmann\"\n");
    for words in [
        &["replay", "t.csv", "--predict", "kalmann"][..],
        &["run", "--predict", "kalmann", "--out", "o"],
        &["run", "s.toml", "--out", "o"],
    ] {
        let ran = s.run(words);
        assert_eq!(ran.code, 2, "{words:?}: {}", ran.err);
        for part in ["kalmann", "`kalman`", "constant, linear, components"] {
            assert!(ran.err.contains(part), "{words:?}: {}", ran.err);
        }
        assert_eq!(ran.err.trim_end().lines().count(), 1, "{}", ran.err);
    }
}
