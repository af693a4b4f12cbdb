//! Volumes by `render`: generated and from files, by methods of every kind, and what is refused.

use crate::scratch::{Scratch, number, rows};

const SMALL: [&str; 7] = [
    "render", "--size", "240x180", "--format", "csv", "--out", "r",
];

#[test]
fn every_kind_of_plan_draws_a_volume() {
    let s = Scratch::new();
    for method in [
        "full",
        "layers:3",
        "vrs",
        "fdm",
        "quad",
        "kfr:2:1:published",
        "lms:1:1",
    ] {
        let flags = [
            "--scene",
            "volume:shells:24",
            "--slope",
            "j:4",
            "--method",
            method,
        ];
        let quality = rows(&s.ok(&[&SMALL[..], &flags].concat()));
        let ssim = number(&quality[0], "ssim");
        assert!(ssim > 0.9, "{method}: {ssim}");
        let work = rows(&s.read("r/work.csv"));
        let [reference, rays] = [&work[0], &work[work.len() - 1]].map(|row| number(row, "rays"));
        assert_eq!(reference, 43_200.0);
        if method == "full" {
            assert_eq!((ssim, rays), (1.0, reference));
        } else {
            assert!(rays > 0.0 && rays < 0.5 * reference, "{method}: {rays}");
        }
    }
    let files = [
        "error.png",
        "frame.png",
        "quality.csv",
        "reference.png",
        "transfer.svg",
        "work.csv",
    ];
    let mut names = s.names("r");
    names.retain(|n| files.contains(&n.as_str()));
    names.sort();
    assert_eq!(names, files);
}

#[test]
fn files_transfer_functions_and_switches() {
    let s = Scratch::new();
    let ball = |k: usize| {
        let p = [k % 12, k / 12 % 12, k / 144].map(|v| v as f64 - 5.5);
        let r = p.iter().map(|v| v * v).sum::<f64>().sqrt();
        (255.0 - 40.0 * r).max(0.0) as u8
    };
    s.write("ball.raw", (0..1728).map(ball).collect::<Vec<u8>>());
    s.write(
        "ball.toml",
        "data = \"ball.raw\"\ndims = [12, 12, 12]\ntype = \"u8\"\n",
    );
    let point = |value, opacity| {
        format!("[[point]]\nvalue = {value}\nsrgb = [1, 0.5, 0]\nopacity = {opacity}\n")
    };
    s.write("tf.toml", point(50, 0.0) + &point(200, 0.8));
    let draw = |flags: &[&str]| {
        let own = [
            "--scene",
            "ball.toml",
            "--transfer",
            "tf.toml",
            "--method",
            "full",
        ];
        s.ok(&[&SMALL[..], &own, flags].concat());
        std::fs::read(s.path("r/frame.png")).unwrap()
    };
    let own = draw(&[]);
    assert_eq!(own, draw(&["--skip", "none"]));
    assert_eq!(own, draw(&["--simd", "scalar", "--threads", "1"]));
    for other in [
        &["--unlit"][..],
        &["--step", "2"],
        &["--jitter-rays"],
        &["--orbit", "80,-10,2"],
        &["--camera", "3,4,30"],
    ] {
        assert_ne!(own, draw(other), "{other:?}");
    }
}

#[test]
fn what_cannot_be_drawn_is_said() {
    let s = Scratch::new();
    let refused = |flags: &[&str], said: &str| {
        let ran = s.run(&[&SMALL[..], flags].concat());
        assert_eq!(ran.code, 2, "{flags:?}");
        assert!(
            ran.err.contains(said) && ran.err.lines().count() == 1,
            "{}",
            ran.err
        );
        assert!(!s.path("r").join("frame.png").exists());
    };
    let jet = ["--scene", "volume:jet:8"];
    let with = |flags: &[&'static str]| [&jet[..], flags].concat();
    refused(&["--scene", "volume:jett"], "did you mean `jet`");
    refused(&["--scene", "volume:jet:813"], "2 to 812");
    refused(&["--scene", "none.nii"], "none.nii: cannot be read");
    s.write(
        "bad.nrrd",
        "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 9999999 9999999 9999999\nencoding: raw\n\n",
    );
    refused(&["--scene", "bad.nrrd"], "bad.nrrd: dimensions");
    refused(&with(&["--step", "0"]), "step_voxels = 0");
    refused(&with(&["--terminate", "nan"]), "terminate = NaN");
    refused(&with(&["--transfer", "no.toml"]), "no.toml");
    refused(&with(&["--msaa", "4"]), "--msaa: not with a volume");
    refused(
        &with(&["--stereo", "--display", "quest-pro"]),
        "--stereo: not with a volume",
    );
    refused(&with(&["--skip", "hidden"]), "all or none");
    refused(&with(&["--orbit", "1"]), "35,20");
    refused(&["--orbit", "1,2"], "--orbit: only with a volume");
    refused(&with(&["--time", "1"]), "--time: not with a volume");
}
