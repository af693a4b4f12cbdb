use std::sync::Arc;
use std::time::Duration;

use foveasim_assets::GeneratedScene;
use foveasim_models::{Acuity, GazeMode};

use super::*;
use crate::{GazeAt, Resolution, SweepDisplay};

fn display(fov: f64, width: u32) -> SweepDisplay {
    let pixels = Resolution::Pixels([width, width * 9 / 16]);
    pixels.display(fov, 0.5625).unwrap()
}

fn sweep(displays: Vec<SweepDisplay>) -> Sweep {
    Sweep {
        displays,
        acuities: vec![Acuity::default()],
        gazes: vec![GazeAt::Centre],
        gaze_mode: GazeMode::Tracked,
        margins_deg: vec![0.0],
        methods: Method::parse_list("full,layers:2,layers:3,fdm,vrs").unwrap(),
        terms: Arc::default(),
    }
}

fn scenes() -> Vec<VerifyScene> {
    let scene = |strands: u32| {
        let generated = GeneratedScene::Hairball { strands };
        VerifyScene {
            name: generated.to_string(),
            scene: generated.build(1),
            eye: Box::new(move |_| generated.camera(0.1, 1)),
            near_m: 0.05,
        }
    };
    vec![scene(10), scene(40), scene(80)]
}

#[test]
fn cells_are_drawn_and_predicted() {
    let sweep = sweep(vec![
        display(60.0, 96),
        display(60.0, 128),
        display(90.0, 96),
        display(90.0, 160),
    ]);
    let scenes = scenes();
    let verify = Verify {
        sweep: &sweep,
        scenes: &scenes,
        cells: 40,
        rounds: 2,
        options: RenderOptions::default(),
        seed: 1,
    };
    // A clock that only ever goes on: times are all alike, and what they are made of is not to be told.
    let mut now = Duration::ZERO;
    let mut clock = || {
        now += Duration::from_millis(5);
        now
    };
    let found = verify.run(&mut clock, &|_, _| ()).unwrap();
    assert!(found.rows.len() >= 40);
    let fitted = found.rows.iter().filter(|r| r.held_out.is_none()).count();
    assert!(2 * fitted <= found.rows.len() && fitted > 0, "{fitted}");
    for why in [HeldOutFor::Scene, HeldOutFor::Size] {
        assert!(
            found.rows.iter().any(|r| r.held_out == Some(why)),
            "{why:?}"
        );
    }
    for row in &found.rows {
        assert!(
            (row.measured_ms - 5.0).abs() < 1e-9 && row.predicted_ms > 0.0,
            "{row:?}"
        );
        let largest = row.size == [160, 90];
        assert!(!largest || row.held_out.is_some());
        assert_eq!(row.terms.len(), found.coefficients.len());
    }
    // Full resolution stands beside every cell.
    assert!(
        found
            .rows
            .iter()
            .all(|r| { r.method == Method::Full || found.ratio_errors(r).is_some() })
    );
    assert_eq!(found.table().rows().len(), found.rows.len());
    assert!(found.sentence().contains("no fit has seen"));
    assert!(found.scatter().svg().contains("held out"));
}

#[test]
fn what_cannot_be_verified_is_refused() {
    let scenes = scenes();
    let whole = sweep(vec![display(60.0, 96)]);
    let verify = |sweep, cells, rounds| Verify {
        sweep,
        scenes: &scenes,
        cells,
        rounds,
        options: RenderOptions::default(),
        seed: 1,
    };
    let refused = |v: Verify<'_>| {
        let error = v.run(&mut || Duration::ZERO, &|_, _| ()).unwrap_err();
        error.to_string()
    };
    assert!(refused(verify(&whole, 3, 2)).contains("cells to be drawn = 3"));
    assert!(refused(verify(&whole, 60, 1)).contains("rounds = 1"));
    let text = refused(verify(&whole, 60, 2));
    assert!(text.contains("cells that can be drawn = 15"), "{text}");
    let sharp = Resolution::Sharpness(0.5).display(60.0, 0.5625).unwrap();
    assert!(refused(verify(&sweep(vec![sharp]), 60, 2)).contains("whole pixels"));
}
