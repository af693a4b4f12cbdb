//! Table 1: what each part of the scene costs, with and without foveation.

use std::time::Duration;

use foveasim_assets::{StudyContent, study_scene_with};
use foveasim_models::Acuity;
use foveasim_models::foveation::{Method, Prepared};
use foveasim_reports::{Cell, Table};

use super::paper::{COLUMNS, Column, TABLE_1_MS};
use super::shooter::{Antialiasing, Due, Flight, Shooter, Times, time};
use super::{ReproduceError, layers};

/// Table 1, measured here.
#[derive(Debug, Clone, PartialEq)]
pub struct Table1 {
    /// Row by row, each from the first column to the last.
    pub cells: Vec<Table1Cell>,
}

/// One cell of Table 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Table1Cell {
    /// Its row.
    pub content: StudyContent,
    /// Its column.
    pub column: Column,
    /// Samples drawn per frame, staggered layers at their own rate, mean over the moments.
    pub samples: f64,
    /// Times measured here.
    pub times: Times,
    /// As printed \[ms\].
    pub paper_ms: f64,
}

impl Column {
    /// How it is drawn; `informal` is the acuity that column I stands for.
    pub(super) fn draws(
        self,
        flight: &Flight,
        informal: Acuity,
    ) -> Result<(Prepared, Antialiasing), ReproduceError> {
        let acuity = match self {
            Self::Informal => informal,
            Self::QualityB => Acuity::parse("guenter-b")?,
            _ => Acuity::default(),
        };
        let (method, antialiasing) = match self {
            Self::Informal | Self::QualityA | Self::QualityB => (layers()?, Antialiasing::ALL),
            Self::Plain => (Method::Full, Antialiasing::default()),
            Self::Msaa => (Method::Full, Antialiasing::MSAA),
            Self::Reference => (Method::Full, Antialiasing::ALL),
        };
        Ok((flight.prepare(method, acuity)?, antialiasing))
    }
}

impl Table1 {
    /// Draws and times every cell at `moments`. `done` hears of each cell's moments.
    pub(super) fn measure(
        flight: &Flight,
        informal: Acuity,
        moments: &[u32],
        clock: &mut dyn FnMut() -> Duration,
        done: &mut dyn FnMut(),
    ) -> Result<Self, ReproduceError> {
        let mut cells = Vec::new();
        for (content, paper) in StudyContent::ALL.into_iter().zip(TABLE_1_MS) {
            let scene = study_scene_with(flight.seed, content);
            let mut shooters = Vec::new();
            for column in COLUMNS {
                let (method, antialiasing) = column.draws(flight, informal)?;
                let shooter = Shooter::new(flight, &scene, method, antialiasing);
                shooters.push(match content {
                    StudyContent::NoRender => shooter.due(Due::Nothing),
                    _ => shooter,
                });
            }
            let times = time(&mut shooters, moments, clock, done)?;
            for (k, (column, times)) in COLUMNS.into_iter().zip(times).enumerate() {
                cells.push(Table1Cell {
                    content,
                    column,
                    samples: shooters[k].samples(moments)?,
                    times,
                    paper_ms: paper[k],
                });
            }
        }
        Ok(Self { cells })
    }

    /// A cell.
    pub fn cell(&self, content: StudyContent, column: Column) -> &Table1Cell {
        let is = |c: &&Table1Cell| (c.content, c.column) == (content, column);
        self.cells.iter().find(is).expect("every cell is measured")
    }

    /// How many times faster a cell's whole fly-through is than that of N₂ in its row: here, and as
    /// printed.
    pub fn speedup(&self, content: StudyContent, column: Column) -> [f64; 2] {
        let (reference, cell) = (
            self.cell(content, Column::Reference),
            self.cell(content, column),
        );
        [
            reference.times.total_ms() / cell.times.total_ms(),
            reference.paper_ms / cell.paper_ms,
        ]
    }

    /// One row per cell, with everything.
    pub fn table(&self) -> Table {
        let mut table = Table::new([
            "content",
            "column",
            "moments",
            "samples_per_frame",
            "median_ms",
            "mean_ms",
            "total_ms",
            "paper_ms",
            "speedup_over_N2",
            "paper_speedup_over_N2",
        ]);
        for c in &self.cells {
            let [ours, paper] = self.speedup(c.content, c.column);
            table.push(vec![
                c.content.name().into(),
                c.column.name().into(),
                c.times.frame_ms.len().into(),
                c.samples.into(),
                c.times.median_ms().into(),
                c.times.mean_ms().into(),
                c.times.total_ms().into(),
                c.paper_ms.into(),
                ours.into(),
                paper.into(),
            ]);
        }
        table
    }

    /// Median times \[ms\] as the paper prints them, ours above the paper's.
    pub fn times_as_printed(&self) -> Table {
        self.as_printed(|c| [c.times.median_ms(), c.paper_ms])
    }

    /// How many times faster than N₂, ours above the paper's.
    pub fn speedups_as_printed(&self) -> Table {
        self.as_printed(|c| self.speedup(c.content, c.column))
    }

    /// Two lines for each row of the paper.
    fn as_printed(&self, value: impl Fn(&Table1Cell) -> [f64; 2]) -> Table {
        let mut table = Table::new(
            ["rendering", "whose"]
                .into_iter()
                .chain(COLUMNS.map(Column::name)),
        );
        for content in StudyContent::ALL {
            let values = COLUMNS.map(|column| value(self.cell(content, column)));
            for (k, whose) in ["ours", "paper"].into_iter().enumerate() {
                let name = if k == 0 {
                    content.name().into()
                } else {
                    Cell::Empty
                };
                let head = [name, whose.into()];
                let cells = values.map(|v| Cell::Float(round3(v[k])));
                table.push(head.into_iter().chain(cells).collect());
            }
        }
        table
    }
}

/// Three digits after the point at most: times are not known better.
fn round3(v: f64) -> f64 {
    (v * 1e3).round() / 1e3
}

impl Shooter<'_> {
    /// Samples per frame, staggered layers at their own rate: mean over the moments; none if nothing is
    /// due.
    pub(super) fn samples(&self, moments: &[u32]) -> Result<f64, ReproduceError> {
        if self.is_idle() {
            return Ok(0.0);
        }
        let mut all = Vec::with_capacity(moments.len());
        for &moment in moments {
            all.push(self.plan(moment)?.count().samples_staggered());
        }
        Ok(foveasim_models::math::mean(&all))
    }
}
