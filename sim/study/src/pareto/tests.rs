use std::time::Duration;

use foveasim_assets::{GeneratedScene, Scene};
use foveasim_models::{Acuity, Eye, Viewport};
use glam::UVec2;

use super::*;

fn pareto(scene: &Scene, frames: usize) -> Pareto<'_> {
    let viewport = Viewport::symmetric(UVec2::new(320, 180), 0.8).unwrap();
    let eye = GeneratedScene::Hairball { strands: 30 };
    let frame = |k: usize| ClipFrame {
        sight: Sight {
            scene,
            world_from_eye: eye.camera(0.01 * k as f64, 1),
            scan: None,
        },
        gaze: GazeDirection::new(3.0 * k as f64, 0.0),
        believed: GazeDirection::AHEAD,
    };
    Pareto {
        clips: vec![Clip {
            name: "hair".into(),
            frames: (0..frames).map(frame).collect(),
            first_frame: 0,
        }],
        methods: Method::parse_list("vrs,kfr:2:4,full,vrs").unwrap(),
        request: Request {
            eye: Eye::Cyclopean,
            viewport,
            acuity: Acuity::default(),
            gaze: GazeDirection::AHEAD,
            ahead: GazeDirection::AHEAD,
            margin_deg: 0.0,
        },
        drawing: Drawing {
            reference_samples: 2,
            ..Drawing::default()
        },
        rings: Rings::default(),
        warm_up: 1,
        terms: Terms::default(),
    }
}

fn scene() -> Scene {
    GeneratedScene::Hairball { strands: 30 }.build(1)
}

fn run(asked: &Pareto<'_>, timing: Timing<'_, '_>) -> ParetoOutcome {
    let mut steps = 0;
    let found = asked.run(
        timing,
        &mut |_, _, _, _, _| Ok::<(), FrameError>(()),
        &mut || {
            steps += 1;
        },
    );
    assert!(steps > 0);
    found.unwrap()
}

#[test]
fn methods_are_judged_and_the_front_is_theirs() {
    let scene = scene();
    let asked = pareto(&scene, 3);
    let found = run(&asked, Timing::Predicted);
    let names: Vec<String> = found.methods.iter().map(Method::to_string).collect();
    assert_eq!(names, ["full", "vrs", "kfr:2:4"]);
    assert_eq!(found.rows.len(), 2 * 3);
    // The same again: nothing depends on when or where.
    assert_eq!(found, run(&asked, Timing::Predicted));
    let row = |k: usize| &found.rows[k];
    assert!(row(0).errors.ssim > row(2).errors.ssim);
    assert_eq!(row(0).samples, 320.0 * 180.0);
    assert!(row(1).shadings < row(0).shadings && row(2).samples < row(0).samples);
    assert!(row(0).errors.followed.is_some());
    // Rings hold all pixels of the judged frames.
    let pixels: u64 = row(0).errors.rings.iter().map(|r| r.pixels).sum();
    assert_eq!(pixels, 2 * 320 * 180);
    let measure = ErrorMeasure::Dssim;
    for r in found.overall() {
        let dominated = found
            .overall()
            .any(|o| o.time_ms < r.time_ms && measure.of(o).unwrap() < measure.of(r).unwrap());
        assert_eq!(found.on_front(r, measure), Some(!dominated), "{}", r.method);
    }
    let [best, worst] = [0, 2].map(|k| measure.of(row(k)).unwrap());
    let answer = found.cheapest(measure, worst);
    let least = found
        .overall()
        .map(|r| r.time_ms)
        .fold(f64::INFINITY, f64::min);
    assert_eq!(answer.time_ms, least);
    assert!(answer.to_string().contains("takes least"), "{answer}");
    let none = found.cheapest(measure, best / 2.0);
    assert!(none.method.is_none() && none.to_string().contains("No method is within"));
    assert!(found.chart(measure).svg().contains("front"));
    assert_eq!(found.table().rows().len(), 6);
}

#[test]
fn times_are_of_all_in_turn() {
    let scene = scene();
    let mut now = Duration::ZERO;
    let mut clock = || {
        now += Duration::from_millis(4);
        now
    };
    let found = run(&pareto(&scene, 2), Timing::Measured(&mut clock, 2));
    assert!(found.rows.iter().all(|r| (r.time_ms - 4.0).abs() < 1e-9));
    assert!(found.noise.unwrap() < 1e-9 && found.measured);
    // A frame by itself does not flicker.
    assert!(found.rows.iter().all(|r| r.errors.flicker.is_none()));
    let answer = found.cheapest(ErrorMeasure::Dssim, 1.0);
    assert!(
        answer.next.is_some() && answer.to_string().contains("cannot be told from it"),
        "{answer}"
    );
}

#[test]
fn exported_frames_come_back_as_scores() {
    let scene = scene();
    let asked = pareto(&scene, 3);
    let rate = foveasim_models::Rate::from_hz("rate", 60.0).unwrap();
    let mut export = Export::new(asked.request.viewport, rate);
    let mut names = Vec::new();
    let mut found = asked
        .run(
            Timing::Predicted,
            &mut |clip, method, number, frame, reference| {
                let files = export
                    .frame(clip, method, number, frame, reference)
                    .unwrap();
                names.extend(files.into_iter().map(|(name, _)| name));
                Ok::<(), FrameError>(())
            },
            &mut || (),
        )
        .unwrap();
    names.sort();
    assert_eq!(names.len(), 4 * 2, "{names:?}");
    assert!(
        names.contains(&"hair/kfr-2-4/0001.png".to_owned()),
        "{names:?}"
    );
    assert!(names.contains(&"hair/reference/0000.png".to_owned()));
    let files = export.finish(&asked);
    let text = |name: &str| &files.iter().find(|(n, _)| n == name).unwrap().1;
    // Where the eye really looks: it moves to the right from frame to frame.
    let gaze: Vec<f64> = text("hair/gaze.csv")
        .lines()
        .skip(1)
        .map(|l| l.split(',').nth(1).unwrap().parse().unwrap())
        .collect();
    assert!(gaze.len() == 2 && gaze[1] > gaze[0] + 5.0, "{gaze:?}");
    assert!(text("display_models.json").contains("\"resolution\": [320, 180]"));
    assert!(serde_json::from_str::<serde_json::Value>(text("display_models.json")).is_ok());
    assert!(text("score.py").contains("FRAMES_PER_SECOND = 60"));
    assert_eq!(text("index.csv").lines().count(), 4);
    let scores = Scores::parse("clip,method,jod\nhair,vrs,9.5\n", "s.csv").unwrap();
    found.join(&scores);
    let jod: Vec<Option<f64>> = found.overall().map(|r| r.jod).collect();
    assert_eq!(jod, [None, Some(9.5), None]);
    assert_eq!(
        found.cheapest(ErrorMeasure::Jod, 1.0).method,
        Some(found.methods[1])
    );
}
