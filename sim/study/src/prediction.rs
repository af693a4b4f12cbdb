use foveasim_models::math::{quantile_sorted, sqrt, sum};
use foveasim_models::{HeadPredictor, HeadTracker, Nanos, Pose, PoseSeries, Recording};
use foveasim_reports::{Cell, LineChart, LineSeries, Table};
use foveasim_traces::{TraceError, require_pose};

/// Horizons by default \[ms\]: what render and display together take.
const HORIZONS_MS: [f64; 12] = [
    5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0,
];
/// Holes longer than this are not predicted across by default.
const MAX_GAP: Nanos = Nanos(100_000_000);

/// How well head pose is predicted on a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictionStudy {
    /// The predictors that are compared.
    pub predictors: Vec<HeadPredictor>,
    /// How far ahead.
    pub horizons: Vec<Nanos>,
    /// A hole longer than this is neither predicted nor judged across.
    pub max_gap: Nanos,
}

impl Default for PredictionStudy {
    fn default() -> Self {
        Self {
            predictors: HeadPredictor::ALL.to_vec(),
            horizons: HORIZONS_MS.map(Nanos::from_ms).to_vec(),
            max_gap: MAX_GAP,
        }
    }
}

/// Size of an error over a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorSpread {
    /// Root mean square.
    pub rms: f64,
    /// Median.
    pub p50: f64,
    /// 95 % quantile.
    pub p95: f64,
    /// Largest.
    pub max: f64,
}

impl ErrorSpread {
    fn new(mut errors: Vec<f64>) -> Self {
        let squares: Vec<f64> = errors.iter().map(|e| e * e).collect();
        let rms = sqrt(sum(&squares) / errors.len() as f64);
        errors.sort_unstable_by(f64::total_cmp);
        Self {
            rms,
            p50: quantile_sorted(&errors, 0.5),
            p95: quantile_sorted(&errors, 0.95),
            max: quantile_sorted(&errors, 1.0),
        }
    }
}

/// Errors of one predictor at one horizon.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictionRow {
    /// The predictor.
    pub predictor: HeadPredictor,
    /// How far ahead.
    pub horizon: Nanos,
    /// Predictions judged.
    pub samples: usize,
    /// Distance from where the head was \[mm\].
    pub translation_mm: ErrorSpread,
    /// Angle to how it was turned \[deg\].
    pub rotation_deg: ErrorSpread,
}

/// Errors on one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// The recording.
    pub source: String,
    /// One row per predictor and horizon.
    pub rows: Vec<PredictionRow>,
}

impl PredictionStudy {
    /// Predicts from every sample of a recording, and compares with where the head was then.
    ///
    /// Predictors see the samples up to each and no later one. All are judged from the third sample on, at the start
    /// and after each loss or hole: before, some know how the head moves and some cannot. The truth between samples is interpolated
    /// (linear and along the great arc), and not judged next to a loss or in a hole.
    ///
    /// # Errors
    /// If the recording has no head pose.
    ///
    /// # Panics
    /// If a predictor has settings out of range ([`HeadTracker::new`] says which).
    pub fn run(&self, recording: &Recording) -> Result<Prediction, TraceError> {
        let poses = require_pose(recording)?;
        let rows = self.predictors.iter().flat_map(|p| self.rows(*p, poses));
        Ok(Prediction {
            source: recording.source.clone(),
            rows: rows.collect(),
        })
    }

