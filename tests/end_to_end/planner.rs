//! Long sweeps in parts, inverse questions, and cost profiles from measured frames.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::scratch::Scratch;

/// A few cells of every kind.
const GRID: [&str; 12] = [
    "plan",
    "--fov",
    "40..100:20",
    "--ppd",
    "centre:8,centre:12",
    "--refresh",
    "72,90",
    "--eyes",
    "1,2",
    "--margin",
    "0,1",
    "--method=full,layers:3,vrs,quad:auto,kfr:2:4",
];

fn with<'a>(more: &[&'a str]) -> Vec<&'a str> {
    GRID.iter().copied().chain(more.iter().copied()).collect()
}

#[test]
fn shards_and_what_was_stopped_make_the_same_table() {
    let scratch = Scratch::new();
    scratch.ok(&with(&["--out", "whole"]));
    let whole = scratch.read("whole/plan.csv");
    assert_eq!(whole.lines().count(), 1 + 4 * 2 * 2 * 2 * 2 * 5);
    // Four parts, put together in any order.
    for part in ["1/4", "2/4", "3/4", "4/4"] {
        scratch.ok(&with(&[
            "--shard",
            part,
            "--out",
            &format!("part{}", &part[..1]),
        ]));
    }
    scratch.ok(&[
        "plan", "merge", "part3", "part1", "part4", "part2", "--out", "merged",
    ]);
    assert_eq!(scratch.read("merged/plan.csv"), whole);
    assert_eq!(
        scratch.ok(&["plan", "merge", "part1", "part2", "part3", "part4"]),
        whole
    );
    // A log that was cut off anywhere goes on to the same table.
    scratch.ok(&with(&["--shard", "1/1", "--out", "log"]));
    let log = scratch.read("log/plan.rows");
    for (i, cut) in [
        0,
        40,
        300,
        log.len() / 3,
        log.len() / 2 + 7,
        log.len() - 1,
        log.len(),
    ]
    .into_iter()
    .enumerate()
    {
        let folder = format!("resumed{i}");
        std::fs::create_dir(scratch.path(&folder)).unwrap();
        scratch.write(&format!("{folder}/plan.rows"), &log[..cut]);
        scratch.ok(&with(&["--resume", "--out", &folder]));
        assert_eq!(
            scratch.read(&format!("{folder}/plan.csv")),
            whole,
            "cut at {cut}"
        );
        assert!(!scratch.path(&format!("{folder}/plan.rows")).exists());
    }
}

