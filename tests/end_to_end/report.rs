//! The main job, on embedded defaults and from a scenario file.

use crate::scratch::{Scratch, number, rows};

/// Small enough for a test.
const QUICK: [&str; 10] = [
    "--runs",
    "2000",
    "--images",
    "1",
    "--method",
    "layers:3",
    "--fov",
    "60,100",
    "--ppd-centre",
    "20,40",
];

fn with<'a>(words: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    words.iter().chain(more).copied().collect()
}

#[test]
fn the_embedded_default_makes_a_report() {
    let scratch = Scratch::new();
    let ran = scratch.run(&with(&["run"], &QUICK));
    assert_eq!(ran.code, 0, "{}", ran.err);
    assert!(
        ran.out.contains("out/report.html"),
        "says where the report is: {}",
        ran.out
    );
    let names = scratch.names("out");
    for name in [
        "latency.csv",
        "map.csv",
        "moment-1-error.png",
        "moment-1-frame.png",
        "moment-1-layers.png",
        "moment-1-overview.png",
        "moment-1-reference.png",
        "plan.csv",
        "quality.csv",
        "replay.csv",
        "report.html",
        "summary.csv",
        "timeline.json",
        "work.csv",
    ] {
        assert!(names.iter().any(|n| n == name), "{name} in {names:?}");
    }
    assert!(
        names.iter().all(|n| !n.starts_with('.')),
        "nothing temporary is left: {names:?}"
    );
    let html = scratch.read("out/report.html");
    let without_namespace = html.replace("http://www.w3.org/", "");
    for outside in ["http://", "https://", "<script", "src=\"/", "url("] {
        assert!(
            !without_namespace.contains(outside),
            "the page needs nothing else: {outside}"
        );
    }
    serde_json::from_str::<serde_json::Value>(&scratch.read("out/timeline.json")).expect("JSON");
    let summary = rows(&scratch.read("out/summary.csv"));
    let full = summary
        .iter()
        .find(|r| r["method"] == "full")
        .expect("full is always there");
    assert_eq!(number(full, "sample_ratio"), 1.0);
    assert!(summary.iter().any(|r| number(r, "sample_ratio") > 5.0));
}

#[test]
fn a_scenario_file_says_what_flags_say() {
    let scratch = Scratch::new();
    scratch.ok(&["init"]);
    scratch.ok(&with(
        &[
            "run",
            "--out",
            "flags",
            "--sync",
            "tearing",
            "--margin-deg",
            "1",
        ],
        &QUICK,
    ));
    let text = scratch.read("scenario.toml");
    let text = text.replace("sync = \"vsync\"", "sync = \"tearing\"");
    let text = text.replace("margin_deg = 0.0", "margin_deg = 1.0");
    scratch.write("other.toml", text);
    scratch.ok(&with(&["run", "other.toml", "--out", "file"], &QUICK));
    for name in [
        "summary.csv",
        "latency.csv",
        "replay.csv",
        "map.csv",
        "quality.csv",
    ] {
        let [a, b] = ["flags", "file"].map(|f| scratch.read(&format!("{f}/{name}")));
        assert_eq!(a, b, "{name}");
    }
}

#[test]
fn the_cost_profile_can_set_the_pace() {
    let scratch = Scratch::new();
    scratch.ok(&with(
        &["run", "--render-time", "cost", "--out", "cost"],
        &QUICK,
    ));
    scratch.ok(&with(&["run", "--out", "refresh"], &QUICK));
    let render = |folder: &str| {
        let latency = rows(&scratch.read(&format!("{folder}/latency.csv")));
        number(
            latency
                .iter()
                .find(|r| r["stage"] == "render")
                .expect("render"),
            "mean_ms",
        )
    };
    assert!(render("cost") < render("refresh"));
}

#[test]
fn a_shorter_run_leaves_no_pictures_of_an_earlier_one() {
    let scratch = Scratch::new();
    scratch.write("mine.txt", "");
    scratch.ok(&with(&["run", "--out", "out"], &QUICK));
    std::fs::rename(
        scratch.path("mine.txt"),
        scratch.path("out/moment-9-mine.png"),
    )
    .unwrap();
    let more: Vec<&str> = QUICK
        .map(|word| if word == "1" { "0" } else { word })
        .to_vec();
    scratch.ok(&[&["run", "--out", "out"][..], &more].concat());
    let left: Vec<String> = scratch
        .names("out")
        .into_iter()
        .filter(|n| n.starts_with("moment"))
        .collect();
    assert_eq!(left, ["moment-9-mine.png"], "only what is not ours stays");
}

#[test]
fn numbers_in_a_scenario_may_be_numbers() {
    let scratch = Scratch::new();
    let keys = "slope = 0.0275\nfov = 60\nppd_centre = 20\nrender_time = 8\n";
    scratch.write(
        "s.toml",
        format!("{keys}images = 0\nruns = 1000\nmethod = 'layers:3'\n"),
    );
    scratch.ok(&["run", "s.toml"]);
    assert!(scratch.read("out/map.csv").lines().count() == 2);
}

#[test]
fn init_does_not_replace_a_file_unasked() {
    let scratch = Scratch::new();
    scratch.write("scenario.toml", "mine");
    let ran = scratch.run(&["init"]);
    assert_eq!(ran.code, 2);
    assert_eq!(scratch.read("scenario.toml"), "mine");
    scratch.ok(&["init", "--force"]);
    assert!(
        scratch
            .read("scenario.toml")
            .contains("display = \"lg-w2363d\"")
    );
    scratch.ok(&[
        "init",
        "--kind",
        "display",
        "--from",
        "quest-pro",
        "mine.toml",
    ]);
    scratch.ok(&["plan", "--display", "mine.toml"]);
}

#[test]
fn evidence_is_shown_and_its_absence_is_said() {
    let scratch = Scratch::new();
    std::fs::create_dir(scratch.path("found")).unwrap();
    let run = |out: &str, more: &[&str]| {
        let words = [&["run", "--images", "0", "--out", out][..], more].concat();
        scratch.run(&with(&words, &QUICK[..2]))
    };
    let empty = run("e", &["--evidence", "found"]);
    assert_eq!(empty.code, 2);
    assert!(
        empty.err.contains("want one of verify.svg"),
        "{}",
        empty.err
    );
    assert_eq!(run("e", &["--evidence", "nowhere"]).code, 2);
    scratch.write(
        "found/verify-summary.csv",
        "quantity,value\nmedian error,0.04\n",
    );
    assert_eq!(run("e", &["--evidence", "found"]).code, 0);
    let html = scratch.read("e/report.html");
    assert!(html.contains("median error") && html.contains("No front of time against error"));
    scratch.write("found/verify.svg", "<svg onload=\"x()\"></svg>");
    let foreign = run("e", &["--evidence", "found"]);
    assert_eq!(foreign.code, 2);
    assert!(
        foreign
            .err
            .contains("verify.svg: not a chart that foveasim wrote")
    );
    // Growth is of every method, at the display's own sharpness.
    let growth = rows(&scratch.read("e/growth.csv"));
    assert_eq!(growth.len(), 4 * 25);
    let at = |fov: &str, method: &str| {
        let row = growth
            .iter()
            .find(|r| r["fov_h_deg"] == fov && r["method"] == method);
        number(row.expect("a row"), "sample_ratio")
    };
    assert!(at("90", "layers:3") > at("45", "layers:3") && at("90", "full") == 1.0);
}
