use super::*;
use crate::reproduce::{Paper, check_published};

/// A clock that moves by 3 ms whenever it is read.
fn ticking() -> impl FnMut() -> Duration {
    let mut read = 0;
    move || {
        read += 1;
        Duration::from_millis(3 * read)
    }
}

fn small() -> Guenter2012 {
    Guenter2012 {
        size: UVec2::new(128, 72),
        moments: 1,
        antialiasing_frames: 2,
        antialiasing_size: UVec2::new(48, 27),
        ..Guenter2012::default()
    }
}

#[test]
fn everything_is_there() {
    let steps = std::cell::RefCell::new(Vec::new());
    let progress = |what: &str, done: f64| steps.borrow_mut().push((what.to_owned(), done));
    let found = small().run(&mut ticking(), &progress).unwrap();
    let steps = steps.into_inner();
    assert!(steps.windows(2).all(|w| w[0].1 <= w[1].1 + 1e-12));
    assert!((steps[steps.len() - 1].1 - 1.0).abs() < 1e-9);

    assert_eq!(found.table_1.cells.len(), 36);
    for cell in &found.table_1.cells {
        // Two frames, each between two readings of the clock.
        assert!((cell.times.median_ms() - 3.0).abs() < 1e-9);
        assert!((cell.times.total_ms() - 6.0).abs() < 1e-9);
    }
    assert_eq!(found.quality.rows.len(), 19);
    assert_eq!(found.antialiasing.len(), 7);
    check_published(&found.published(), Paper::Guenter2012, 37, 6, 33);

    let names: Vec<String> = found
        .reproduction()
        .files()
        .into_iter()
        .map(|f| f.0)
        .collect();
    for name in [
        "table1.csv",
        "fig10.svg",
        "fig13-b.svg",
        "antialiasing.csv",
        "report.html",
    ] {
        assert!(names.iter().any(|n| n == name), "{name} in {names:?}");
    }

    for row in &found.quality.rows {
        let sum: f64 = row.layer_samples.iter().sum();
        assert!((128.0 * 72.0 / sum - row.drawn_speedup).abs() < 1e-9);
    }
    let without = Guenter2012Outcome {
        antialiasing: Vec::new(),
        ..found
    };
    let files = without.reproduction().files();
    assert!(
        files
            .iter()
            .all(|(name, _)| !name.starts_with("antialiasing"))
    );
}

#[test]
fn the_full_columns_draw_every_pixel_and_the_others_fewer() {
    let asked = small();
    // Finer than that of the others: on a display too coarse for layers there would be none.
    let flight = asked.flight(UVec2::new(480, 270)).unwrap();
    let measure = |threads| {
        let informal = Acuity::from_quality_index(10.0).unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        let moments = shooter::moments(1);
        let run = || Table1::measure(&flight, informal, &moments, &mut ticking(), &mut || ());
        pool.install(run).unwrap()
    };
    let table = measure(2);
    let samples = |column| table.cell(StudyContent::Full, column).samples;
    assert_eq!(samples(Column::Plain), 480.0 * 270.0);
    assert_eq!(samples(Column::Reference), 480.0 * 270.0);
    assert!(samples(Column::Informal) < samples(Column::QualityA));
    assert!(samples(Column::QualityA) < samples(Column::QualityB));
    assert!(samples(Column::QualityB) < samples(Column::Plain));
    let idle = table.cell(StudyContent::NoRender, Column::QualityA);
    assert_eq!(idle.samples, 0.0);
    // Nothing depends on anything but what is asked and the clock.
    assert_eq!(measure(5), table);
}

#[test]
fn wrong_numbers_are_refused() {
    let run = |asked: Guenter2012| {
        asked
            .run(&mut ticking(), &|_, _| ())
            .unwrap_err()
            .to_string()
    };
    let none = Guenter2012 {
        moments: 0,
        ..small()
    };
    assert_eq!(run(none), "moments = 0: must be from 1 to 1000");
    let empty = Guenter2012 {
        size: UVec2::ZERO,
        ..small()
    };
    assert!(run(empty).contains("viewport"));
    let tiny = Guenter2012 {
        antialiasing_size: UVec2::new(8, 8),
        ..small()
    };
    assert!(run(tiny).contains("at least 11 pixels"));
}
