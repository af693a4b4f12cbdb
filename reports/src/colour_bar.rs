use std::ops::Range;

use foveasim_models::math;
use plotters::coord::ranged1d::{BoldPoints, Ranged};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::{ChartBuilder, RGBColor};

use crate::ColourMap;
use crate::axes::{Axes, exactly, tick};
use crate::frame::{Area, Drawn, FONT, FOOT, WIDTH, block, outline, place, px, untitled};
use crate::number::short;
use crate::svg::text_width;
use crate::ticked::Ticked;

/// Breadth of a colour bar \[px\].
pub(crate) const BAR_WIDTH: f64 = 16.0;

/// Which colours values have: the range of a colour map, with its numbers.
pub(crate) struct ColourAxis {
    range: Range<f64>,
    /// Where numbers stand, and what they say.
    ticks: Vec<(f64, String)>,
}

impl ColourAxis {
    pub(crate) fn linear(low: f64, high: f64) -> Self {
        let range = exactly(low, high);
        let ticks = RangedCoordf64::from(range.clone()).key_points(BoldPoints(8));
        Self {
            range,
            ticks: ticks.into_iter().map(|v| (v, tick(v))).collect(),
        }
    }

    /// From logarithm `low` to logarithm `high` (base ten).
    pub(crate) fn logarithmic(low: f64, high: f64) -> Self {
        let (low, high) = if high - low < 1e-9 {
            (low - 0.1, high + 0.1)
        } else {
            (low, high)
        };
        let steps: &[f64] = if high - low < 3.0 {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0]
        };
        // Ten decades' numbers at most find room.
        let every = ((high - low) / 10.0).ceil().max(1.0) as usize;
        let ticks = (low.floor() as i32..=high.ceil() as i32)
            .step_by(every)
            .flat_map(|d| steps.iter().map(move |m| m * math::pow(10.0, f64::from(d))))
            .map(|v| (math::log10(v), short(v)))
            .filter(|(l, _)| (low - 1e-9..=high + 1e-9).contains(l))
            .collect();
        Self {
            range: low..high,
            ticks,
        }
    }

    /// Where in the colour map a value lies, 0 to 1.
    pub(crate) fn share(&self, value: f64) -> f64 {
        (value - self.range.start) / (self.range.end - self.range.start)
    }

    /// Width of the widest number \[px\].
    pub(crate) fn numbers_width(&self) -> f64 {
        let widths = self.ticks.iter().map(|(_, t)| text_width(t, FONT));
        widths.fold(0.0, f64::max)
    }

    fn places(&self) -> Vec<f64> {
        self.ticks.iter().map(|(v, _)| *v).collect()
    }

    fn text(&self, value: f64) -> String {
        let tick = self.ticks.iter().find(|(v, _)| *v == value);
        tick.map(|(_, t)| t.clone()).unwrap_or_default()
    }

    /// A vertical bar as high as `body`, with its numbers to the right.
    pub(crate) fn draw_vertical(&self, root: &Area<'_>, body: &Area<'_>, map: ColourMap) -> Drawn {
        let numbers = f64::from(body.dim_in_pixel().0) / f64::from(px(1.0)) - BAR_WIDTH;
        let mut chart = ChartBuilder::on(body)
            .right_y_label_area_size(px(numbers))
            .build_cartesian_2d(0.0..1.0, Ticked::new(self.range.clone(), self.places()))?;
        let plot = chart.plotting_area();
        let [left, bottom] = place(plot, (0.0, self.range.start));
        let [right, top] = place(plot, (1.0, self.range.end));
        let (corner, opposite) = ([left, bottom], [right, top]);
        gradient(root, map, 64, |share| {
            [
                [left, bottom + (top - bottom) * share.end],
                [right, bottom + (top - bottom) * share.start],
            ]
        })?;
        outline(root, corner, opposite)?;
        Axes {
            x_label: "",
            count: [0, self.ticks.len()],
            grid: [false, false],
            x_text: &|_| String::new(),
            y_text: &|v| self.text(*v),
        }
        .draw(&mut chart)
    }
}

/// Draws a colour map in steps, each in the rectangle that `place` gives for its part of 0 to 1.
fn gradient(
    root: &Area<'_>,
    map: ColourMap,
    steps: u32,
    place: impl Fn(Range<f64>) -> [[f64; 2]; 2],
) -> Drawn {
    let share = |k: u32| f64::from(k) / f64::from(steps);
    for k in 0..steps {
        let [r, g, b] = map.at(f64::midpoint(share(k), share(k + 1)));
        let [from, to] = place(share(k)..share(k + 1));
        block(root, from, to, RGBColor(r, g, b))?;
    }
    Ok(())
}

/// A horizontal colour bar from 0 to `max`, to stand under an error map.
pub(crate) fn error_scale(max: f64, label: &str) -> String {
    let x = exactly(0.0, max);
    untitled(label, 6.0 + BAR_WIDTH + FOOT, |root, body| {
        let mut chart = ChartBuilder::on(body)
            .margin_top(px(6.0))
            .margin_left(px(16.0))
            .margin_right(px(WIDTH - 536.0))
            .x_label_area_size(px(FOOT))
            .build_cartesian_2d(x.clone(), 0.0..1.0)?;
        let plot = chart.plotting_area();
        let [left, bottom] = place(plot, (x.start, 0.0));
        let [right, top] = place(plot, (x.end, 1.0));
        gradient(root, ColourMap::Inferno, 128, |share| {
            [
                [left + (right - left) * share.start, top],
                [left + (right - left) * share.end, bottom],
            ]
        })?;
        outline(root, [left, top], [right, bottom])?;
        Axes {
            x_label: label,
            count: [9, 0],
            grid: [false, false],
            x_text: &|v| tick(*v),
            y_text: &|_| String::new(),
        }
        .draw(&mut chart)
    })
}
