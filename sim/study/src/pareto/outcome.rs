use foveasim_models::foveation::Method;
use foveasim_models::math::mean;
use foveasim_quality::psnr_db;
use foveasim_reports::{ScatterChart, ScatterSeries, Table};

use super::row::Errors;
use super::{ErrorMeasure, ParetoRow, Scores};

/// What a [`Pareto`](super::Pareto) found.
#[derive(Debug, Clone, PartialEq)]
pub struct ParetoOutcome {
    /// The methods, full resolution first.
    pub methods: Vec<Method>,
    /// For each clip a row for each method; then, of all clips together, the same once more.
    pub rows: Vec<ParetoRow>,
    /// By how much full resolution drawn again differed in time, as a share: the largest of the clips. `None` if no time
    /// was measured.
    pub noise: Option<f64>,
    /// Whether times were measured; else they are a cost profile's.
    pub measured: bool,
}

/// The name of all clips together.
const ALL: &str = "all";

impl ParetoOutcome {
    pub(super) fn new(
        methods: Vec<Method>,
        mut rows: Vec<ParetoRow>,
        noise: Option<f64>,
        measured: bool,
    ) -> Self {
        let overall: Vec<ParetoRow> = methods
            .iter()
            .filter_map(|&method| together(&rows, method))
            .collect();
        rows.extend(overall);
        Self {
            methods,
            rows,
            noise,
            measured,
        }
    }

    /// Rows of all clips together.
    pub fn overall(&self) -> impl Iterator<Item = &ParetoRow> {
        self.rows.iter().filter(|r| r.clip == ALL)
    }

    /// Time of full resolution on a clip \[ms\].
    pub(super) fn full_ms(&self, clip: &str) -> f64 {
        let full = |r: &&ParetoRow| r.clip == clip && r.method == Method::Full;
        self.rows.iter().find(full).map_or(f64::NAN, |r| r.time_ms)
    }

    /// Joins qualities that another program found; of all clips together, the mean. Rows without one keep none.
    pub fn join(&mut self, scores: &Scores) {
        for row in &mut self.rows {
            row.jod = scores.jod(&row.clip, row.method);
        }
        let of = |method: Method, rows: &[ParetoRow]| {
            let clips: Vec<Option<f64>> = rows
                .iter()
                .filter(|r| r.clip != ALL && r.method == method)
                .map(|r| r.jod)
                .collect();
            let known: Option<Vec<f64>> = clips.into_iter().collect();
            known.filter(|k| !k.is_empty()).map(|k| mean(&k))
        };
        for &method in &self.methods {
            let jod = of(method, &self.rows);
            let mut rows = self.rows.iter_mut();
            if let Some(row) = rows.find(|r| r.clip == ALL && r.method == method) {
                row.jod = jod;
            }
        }
    }

    /// Whether a row is on the front of its clip: no other method has both less time and less error, nor one of them
    /// less and the other the same. `None` where its error is not known.
    pub fn on_front(&self, row: &ParetoRow, measure: ErrorMeasure) -> Option<bool> {
        let error = measure.of(row)?;
        let beats = |other: &ParetoRow| {
            let Some(e) = measure.of(other) else {
                return false;
            };
            let less = other.time_ms < row.time_ms || e < error;
            less && other.time_ms <= row.time_ms && e <= error
        };
        let mut same = self.rows.iter().filter(|r| r.clip == row.clip);
        Some(!same.any(beats))
    }

