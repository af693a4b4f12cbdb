//! The same input gives the same bytes: on any number of threads, on any run, with any vector width.

use crate::scratch::Scratch;

#[test]
fn run_replay_and_latency_do_not_depend_on_threads() {
    let scratch = Scratch::new();
    scratch.ok(&[
        "trace",
        "synth",
        "--duration",
        "4s",
        "--seed",
        "3",
        "--to",
        "t.csv",
    ]);
    let mut seen: Vec<Vec<String>> = Vec::new();
    for (k, threads) in ["1", "2", "7", "2"].into_iter().enumerate() {
        let out = format!("out{k}");
        let ran = scratch.run(&[
            "run",
            "--trace",
            "t.csv",
            "--display",
            "quest-pro",
            "--tracker",
            "quest-pro",
            "--runs",
            "40000",
            "--images",
            "1",
            "--method",
            "layers:3",
            "--threads",
            threads,
            "--out",
            &out,
        ]);
        assert_eq!(ran.code, 0, "{}", ran.err);
        let mut outcome: Vec<String> = ["report.html", "latency.csv", "work.csv", "timeline.json"]
            .map(|name| scratch.read(&format!("{out}/{name}")))
            .into();
        outcome.push(scratch.ok(&["replay", "t.csv", "--threads", threads, "--digest"]));
        seen.push(outcome);
    }
    for other in &seen[1..] {
        assert!(
            *other == seen[0],
            "results differ between thread counts or runs"
        );
    }
}

#[test]
fn a_frame_does_not_depend_on_threads_or_vector_width() {
    let scratch = Scratch::new();
    let mut seen = Vec::new();
    for (threads, simd) in [("1", "auto"), ("2", "scalar"), ("7", "auto")] {
        let out = format!("{threads}-{simd}");
        scratch.ok(&[
            "render",
            "--scene",
            "study",
            "--method",
            "layers:3",
            "--size",
            "320x200",
            "--gaze",
            "100,120",
            "--threads",
            threads,
            "--simd",
            simd,
            "--out",
            &out,
        ]);
        let pixels = |name: &str| {
            let image = image::open(scratch.path(&out).join(name)).expect("a PNG");
            image.into_rgb8().into_raw()
        };
        let work = scratch.read(&format!("{out}/work.csv"));
        seen.push((pixels("frame.png"), pixels("reference.png"), work));
    }
    assert!(seen[0] == seen[1] && seen[0] == seen[2]);
}

#[test]
fn phases_are_the_same_on_any_threads() {
    let scratch = Scratch::new();
    let synth = "trace synth --duration 6s --gaze-rate 1200 --to t.csv";
    scratch.ok(&synth.split(' ').collect::<Vec<_>>());
    let phases = |threads| {
        let flags = "replay t.csv --phases --decimate 72 --format csv --threads";
        let args: Vec<&str> = flags.split(' ').chain([threads]).collect();
        scratch.ok(&args)
    };
    let one = phases("1");
    assert!(
        one.starts_with("phase,frames,") && one.contains("\nlanding,"),
        "{one}"
    );
    assert!(["2", "7"].iter().all(|threads| phases(threads) == one));
}

#[test]
fn a_golden_replay_names_the_first_difference() {
    let scratch = Scratch::new();
    scratch.ok(&["trace", "synth", "--duration", "2s", "--to", "t.csv"]);
    let digest = scratch.ok(&["replay", "t.csv", "--digest"]);
    assert_eq!(digest.lines().count(), 1);
    scratch.write("digest.txt", &digest);
    let golden = scratch.ok(&["replay", "t.csv", "--format", "csv"]);
    scratch.write("golden.csv", &golden);
    scratch.ok(&["replay", "t.csv", "--check", "digest.txt"]);
    scratch.ok(&["replay", "t.csv", "--check", "golden.csv"]);

    let ran = scratch.run(&["replay", "t.csv", "--seed", "2", "--check", "digest.txt"]);
    assert_eq!(ran.code, 1, "{}", ran.err);
    let mut lines: Vec<String> = golden.lines().map(str::to_owned).collect();
    lines[5] = lines[5].replacen(',', ",9", 1);
    scratch.write("changed.csv", lines.join("\n") + "\n");
    let ran = scratch.run(&["replay", "t.csv", "--check", "changed.csv"]);
    assert_eq!(ran.code, 1);
    assert!(
        ran.err.contains("vblank_ms"),
        "names the column: {}",
        ran.err
    );
    let ran = scratch.run(&["replay", "t.csv", "--check", "missing.csv"]);
    assert_eq!(
        ran.code, 2,
        "a golden file that is not there is bad input: {}",
        ran.err
    );
}

#[test]
fn a_recording_that_passes_by_gives_what_a_kept_one_gives() {
    let scratch = Scratch::new();
    scratch.ok(&["trace", "synth", "--duration", "3s", "--to", "t.csv"]);
    let csv = scratch.ok(&["replay", "t.csv", "--format", "csv"]);
    // With --out the recording is kept.
    let kept = scratch.ok(&["replay", "t.csv", "--format", "csv", "--out", "out"]);
    assert_eq!(csv, kept);
    assert_eq!(csv, scratch.read("out/replay.csv"));
    assert!(scratch.names("out").contains(&"latency.svg".to_owned()));
    let text = scratch.ok(&["replay", "t.csv"]);
    assert_eq!(text, scratch.ok(&["replay", "t.csv", "--out", "again"]));
    assert_eq!(text.lines().count(), csv.lines().count());
    let json = scratch.ok(&["replay", "t.csv", "--format", "json"]);
    let rows: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(rows.as_array().unwrap().len() + 1, csv.lines().count());

    // A pipe can be read once: it is kept.
    #[cfg(unix)]
    {
        let from = std::fs::File::open(scratch.path("t.csv")).unwrap();
        let mut cat = std::process::Command::new("cat")
            .stdin(from)
            .stdout(std::process::Stdio::piped())
            .spawn()
            .expect("cat is everywhere");
        let piped = std::process::Command::new(env!("CARGO_BIN_EXE_foveasim"))
            .args(["replay", "/dev/stdin", "--format", "csv"])
            .stdin(cat.stdout.take().unwrap())
            .output()
            .unwrap();
        cat.wait().unwrap();
        let err = String::from_utf8_lossy(&piped.stderr).into_owned();
        assert!(piped.status.success(), "{err}");
        assert_eq!(String::from_utf8(piped.stdout).unwrap(), csv);
    }
}