#[test]
fn a_killed_sweep_goes_on() {
    let scratch = Scratch::new();
    // Long enough to be killed in the middle; if it is not, there is nothing to go on with, and it starts anew.
    let words = [
        "plan",
        "--fov",
        "30..110:4",
        "--ppd",
        "centre:10,centre:14",
        "--margin",
        "0..3:0.25",
        "--method",
        "layers:3,vrs",
        "--resume",
        "--out",
    ];
    let mut child = Command::new(env!("CARGO_BIN_EXE_foveasim"))
        .args(words)
        .arg(scratch.path("killed"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let log = scratch.path("killed/plan.rows");
    let begun = Instant::now();
    let size = || std::fs::metadata(&log).map_or(0, |m| m.len());
    while size() < 20_000
        && child.try_wait().unwrap().is_none()
        && begun.elapsed() < Duration::from_secs(60)
    {
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let run = |folder: &str| {
        let mut all = words.to_vec();
        all.push(folder);
        scratch.ok(&all);
        scratch.read(&format!("{folder}/plan.csv"))
    };
    assert_eq!(run("killed"), run("fresh"));
}

#[test]
fn parts_that_do_not_belong_together_are_named() {
    let scratch = Scratch::new();
    let plan = ["plan", "--fov", "60,80", "--sharpness", "0.2", "--method"];
    let part = |method: &str, more: &[&str]| {
        let words: Vec<&str> = plan
            .iter()
            .copied()
            .chain([method])
            .chain(more.iter().copied())
            .collect();
        scratch.run(&words)
    };
    assert_eq!(part("layers:3", &["--shard", "1/2", "--out", "a"]).code, 0);
    assert_eq!(part("layers:2", &["--shard", "2/2", "--out", "b"]).code, 0);
    let log = scratch.read("a/plan.rows");
    for (folder, text) in [
        ("damaged", log.replace("layers:3,60", "layers:3,61")),
        ("columns", log.replace("number,address", "number,adress")),
        ("other", "x\n".to_owned()),
    ] {
        std::fs::create_dir(scratch.path(folder)).unwrap();
        scratch.write(&format!("{folder}/plan.rows"), text);
    }
    let bad = |ran: crate::scratch::Ran, expect: &str| {
        assert_eq!(ran.code, 2, "{expect}: {}", ran.out);
        assert!(
            ran.err.contains(expect) && ran.err.lines().count() == 1,
            "{}",
            ran.err
        );
    };
    bad(
        scratch.run(&["plan", "merge", "a"]),
        "not complete: shard 2/2",
    );
    bad(
        scratch.run(&["plan", "merge", "a", "b"]),
        "different sweeps",
    );
    bad(
        scratch.run(&["plan", "merge", "nowhere"]),
        "has no plan.rows",
    );
    bad(
        scratch.run(&["plan", "merge", "damaged"]),
        "plan.rows:3: row 0 is damaged",
    );
    bad(
        scratch.run(&["plan", "merge", "columns"]),
        "plan.rows:2: columns of another version",
    );
    bad(
        scratch.run(&["plan", "merge", "other"]),
        "plan.rows:1: want a line",
    );
    bad(
        part("layers:3", &["--shard", "1/2", "--out", "a"]),
        "--resume goes on",
    );
    bad(
        part("layers:2", &["--shard", "1/2", "--resume", "--out", "a"]),
        "another sweep",
    );
    bad(
        part("layers:3", &["--shard", "2/2", "--resume", "--out", "a"]),
        "holds shard 1/2",
    );
    bad(part("layers:3", &["--out", "a"]), "was not finished");
    bad(
        part("layers:3", &["--shard", "3/2", "--out", "c"]),
        "shard = 3/2",
    );
    bad(part("layers:3", &["--shard", "1/2"]), "--out");
}

#[test]
fn what_is_solved_for_meets_its_target_when_put_back() {
    let scratch = Scratch::new();
    let cell = |csv: &str, column: &str| -> f64 {
        let mut lines = csv.lines().map(|l| l.split(',').collect::<Vec<_>>());
        let place = lines
            .next()
            .unwrap()
            .iter()
            .position(|c| *c == column)
            .unwrap();
        lines.next().unwrap()[place].parse().unwrap()
    };
    let base = [
        "plan", "--fov", "100", "--method", "layers:3", "--format", "csv",
    ];
    let ask = |more: &[&str]| {
        let words: Vec<&str> = base.iter().copied().chain(more.iter().copied()).collect();
        scratch.ok(&words)
    };
    let found = ask(&[
        "--ppd",
        "centre:25",
        "--solve",
        "accuracy",
        "--target",
        "5x",
    ]);
    let margin = cell(&found, "value").to_string();
    let back = ask(&["--ppd", "centre:25", "--margin", &margin]);
    assert!((cell(&back, "predicted_speedup") / 5.0 - 1.0).abs() < 1e-3);
    let found = ask(&["--sharpness", "0.5", "--solve", "ppd", "--target", "90hz"]);
    let ppd = format!("centre:{}", cell(&found, "value"));
    let back = ask(&["--ppd", &ppd]);
    assert!((cell(&back, "frame_ms") * 90.0 / 1e3 - 1.0).abs() < 1e-3);
    let found = ask(&[
        "--ppd",
        "centre:25",
        "--solve",
        "accuracy",
        "--target",
        "100000x",
    ]);
    assert!(found.contains("no: this comes nearest"), "{found}");
    for (words, expect) in [
        (["--solve", "speed", "--target", "5x"], "unknown"),
        (
            ["--solve", "gpu", "--target", "5x"],
            "draws full resolution faster, too",
        ),
        (["--solve", "ppd", "--target", "5"], "5x, 11ms, 90hz"),
    ] {
        let mut all = base.to_vec();
        all.extend(words);
        let ran = scratch.run(&all);
        assert!(ran.code == 2 && ran.err.contains(expect), "{}", ran.err);
    }
    let spread = ask(&["--ppd", "centre:25", "--spread", "--draws", "19"]);
    assert_eq!(spread.lines().count(), 5);
    assert!(cell(&spread, "sample_ratio_p10") < cell(&spread, "sample_ratio_p90"));
}

#[test]
fn a_profile_that_was_fitted_is_planned_with() {
    let scratch = Scratch::new();
    let rows = include_str!("../../examples/data/guenter2012-table1.csv");
    scratch.write("rows.csv", rows);
    let fit = [
        "calibrate",
        "rows.csv",
        "--group",
        "Full",
        "--name",
        "mine",
        "--out",
        "fit",
    ];
    let table = scratch.ok(&fit);
    assert!(table.contains("samples_shaded") && table.contains("median_error"));
    assert!(scratch.read("fit/residuals.svg").contains("error [%]"));
    assert_eq!(scratch.ok(&fit), table);
    let planned = scratch.ok(&[
        "plan",
        "--display",
        "lg-w2363d",
        "--method",
        "layers:3",
        "--cost",
        "fit/mine.toml",
        "--format",
        "csv",
    ]);
    assert!(planned.contains(",mine,"), "{planned}");
    for (name, text, expect) in [
        ("a.csv", "time_ms,samples\n1,2\n", "measured rows = 1"),
        ("b.csv", "time_ms,sampels\n1,2\n", "samples"),
        ("c.csv", "time_ms,samples\n1,x\n", "c.csv:2: samples = `x`"),
    ] {
        scratch.write(name, text);
        let ran = scratch.run(&["calibrate", name]);
        assert!(ran.code == 2 && ran.err.contains(expect), "{}", ran.err);
    }
    let ran = scratch.run(&["calibrate", "rows.csv", "--group", "Ful"]);
    assert!(
        ran.code == 2 && ran.err.contains("did you mean `Full`"),
        "{}",
        ran.err
    );
    let ran = scratch.run(&["calibrate", "rows.csv", "--name", "../x"]);
    assert!(ran.code == 2 && ran.err.contains("--name"), "{}", ran.err);
}

/// Built in or not, it is no other command's; and of those that `plan` has, no rows that are kept as CSV.
#[test]
fn parquet_is_of_whole_sweeps_and_where_it_is_built_in() {
    let scratch = Scratch::new();
    let refused = |args: &[&str], expect: &str| {
        let ran = scratch.run(args);
        assert!(
            ran.code == 2 && ran.err.contains(expect),
            "{args:?}: {}",
            ran.err
        );
    };
    refused(
        &["presets", "--format", "parquet"],
        "`foveasim plan` has it",
    );
    if cfg!(not(feature = "parquet")) {
        refused(&["plan", "--format", "parquet"], "--features parquet");
        return;
    }
    fn parquet<'a>(args: &[&'a str]) -> Vec<&'a str> {
        let plan = ["plan", "--fov", "90", "--format", "parquet"];
        plan.into_iter().chain(args.iter().copied()).collect()
    }
    refused(&parquet(&["--shard", "1/2", "--out", "part"]), "CSV");
    refused(&["plan", "merge", "part", "--format", "parquet"], "CSV");
    scratch.ok(&["plan", "--fov", "90", "--out", "a"]);
    for folder in ["a", "b"] {
        assert_eq!(scratch.ok(&parquet(&["--out", folder])), "");
    }
    let file = |name: &str| std::fs::read(scratch.path(name)).unwrap();
    let bytes = file("a/plan.parquet");
    assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
    assert_eq!(bytes, file("b/plan.parquet"));
    // The table of the run before is gone.
    assert!(!scratch.path("a/plan.csv").exists());
}
