use std::sync::Arc;

use foveasim_models::ModelError;
use foveasim_models::foveation::Method;
use foveasim_reports::{Heatmap, Table};

use super::Growth;
use crate::{GazeAt, MapRatio, Scenario, Sweep, SweepDisplay, SweepRow, Terms};

/// What the methods save on the scenario's display, and what the featured one saves on others.
#[derive(Debug, Clone)]
pub struct Savings {
    /// Each method on the scenario's display, in the scenario's order.
    pub methods: Vec<MethodSaving>,
    /// The same with all columns.
    pub table: Table,
    /// Over field of view × pixels per degree, method by method, the featured one first; `full` is only there by itself.
    pub maps: Vec<(Method, Vec<SweepRow>)>,
    /// Over field of view on displays of the scenario's sharpness.
    pub growth: Growth,
    fov: Vec<f64>,
    ppd: Vec<f64>,
    featured: Method,
}

/// What one method needs on the scenario's display, gaze at the centre, all eyes.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodSaving {
    /// The method.
    pub method: Method,
    /// Samples per frame on average, each layer at its own cadence.
    pub samples_staggered: f64,
    /// Display pixels over samples.
    pub sample_ratio: f64,
    /// Display pixels over evaluations of shading.
    pub shading_ratio: f64,
    /// Display pixels over staggered evaluations of shading.
    pub shading_ratio_staggered: f64,
    /// Display pixels over staggered samples.
    pub sample_ratio_staggered: f64,
    /// Display pixels over the samples of the continuous falloff.
    pub ideal_ratio: f64,
    /// Frame time that the cost profile predicts, staggered \[ms\].
    pub predicted_ms: f64,
    /// Predicted time of `full` over this method's.
    pub predicted_speedup: f64,
    /// Whether acuity is used beyond where it was measured.
    pub extrapolated: bool,
}

pub(super) fn savings(scenario: &Scenario) -> Result<Savings, ModelError> {
    let terms = Arc::new(Terms {
        cost: scenario.cost.clone(),
        ..Terms::default()
    });
    let sweep = |displays, methods| Sweep {
        displays,
        acuities: vec![scenario.acuity],
        gazes: vec![GazeAt::Centre],
        gaze_mode: scenario.gaze_mode,
        margins_deg: vec![scenario.spec.margin_deg],
        methods,
        terms: terms.clone(),
    };
    let display = SweepDisplay::from(&scenario.display);
    let rows = sweep(vec![display], scenario.methods.clone()).run(|_| ())?;
    let featured = *scenario.featured();
    let foveated = scenario.methods.iter().copied();
    let others = foveated.filter(|m| *m != Method::Full && *m != featured);
    let mut maps = Vec::new();
    for method in [featured].into_iter().chain(others) {
        let rows = sweep(scenario.map.displays.clone(), vec![method]).run(|_| ())?;
        maps.push((method, rows));
    }
    let time = |row: &SweepRow| row.needs().frame_ms;
    let full = rows
        .iter()
        .find(|r| r.method == Method::Full)
        .map_or(f64::NAN, time);
    let methods = rows.iter().map(|row| MethodSaving {
        method: row.method,
        samples_staggered: row.method_samples_staggered,
        sample_ratio: row.sample_ratio(),
        shading_ratio: row.shading_ratio(),
        shading_ratio_staggered: row.shading_ratio_staggered(),
        sample_ratio_staggered: row.sample_ratio_staggered(),
        ideal_ratio: row.ideal_ratio(),
        predicted_ms: time(row),
        predicted_speedup: full / time(row),
        extrapolated: row.extrapolated,
    });
    Ok(Savings {
        methods: methods.collect(),
        table: SweepRow::table(&rows),
        maps,
        growth: Growth::new(scenario, &terms)?,
        fov: scenario.map.fov_deg.clone(),
        ppd: scenario.map.ppd_centre.clone(),
        featured,
    })
}

impl Savings {
    /// The method that the report explains in detail.
    pub fn featured(&self) -> &MethodSaving {
        let found = self.methods.iter().find(|m| m.method == self.featured);
        found.expect("the featured method is one of the scenario's")
    }

    /// All maps as a table, method by method.
    pub fn map_table(&self) -> Table {
        let rows: Vec<SweepRow> = self.maps.iter().flat_map(|(_, r)| r.clone()).collect();
        SweepRow::table(&rows)
    }

    /// Every method's map of a ratio as a picture, all in the same colours.
    pub fn heatmaps(&self, ratio: MapRatio) -> Vec<Heatmap> {
        let all = || self.maps.iter().flat_map(|(_, rows)| rows);
        let values = || all().map(|row| ratio.of(row)).filter(|v| v.is_finite());
        let ends = [
            values().fold(f64::INFINITY, f64::min),
            values().fold(f64::NEG_INFINITY, f64::max),
        ];
        let map = |(method, rows): &(Method, Vec<SweepRow>)| Heatmap {
            ends: Some(ends),
            ..SweepRow::heatmap(
                rows,
                ratio,
                match ratio {
                    MapRatio::Shading => format!("Times fewer shaded samples with {method}"),
                    MapRatio::Time => format!("Predicted speedup with {method}"),
                },
                self.fov.clone(),
                ("pixels per degree at the centre", self.ppd.clone()),
            )
        };
        self.maps.iter().map(map).collect()
    }
}
