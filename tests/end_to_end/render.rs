//! How a frame is drawn: antialiasing, skips, levels of detail, frame sequences, every method.

use std::collections::HashMap;

use crate::scratch::{Scratch, number, rows};

/// Few pixels, and a slope so steep that layers are still of use.
const SMALL: [&str; 6] = ["--size", "160x90", "--slope", "j:4", "--format", "csv"];

/// What `render` with these flags says of the whole image, and its counters: of the frame and of the
/// reference, all passes together.
fn render(scratch: &Scratch, flags: &[&str]) -> (f64, [HashMap<String, String>; 2]) {
    let words = [&["render", "--out", "r"], &SMALL[..], flags].concat();
    let quality = rows(&scratch.ok(&words));
    let work = rows(&scratch.read("r/work.csv"));
    let all = |image: &str| {
        let mut found = work.iter();
        let row = found.find(|r| r["image"] == image && r["pass"] == "all");
        row.expect("a row for all passes").clone()
    };
    (
        number(&quality[0], "ssim"),
        [all("frame"), all("reference")],
    )
}

/// The decoded pixels of a picture.
fn pixels(scratch: &Scratch, name: &str) -> Vec<u8> {
    let picture = image::open(scratch.path(name)).expect("a picture");
    picture.into_rgb8().into_raw()
}

#[test]
fn multisampling_is_drawn_and_counted() {
    let s = Scratch::new();
    let truth = ["--method", "full", "--supersample", "6"];
    let (one, [work, _]) = render(&s, &truth);
    assert_eq!(number(&work, "samples_with_edge"), 0.0);
    let (four, [work, _]) = render(&s, &[&truth[..], &["--msaa", "4"]].concat());
    assert!(number(&work, "samples_with_edge") > 0.0);
    assert!(four > one, "nearer to the truth: {four} {one}");
    // Full resolution beside itself.
    let (same, [frame, reference]) = render(&s, &["--method", "full", "--msaa", "4"]);
    assert_eq!(same, 1.0);
    assert_eq!(frame["samples_tested"], reference["samples_tested"]);
}

#[test]
fn skips_leave_the_picture_as_it_is() {
    let s = Scratch::new();
    let picture = |list: &str| {
        let (_, [work, _]) = render(&s, &["--method", "layers:3", "--skip", list]);
        (pixels(&s, "r/frame.png"), work)
    };
    let (all, least) = picture("all");
    let (same, most) = picture("back-faces");
    assert!(all == same, "back faces alone may change the picture");
    for (counter, less) in [
        ("triangles_set_up", "triangles_set_up"),
        ("samples_tested", "samples_tested"),
        ("samples_shaded", "samples_shaded"),
        ("vertices", "vertices"),
    ] {
        assert!(
            number(&least, counter) <= number(&most, less),
            "{counter}: {} {}",
            least[counter],
            most[counter]
        );
    }
    assert!(number(&least, "vertices") < number(&most, "vertices"));
    assert!(number(&least, "samples_hidden") > 0.0);
    assert_eq!(number(&most, "samples_hidden"), 0.0);
    let (_, none) = picture("none");
    assert_eq!(number(&none, "triangles_back_facing"), 0.0);
}

#[test]
fn levels_of_detail_are_chosen() {
    let s = Scratch::new();
    let triangles = |lod: &str| {
        let (_, [work, _]) = render(&s, &["--method", "full", "--lod", lod]);
        number(&work, "triangles")
    };
    let [finest, distance, footprint] = ["finest", "distance", "footprint"].map(triangles);
    assert!(
        finest > distance && distance > footprint,
        "{finest} {distance} {footprint}"
    );
}

