use std::ops::Range;

use plotters::chart::ChartContext;
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::ChartBuilder;
use plotters::style::text_anchor::HPos;

use crate::axes::{Axes, tick};
use crate::frame::{Area, Backend, DrawError, Drawn, FONT, FOOT, place, px, text};
use crate::svg::{text_width, wrap};
use crate::theme::INK;
use crate::ticked::Ticked;

type Chart<'a, 'b> = ChartContext<'a, Backend<'b>, Cartesian2d<RangedCoordf64, Ticked>>;

/// A chart whose vertical axis is a list of named rows, top to bottom.
pub(crate) struct Rows<'a> {
    pub(crate) names: Vec<&'a str>,
    /// Names take at most so much \[px\].
    pub(crate) names_at_most: f64,
    /// Height of a row \[px\].
    pub(crate) height: f64,
    /// Room kept free above and to the right of the plotting area \[px\].
    pub(crate) above: f64,
    pub(crate) right: f64,
}

impl Rows<'_> {
    /// Height of the whole chart \[px\].
    pub(crate) fn total_height(&self) -> f64 {
        self.above + self.height * self.names.len() as f64 + FOOT
    }

    /// Axes and names; row k reaches from k to k + 1 on the vertical axis.
    pub(crate) fn chart<'a, 'b>(
        &self,
        root: &Area<'b>,
        body: &'a Area<'b>,
        x: &Range<f64>,
        x_label: &str,
    ) -> Result<Chart<'a, 'b>, DrawError> {
        let rows = self.names.len();
        let widths = self.names.iter().map(|n| text_width(n, FONT));
        let room = widths.fold(40.0, f64::max).min(self.names_at_most);
        let mut chart = ChartBuilder::on(body)
            .margin_top(px(self.above))
            .margin_right(px(self.right))
            .x_label_area_size(px(FOOT))
            .y_label_area_size(px(room + 14.0))
            .build_cartesian_2d(x.clone(), Ticked::new(rows as f64..0.0, Vec::new()))?;
        Axes {
            x_label,
            count: [7, 0],
            grid: [true, false],
            x_text: &|v| tick(*v),
            y_text: &|_| String::new(),
        }
        .draw(&mut chart)?;
        for (k, name) in self.names.iter().enumerate() {
            let [left, middle] = place(chart.plotting_area(), (x.start, k as f64 + 0.5));
            self.name(root, name, [left - 8.0, middle], room)?;
        }
        Ok(chart)
    }

    /// Writes a name in one or two lines before `right`.
    fn name(&self, root: &Area<'_>, name: &str, [right, middle]: [f64; 2], room: f64) -> Drawn {
        let lines = shown(name, room);
        let last = middle + 8.0 + 8.0 * (lines.len() as f64 - 1.0);
        for (i, line) in lines.iter().rev().enumerate() {
            text(
                root,
                line,
                [right, last - 16.0 * i as f64],
                HPos::Right,
                FONT,
                &INK,
            )?;
        }
        Ok(())
    }
}

/// At most two lines of at most `room` px; what does not fit ends in an ellipsis.
fn shown(name: &str, room: f64) -> Vec<String> {
    let mut lines = wrap(name, FONT, room);
    let too_many = lines.len() > 2;
    lines.truncate(2);
    let count = lines.len();
    let fitting = (room / text_width("x", FONT) + 0.01) as usize;
    for (i, line) in lines.iter_mut().enumerate() {
        let goes_on = too_many && i + 1 == count;
        if goes_on || line.chars().count() > fitting {
            *line = line.chars().take(fitting.saturating_sub(1)).collect();
            line.push('…');
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_never_leave_their_room() {
        let names = [
            "render",
            "gaze to photon, gaze row",
            "a/very/long/path/without/any/space",
        ];
        let long = "one two three four five six seven eight nine ten eleven twelve";
        for name in names.into_iter().chain([long, ""]) {
            let lines = shown(name, 140.0);
            assert!(lines.len() <= 2);
            let width = |l: &String| text_width(l, FONT);
            assert!(lines.iter().all(|l| width(l) <= 140.0), "{lines:?}");
        }
        assert_eq!(shown(names[1], 140.0).join(" "), names[1]);
        assert!(shown(long, 140.0)[1].ends_with('…'));
    }
}
