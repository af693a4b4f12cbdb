//! The exact commands that others script against, and the numbers they print.

use crate::scratch::{Scratch, number, rows};

#[test]
fn plan_of_the_study_display() {
    let csv = Scratch::new().ok(&[
        "plan",
        "--display",
        "lg-w2363d",
        "--slope",
        "0.0275",
        "--method",
        "layers:3",
        "--format",
        "csv",
    ]);
    let wanted = "method,fov_h_deg,width_px,height_px,display_samples,method_samples,sample_ratio,\
                  sample_ratio_staggered,ideal_ratio";
    assert!(csv.starts_with(wanted), "{csv}");
    let rows = rows(&csv);
    assert_eq!(rows.len(), 1);
    // Guenter 2012, Eqs 2-8, optimised continuously by an independent computation.
    assert!((number(&rows[0], "sample_ratio") / 8.497_841_827_596_73 - 1.0).abs() < 1e-6);
    assert!((number(&rows[0], "sample_ratio_staggered") - 13.292_452).abs() < 1e-3);
    assert!(number(&rows[0], "ideal_ratio") > number(&rows[0], "sample_ratio"));
}

#[test]
fn plan_of_everything_that_ships() {
    let csv = Scratch::new().ok(&[
        "plan",
        "--display",
        "quest-pro",
        "--method",
        "full,layers:3:strict,vrs,fdm,rates,quad,quad:auto,vrs:fixed",
        "--format",
        "csv",
    ]);
    let rows = rows(&csv);
    let of = |name: &str| rows.iter().map(|r| number(r, name)).collect::<Vec<_>>();
    let [samples, shadings] = [of("sample_ratio"), of("shading_ratio")];
    // Variable-rate shading keeps visibility at every pixel; the others shade each sample.
    assert_eq!([samples[2], samples[7]], [1.0, 1.0]);
    for i in [0, 1, 3, 4, 5, 6] {
        assert_eq!(samples[i], shadings[i]);
    }
    // Focus 0.35 of each side and periphery 0.5.
    assert!((shadings[5] - 1.0 / 0.3725).abs() < 1e-3);
    // A separable map saves less than a map of tiles, and a fixed one than a tracked one.
    assert!(shadings[3] > shadings[4] && shadings[4] > 1.0);
    assert!(shadings[2] > shadings[7] && shadings[7] > 1.0);
    let tracked_over_fixed = of("tracked_over_fixed");
    assert!((tracked_over_fixed[2] / (shadings[2] / shadings[7]) - 1.0).abs() < 1e-9);
    assert_eq!(tracked_over_fixed[0], 1.0);
    assert!(tracked_over_fixed[1..].iter().all(|r| *r > 1.3));
}

#[test]
fn plan_of_kernels() {
    let methods = "full,kfr:2:4,kfr:2:4:published,efr:2:3,lms:0:0,lms:1:1";
    let args = [
        "plan",
        "--display",
        "quest-pro",
        "--format",
        "csv",
        "--method",
    ];
    let csv = Scratch::new().ok(&[&args[..], &[methods]].concat());
    let rows = rows(&csv);
    let of = |name: &str| rows.iter().map(|r| number(r, name)).collect::<Vec<_>>();
    let [samples, shadings] = [of("sample_ratio"), of("shading_ratio")];
    assert!(shadings[1] > 4.0 && shadings[1] < 4.2 && samples[1] == shadings[1]);
    // As published, visibility is found at every pixel.
    assert_eq!([samples[2], shadings[2]], [1.0, shadings[1]]);
    // One eye of each: 2/(1/σ_d² + 1/σ_nd²), where as much is beyond the display.
    assert!((shadings[3] / shadings[1] - 18.0 / 13.0).abs() < 1e-6);
    assert!((samples[4] - 1.0).abs() < 1e-9 && samples[5] > 4.0);
    assert!(
        rows[1..]
            .iter()
            .all(|row| row["tracked_over_fixed"].is_empty())
    );
}

