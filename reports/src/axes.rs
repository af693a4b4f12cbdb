use std::ops::Range;

use plotters::chart::ChartContext;
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::ranged1d::{BoldPoints, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::style::{Color, TRANSPARENT};

use crate::frame::{Backend, Drawn, FONT, clean, px, stroke, style};
use crate::svg::text_width;
use crate::theme::INK;

/// Whether a number can be placed on an axis: finite, and not so large that differences overflow.
pub(crate) fn drawable(v: f64) -> bool {
    v.abs() <= 1e100
}

/// A range with a width, whatever `low` and `high` are.
pub(crate) fn exactly(low: f64, high: f64) -> Range<f64> {
    let least = 1e-6 * low.abs().max(high.abs());
    let half = if high - low > least.max(1e-100) {
        0.0
    } else {
        least.max(0.5)
    };
    low - half..high + half
}

/// A range with some room above, and from zero where that is near: lengths are read from there.
pub(crate) fn roomy(low: f64, high: f64) -> Range<f64> {
    let Range { start, end } = exactly(low, high);
    let room = 0.05 * (end - start);
    let start = match start {
        s if s >= 0.0 && s < 0.5 * end => 0.0,
        s => s - room,
    };
    let end = if end <= 0.0 && high == 0.0 {
        0.0
    } else {
        end + room
    };
    start..end
}

/// Width of the widest number beside a vertical axis with at most `count` of them \[px\].
pub(crate) fn numbers_width(range: &Range<f64>, count: usize) -> f64 {
    let ticks = RangedCoordf64::from(range.clone()).key_points(BoldPoints(count));
    let widths = ticks.iter().map(|v| text_width(&tick(*v), FONT));
    widths.fold(0.0, f64::max)
}

/// An axis number, without the noise of binary fractions; from 100,000 on with k, M or G.
pub(crate) fn tick(v: f64) -> String {
    let (unit, suffix) = match v.abs() {
        x if x >= 1e12 || (x < 1e-6 && x > 0.0) => return format!("{v:.1e}"),
        x if x >= 1e9 => (1e9, "G"),
        x if x >= 1e6 => (1e6, "M"),
        x if x >= 1e5 => (1e3, "k"),
        _ => (1.0, ""),
    };
    let text = format!("{:.9}", v / unit);
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match text {
        "-0" | "0" => "0".into(),
        _ => format!("{text}{suffix}"),
    }
}

/// The look of axes and grid.
pub(crate) struct Axes<'a> {
    /// Under the horizontal axis.
    pub(crate) x_label: &'a str,
    /// Numbers along the axes, at most.
    pub(crate) count: [usize; 2],
    /// Which lines of the grid are drawn: at numbers of the horizontal, of the vertical axis.
    pub(crate) grid: [bool; 2],
    /// What stands at each value.
    pub(crate) x_text: &'a dyn Fn(&f64) -> String,
    pub(crate) y_text: &'a dyn Fn(&f64) -> String,
}

impl Axes<'_> {
    pub(crate) fn draw<X, Y>(
        &self,
        chart: &mut ChartContext<'_, Backend<'_>, Cartesian2d<X, Y>>,
    ) -> Drawn
    where
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let mut mesh = chart.configure_mesh();
        if !self.grid[0] {
            mesh.disable_x_mesh();
        }
        if !self.grid[1] {
            mesh.disable_y_mesh();
        }
        mesh.light_line_style(TRANSPARENT)
            .bold_line_style(stroke(INK.mix(0.15), 1.0))
            .axis_style(stroke(INK.mix(0.65), 1.0))
            .label_style(style(FONT))
            .x_labels(self.count[0])
            .y_labels(self.count[1])
            .x_label_formatter(self.x_text)
            .y_label_formatter(self.y_text)
            .set_all_tick_mark_size(px(4.0))
            .x_desc(clean(self.x_label))
            .draw()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_range_is_too_odd_to_draw() {
        for (low, high) in [
            (0.0, 0.0),
            (5.0, 5.0),
            (-3.0, 0.0),
            (1e100, 1e100),
            (-1e100, 1e100),
            (0.0, 1e-300),
        ] {
            for range in [exactly(low, high), roomy(low, high)] {
                assert!(range.start <= low && range.end >= high && range.start < range.end);
                let ticks = RangedCoordf64::from(range.clone()).key_points(BoldPoints(6));
                assert!(ticks.len() <= 6, "{range:?}: {ticks:?}");
            }
        }
        assert_eq!(roomy(1.0, 20.0).start, 0.0);
        assert!(![f64::NAN, f64::INFINITY, -1e200].into_iter().any(drawable));
    }

    #[test]
    fn axis_numbers_are_short() {
        let texts = [0.1 + 0.2, -0.0, 150_000.0, 2_500_000.0, 12.5, -4.0, 1e-9].map(tick);
        assert_eq!(texts, ["0.3", "0", "150k", "2.5M", "12.5", "-4", "1.0e-9"]);
    }
}
