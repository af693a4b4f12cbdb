use plotters::prelude::{Color, PathElement};
use plotters::style::text_anchor::HPos;

use crate::axes::{drawable, exactly};
use crate::frame::{Key, SMALL, Sample, block, ends, nothing, picture, place, stroke, text};
use crate::number::short;
use crate::rows::Rows;
use crate::svg::text_width;
use crate::theme::{self, INK};

/// One colour of a [`BarChart`].
#[derive(Debug, Clone, PartialEq)]
pub struct BarSeries {
    /// Its name.
    pub label: String,
    /// One value per group; `None` (or not finite) where there is none.
    pub values: Vec<Option<f64>>,
}

/// Values of several things side by side: samples per method, time per method.
#[derive(Debug, Clone, PartialEq)]
pub struct BarChart {
    /// What is shown.
    pub title: String,
    /// Name and unit of the values.
    pub value_label: String,
    /// The things compared, top to bottom.
    pub groups: Vec<String>,
    /// What is compared of each.
    pub series: Vec<BarSeries>,
}

/// Between the bars of two groups \[px\].
const GAP: f64 = 12.0;

impl BarChart {
    /// The picture: bars from zero, each with its value.
    ///
    /// A value beyond 10¹⁰⁰ counts as not finite.
    ///
    /// # Panics
    /// If a series does not have one value per group.
    pub fn svg(&self) -> String {
        for s in &self.series {
            assert_eq!(s.values.len(), self.groups.len(), "values of {}", s.label);
        }
        let values = || {
            self.series
                .iter()
                .flat_map(|s| &s.values)
                .flatten()
                .filter(|v| drawable(**v))
        };
        if values().next().is_none() {
            return nothing(&self.title);
        }
        let low = values().copied().fold(0.0, f64::min);
        let high = values().copied().fold(0.0, f64::max);
        let x = exactly(low, high);
        let count = self.series.len();
        let key = |(i, s): (usize, &BarSeries)| Key::new(theme::series(i), Sample::Block, &s.label);
        let keys: Vec<Key> = self.series.iter().enumerate().map(key).collect();
        let keys = if count > 1 { keys } else { Vec::new() };
        let bar = if count > 1 { 17.0 } else { 22.0 };
        let widest = values().map(|v| text_width(&short(*v), SMALL));
        let rows = Rows {
            names: self.groups.iter().map(String::as_str).collect(),
            names_at_most: 170.0,
            height: bar * count as f64 + GAP,
            above: 8.0,
            right: widest.fold(0.0, f64::max) + 16.0,
        };
        picture(&self.title, &keys, rows.total_height(), |root, body| {
            let chart = rows.chart(root, body, &x, &self.value_label)?;
            let plot = chart.plotting_area();
            for (g, _) in self.groups.iter().enumerate() {
                let [zero, row] = place(plot, (0.0, g as f64));
                for (i, series) in self.series.iter().enumerate() {
                    let y = row + GAP / 2.0 + bar * i as f64;
                    let label_y = y + bar / 2.0 + 7.5;
                    let Some(v) = series.values[g].filter(|v| drawable(*v)) else {
                        let at = [zero + 5.0, label_y];
                        text(root, "no value", at, HPos::Left, SMALL, &INK)?;
                        continue;
                    };
                    let [end, _] = place(plot, (v, 0.0));
                    let (from, to) = (zero.min(end), zero.max(end));
                    block(root, [from, y + 1.0], [to, y + bar - 1.0], theme::series(i))?;
                    text(
                        root,
                        &short(v),
                        [to + 5.0, label_y],
                        HPos::Left,
                        SMALL,
                        &INK,
                    )?;
                }
            }
            let foot = place(plot, (0.0, self.groups.len() as f64));
            let axis = ends(place(plot, (0.0, 0.0)), foot);
            root.draw(&PathElement::new(axis, stroke(INK.mix(0.65), 1.0)))
        })
    }
}