#[test]
fn the_kernel_is_found() {
    let scratch = Scratch::new();
    let args = [
        "plan",
        "kernel",
        "--display",
        "dk2",
        "--gaze",
        "300,500",
        "--margin-deg",
        "1",
    ];
    let csv = scratch.ok(&[&args[..], &["--format", "csv", "--out", "k"]].concat());
    let rows = rows(&csv);
    let row = |name: &str| rows.iter().find(|r| r["name"] == name).expect(name);
    assert_eq!(row("kfr, best")["meets_line"], "yes");
    assert!(number(row("kfr, best"), "samples") < number(row("full"), "samples") / 3.0);
    assert!(number(row("kfr, best"), "over_ideal") > 1.0);
    assert_eq!(row("layers:3:blending=strict")["meets_line"], "yes");
    let names = [
        "kernel.csv",
        "spacing-centre.svg",
        "spacing.csv",
        "spacing.svg",
        "vrs-rates.csv",
    ];
    assert_eq!(scratch.names("k"), names);
}

#[test]
fn plan_over_field_of_view_gives_the_hundredfold_saving_at_70_degrees() {
    let csv = Scratch::new().ok(&[
        "plan",
        "--fov",
        "10..130:5",
        "--sharpness",
        "foveal",
        "--aspect",
        "0.75",
        "--slope",
        "0.0275",
        "--method",
        "layers:4",
        "--format",
        "csv",
    ]);
    let rows = rows(&csv);
    assert_eq!(rows.len(), 25);
    let at_70 = rows
        .iter()
        .find(|r| number(r, "fov_h_deg") == 70.0)
        .expect("a row for 70");
    assert!((number(at_70, "sample_ratio") / 102.981_630_683_630_3 - 1.0).abs() < 1e-6);
}

#[test]
fn latency_agrees_with_the_published_set_up() {
    // Exact distributions of the unrounded set-up, by an independent computation [ms]: p5, p50, mean,
    // p95 and p99, then the exact extremes.
    #[rustfmt::skip]
    let cases = [
        ("tearing", "gaze_to_photon_gaze_row", [24.02, 29.97, 29.97, 35.92, 37.70], [18.966_667, 40.966_667]),
        ("tearing", "gaze_to_photon_last_row", [25.56, 31.39, 31.37, 37.03, 38.61], [20.509_877, 40.966_667]),
        ("tearing", "gaze_to_photon_complete_pass", [25.56, 31.51, 31.51, 37.46, 39.24], [20.509_877, 42.509_877]),
        ("vsync-free", "gaze_to_photon_last_row", [28.96, 34.90, 34.90, 40.85, 42.64], [23.904_938, 45.904_938]),
        ("vsync", "gaze_to_photon_last_row", [26.47, 30.74, 30.74, 35.01, 36.08], [23.904_938, 37.571_605]),
    ];
    let scratch = Scratch::new();
    for sync in ["tearing", "vsync-free", "vsync"] {
        let csv = scratch.ok(&[
            "latency",
            "--display",
            "lg-w2363d",
            "--tracker",
            "tx300",
            "--sync",
            sync,
            "--runs",
            "1000000",
            "--seed",
            "5",
            "--format",
            "csv",
        ]);
        let header = "stage,min_ms,p5_ms,p50_ms,mean_ms,p95_ms,p99_ms,max_ms,bound_min_ms,bound_max_ms,bound";
        assert!(csv.starts_with(header), "{csv}");
        let rows = rows(&csv);
        for (_, quantity, wanted, [min, max]) in cases.iter().filter(|c| c.0 == sync) {
            let row = rows
                .iter()
                .find(|r| r["stage"] == *quantity)
                .expect("the quantity");
            for (column, wanted) in ["p5_ms", "p50_ms", "mean_ms", "p95_ms", "p99_ms"]
                .iter()
                .zip(wanted)
            {
                let off = number(row, column) - wanted;
                assert!(off.abs() < 0.05, "{sync} {quantity} {column}: {off} ms off");
            }
            assert!(
                (number(row, "bound_min_ms") - min).abs() < 1e-3,
                "{sync} {quantity} {row:?}"
            );
            assert!(
                (number(row, "bound_max_ms") - max).abs() < 1e-3,
                "{sync} {quantity} {row:?}"
            );
        }
        for row in &rows {
            assert_eq!(row["bound"], "exact", "{row:?}");
            assert!(
                number(row, "bound_min_ms") <= number(row, "min_ms"),
                "{row:?}"
            );
            assert!(
                number(row, "max_ms") <= number(row, "bound_max_ms"),
                "{row:?}"
            );
        }
    }
}