#[test]
fn frames_follow_one_another() {
    let s = Scratch::new();
    // In odd frames the only outer layer waits.
    let shot = ["--frame", "1501", "--msaa", "4"];
    render(&s, &shot);
    let still = pixels(&s, "r/frame.png");
    let frames = [&shot[..], &["--frames", "4"]].concat();
    let (_, [work, _]) = render(&s, &frames);
    assert!(number(&work, "samples_reprojected") > 0.0);
    assert!(pixels(&s, "r/frame.png") != still, "blended with a history");
    let (_, [off, _]) = render(&s, &[&frames[..], &["--temporal", "off"]].concat());
    assert_eq!(number(&off, "samples_reprojected"), 0.0);
    assert!(pixels(&s, "r/frame.png") == still, "each frame by itself");
    let turns = [&frames[..], &["--staggered", "--all-frames"]].concat();
    let (_, [work, _]) = render(&s, &turns);
    assert_eq!(number(&work, "passes_not_due"), 1.0);
    let names = s.names("r");
    for number in 1498..=1501 {
        let name = format!("frame-{number}.png");
        assert!(names.contains(&name), "{name} in {names:?}");
    }
    assert!(pixels(&s, "r/frame-1501.png") == pixels(&s, "r/frame.png"));
    assert!(pixels(&s, "r/frame-1498.png") != pixels(&s, "r/frame.png"));
}

#[test]
fn every_method_is_drawn() {
    let s = Scratch::new();
    for method in [
        "full",
        "layers:4",
        "vrs",
        "fdm",
        "rates",
        "quad",
        "vrs:fixed",
    ] {
        let (ssim, [frame, reference]) = render(&s, &["--method", method, "--msaa", "4"]);
        assert!(ssim > 0.6, "{method}: {ssim}");
        let shaded = |w| number(w, "samples_shaded") + number(w, "samples_sky");
        assert!(shaded(&frame) <= shaded(&reference), "{method}");
    }
}

#[test]
fn a_report_compares_every_method() {
    let s = Scratch::new();
    s.write(
        "all.toml",
        "method = \"vrs,full,layers:3,fdm,rates,quad,quad:fixed\"\nruns = 1000\nimages = 1\n\
         fov = \"60,90\"\nppd_centre = \"20\"\n",
    );
    s.ok(&["run", "all.toml", "--out", "o"]);
    let summary = rows(&s.read("o/summary.csv"));
    assert_eq!(summary.len(), 7);
    for row in &summary {
        let method = &row["method"];
        if method != "full" {
            assert!(number(row, "ssim") > 0.6, "{method}");
            // Fixed quad views may need more than full resolution.
            let saves = number(row, "shading_ratio") > 1.0;
            assert!(saves || method == "quad:fixed", "{method}");
        }
    }
    let html = s.read("o/report.html");
    for method in ["vrs", "fdm", "rates", "quad:fixed"] {
        assert!(html.contains(method), "{method}");
    }
    // The first method but full is the one that is shown.
    assert!(s.names("o").contains(&"moment-1-frame.png".to_owned()));
}

#[test]
fn flags_that_cannot_be_meant() {
    let s = Scratch::new();
    for (flags, parts) in [
        (vec!["--msaa", "2"], vec!["--msaa", "want 1 or 4"]),
        (
            vec!["--skip", "hiden"],
            vec!["--skip", "did you mean `hidden`?"],
        ),
        (vec!["--lod", "fine"], vec!["--lod", "finest"]),
        (vec!["--supersample", "17"], vec!["--supersample", "1..=16"]),
        (vec!["--frames", "0"], vec!["--frames", "1..=5377"]),
        (vec!["--staggered"], vec!["--staggered: needs --frames"]),
        (vec!["--all-frames"], vec!["--all-frames: needs --frames"]),
        (
            vec!["--temporal", "jitter"],
            vec!["--temporal: needs --frames"],
        ),
        (
            vec!["--frames", "9", "--frame", "3"],
            vec!["--frames 9", "has 4 up to --frame 3"],
        ),
        (
            vec!["--frames", "601", "--frame", "900", "--all-frames"],
            vec!["at most 600"],
        ),
    ] {
        let words = [&["render", "--out", "x"], &flags[..]].concat();
        let ran = s.run(&words);
        assert_eq!(ran.code, 2, "{words:?}: {}", ran.out);
        assert_eq!(ran.err.trim_end().lines().count(), 1, "{}", ran.err);
        for part in parts {
            assert!(
                ran.err.contains(part),
                "{words:?} says {part:?}: {}",
                ran.err
            );
        }
    }
    assert!(!s.path("x").exists());
}

