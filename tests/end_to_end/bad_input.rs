//! Wrong input: one clear line on standard error, exit 2, nothing written.

use crate::scratch::Scratch;

/// Runs, and checks that the command refuses with one line that holds all of `parts`.
fn refused(scratch: &Scratch, words: &[&str], parts: &[&str]) {
    let ran = scratch.run(words);
    assert_eq!(ran.code, 2, "{words:?}: {} {}", ran.out, ran.err);
    assert!(ran.out.is_empty(), "{words:?}: {}", ran.out);
    assert!(!ran.err.contains("panicked"), "{words:?}: {}", ran.err);
    for part in parts {
        assert!(
            ran.err.contains(part),
            "{words:?} should say {part:?}: {}",
            ran.err
        );
    }
    assert_eq!(
        ran.err.trim_end().lines().count(),
        1,
        "{words:?}: {}",
        ran.err
    );
    assert!(ran.err.starts_with("foveasim: "), "{words:?}: {}", ran.err);
}

#[test]
fn kernels() {
    let s = Scratch::new();
    for (method, part) in [
        ("kfr", "sigma of kfr"),
        ("kfr:0:4", "a number from 0.25 to 100, as in kfr:2:4"),
        ("kfr:2:inf", "alpha of kfr = inf"),
        ("kfr:2:4:publish", "did you mean `published`?"),
        (
            "efr:3:2",
            "sigma of the other eye = 2: must be a number from 3",
        ),
        ("efr:2:3:dominant=both", "valid: left, right"),
        ("lms:21:0", "A of lms = 21"),
    ] {
        refused(&s, &["plan", "--method", method], &["--method", part]);
    }
    let kernel = |more: &[&str], parts: &[&str]| {
        let words = [&["plan", "kernel", "--display", "dk2"], more].concat();
        refused(&s, &words, parts);
    };
    kernel(&["--gaze", "middle"], &["centre, any", "middle"]);
    kernel(&["--margin-deg", "-1"], &["--margin-deg -1", "0 to 90"]);
    kernel(&["--slope", "nan"], &["slope"]);
    kernel(&["--method", "vsr"], &["unknown method `vsr`", "vrs"]);
    refused(
        &s,
        &["reproduce", "meng2020", "--antialiasing-frames", "3"],
        &["meng2020 has no antialiasing"],
    );
}

#[test]
fn both_eyes() {
    let s = Scratch::new();
    let render = |more: &str, parts: &[&str]| {
        let words = format!("render --method kfr:2:1 --size 64x64 {more}");
        refused(&s, &words.split(' ').collect::<Vec<_>>(), parts);
    };
    render("--stereo", &["--stereo: lg-w2363d", "want a headset"]);
    render(
        "--stereo --display quest-pro --frames 2",
        &["--stereo: draws one frame"],
    );
    for distance in ["0", "nan", "1e9"] {
        let flags = format!("--stereo --display quest-pro --gaze-distance {distance}");
        render(&flags, &["--gaze-distance", "0.05 to 10000"]);
    }
    render("--gaze-distance 2", &["--stereo"]);
    render("--frames 2", &["kfr:2:1", "do not lie evenly"]);
}

#[test]
fn names_and_numbers() {
    let s = Scratch::new();
    refused(
        &s,
        &["plan", "--display", "quest-por"],
        &["quest-por", "did you mean `quest-pro`"],
    );
    refused(&s, &["run", "--tracker", "tx30"], &["did you mean `tx300`"]);
    refused(
        &s,
        &["plan", "--fov", "180", "--sharpness", "foveal"],
        &["180"],
    );
    refused(
        &s,
        &["plan", "--fov", "0", "--sharpness", "foveal"],
        &["above 0 and below 180"],
    );
    refused(
        &s,
        &["plan", "--fov", "nan", "--sharpness", "foveal"],
        &["nan"],
    );
    refused(
        &s,
        &["plan", "--fov", "120", "--ppd", "40"],
        &["7939", "4800", "centre:40"],
    );
    refused(&s, &["plan", "--slope", "NaN"], &["NaN"]);
    refused(&s, &["plan", "--slope=-1"], &["-1"]);
    refused(
        &s,
        &["plan", "--method", "layrs:3"],
        &["did you mean `layers`"],
    );
    refused(
        &s,
        &["plan", "--pixels", "0x100", "--fov", "90"],
        &["0x100"],
    );
    refused(
        &s,
        &["plan", "--pixels", "9999999x9999999", "--fov", "90"],
        &["65536"],
    );
    refused(
        &s,
        &["plan", "--fov", "10..130:1e-9", "--sharpness", "foveal"],
        &["more than 1000000"],
    );
    refused(&s, &["latency", "--runs", "0"], &["runs", "1 to"]);
    refused(&s, &["latency", "--sync", "vsnc"], &["vsync"]);
    refused(&s, &["render", "--size", "0x0", "--out", "x"], &["0x0"]);
    refused(&s, &["render", "--size=-5x7", "--out", "x"], &["-5x7"]);
    for scene in ["study", "volume:shells:8"] {
        let words = [
            "render",
            "--scene",
            scene,
            "--size",
            "20000x20000",
            "--out",
            "x",
        ];
        refused(&s, &words, &["--size 20000x20000", "1 to 16384"]);
    }
    refused(&s, &["render", "--gaze", "nan,3", "--out", "x"], &["nan,3"]);
    refused(&s, &["render", "--scene", "stdy", "--out", "x"], &["study"]);
    refused(
        &s,
        &["run", "--margin-deg", "nan"],
        &["margin_deg", "0 to 90"],
    );
    refused(&s, &["presets", "qest-3"], &["did you mean `quest-3`"]);
    refused(&s, &["plan", "--threads", "0"], &["--threads", "1..=1024"]);
    refused(&s, &["run", "--images", "-1"], &["--images", "-1"]);
    refused(&s, &["run", "--fov", "40..120:0.0001"], &["at most 10000"]);
    refused(&s, &["run", "--scale", "2"], &["trace"]);
    refused(&s, &["latency", "--render-ms", "nan"], &["0 to 10000"]);
    refused(
        &s,
        &["replay", "t.csv", "--gaze-mode", "fixd"],
        &["did you mean `fixed`"],
    );
    refused(
        &s,
        &["render", "--fov", "1e-40", "--out", "x"],
        &["pixel size"],
    );
    refused(&s, &["trace", "synth", "--out", "x"], &["--to"]);
    refused(
        &s,
        &["run", "--dispaly", "dk2"],
        &["--dispaly", "'--display'"],
    );
    refused(&s, &["nonsense"], &["nonsense"]);
    assert!(
        s.names(".").iter().all(|n| n == "out" || n == "x"),
        "{:?}",
        s.names(".")
    );
}

