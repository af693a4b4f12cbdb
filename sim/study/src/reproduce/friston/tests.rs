use std::time::Duration;

use super::*;
use crate::reproduce::{Paper, check_published};

fn tiny() -> Friston2019 {
    Friston2019 {
        size: UVec2::splat(96),
        scenes: vec![GeneratedScene::Room { bars: 6 }],
        reference_samples: 2,
        ..Friston2019::quick()
    }
}

#[test]
fn every_row_is_there_and_means_something() {
    let asked = std::cell::Cell::new(0u64);
    let mut clock = || {
        asked.set(asked.get() + 1);
        Duration::from_millis(asked.get() * asked.get())
    };
    let found = tiny().run(&mut clock, &|_, _| ()).unwrap();
    assert_eq!(found.foveated.len(), FoveatedWay::ALL.len());
    let pixels = 96.0 * 96.0;
    for row in &found.strengths {
        let off = row.samples as f64 / pixels - 1.0;
        assert!(off.abs() < 0.03, "{}: {off}", row.method);
        assert!((0.0..=1.0).contains(&row.ssim) && row.buffer_samples >= row.samples);
    }
    for row in &found.foveated {
        let way = row.way;
        assert_eq!(row.ssim.is_none(), way == FoveatedWay::Traced);
        assert!(row.samples > 0 && row.over_common > 0.0);
        assert!(
            row.efficiency.is_none_or(|e| e > 0.0 && e <= 1.0),
            "{way:?}"
        );
    }
    assert_eq!(found.foveated[0].over_common, 1.0);
    assert_eq!(found.rolling.len(), RollingWay::ALL.len());
    let rolling = |way| found.rolling.iter().find(|r| r.way == way).unwrap();
    let ours = rolling(RollingWay::Rolling(Bound::Conservative));
    let [warped, common] = [RollingWay::Warped, RollingWay::Common].map(rolling);
    assert_eq!((ours.ssim, ours.missed), (1.0, Some(0)));
    assert!(
        common.ssim < warped.ssim && warped.ssim < 1.0,
        "{common:?} {warped:?}"
    );
    assert!(warped.disoccluded.unwrap() > 0.0 && warped.disoccluded.unwrap() < 0.2);
    assert!(found.both.iter().all(|r| r.ssim > 0.0 && r.ssim <= 1.0));
    assert_eq!((found.shadows.len(), found.efficiency.len()), (2, 4));
    // A head that only moves by its sway changes little; a turn changes more.
    let still = found
        .turns
        .iter()
        .find(|r| r.way == RollingWay::Common)
        .unwrap();
    assert!(still.turn_deg == 0.0 && still.ssim > common.ssim);
    let numbers = found.published();
    let explained = numbers
        .iter()
        .filter(|p| p.why().is_some() && !p.is_measured());
    let explained = explained.count();
    // Likeness of lattices and the best strength depend on the scene; head poses are always of another head.
    assert!((4..=10).contains(&explained), "{numbers:?}");
    check_published(&numbers, Paper::Friston2019, 15 - explained, explained, 3);
    let names: Vec<String> = found
        .reproduction()
        .unwrap()
        .files()
        .into_iter()
        .map(|(name, _)| name)
        .collect();
    for name in [
        "fig12-foveated.csv",
        "fig12-rolling.csv",
        "fig13-turn.csv",
        "fig14.csv",
        "fig15-box.png",
        "fig8-room.png",
        "head.csv",
        "report.html",
    ] {
        assert!(names.iter().any(|n| n == name), "{name}");
    }
}

#[test]
fn head_poses_are_what_formulas_say() {
    let rows = head::rows(1).unwrap();
    for row in &rows {
        if let Some(exact) = row.exact_deg {
            // Velocity is taken from the last two samples, and for quaternions is not quite an angle's.
            let bound = if row.predictor == foveasim_models::HeadPredictor::Constant {
                1e-3
            } else {
                0.12
            };
            assert!((row.rotation_deg / exact - 1.0).abs() < bound, "{row:?}");
        }
    }
    let exact: Vec<f64> = rows.iter().filter_map(|r| r.exact_deg).collect();
    assert!((exact[0] - 0.0778).abs() < 1e-4 && (exact[1] - 1.4832).abs() < 1e-4);
    assert_eq!(rows.len(), 4);
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let run = |asked: Friston2019| {
        let mut clock = || Duration::ZERO;
        asked.run(&mut clock, &|_, _| ()).unwrap_err().to_string()
    };
    let small = Friston2019 {
        size: UVec2::new(96, 40),
        ..tiny()
    };
    assert!(run(small).contains("pixels along a side = 40: must be from 64"));
    assert!(
        run(Friston2019 {
            rounds: 0,
            ..tiny()
        })
        .contains("rounds = 0")
    );
    assert!(
        run(Friston2019 {
            scenes: vec![],
            ..tiny()
        })
        .contains("scenes = 0")
    );
}