/// A chain with everything on that can be.
const XR: [&str; 15] = [
    "latency",
    "--display",
    "quest-3",
    "--tracker",
    "quest-pro",
    "--render",
    "uniform:5..6.5",
    "--warp-ms",
    "1.5",
    "--lead-ms",
    "2",
    "--missed",
    "reproject",
    "--runs",
    "5000",
];

#[test]
fn a_runtimes_loop_is_told_by_flags() {
    let scratch = Scratch::new();
    let latency = |more: &[&str]| {
        let args = [&XR[..], more, &["--format", "csv"]].concat();
        rows(&scratch.ok(&args))
    };
    let p95 = |rows: &[std::collections::HashMap<String, String>], stage: &str| {
        let row = rows.iter().find(|r| r["stage"] == stage).expect(stage);
        number(row, "p95_ms")
    };
    let plain = latency(&[]);
    let hurried = latency(&["--start", "just-in-time"]);
    let gaze = "gaze_to_photon_gaze_row";
    assert!(p95(&hurried, gaze) < p95(&plain, gaze) - 1.0);
    // A warp reads the head's pose when the compositor takes the frame, whenever that was rendered.
    let motion = "motion_to_photon_gaze_row";
    assert_eq!(p95(&hurried, motion), p95(&plain, motion));
    assert_eq!(p95(&plain, "compose"), 2.0);
    let held = latency(&["--buffered-frames", "2", "--transport", "1.5"]);
    assert!((p95(&held, "display_buffer") - 2e3 / 90.0).abs() < 1e-3);
    assert_eq!(p95(&held, "tracker_transport"), 1.5);
    let off = latency(&["--off", "processing,exposure,response,lead"]);
    assert!(p95(&off, gaze) < p95(&plain, gaze) - 30.0);
    assert!(
        off.iter().all(|r| r["stage"] != "compose"),
        "what is off has no row"
    );
}

#[test]
fn frames_and_tracker_times_can_be_measured_ones() {
    let scratch = Scratch::new();
    scratch.write("frames.csv", "frame,gpu_ms\n0,6.5\n1,7.25\n2,6.75\n");
    let args = [
        "latency",
        "--runs",
        "2000",
        "--format",
        "csv",
        "--render",
        "csv:frames.csv",
    ];
    let csv = scratch.ok(&[&args[..], &["--processing", "csv:frames.csv"]].concat());
    let rows = rows(&csv);
    for stage in ["render", "tracker_processing"] {
        let row = rows.iter().find(|r| r["stage"] == stage).expect(stage);
        let ends = [number(row, "bound_min_ms"), number(row, "bound_max_ms")];
        assert_eq!(ends, [6.5, 7.25], "{stage}");
    }
}

#[test]
fn a_budget_that_does_not_hold_names_what_to_shorten() {
    let scratch = Scratch::new();
    scratch.ok(&["latency", "--runs", "5000", "--budget", "50ms"]);
    for (flags, what) in [
        (
            &["--budget", "30"][..],
            "over the budget of 30 ms: read the gaze later",
        ),
        // As late as can be.
        (
            &["--budget", "20", "--gaze-latch-ms", "8.333333"],
            "over the budget of 20 ms: shorten ",
        ),
    ] {
        let ran = scratch.run(&[&["latency", "--runs", "5000"], flags].concat());
        assert_eq!(ran.code, 1);
        assert!(ran.err.contains(what), "{}", ran.err);
    }
}

#[test]
fn the_rounded_numbers_of_fig_5() {
    let scratch = Scratch::new();
    for (reading, worst) in [
        ("figure", 40.0),
        ("scan-after-wait", 42.0),
        ("two-periods-more", 48.0),
    ] {
        let csv = scratch.ok(&["latency", "--reading", reading, "--format", "csv"]);
        let rows = rows(&csv);
        let total = rows.last().expect("a total");
        assert_eq!(number(total, "bound_min_ms"), 23.0);
        assert_eq!(number(total, "bound_max_ms"), worst);
    }
}

