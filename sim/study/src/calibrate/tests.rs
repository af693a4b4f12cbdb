use foveasim_models::{CostProfile, presets};

use super::*;

const GUENTER: &str = include_str!("../../../../examples/data/guenter2012-table1.csv");
const MENG: &str = include_str!("../../../../examples/data/meng2020-fig7.csv");

/// Rows whose times are known: 2 ms, 10 ns a shaded sample, 1 ns a pixel, each wrong by up to `noise`.
fn known(form: CostForm, noise: f64) -> CostRows {
    let truth = CostProfile {
        form,
        fixed_ms: 2.0,
        per_sample_ns: 10.0,
        per_pixel_ns: 3.0,
        ..presets::cost("guenter2012").unwrap()
    };
    let mut stream = Stream::new(7, Role::Population, 0);
    let rows = (0..24u32).map(|i| {
        let work = FrameWork {
            samples_shaded: f64::from(i % 6 + 1) * 2e5,
            pixels_resolved: f64::from(i / 6) * 7e5,
            passes: f64::from(i % 3),
            ..FrameWork::default()
        };
        CostRow {
            name: i.to_string(),
            group: String::new(),
            work,
            time_ms: truth.time_ns(&work) / 1e6 * (1.0 + stream.range(-noise, noise.max(1e-300))),
        }
    });
    CostRows {
        rows: rows.collect(),
        terms: vec![0, 2, 3],
    }
}

#[test]
fn what_made_the_rows_is_found() {
    for (i, form) in CostForm::ALL.into_iter().enumerate() {
        let exact = Calibration::new(known(form, 0.0), 1).unwrap();
        let values: Vec<f64> = exact.fits[i]
            .coefficients
            .iter()
            .map(Coefficient::value)
            .collect();
        let want = [2.0, 1e-5, 3e-6, 0.0];
        let close = values
            .iter()
            .zip(want)
            .all(|(v, w)| (v - w).abs() <= 1e-6 * w.max(1e-6));
        assert!(close, "{form:?}: {values:?}");
        assert_eq!(exact.best().form, form);
        let noisy = Calibration::new(known(form, 0.05), 1).unwrap();
        let best = &noisy.fits[i];
        let samples = best
            .coefficients
            .iter()
            .find(|c| c.name() == "samples_shaded")
            .unwrap();
        assert!(
            (samples.value() / 1e-5 - 1.0).abs() < 0.1,
            "{}",
            samples.value()
        );
        assert!(samples.interval[0] < samples.value() && samples.value() < samples.interval[1]);
        // Samples matter, passes do not.
        let error = median_error(&noisy.measured(), &best.left_out_ms);
        assert!(samples.error_without.unwrap() > 2.0 * error);
        assert_eq!(noisy, Calibration::new(known(form, 0.05), 1).unwrap());
    }
}

#[test]
fn a_profile_gives_back_what_was_fitted() {
    let calibration = Calibration::new(known(CostForm::Sum, 0.05), 1).unwrap();
    for fit in &calibration.fits {
        let profile = calibration.profile(fit, "mine", "rows.csv").unwrap();
        for (row, ms) in calibration.rows.rows.iter().zip(&fit.fitted_ms) {
            assert!((profile.time_ns(&row.work) / 1e6 / ms - 1.0).abs() < 1e-9);
            assert_eq!(profile.extrapolates(&row.work), None);
        }
        let text = toml::to_string(&profile).unwrap();
        assert_eq!(presets::parse_cost(&text, "mine").unwrap(), profile);
        let more = FrameWork {
            samples_shaded: 1e9,
            ..FrameWork::default()
        };
        assert_eq!(profile.extrapolates(&more), Some("samples_shaded"));
    }
}

/// One time for a sample does not say what scenes of different cost take, and the tables show it.
#[test]
fn published_rows_with_their_honest_errors() {
    let rows = CostRows::parse(GUENTER, "guenter2012-table1.csv").unwrap();
    assert_eq!(rows.rows.len(), 36);
    let all = Calibration::new(rows.clone(), 1).unwrap();
    assert!(median_error(&all.measured(), &all.best().left_out_ms) > 0.3);
    let full = Calibration::new(rows.of_group("Full").unwrap(), 1).unwrap();
    let error = median_error(&full.measured(), &full.best().left_out_ms);
    assert!(error < 0.12, "{error}");
    let meng = Calibration::new(CostRows::parse(MENG, "meng2020-fig7.csv").unwrap(), 1).unwrap();
    let error = median_error(&meng.measured(), &meng.best().left_out_ms);
    assert!(error < 0.15, "{error}");
    // The rule that time goes with samples is far off: a frame is not samples alone.
    let naive = median_error(&meng.measured(), meng.naive.as_ref().unwrap());
    assert!(naive > 2.0 * error, "{naive}");
    for calibration in [&all, &full, &meng] {
        assert!(calibration.residuals().svg().contains("error"));
        assert_eq!(calibration.errors().rows().len(), 5);
        assert_eq!(
            calibration.predictions().rows().len(),
            calibration.rows.rows.len()
        );
    }
}

#[test]
fn too_few_rows_are_refused() {
    let mut rows = known(CostForm::Sum, 0.0);
    rows.rows.truncate(4);
    assert!(Calibration::new(rows, 1).is_err());
}