    fn rows(&self, predictor: HeadPredictor, poses: &PoseSeries) -> Vec<PredictionRow> {
        let mut head =
            HeadTracker::new(predictor, self.max_gap).expect("settings were checked by the caller");
        let mut judge = HeadTracker::new(HeadPredictor::Acceleration, self.max_gap)
            .expect("this one has no settings");
        let mut errors: Vec<(Vec<f64>, Vec<f64>)> = vec![Default::default(); self.horizons.len()];
        for sample in poses.samples() {
            head.observe(*sample);
            judge.observe(*sample);
            if sample.value.is_none() || !judge.is_settled() {
                continue;
            }
            for (horizon, (moved, turned)) in self.horizons.iter().zip(&mut errors) {
                let then = sample.t + *horizon;
                let truth: Option<Pose> = poses.at(then, self.max_gap);
                if let Some((got, want)) = head.predict(then).zip(truth) {
                    moved.push(1e3 * (got.position - want.position).length());
                    turned.push(got.angle_to_deg(want));
                }
            }
        }
        let row = |(horizon, (moved, turned)): (&Nanos, (Vec<f64>, Vec<f64>))| PredictionRow {
            predictor,
            horizon: *horizon,
            samples: moved.len(),
            translation_mm: ErrorSpread::new(moved),
            rotation_deg: ErrorSpread::new(turned),
        };
        self.horizons.iter().zip(errors).map(row).collect()
    }
}

impl Prediction {
    /// One row per predictor and horizon. `…_over_constant` is the RMS error over that of the pose that
    /// stays: below 1 the predictor is the better one.
    pub fn table(&self) -> Table {
        let mut table = Table::new([
            "file",
            "predictor",
            "horizon_ms",
            "samples",
            "rotation_rms_deg",
            "rotation_p50_deg",
            "rotation_p95_deg",
            "rotation_max_deg",
            "rotation_over_constant",
            "translation_rms_mm",
            "translation_p50_mm",
            "translation_p95_mm",
            "translation_max_mm",
            "translation_over_constant",
        ]);
        let number = |v: f64| if v.is_finite() { v.into() } else { Cell::Empty };
        for row in &self.rows {
            let constant = self.find(HeadPredictor::Constant, row.horizon);
            let spread = |e: ErrorSpread| [e.rms, e.p50, e.p95, e.max].map(number);
            let over = |pick: fn(&PredictionRow) -> f64| -> Cell {
                constant.map_or(Cell::Empty, |c| number(pick(row) / pick(c)))
            };
            let mut cells = vec![
                self.source.as_str().into(),
                row.predictor.name().into(),
                row.horizon.as_ms().into(),
                row.samples.into(),
            ];
            cells.extend(spread(row.rotation_deg));
            cells.push(over(|r| r.rotation_deg.rms));
            cells.extend(spread(row.translation_mm));
            cells.push(over(|r| r.translation_mm.rms));
            table.push(cells);
        }
        table
    }

    /// The row of a predictor at a horizon.
    pub fn find(&self, predictor: HeadPredictor, horizon: Nanos) -> Option<&PredictionRow> {
        let is = |r: &&PredictionRow| r.predictor == predictor && r.horizon == horizon;
        self.rows.iter().find(is)
    }

    /// RMS error of rotation over the horizon, a line per predictor.
    pub fn rotation_chart(&self) -> LineChart {
        self.chart("Head rotation ahead", "RMS error [deg]", |r| {
            r.rotation_deg.rms
        })
    }

    /// RMS error of translation over the horizon, a line per predictor.
    pub fn translation_chart(&self) -> LineChart {
        self.chart("Head translation ahead", "RMS error [mm]", |r| {
            r.translation_mm.rms
        })
    }