#[test]
fn what_may_rise_without_a_part_is_told() {
    let scratch = Scratch::new();
    let said = |flags: &[&str]| {
        let ran = scratch.run(&[&["latency", "--runs", "10"], flags].concat());
        assert_eq!(ran.code, 0, "{flags:?}: {}", ran.err);
        ran.err.contains("may be")
    };
    let locked = [
        "--sync",
        "vsync-free",
        "--host-lock-ms",
        "5",
        "--render",
        "uniform:4..14",
    ];
    assert!(said(&[&locked[..], &["--off", "render"]].concat()));
    assert!(!said(&locked));
    assert!(!said(&[&locked[..], &["--off", "exposure"]].concat()));
    assert!(said(&["--warp-ms", "1", "--off", "lead"]));
    assert!(!said(&["--off", "render,response"]));
    // Whoever reads the numbers by a program must know, too.
    for format in ["csv", "json"] {
        assert!(said(&[
            "--warp-ms",
            "1",
            "--off",
            "lead",
            "--format",
            format
        ]));
    }
}

#[test]
fn without_rendering_frames_say_what_time_they_take() {
    let scratch = Scratch::new();
    let told = |flags: &[&str]| {
        scratch
            .run(&[&["latency", "--runs", "10"], flags].concat())
            .err
    };
    let latch = ["--render-ms", "8", "--gaze-latch-ms", "3"];
    assert!(told(&latch).contains("frames render 8 ms;"));
    let off = told(&[&latch[..], &["--off", "render"]].concat());
    assert!(
        off.contains("frames render in no time, but take the 3 ms until"),
        "{off}"
    );
    let off = told(&["--off", "render"]);
    assert!(off.contains("frames render in no time;"), "{off}");
}

#[test]
fn what_does_not_fit_together_is_named() {
    let scratch = Scratch::new();
    scratch.write("bad.csv", "frame_ms\n8\n-1\n");
    scratch.write("short.csv", "frame_ms,n\n8,1\n9\n");
    for (flags, part) in [
        (
            &["--sync", "tearing", "--lead-ms", "1"][..],
            "compositor lead [ms] = 1",
        ),
        (&["--lead-ms", "1", "--warp-ms", "2"], "late warp [ms] = 2"),
        (
            &["--missed", "reproject"],
            "missed-frame policy = reproject",
        ),
        (&["--missed", "reprojct"], "did you mean `reproject`?"),
        (&["--frames-in-flight", "4"], "frames in flight = 4"),
        (
            &["--sync", "vsync-free", "--start", "just-in-time"],
            "frame start = just-in-time",
        ),
        (&["--start", "soon"], "start = soon"),
        (&["--gaze-latch-ms", "9"], "gaze latch [ms] = 9"),
        (&["--buffered-frames", "5"], "buffered_frames = 5"),
        (&["--eye", "right"], "eye = right"),
        (&["--off", "exposure,rendr"], "did you mean `render`?"),
        (&["--drift-ppm", "0,0,nan"], "want three numbers"),
        (&["--drift-ppm", "0,0,2e5"], "drift_ppm.display = 200000"),
        (&["--host-lock-ms", "1"], "host lock [ms] = 1"),
        (&["--render", "uniform:9..8"], "[9, 8]"),
        (&["--render", "csv:bad.csv"], "bad.csv: line 3 = -1"),
        (&["--render", "csv:none.csv"], "none.csv"),
        (&["--head-hz", "0"], "head_hz = 0"),
        (&["--budget", "soon"], "want milliseconds"),
        (&["--budget", "-1ms"], "want milliseconds"),
        // What would be accepted, and ignored.
        (&["--host-hz", "60"], "host_hz = 60"),
        (&["--eye", "left"], "eye = left"),
        (&["--gaze-row", "1080"], "gaze row = 1080"),
        (
            &["--render", "csv:short.csv"],
            "short.csv: line 3 = 1 fields",
        ),
        (&["--reading", "figure", "--off", "render"], "--off"),
        (&["--reading", "figure", "--sync", "tearing"], "--sync"),
        (&["--reading", "figure", "--warp-ms", "2"], "--warp-ms"),
        (&["--render", "1e300"], "1e300"),
    ] {
        let ran = scratch.run(&[&["latency", "--runs", "10"], flags].concat());
        assert_eq!(ran.code, 2, "{flags:?}: {}", ran.err);
        assert!(ran.err.contains(part), "{flags:?}: {}", ran.err);
    }
}

#[test]
fn stein_2021_says_what_nobody_verified() {
    let table = Scratch::new().ok(&["reproduce", "stein2021"]);
    for part in [
        "Fove-0",
        "HTC Vive Pro Eye",
        "least of the three",
        "nobody could verify",
        "processing_ms",
    ] {
        assert!(table.contains(part), "{part}: {table}");
    }
}
