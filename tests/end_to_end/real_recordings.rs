//! Recordings in other people's formats: small samples kept in the repository, and recordings of real
//! people where they are beside the checkout.

use crate::scratch::{Scratch, number, rows, shared};

fn run_on(file: &str, display: &str, tracker: &str) -> Option<(Scratch, String)> {
    let path = shared(file)?;
    let scratch = Scratch::new();
    let ran = scratch.run(&[
        "run",
        "--trace",
        &path.display().to_string(),
        "--display",
        display,
        "--tracker",
        tracker,
        "--images",
        "1",
        "--method",
        "layers:3",
        "--runs",
        "5000",
        "--out",
        "out",
    ]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let html = scratch.read("out/report.html");
    Some((scratch, html))
}

#[test]
fn a_headset_recording_of_gaze_and_head() {
    let Some((scratch, html)) = run_on(
        "head/eyenavgs/user110_playroom.csv",
        "quest-pro",
        "quest-pro",
    ) else {
        return;
    };
    let frames = rows(&scratch.read("out/replay.csv"));
    // 81.5 s at 72 Hz.
    assert!((5800..5900).contains(&frames.len()), "{}", frames.len());
    let known = frames.iter().filter(|f| !f["gaze_error_deg"].is_empty());
    let mut errors: Vec<f64> = known.map(|f| number(f, "gaze_error_deg")).collect();
    errors.sort_by(f64::total_cmp);
    assert!(
        errors.len() * 10 > frames.len() * 9,
        "gaze is always present: {}",
        errors.len()
    );
    assert!(
        (0.3..5.0).contains(&errors[errors.len() / 2]),
        "{}",
        errors[errors.len() / 2]
    );
    for said in ["made one", "scene units to a metre", "renormalised"] {
        assert!(html.contains(said), "the report mentions: {said}");
    }
}

/// Its GazeQ is the identity in every row: a head without gaze, which must be said and not made up.
#[test]
fn a_headset_recording_whose_gaze_is_lost() {
    let Some((scratch, html)) = run_on(
        "head/eyenavgs/user116_playroom.csv",
        "quest-pro",
        "quest-pro",
    ) else {
        return;
    };
    let frames = rows(&scratch.read("out/replay.csv"));
    // 103.7 s at 72 Hz.
    assert!((7300..7500).contains(&frames.len()), "{}", frames.len());
    assert!(
        frames
            .iter()
            .all(|f| f["gaze_state"] == "lost" && f["gaze_error_deg"].is_empty())
    );
    assert!(frames.iter().any(|f| number(f, "head_error_deg") > 0.0));
    assert!(html.contains("the gaze is lost in every sample"));
    let path = shared("head/eyenavgs/user116_playroom.csv").expect("it was there");
    scratch.ok(&[
        "run",
        "--trace",
        &path.display().to_string(),
        "--display",
        "quest-pro",
        "--tracker",
        "quest-pro",
        "--gaze-source",
        "synthetic",
        "--images",
        "0",
        "--runs",
        "1000",
        "--out",
        "made",
    ]);
    let frames = rows(&scratch.read("made/replay.csv"));
    assert!(frames.iter().any(|f| f["gaze_state"] == "tracked"));
    assert!(scratch.read("made/report.html").contains("synthetic"));
}

#[test]
fn a_screen_recording_at_1200_hz() {
    let Some((scratch, _)) = run_on(
        "gaze/etdq_tsv/Tobii_Spectrum_1200Hz.tsv",
        "lg-w2363d",
        "spectrum",
    ) else {
        return;
    };
    let frames = rows(&scratch.read("out/replay.csv"));
    // 21.5 s at 120 Hz.
    assert!((2550..2600).contains(&frames.len()), "{}", frames.len());
}

#[test]
fn a_screen_cannot_replay_a_head_alone() {
    let Some(path) = shared("head/eyenavgs/user104_berlin.csv") else {
        return;
    };
    let (scratch, path) = (Scratch::new(), path.display().to_string());
    let ran = scratch.run(&["replay", &path]);
    assert_eq!(ran.code, 2);
    assert!(ran.err.contains("lost in every sample"), "{}", ran.err);
    scratch.ok(&["replay", &path, "--gaze-mode", "fixed"]);
    scratch.ok(&["replay", &path, "--display", "quest-pro"]);
}

#[test]
fn every_format_replays() {
    let samples = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("traces/data");
    let scratch = Scratch::new();
    for (file, display, format) in [
        ("eyenavgs.csv", "quest-pro", "EyeNavGS"),
        ("screen_centred.tsv", "lg-w2363d", "centred"),
        ("tum.txt", "quest-3", "TUM"),
        ("foveasim.csv", "dk2", "foveasim"),
    ] {
        let path = samples.join(file).display().to_string();
        let info = scratch.ok(&["trace", "info", &path, "--format", "csv"]);
        assert!(
            info.to_lowercase().contains(&format.to_lowercase()),
            "{file}: {info}"
        );
        let frames = rows(&scratch.ok(&["replay", &path, "--display", display, "--format", "csv"]));
        assert!(
            frames.len() > 50,
            "{file}: {} frames of one second",
            frames.len()
        );
    }
}