#[test]
fn traces() {
    let s = Scratch::new();
    s.ok(&["trace", "synth", "--duration", "1s", "--to", "good.csv"]);
    let good = s.read("good.csv");
    let lines: Vec<&str> = good.lines().collect();
    let header = lines
        .iter()
        .position(|l| l.starts_with("t_ns"))
        .expect("a header")
        + 1;

    s.write("empty.csv", "");
    s.write("binary.csv", [0u8, 159, 146, 150, 0, 0, 1, 2, 3]);
    s.write("header.csv", lines[..header].join("\n") + "\n");
    s.write("truncated.csv", &good[..good.trim_end().len() - 40]);
    let mut swapped = lines.clone();
    swapped.swap(header + 10, header + 20);
    s.write("reversed.csv", swapped.join("\n") + "\n");
    let nan = lines[header + 4].replacen(',', ",nan", 1);
    let mut with_nan = lines.clone();
    with_nan[header + 4] = &nan;
    s.write("nan.csv", with_nan.join("\n") + "\n");
    let lost: Vec<String> = lines[header..]
        .iter()
        .map(|l| {
            let mut fields: Vec<&str> = l.split(',').collect();
            fields[1..].fill("");
            fields.join(",")
        })
        .collect();
    s.write(
        "lost.csv",
        lines[..header].join("\n") + "\n" + &lost.join("\n") + "\n",
    );
    std::fs::create_dir(s.path("folder.csv")).unwrap();

    for (file, part) in [
        ("empty.csv", "empty"),
        ("binary.csv", "text"),
        ("header.csv", "sample"),
        ("truncated.csv", "line"),
        ("reversed.csv", "line"),
        ("nan.csv", "line"),
        ("lost.csv", "lost"),
        ("missing.csv", "missing.csv"),
        ("folder.csv", "folder.csv"),
    ] {
        refused(&s, &["run", "--trace", file], &[file, part]);
        refused(&s, &["replay", file], &[file, part]);
    }
    assert!(!s.path("out/report.html").exists());
}

#[test]
fn phases_of_a_replay() {
    let s = Scratch::new();
    s.ok(&["trace", "synth", "--duration", "1s", "--to", "t.csv"]);
    for (flags, part) in [
        (&["--phases", "--suppression-ms", "-1"][..], "0 to 10000"),
        (&["--phases", "--suppression-ms", "NaN"], "0 to 10000"),
        (
            &["--phases", "--suppression-before-ms", "-1"],
            "--suppression-before-ms",
        ),
        (
            &["--phases", "--suppression-before-ms", "inf"],
            "0 to 10000",
        ),
        (&["--suppression-before-ms", "50"], "--phases"),
        (&["--phases", "--decimate", "0"], "--decimate"),
        (&["--phases", "--decimate", "NaN"], "--decimate"),
        (&["--phases", "--decimate", "5000"], "below the"),
        (&["--phases", "--decimate", "1"], "3"),
        (&["--phases", "--method", "layer"], "did you mean `layers`"),
        (&["--phases", "--slope", "steep"], "steep"),
        (&["--phases", "--digest"], "--digest"),
        (&["--decimate", "72"], "--phases"),
    ] {
        let args: Vec<&str> = ["replay", "t.csv"].iter().chain(flags).copied().collect();
        refused(&s, &args, &[part]);
    }
}