#[test]
fn both_eyes_and_what_they_share() {
    let s = Scratch::new();
    let words = "render --stereo --display quest-pro --size 96x100 --method efr:2:3 --gaze-distance 2 --passes --format csv --out e";
    let quality = rows(&s.ok(&words.split(' ').collect::<Vec<_>>()));
    assert!(
        quality.iter().any(|r| r["eye"] == "left") && quality.iter().any(|r| r["eye"] == "right")
    );
    let (left, right) = (pixels(&s, "e/left.png"), pixels(&s, "e/right.png"));
    assert!(left.len() == 3 * 96 * 100 && right.len() == left.len() && left != right);
    // W/σ × H/σ samples: the right eye is dominant.
    assert_eq!(pixels(&s, "e/left-pass-0.png").len(), 3 * 32 * 34);
    assert_eq!(pixels(&s, "e/right-pass-0.png").len(), 3 * 48 * 50);
    let work = rows(&s.read("e/work.csv"));
    let of = |eye: &str, pass: &str| {
        let mut found = work.iter();
        let row = found.find(|r| r["eye"] == eye && r["image"] == "frame" && r["pass"] == pass);
        row.expect("a row").clone()
    };
    let vertices = |row| number(&row, "vertices");
    assert!(vertices(of("both", "shared")) > 0.0);
    assert_eq!(vertices(of("both", "all")), vertices(of("both", "shared")));
    let again = words.replace("--out e", "--skip occluded --out f");
    s.ok(&again.split(' ').collect::<Vec<_>>());
    assert!(pixels(&s, "f/left.png") == left && pixels(&s, "f/right.png") == right);
}

#[test]
fn rolling_and_lens_change_the_picture() {
    let s = Scratch::new();
    let picture = |flags: &[&str]| {
        let (ssim, _) = render(&s, &[&["--method", "radial:2"], flags].concat());
        (pixels(&s, "r/frame.png"), ssim)
    };
    let (still, ssim) = picture(&[]);
    assert!(ssim > 0.8, "{ssim}");
    // The camera flies on, by little; the head turns by degrees.
    let (flown, _) = picture(&["--rolling"]);
    let (turned, ssim) = picture(&["--rolling", "--head-velocity", "500,0"]);
    assert!(still != flown && flown != turned);
    // Its reference rolls, too.
    assert!(ssim > 0.8, "{ssim}");
    let (seen, _) = picture(&["--lens", "0.2,0.1"]);
    let (coloured, _) = picture(&["--lens", "0.2,0.1,0.99,1,1.01"]);
    assert!(still != seen && seen != coloured);
    // Nothing magnified, nothing moved.
    let (one, _) = render(&s, &["--method", "radial:1"]);
    assert_eq!(one, 1.0);
    for bound in ["box", "simple", "adaptive", "conservative"] {
        let (_, [work, _]) = render(&s, &["--method", "full", "--rolling", "--bound", bound]);
        assert!(number(&work, "samples_covered") > 0.0);
    }
}

#[test]
fn a_recorded_head_rolls_the_picture() {
    let s = Scratch::new();
    s.ok(&["trace", "synth", "--duration", "2s", "--to", "t.csv"]);
    let picture = |at: &str| {
        let flags = ["--method", "full", "--rolling", "--scan-ms", "50"];
        render(
            &s,
            &[&flags[..], &["--head-trace", "t.csv", "--at", at]].concat(),
        );
        pixels(&s, "r/frame.png")
    };
    assert!(picture("0.3") != picture("1.1"), "the head moves otherwise");
    let words = "render --size 96x54 --rolling --head-trace t.csv --at 99 --out r";
    let ran = s.run(&words.split(' ').collect::<Vec<_>>());
    assert!(ran.code == 2 && ran.err.contains("--at 99"), "{}", ran.err);
}