    fn chart(&self, title: &str, y_label: &str, pick: fn(&PredictionRow) -> f64) -> LineChart {
        let mut series: Vec<LineSeries> = Vec::new();
        for row in &self.rows {
            let label = row.predictor.name();
            if series.last().is_none_or(|s| s.label != label) {
                series.push(LineSeries {
                    label: label.into(),
                    points: Vec::new(),
                });
            }
            if let Some(line) = series.last_mut() {
                line.points.push([row.horizon.as_ms(), pick(row)]);
            }
        }
        LineChart {
            title: title.into(),
            x_label: "horizon [ms]".into(),
            y_label: y_label.into(),
            series,
            ..LineChart::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::{Provenance, Sample, Series, exp_so3};
    use glam::DVec3;

    use super::*;

    /// A head that turns by A·sin 2πft about Y, 72 samples a second, rounded to `step` deg.
    fn recording(amplitude_deg: f64, step: f64) -> Recording {
        let pose = |k: i64| {
            let t = Nanos(k * 1_000_000_000 / 72);
            let angle =
                amplitude_deg * foveasim_models::math::sin(std::f64::consts::TAU * t.as_secs());
            let angle = if step > 0.0 {
                (angle / step).round() * step
            } else {
                angle
            };
            let turn = exp_so3(DVec3::Y * foveasim_models::math::to_rad(angle));
            Sample {
                t,
                value: Some(Pose::new(DVec3::X * angle * 1e-3, turn)),
            }
        };
        Recording {
            pose: Some(Series::new((0..1440).map(pose).collect(), Provenance::Truth).unwrap()),
            ..Recording::default()
        }
    }

    #[test]
    fn velocity_helps_a_head_that_moves_and_not_one_that_is_rounded() {
        let study = PredictionStudy::default();
        let over = |r: &Recording, ms| {
            let out = study.run(r).unwrap();
            let at = |p| out.find(p, Nanos::from_ms(ms)).unwrap().rotation_deg.rms;
            at(HeadPredictor::AngularVelocity) / at(HeadPredictor::Constant)
        };
        assert!(over(&recording(20.0, 0.0), 20.0) < 0.2);
        assert!(over(&recording(0.2, 0.115), 10.0) > 1.2);
    }

    #[test]
    fn errors_are_those_of_the_closed_form_from_end_to_end() {
        use foveasim_models::math::{cos, sin, sqrt};
        // A lost sample amid, after which velocities must be learnt anew.
        let mut recording = recording(20.0, 0.0);
        let mut samples = recording.pose.unwrap().samples().to_vec();
        samples[700].value = None;
        recording.pose = Some(Series::new(samples, Provenance::Truth).unwrap());
        let h = 1.0 / 72.0;
        let (ahead, step) = (std::f64::consts::TAU * 2.0 * h, std::f64::consts::TAU * h);
        let study = PredictionStudy {
            horizons: vec![Nanos::from_ms(2e3 * h)],
            ..PredictionStudy::default()
        };
        let found = study.run(&recording).unwrap();
        // |e^{ix} − 1 − v|, v of the backward difference and of none.
        for (predictor, v) in [
            (HeadPredictor::Constant, [0.0, 0.0]),
            (
                HeadPredictor::AngularVelocity,
                [2.0 * (1.0 - cos(step)), 2.0 * sin(step)],
            ),
        ] {
            let row = found.find(predictor, study.horizons[0]).unwrap();
            let (re, im) = (cos(ahead) - 1.0 - v[0], sin(ahead) - v[1]);
            let amplitude = 20.0 * sqrt(re * re + im * im);
            let spread = row.rotation_deg;
            let off = |got: f64, want: f64| (got / want - 1.0).abs();
            assert!(off(spread.max, amplitude) < 1e-3, "{row:?}, {amplitude}");
            assert!(off(spread.rms, amplitude / sqrt(2.0)) < 1e-2, "{row:?}");
        }
    }

    #[test]
    fn a_table_row_per_predictor_and_horizon() {
        let out = PredictionStudy::default()
            .run(&recording(5.0, 0.0))
            .unwrap();
        assert_eq!(out.rows.len(), 6 * 12);
        assert_eq!(out.table().rows().len(), 6 * 12);
        // The first two samples do not tell how the head moves, the last have no truth 60 ms ahead.
        assert_eq!(
            out.find(HeadPredictor::Constant, Nanos::from_ms(60.0))
                .unwrap()
                .samples,
            1433
        );
        assert_eq!(out.rotation_chart().series.len(), 6);
        assert!(
            PredictionStudy::default()
                .run(&Recording::default())
                .is_err()
        );
    }
}
