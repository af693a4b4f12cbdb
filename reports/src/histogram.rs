use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use crate::axes::{Axes, drawable, exactly, numbers_width, roomy, tick};
use crate::frame::{
    FONT, FOOT, Key, PLOT, Sample, WIDTH, block, dashes, edge, ends, nothing, picture, place, px,
    shade, stroke, text, top,
};
use crate::number::short;
use crate::svg::text_width;
use crate::theme::{self, INK};

/// One distribution of a [`Histogram`].
#[derive(Debug, Clone, PartialEq)]
pub struct HistogramSeries {
    /// Its name.
    pub label: String,
    /// Bins (from, to, fraction of all values) by increasing place; one that is not finite, or ends
    /// before it begins, is left out.
    pub bins: Vec<(f64, f64, f64)>,
    /// Vertical lines and what they are: (`"p95"`, its value).
    pub marks: Vec<(String, f64)>,
}

/// How often values occur, with the quantiles that matter and the bounds that analysis gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// What is shown.
    pub title: String,
    /// Name and unit of the quantity.
    pub x_label: String,
    /// The distributions, drawn over each other.
    pub series: Vec<HistogramSeries>,
    /// Least and greatest value possible by analysis: shaded between.
    pub bounds: Option<[f64; 2]>,
}

/// Numbers along the axes, at most.
const COUNT: [usize; 2] = [9, 6];
/// Height of a row of marks' labels \[px\].
const MARK_ROW: f64 = 16.0;

impl Histogram {
    /// The picture.
    pub fn svg(&self) -> String {
        let bins: Vec<Vec<(f64, f64, f64)>> = self.series.iter().map(valid_bins).collect();
        let all = || bins.iter().flatten();
        if all().next().is_none() {
            return nothing(&self.title);
        }
        let bounds = self
            .bounds
            .filter(|b| b.iter().all(|v| drawable(*v)) && b[0] <= b[1]);
        let marks = self.marks();
        let places = || {
            let ends = all()
                .flat_map(|b| [b.0, b.1])
                .chain(bounds.into_iter().flatten());
            ends.chain(marks.iter().map(|m| m.at))
        };
        let low = places().fold(f64::INFINITY, f64::min);
        let x = exactly(low, places().fold(f64::NEG_INFINITY, f64::max));
        let y = roomy(0.0, all().map(|b| 100.0 * b.2).fold(0.0, f64::max));

        let y_label = format!("share per {} [%]", self.bin_name(&bins));
        let left = numbers_width(&y, COUNT[1]) + 14.0;
        let right = WIDTH - 26.0;
        let scale = (right - left) / (x.end - x.start);
        let (rows, labels) = mark_rows(&marks, |v| left + (v - x.start) * scale);
        let rows_height = MARK_ROW * rows as f64;
        let height = rows_height + 28.0 + PLOT + FOOT;
        picture(
            &self.title,
            &self.keys(bounds.is_some()),
            height,
            |root, body| {
                let y_label_at = [6.0, top(body) + rows_height + 18.0];
                text(root, &y_label, y_label_at, HPos::Left, FONT, &INK)?;
                let mut chart = ChartBuilder::on(body)
                    .margin_top(px(rows_height + 28.0))
                    .margin_right(px(26.0))
                    .x_label_area_size(px(FOOT))
                    .y_label_area_size(px(left))
                    .build_cartesian_2d(x.clone(), y.clone())?;
                Axes {
                    x_label: &self.x_label,
                    count: COUNT,
                    grid: [true, true],
                    x_text: &|v| tick(*v),
                    y_text: &|v| tick(*v),
                }
                .draw(&mut chart)?;
                let corners = |[from, to]: [f64; 2]| {
                    let plot = chart.plotting_area();
                    (place(plot, (from, y.end)), place(plot, (to, y.start)))
                };
                if let Some(bounds) = bounds {
                    let ([left, upper], [right, lower]) = corners(bounds);
                    block(root, [left, upper], [right, lower], shade())?;
                    for x in [left, right] {
                        root.draw(&dashes(ends([x, upper], [x, lower]), stroke(edge(), 1.0)))?;
                    }
                }
                for (i, bins) in bins.iter().enumerate().filter(|(_, b)| !b.is_empty()) {
                    let colour = theme::series(i);
                    let area = AreaSeries::new(steps(bins), 0.0, colour.mix(0.28));
                    chart.draw_series(area.border_style(stroke(colour, 1.8)))?;
                }
                for (mark, (row, left)) in marks.iter().zip(labels) {
                    let y_label = top(body) + 16.0 + MARK_ROW * row as f64;
                    let plot = chart.plotting_area();
                    let [x, lower] = place(plot, (mark.at, y.start));
                    let line = ends([x, y_label], [x, lower]);
                    root.draw(&dashes(line, stroke(mark.colour, 1.6)))?;
                    text(
                        root,
                        &mark.label,
                        [left, y_label],
                        HPos::Left,
                        FONT,
                        &mark.colour,
                    )?;
                }
                Ok(())
            },
        )
    }

