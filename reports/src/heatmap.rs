use foveasim_models::math;
use plotters::prelude::{ChartBuilder, Color, PathElement, RGBColor};
use plotters::style::text_anchor::HPos;

use crate::ColourMap;
use crate::axes::{Axes, drawable};
use crate::colormap::is_light;
use crate::colour_bar::{BAR_WIDTH, ColourAxis};
use crate::frame::{
    Area, Drawn, FONT, FOOT, SMALL, WIDTH, block, ends, nothing, picture, place, px, stroke, text,
    top,
};
use crate::number::short;
use crate::svg::text_width;
use crate::theme::INK;
use crate::ticked::Ticked;

/// How values become colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColourScale {
    /// Equal differences look equal.
    #[default]
    Linear,
    /// Equal ratios look equal; values must be positive, others are drawn as missing.
    Logarithmic,
}

/// One cell of a [`Heatmap`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeatCell {
    /// Its value; `None` (or not finite) where there is none.
    pub value: Option<f64>,
    /// Whether the model goes beyond what it was checked against there: drawn hatched.
    pub extrapolated: bool,
}

/// A quantity over two others, as coloured cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Heatmap {
    /// What is shown.
    pub title: String,
    /// Name and unit of the horizontal quantity.
    pub x_label: String,
    /// Its value in each column, left to right.
    pub x: Vec<f64>,
    /// Name and unit of the vertical quantity.
    pub y_label: String,
    /// Its value in each row, bottom to top.
    pub y: Vec<f64>,
    /// Name and unit of the coloured quantity.
    pub value_label: String,
    /// Row by row from the bottom: cell (column i, row j) is `cells[j * x.len() + i]`.
    pub cells: Vec<HeatCell>,
    /// How values become colours.
    pub scale: ColourScale,
    /// Least and greatest value of the colours, for maps that are to be compared; those of the cells if none. Cells beyond
    /// have the colour of the end.
    pub ends: Option<[f64; 2]>,
}

impl Heatmap {
    /// The picture.
    ///
    /// # Panics
    /// If there is not one cell per column and row.
    pub fn svg(&self) -> String {
        let (columns, rows) = (self.x.len(), self.y.len());
        assert_eq!(self.cells.len(), columns * rows, "cells of {}", self.title);
        let values: Vec<f64> = self
            .cells
            .iter()
            .filter_map(|c| self.scaled(c.value))
            .collect();
        if values.is_empty() {
            return nothing(&self.title);
        }
        let ends = self.ends.iter().flatten();
        let ends: Vec<f64> = ends.filter_map(|v| self.scaled(Some(*v))).collect();
        let colours = if ends.len() == 2 { &ends } else { &values };
        let low = colours.iter().copied().fold(f64::INFINITY, f64::min);
        let high = colours.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let colours = match self.scale {
            ColourScale::Linear => ColourAxis::linear(low, high),
            ColourScale::Logarithmic => ColourAxis::logarithmic(low, high),
        };
        let [x_names, y_names] = [&self.x, &self.y].map(|v| v.iter().map(|v| short(*v)).collect());
        let (x_names, y_names): (Vec<String>, Vec<String>) = (x_names, y_names);
        let bar = BAR_WIDTH + colours.numbers_width() + 14.0;
        let left = widest(&y_names) + 14.0;
        let right = WIDTH - bar - 16.0;
        let size = [
            (right - left) / columns as f64,
            (300.0 / rows as f64).clamp(6.0, 44.0),
        ];
        let legend = self.legend(values.len());
        let above = if legend.is_empty() { 26.0 } else { 44.0 };
        let height = above + size[1] * rows as f64 + FOOT;
        picture(&self.title, &[], height, |root, body| {
            // The legend of a hatch is its words: a sample of it would be too small to recognise.
            text(
                root,
                &legend,
                [6.0, top(body) + 16.0],
                HPos::Left,
                SMALL,
                &INK,
            )?;
            let y = top(body) + above - 8.0;
            text(root, &self.y_label, [6.0, y], HPos::Left, FONT, &INK)?;
            text(
                root,
                &self.value_label,
                [WIDTH - 4.0, y],
                HPos::Right,
                FONT,
                &INK,
            )?;
            let every = [(widest(&x_names) + 8.0) / size[0], 18.0 / size[1]];
            let ticks = |count: usize, every: f64| -> Vec<f64> {
                let every = every.ceil().max(1.0) as usize;
                (0..count).step_by(every).map(|k| k as f64 + 0.5).collect()
            };
            let mut chart = ChartBuilder::on(body)
                .margin_top(px(above))
                .margin_right(px(WIDTH - right))
                .x_label_area_size(px(FOOT))
                .y_label_area_size(px(left))
                .build_cartesian_2d(
                    Ticked::new(0.0..columns as f64, ticks(columns, every[0])),
                    Ticked::new(0.0..rows as f64, ticks(rows, every[1])),
                )?;
            let plot = chart.plotting_area();
            for (k, cell) in self.cells.iter().enumerate() {
                let (i, j) = ((k % columns) as f64, (k / columns) as f64);
                let corners = [place(plot, (i, j + 1.0)), place(plot, (i + 1.0, j))];
                self.draw_cell(root, cell, &colours, corners)?;
            }
            Axes {
                x_label: &self.x_label,
                count: [columns, rows],
                grid: [false, false],
                x_text: &|v| x_names[*v as usize].clone(),
                y_text: &|v| y_names[*v as usize].clone(),
            }
            .draw(&mut chart)?;
            let beside = body.margin(px(above), px(FOOT), px(WIDTH - bar), 0);
            colours.draw_vertical(root, &beside, ColourMap::Viridis)
        })
    }