#[test]
fn scenarios_and_folders() {
    let s = Scratch::new();
    s.write("wrong.toml", "seed = 1\nmetod = \"full\"\n");
    refused(
        &s,
        &["run", "wrong.toml"],
        &["wrong.toml", "line 2", "did you mean `method`"],
    );
    s.write("broken.toml", "seed = = 1\n");
    refused(&s, &["run", "broken.toml"], &["broken.toml", "line 1"]);
    s.write("type.toml", "seed = \"one\"\n");
    refused(&s, &["run", "type.toml"], &["type.toml", "line 1"]);
    refused(&s, &["run", "missing.toml"], &["missing.toml"]);
    s.write("three.toml", "screen_px = [1, 2, 3]\ntrace = \"t.csv\"\n");
    refused(
        &s,
        &["run", "three.toml"],
        &["screen_px", "[width, height]"],
    );
    s.write("file", "in the way");
    refused(&s, &["run", "--out", "file/out"], &["file/out"]);
    refused(&s, &["run", "--out", "/proc/nowhere"], &["/proc/nowhere"]);
    refused(&s, &["render", "--out", "file"], &["file"]);
    assert_eq!(s.read("file"), "in the way");
}

#[test]
fn a_closed_pipe_is_not_an_error() {
    use std::process::{Command, Stdio};
    let mut child = Command::new(env!("CARGO_BIN_EXE_foveasim"))
        .args(["plan", "--fov", "10..130:0.1", "--format", "csv"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
}

#[test]
fn masks() {
    let s = Scratch::new();
    let build = |more: &[&str], parts: &[&str]| {
        refused(&s, &[&["mask", "build"], more].concat(), parts);
    };
    build(&["--density", "gausian"], &["did you mean `gaussian`?"]);
    build(
        &["--interpolation", "cubic"],
        &["valid: nearest, barycentric, natural"],
    );
    build(&["--fraction", "0"], &["fraction of rays = 0", "above 0"]);
    build(&["--fraction", "nan"], &["fraction of rays = NaN"]);
    build(
        &["--density", "mar", "--fraction", "1.5"],
        &["fraction of rays = 1.5"],
    );
    build(
        &["--density", "mar", "--floor", "0.1"],
        &["--floor are for --density gaussian"],
    );
    build(&["--slope", "guenter-a"], &["--slope is for --density mar"]);
    build(&["--sigma-deg", "-3"], &["--sigma-deg -3", "0.001 to 60"]);
    build(
        &["--distance-cm", "0"],
        &["--distance-cm 0", "0.001 to 100000"],
    );
    build(&["--size", "4x4"], &["display of a mask = 4 x 4"]);
    build(
        &["--size", "60000x60000"],
        &["display of a mask = 60000 x 60000"],
    );
    build(&["--hysteresis-step", "0"], &["hysteresis = 0.5 + 0 i"]);
    build(&["--display", "quest-por"], &["did you mean `quest-pro`?"]);
    build(&["--floor", "2"], &["floor [rays per pixel] = 2"]);
    let bruder = |more: &[&str], parts: &[&str]| {
        refused(&s, &[&["reproduce", "bruder2019"], more].concat(), parts);
    };
    bruder(
        &["--cameras", "0", "--size", "32x32", "--volume", "jet:8"],
        &["cameras = 0"],
    );
    bruder(&["--volume", "jett:8"], &["did you mean `jet`?"]);
    bruder(&["--volume", "no/such.nii"], &["no/such.nii"]);
    bruder(
        &["--antialiasing-frames", "3"],
        &["--antialiasing-* are for guenter2012"],
    );
    let stein = ["reproduce", "stein2021", "--gazes", "3"];
    refused(&s, &stein, &["stein2021 has no volumes"]);
}

#[test]
fn scans_and_lenses() {
    let s = Scratch::new();
    let render = |more: &[&str], parts: &[&str]| {
        let words = [&["render", "--size", "96x54", "--out", "r"], more].concat();
        refused(&s, &words, parts);
    };
    render(&["--method", "radial:0.5"], &["exponent of radial"]);
    render(
        &["--rolling", "--scan-ms", "-1"],
        &["--scan-ms = -1", "0 to 10000"],
    );
    render(
        &["--rolling", "--head-velocity", "1e9,0"],
        &["--head-velocity", "within ±10000"],
    );
    render(&["--lens", "1"], &["--lens", "K1,K2"]);
    render(
        &["--method", "full", "--lens", "-3,0"],
        &["lens coefficients", "grows"],
    );
    render(&["--method", "vrs", "--rolling"], &["shaded by itself"]);
    render(
        &["--method", "full", "--msaa", "4", "--rolling"],
        &["one position of visibility"],
    );
    render(&["--bound", "boxx"], &["did you mean `box`"]);
    render(
        &["--rolling", "--head-trace", "nowhere.csv", "--at", "1"],
        &["nowhere.csv"],
    );
}