    /// The width that all bins have, with its unit; `bin` where they differ.
    fn bin_name(&self, bins: &[Vec<(f64, f64, f64)>]) -> String {
        let mut widths = bins.iter().flatten().map(|(from, to, _)| to - from);
        let Some(first) = widths.next() else {
            return "bin".into();
        };
        if !widths.all(|w| (w - first).abs() < 1e-6 * first) {
            return "bin".into();
        }
        let unit = self
            .x_label
            .rsplit_once('[')
            .map_or("", |(_, unit)| unit.trim_end_matches(']'));
        format!("{} {unit}", short(first)).trim_end().to_owned()
    }

    fn keys(&self, bounds: bool) -> Vec<Key> {
        let series = self.series.iter().enumerate();
        let mut keys: Vec<Key> = series
            .map(|(i, s)| Key::new(theme::series(i).mix(0.6), Sample::Block, &s.label))
            .collect();
        if bounds {
            keys.push(Key::new(shade(), Sample::Block, "possible by analysis"));
        }
        keys
    }

    fn marks(&self) -> Vec<Mark> {
        let of = |(i, s): (usize, &HistogramSeries)| -> Vec<Mark> {
            let marks = s.marks.iter().filter(|(_, at)| drawable(*at));
            marks
                .map(|(name, at)| Mark {
                    at: *at,
                    label: format!("{name} {at:.2}"),
                    colour: theme::series(i),
                })
                .collect()
        };
        self.series.iter().enumerate().flat_map(of).collect()
    }
}

fn valid_bins(series: &HistogramSeries) -> Vec<(f64, f64, f64)> {
    let valid = |b: &&(f64, f64, f64)| [b.0, b.1, b.2].into_iter().all(drawable) && b.0 < b.1;
    series.bins.iter().filter(valid).copied().collect()
}

/// The upper edge of the bins: up, along and down; to the ground where bins are missing.
fn steps(bins: &[(f64, f64, f64)]) -> Vec<(f64, f64)> {
    let mut out = vec![(bins[0].0, 0.0)];
    for (from, to, fraction) in bins {
        if let Some(&(last, _)) = out.last().filter(|(last, _)| last < from) {
            out.extend([(last, 0.0), (*from, 0.0)]);
        }
        out.extend([(*from, 100.0 * fraction), (*to, 100.0 * fraction)]);
    }
    out.push((bins[bins.len() - 1].1, 0.0));
    out
}

/// A labelled vertical line.
#[derive(Debug, Clone)]
struct Mark {
    at: f64,
    label: String,
    colour: RGBColor,
}

/// Rows of label text that marks need above an area, and each label's row and left end \[px\].
///
/// A label begins at its line, which goes down from it. Marks are placed from left to right, each in
/// the highest row from which its line crosses no label.
fn mark_rows(marks: &[Mark], px: impl Fn(f64) -> f64) -> (usize, Vec<(usize, f64)>) {
    let mut order: Vec<usize> = (0..marks.len()).collect();
    order.sort_by(|&a, &b| marks[a].at.total_cmp(&marks[b].at));
    let mut ends: Vec<f64> = Vec::new();
    let mut places = vec![(0, 0.0); marks.len()];
    for i in order {
        let width = text_width(&marks[i].label, FONT);
        let left = (px(marks[i].at) + 3.0).min(WIDTH - width - 2.0);
        let row = ends
            .iter()
            .rposition(|end| left - 6.0 < *end)
            .map_or(0, |last| last + 1);
        ends.truncate(row);
        ends.push(left + width);
        places[i] = (row, left);
    }
    let rows = places.iter().map(|(row, _)| row + 1).max().unwrap_or(0);
    (rows, places)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_line_crosses_a_label() {
        let mark = |at| Mark {
            at,
            label: "p50 29.97".into(),
            colour: INK,
        };
        let marks: Vec<_> = [300.0, 10.0, 40.0, 55.0, 150.0, 40.0].map(mark).into();
        let (rows, places) = mark_rows(&marks, |v| v);
        assert!(places.iter().all(|(row, _)| *row < rows));
        let width = text_width("p50 29.97", FONT);
        for (i, (line, (from, _))) in marks.iter().zip(&places).enumerate() {
            for (j, (row, left)) in places.iter().enumerate().filter(|(_, p)| p.0 >= *from) {
                assert!(
                    i == j || line.at < *left || line.at > left + width,
                    "{i} crosses {j} in row {row}"
                );
            }
        }
    }

    #[test]
    fn shares_say_of_what() {
        let histogram = Histogram {
            title: String::new(),
            x_label: "latency [ms]".into(),
            series: Vec::new(),
            bounds: None,
        };
        let bins = |ends: [f64; 3]| vec![vec![(ends[0], ends[1], 0.5), (ends[1], ends[2], 0.5)]];
        assert_eq!(histogram.bin_name(&bins([0.0, 0.5, 1.0])), "0.500 ms");
        assert_eq!(histogram.bin_name(&bins([0.0, 0.5, 1.1])), "bin");
    }

    #[test]
    fn steps_fall_to_the_ground_where_bins_are_missing() {
        let steps = steps(&[(1.0, 2.0, 0.5), (2.0, 3.0, 0.25), (4.0, 5.0, 0.25)]);
        let expected = [
            (1.0, 0.0),
            (1.0, 50.0),
            (2.0, 50.0),
            (2.0, 25.0),
            (3.0, 25.0),
            (3.0, 0.0),
            (4.0, 0.0),
            (4.0, 25.0),
            (5.0, 25.0),
            (5.0, 0.0),
        ];
        assert_eq!(steps, expected);
    }
}
