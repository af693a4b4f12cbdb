use foveasim_mask::{Mask, SpacingStatistics};
use foveasim_reports::{LineChart, LineSeries};

use super::SpacingBin;

pub(super) fn all(
    mask: &Mask,
    statistics: &SpacingStatistics,
    bins: &[SpacingBin],
) -> [(&'static str, LineChart); 4] {
    [
        ("convergence", convergence(mask)),
        ("changes", changes(mask)),
        ("spacing", spacing(bins)),
        ("pairs", pairs(statistics)),
    ]
}

fn line(label: &str, points: impl Iterator<Item = [f64; 2]>) -> LineSeries {
    LineSeries {
        label: label.into(),
        points: points.collect(),
    }
}

fn convergence(mask: &Mask) -> LineChart {
    let found = mask.convergence();
    let rows = || found.iterations.iter();
    let at = |k: u32, v: f64| [f64::from(k), v];
    let bound = |sign: f64, r: &foveasim_mask::LbgIteration| 1.0 / (1.0 + sign * r.width / 2.0);
    LineChart {
        title: "Rays over the integral of density, iteration by iteration".into(),
        x_label: "iteration".into(),
        y_label: "rays / ∫Φ".into(),
        series: vec![
            line(
                "rays",
                rows().map(|r| at(r.iteration, r.sites as f64 / found.integral)),
            ),
            line(
                "least, once nothing changes",
                rows().map(|r| at(r.iteration, bound(1.0, r))),
            ),
            line(
                "most, once nothing changes",
                rows()
                    .filter(|r| r.width < 1.5)
                    .map(|r| at(r.iteration, bound(-1.0, r))),
            ),
        ],
        ..LineChart::default()
    }
}

fn changes(mask: &Mask) -> LineChart {
    let rows = || mask.convergence().iterations.iter();
    let share = |k: u32, n: u64, of: u64| [f64::from(k), 100.0 * n as f64 / of.max(1) as f64];
    LineChart {
        title: "Cells that change, iteration by iteration".into(),
        x_label: "iteration".into(),
        y_label: "share of all cells [%]".into(),
        series: vec![
            line(
                "split",
                rows().map(|r| share(r.iteration, r.split, r.sites)),
            ),
            line(
                "merged",
                rows().map(|r| share(r.iteration, r.merged, r.sites)),
            ),
        ],
        ..LineChart::default()
    }
}

/// Cells of a Gaussian's outermost rays are ten times as wide as any before them: wider ones are in the table alone \[px\].
const WIDEST_PX: f64 = 48.0;

fn spacing(bins: &[SpacingBin]) -> LineChart {
    let shown = || bins.iter().filter(|b| b.spacing_px[2] <= WIDEST_PX);
    let of = |k: usize| shown().map(move |b| [b.distance_px, b.spacing_px[k]]);
    let wanted = shown().map(|b| [b.distance_px, b.wanted_px]);
    LineChart {
        title: "How far apart rays are, up to 48 px".into(),
        x_label: "distance from the gaze [px]".into(),
        y_label: "√(area of a cell) [px]".into(),
        series: vec![
            line("5 % of rays are closer", of(0)),
            line("median", of(1)),
            line("5 % of rays are farther", of(2)),
            line("density asks for", wanted),
        ],
        ..LineChart::default()
    }
}

fn pairs(statistics: &SpacingStatistics) -> LineChart {
    LineChart {
        title: "Pairs of rays by their distance (those more than 1.5 px apart)".into(),
        x_label: "distance over spacing".into(),
        y_label: "pairs, over those of rays at random".into(),
        series: vec![line("this mask", statistics.pairs.bins.iter().copied())],
        levels: vec![(1.0, "at random".into())],
        ..LineChart::default()
    }
}
