use std::time::Duration;

use foveasim_reports::{LineChart, LineSeries, Table};
use glam::UVec2;

use super::place::Place;
use super::rolling::{RollingWay, Scanned};
use super::{Friston2019, Friston2019Outcome, ReproduceError};

/// One way at one size of the image.
#[derive(Debug, Clone, PartialEq)]
pub struct ResolutionRow {
    /// Pixels along each side.
    pub side: u32,
    /// The way.
    pub way: RollingWay,
    /// Time of a frame \[ms\].
    pub frame_ms: f64,
    /// SSIM against what the display should show.
    pub ssim: f64,
}

/// Shares of the asked size at which frames are drawn; the fovea must fit.
const SHARES: [f64; 4] = [0.25, 0.5, 0.75, 1.0];

/// The first scene in images of several sizes.
pub(super) fn measure(
    asked: &Friston2019,
    clock: &mut dyn FnMut() -> Duration,
) -> Result<Vec<ResolutionRow>, ReproduceError> {
    let mut rows = Vec::new();
    for share in SHARES {
        let side = (share * f64::from(asked.size.min_element())).round() as u32;
        let smaller = Friston2019 {
            size: UVec2::splat(side.max(super::FOVEA_PX)),
            reference_samples: 1,
            ..asked.clone()
        };
        let place = Place::new(asked.scenes[0], &smaller)?;
        let scanned = Scanned::new(&place, asked.turn_deg)?;
        for row in scanned.measure(&RollingWay::FEW, asked.rounds, clock)? {
            rows.push(ResolutionRow {
                side: smaller.size.x,
                way: row.way,
                frame_ms: row.raster_ms + row.shading_ms,
                ssim: row.ssim,
            });
        }
    }
    Ok(rows)
}

impl Friston2019Outcome {
    /// Fig. 13, a.
    pub fn resolution_table(&self) -> Table {
        let mut table = Table::new(["side_px", "way", "frame_ms", "ssim"]);
        for r in &self.resolutions {
            table.push(vec![
                r.side.into(),
                r.way.name().into(),
                r.frame_ms.into(),
                r.ssim.into(),
            ]);
        }
        table
    }

    /// Fig. 13, a: a line for each way.
    pub fn resolution_chart(&self) -> LineChart {
        let line = |way: &RollingWay| LineSeries {
            label: way.name(),
            points: self
                .resolutions
                .iter()
                .filter(|r| r.way == *way)
                .map(|r| [f64::from(r.side), r.frame_ms])
                .collect(),
        };
        LineChart {
            title: "Time of a frame over resolution".into(),
            x_label: "pixels along each side".into(),
            y_label: "time [ms]".into(),
            series: RollingWay::FEW.iter().map(line).collect(),
            ..LineChart::default()
        }
    }
}