    fn time_from(&self) -> &'static str {
        match self.measured {
            true => "measured",
            false => "cost profile",
        }
    }

    /// Every row, with whether it is on the front of its clip in each measure.
    pub fn table(&self) -> Table {
        let fronts = ErrorMeasure::ALL.map(|m| format!("on_front_{}", m.name()));
        let columns = ParetoRow::COLUMNS.map(str::to_owned);
        let mut table = Table::new(columns.into_iter().chain(fronts));
        for row in &self.rows {
            let mut cells = row.cells(self.full_ms(&row.clip), self.time_from());
            cells.extend(ErrorMeasure::ALL.map(|measure| {
                let on_front = self.on_front(row, measure);
                on_front.map(|on| if on { "yes" } else { "no" }).into()
            }));
            table.push(cells);
        }
        table
    }

    /// All clips together, in order of time: what there is to read on a terminal or a page.
    pub fn summary(&self, measure: ErrorMeasure) -> Table {
        let mut table = Table::new([
            "method",
            "time_ms",
            "speedup",
            "samples",
            "memory_mb",
            "ssim",
            "psnr_luma_db",
            "followed_flicker_grey_levels",
            "jod",
            "on_front",
        ]);
        let mut rows: Vec<_> = self.overall().collect();
        rows.sort_by(|a, b| a.time_ms.total_cmp(&b.time_ms));
        for row in rows {
            let on_front = self.on_front(row, measure);
            table.push(vec![
                row.method.to_string().into(),
                row.time_ms.into(),
                (self.full_ms(ALL) / row.time_ms).into(),
                row.samples.into(),
                row.memory_mb.into(),
                row.errors.ssim.into(),
                row.errors.psnr_db().into(),
                row.errors.followed.into(),
                row.jod.into(),
                on_front.map(|on| if on { "yes" } else { "no" }).into(),
            ]);
        }
        table
    }

    /// By ring of eccentricity: one row for each clip, method and ring that has pixels.
    pub fn rings(&self) -> Table {
        let mut table = Table::new([
            "clip",
            "method",
            "from_deg",
            "to_deg",
            "pixels",
            "ssim",
            "psnr_luma_db",
            "bias_grey_levels",
        ]);
        for row in &self.rows {
            for ring in row.errors.rings.iter().filter(|r| r.pixels > 0) {
                table.push(vec![
                    row.clip.as_str().into(),
                    row.method.to_string().into(),
                    ring.from_deg.into(),
                    ring.to_deg.into(),
                    ring.pixels.into(),
                    ring.ssim.into(),
                    ring.mse.map(psnr_db).into(),
                    ring.bias.into(),
                ]);
            }
        }
        table
    }

    /// Time against error over all clips, with the front.
    pub fn chart(&self, measure: ErrorMeasure) -> ScatterChart {
        let points = |on: bool| -> Vec<([f64; 2], String)> {
            let mut rows: Vec<_> = self
                .overall()
                .filter(|r| self.on_front(r, measure) == Some(on))
                .filter_map(|r| Some(([r.time_ms, measure.of(r)?], r.method.to_string())))
                .collect();
            rows.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
            rows
        };
        let series = |label: &str, on: bool, hollow: bool| {
            let (points, names) = points(on).into_iter().unzip();
            ScatterSeries {
                label: label.into(),
                points,
                names,
                hollow,
            }
        };
        let front = points(true).into_iter().map(|(p, _)| p).collect();
        let how = match self.measured {
            true => "processor time of a frame, measured [ms]",
            false => "time of a frame by the cost profile [ms]",
        };
        ScatterChart {
            title: "Time against error".into(),
            x_label: how.into(),
            y_label: measure.label().into(),
            logarithmic: [true, false],
            series: vec![
                series("nothing is both faster and closer", true, false),
                series("others", false, true),
            ],
            line: Some(("front".into(), front)),
            identity: None,
        }
    }
}

/// A method on all clips together; `None` of none.
fn together(rows: &[ParetoRow], method: Method) -> Option<ParetoRow> {
    let own: Vec<&ParetoRow> = rows.iter().filter(|r| r.method == method).collect();
    let errors: Vec<&Errors> = own.iter().map(|r| &r.errors).collect();
    let of = |f: fn(&ParetoRow) -> f64| mean(&own.iter().map(|r| f(r)).collect::<Vec<_>>());
    Some(ParetoRow {
        clip: ALL.into(),
        method,
        time_ms: of(|r| r.time_ms),
        samples: of(|r| r.samples),
        shadings: of(|r| r.shadings),
        memory_mb: of(|r| r.memory_mb),
        errors: Errors::mean(&errors)?,
        jod: None,
    })
}
