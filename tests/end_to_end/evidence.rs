//! Predicted times beside drawn ones, and time against error.

use crate::scratch::Scratch;

const SMALL: [&str; 11] = [
    "pareto",
    "--scene",
    "hairball:40,room:20",
    "--size",
    "160x90",
    "--frames",
    "2",
    "--supersample",
    "2",
    "--method=layers:2,vrs,kfr:2:4",
    "--no-time",
];

fn with<'a>(more: &[&'a str]) -> Vec<&'a str> {
    SMALL.iter().copied().chain(more.iter().copied()).collect()
}

#[test]
fn time_against_error_is_the_same_again() {
    let scratch = Scratch::new();
    let table = scratch.ok(&with(&[
        "--format",
        "csv",
        "--threads",
        "1",
        "--out",
        "one",
    ]));
    assert_eq!(
        table,
        scratch.ok(&with(&["--format", "csv", "--threads", "2"]))
    );
    // Two scenes and both together, four methods.
    assert_eq!(table.lines().count(), 1 + 3 * 4);
    assert!(table.contains("all,full,") && table.contains("cost profile"));
    assert_eq!(scratch.read("one/pareto.csv"), table);
    for name in ["one/pareto-rings.csv", "one/pareto.json", "one/pareto.svg"] {
        assert!(!scratch.read(name).is_empty(), "{name}");
    }
    let answer = scratch.ok(&with(&["--error", "1"]));
    assert!(
        answer.contains("Within dssim 1,") && answer.contains("takes least"),
        "{answer}"
    );
}

#[test]
fn frames_leave_and_scores_come_back() {
    let scratch = Scratch::new();
    scratch.ok(&with(&["--export", "frames"]));
    for name in [
        "index.csv",
        "score.py",
        "display_models.json",
        "hairball-40/gaze.csv",
    ] {
        assert!(
            !scratch.read(&format!("frames/{name}")).is_empty(),
            "{name}"
        );
    }
    for name in ["room-20/reference/0001.png", "room-20/kfr-2-4/0000.png"] {
        assert!(scratch.path(&format!("frames/{name}")).exists(), "{name}");
    }
    let rows = "hairball:40,vrs,9.5\nroom:20,vrs,9.0\nhairball:40,full,9.9\nroom:20,full,9.9\n";
    scratch.write("scores.csv", format!("clip,method,jod\n{rows}"));
    let import = [
        "--import",
        "scores.csv",
        "--measure",
        "jod",
        "--error",
        "0.2",
    ];
    let answer = scratch.ok(&with(&import));
    assert!(
        answer.contains("Within jod 0.2, full takes least"),
        "{answer}"
    );
    scratch.write("bad.csv", "clip,method,jod\nroom:20,vrs,twelve\n");
    for (more, expect) in [
        (["--import", "bad.csv"], "bad.csv:2: jod = `twelve`"),
        (["--measure", "jod"], "needs --import"),
        (["--measure", "ssmi"], "unknown measure of error"),
        (["--scene", "study@6000"], "a number from 0 to 5376"),
        (["--scene", "volume:shells"], "not volumes"),
        (["--trace", "none.csv"], "none.csv"),
        (["--fov", "180"], "below 180 degrees"),
        (["--error", "nan"], "--error"),
    ] {
        // A later flag of the same name counts.
        let words: Vec<&str> = match more[0] {
            "--scene" => ["pareto", "--no-time"].into_iter().chain(more).collect(),
            _ => with(&more),
        };
        let ran = scratch.run(&words);
        assert_eq!(ran.code, 2, "{words:?}: {}", ran.err);
        assert!(ran.err.contains(expect), "{words:?}: {}", ran.err);
    }
}

#[test]
fn cells_of_a_plan_are_drawn() {
    let scratch = Scratch::new();
    let grid = [
        "plan",
        "--fov",
        "50,90",
        "--pixels",
        "96x54,160x90,192x108",
        "--method=full,layers:2,layers:3,vrs,fdm",
        "--scene",
        "hairball:20,hairball:60,room:10",
        "--rounds",
        "2",
    ];
    let asked = |more: &[&'static str]| -> Vec<&str> {
        grid.iter().copied().chain(more.iter().copied()).collect()
    };
    let table = scratch.ok(&asked(&["--verify", "40", "--format", "csv", "--out", "v"]));
    assert!(table.lines().count() > 40);
    assert!(
        table.contains(",size,") && table.contains(",scene,"),
        "{table}"
    );
    assert_eq!(scratch.read("v/verify.csv"), table);
    let summary = scratch.read("v/verify-summary.csv");
    assert!(
        summary.contains("held out,") && summary.contains("fitted,"),
        "{summary}"
    );
    assert!(scratch.read("v/verify.svg").contains("as measured"));
    for (more, expect) in [
        (vec!["--verify", "2"], "cells to be drawn = 2"),
        (vec!["--verify", "500", "--spread"], "cannot be used with"),
        (vec![], "--verify"),
    ] {
        let ran = scratch.run(&asked(&more));
        assert_eq!(ran.code, 2, "{more:?}: {}", ran.err);
        assert!(ran.err.contains(expect), "{more:?}: {}", ran.err);
    }
}