    fn legend(&self, values: usize) -> String {
        let extrapolated = self.cells.iter().any(|c| c.extrapolated);
        let extrapolated = extrapolated.then_some("hatched: extrapolated");
        let missing = (values < self.cells.len()).then_some("–: no value");
        let parts: Vec<&str> = extrapolated.into_iter().chain(missing).collect();
        parts.join("; ")
    }

    /// A value as the colour scale sees it.
    fn scaled(&self, value: Option<f64>) -> Option<f64> {
        let value = value.filter(|v| drawable(*v))?;
        match self.scale {
            ColourScale::Linear => Some(value),
            ColourScale::Logarithmic => (value > 0.0).then(|| math::log10(value)),
        }
    }

    fn draw_cell(
        &self,
        root: &Area<'_>,
        cell: &HeatCell,
        colours: &ColourAxis,
        [from, to]: [[f64; 2]; 2],
    ) -> Drawn {
        let printed = to[0] - from[0] >= 40.0 && to[1] - from[1] >= 18.0;
        let at = [
            f64::midpoint(from[0], to[0]),
            f64::midpoint(from[1], to[1]) + 7.5,
        ];
        let Some(value) = self.scaled(cell.value) else {
            block(root, from, to, INK.mix(0.04))?;
            return text(root, "–", at, HPos::Center, SMALL, &INK);
        };
        let rgb = ColourMap::Viridis.at(colours.share(value));
        let [r, g, b] = rgb;
        let ground = RGBColor(r, g, b);
        block(root, from, to, ground)?;
        // Ink on a cell suits the cell, not the surroundings.
        let (ink, opacity) = if is_light(rgb) {
            (RGBColor(0, 0, 0), 0.5)
        } else {
            (RGBColor(255, 255, 255), 0.65)
        };
        if cell.extrapolated {
            hatch(root, ink.mix(opacity), from, to)?;
        }
        if printed {
            let label = short(cell.value.unwrap_or_default());
            if cell.extrapolated {
                // A patch of plain colour keeps the number legible on the hatching.
                let half = text_width(&label, SMALL) / 2.0 + 2.0;
                let patch = [[at[0] - half, at[1] - 14.0], [at[0] + half, at[1]]];
                block(root, patch[0], patch[1], ground)?;
            }
            text(root, &label, at, HPos::Center, SMALL, &ink)?;
        }
        Ok(())
    }
}

fn widest(texts: &[String]) -> f64 {
    texts
        .iter()
        .map(|t| text_width(t, FONT))
        .fold(0.0, f64::max)
}

/// Lines at 45° that end at the rectangle's edges.
fn hatch(root: &Area<'_>, colour: impl Color, [x, y]: [f64; 2], to: [f64; 2]) -> Drawn {
    const STEP: f64 = 7.0;
    let (w, h) = (to[0] - x, to[1] - y);
    // Lines continue from cell to cell: x + y is a multiple of the step on each.
    let mut along = STEP - (x + y).rem_euclid(STEP);
    while along < w + h {
        let from = [x + (along - h).max(0.0), y + along.min(h)];
        let to = [x + along.min(w), y + (along - w).max(0.0)];
        root.draw(&PathElement::new(
            ends(from, to),
            stroke(colour.to_rgba(), 1.25),
        ))?;
        along += STEP;
    }
    Ok(())
}
