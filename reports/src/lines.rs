use std::ops::Range;

use plotters::prelude::{ChartBuilder, Circle, LineSeries as Curve};
use plotters::style::text_anchor::HPos;
use plotters::style::{Color, RGBAColor};

use crate::axes::{Axes, drawable, exactly, numbers_width, roomy, tick};
use crate::frame::{
    FONT, FOOT, Key, PLOT, Sample, block, dashes, edge, ends, nothing, picture, place, px, shade,
    stroke, text, top,
};
use crate::number::short;
use crate::theme::{self, COLOURS, INK};

/// One line of a [`LineChart`].
#[derive(Debug, Clone, PartialEq)]
pub struct LineSeries {
    /// Its name.
    pub label: String,
    /// Points (x, y) by increasing x; a point that is not finite breaks the line, and one alone between
    /// two such is a dot.
    pub points: Vec<[f64; 2]>,
}

/// Quantities over another, as lines: gaze error over time, samples over eccentricity.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LineChart {
    /// What is shown.
    pub title: String,
    /// Name and unit of the horizontal quantity.
    pub x_label: String,
    /// Name and unit of the vertical quantity.
    pub y_label: String,
    /// The lines: eight in colours of their own, further ones in the same colours, broken.
    pub series: Vec<LineSeries>,
    /// Stretches of the horizontal axis to shade: missing gaze, lost tracking.
    pub shaded: Vec<[f64; 2]>,
    /// What the shading means; needed if there is any.
    pub shaded_label: String,
    /// Horizontal lines and what they are: a mean, a limit. The legend names them with their value.
    pub levels: Vec<(f64, String)>,
    /// Stretches of the horizontal axis to mark in a colour: events, as saccades.
    pub marked: Vec<[f64; 2]>,
    /// What the marks mean; needed if there is any.
    pub marked_label: String,
}

/// Numbers along the axes, at most.
const COUNT: [usize; 2] = [8, 6];

impl LineChart {
    /// The picture. A line with more points than the picture has columns is drawn by its extremes in
    /// each column, so no peak is lost. Values beyond 10¹⁰⁰ count as not finite.
    pub fn svg(&self) -> String {
        let points = || {
            self.series
                .iter()
                .flat_map(|s| &s.points)
                .filter(|p| is_drawable(p))
        };
        if points().next().is_none() {
            return nothing(&self.title);
        }
        let stretches = |of: &[[f64; 2]]| {
            let of = of.iter().copied();
            merged(of.filter(|s| is_drawable(s) && s[0] <= s[1]).collect())
        };
        let (shaded, marked) = (stretches(&self.shaded), stretches(&self.marked));
        let levels: Vec<&(f64, String)> = self.levels.iter().filter(|l| drawable(l.0)).collect();
        let span = |k: usize, others: &[f64]| {
            let all = || points().map(|p| p[k]).chain(others.iter().copied());
            let low = all().fold(f64::INFINITY, f64::min);
            (low, all().fold(f64::NEG_INFINITY, f64::max))
        };
        let (low, high) = span(0, &[shaded.as_flattened(), marked.as_flattened()].concat());
        let x = exactly(low, high);
        let (low, high) = span(1, &levels.iter().map(|l| l.0).collect::<Vec<_>>());
        let y = roomy(low, high);

        let height = 28.0 + PLOT + FOOT;
        picture(
            &self.title,
            &self.keys(!shaded.is_empty(), !marked.is_empty(), &levels),
            height,
            |root, body| {
                text(
                    root,
                    &self.y_label,
                    [6.0, top(body) + 18.0],
                    HPos::Left,
                    FONT,
                    &INK,
                )?;
                let mut chart = ChartBuilder::on(body)
                    .margin_top(px(28.0))
                    .margin_left(px(2.0))
                    .margin_right(px(26.0))
                    .x_label_area_size(px(FOOT))
                    .y_label_area_size(px(numbers_width(&y, COUNT[1]) + 12.0))
                    .build_cartesian_2d(x.clone(), y.clone())?;
                Axes {
                    x_label: &self.x_label,
                    count: COUNT,
                    grid: [true, true],
                    x_text: &|v| tick(*v),
                    y_text: &|v| tick(*v),
                }
                .draw(&mut chart)?;
                let plot = chart.plotting_area();
                let grounds = [(shaded, shade()), (marked, mark())];
                let grounds = grounds
                    .into_iter()
                    .flat_map(|(of, colour)| of.into_iter().map(move |s| (s, colour)));
                for ([from, to], colour) in grounds {
                    let ([left, upper], [right, lower]) =
                        (place(plot, (from, y.end)), place(plot, (to, y.start)));
                    block(root, [left, upper], [right.max(left + 0.75), lower], colour)?;
                }
                for (i, series) in self.series.iter().enumerate() {
                    let style = stroke(theme::series(i), 1.8);
                    let runs = || series.points.split(|p| !is_drawable(p));
                    // A series of lone points is a cloud, whose dots are all there is to see.
                    let radius = if runs().all(|r| r.len() < 2) {
                        2.2
                    } else {
                        1.25
                    };
                    for run in runs() {
                        match run {
                            // A lone point between gaps would be a line without length.
                            [only] => {
                                let dot =
                                    Circle::new((only[0], only[1]), px(radius), style.filled());
                                chart.plotting_area().draw(&dot)?;
                            }
                            _ => {
                                let line = thinned(run, &x).into_iter().map(|[x, y]| (x, y));
                                if i < COLOURS {
                                    chart.draw_series(Curve::new(line, style))?;
                                } else {
                                    let plot = chart.plotting_area();
                                    let line: Vec<_> =
                                        line.map(|p| plot.map_coordinate(&p)).collect();
                                    root.draw(&dashes(line, style))?;
                                }
                            }
                        }
                    }
                }
                let plot = chart.plotting_area();
                for (level, _) in &levels {
                    let line = ends(place(plot, (x.start, *level)), place(plot, (x.end, *level)));
                    root.draw(&dashes(line, stroke(edge(), 1.0)))?;
                }
                Ok(())
            },
        )
    }

    fn keys(&self, shaded: bool, marked: bool, levels: &[&(f64, String)]) -> Vec<Key> {
        let series = self.series.iter().enumerate();
        let mut keys: Vec<Key> = series
            .map(|(i, s)| {
                let sample = if i < COLOURS {
                    Sample::Line
                } else {
                    Sample::Dashes
                };
                Key::new(theme::series(i), sample, &s.label)
            })
            .collect();
        if shaded {
            keys.push(Key::new(shade(), Sample::Block, &self.shaded_label));
        }
        if marked {
            keys.push(Key::new(mark(), Sample::Block, &self.marked_label));
        }
        keys.extend(levels.iter().map(|(level, label)| {
            Key::new(
                edge(),
                Sample::Dashes,
                &format!("{label}: {}", short(*level)),
            )
        }));
        keys
    }
}

/// Ground of events: a colour that few charts have so many lines for, and thin enough to see lines on.
fn mark() -> RGBAColor {
    theme::series(4).mix(0.3)
}

fn is_drawable(p: &[f64; 2]) -> bool {
    p.iter().all(|v| drawable(*v))
}

/// Stretches by place, those that touch made one: shading twice would look like something else.
fn merged(mut stretches: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    stretches.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut out: Vec<[f64; 2]> = Vec::new();
    for s in stretches {
        match out.last_mut() {
            Some(last) if s[0] <= last[1] => last[1] = last[1].max(s[1]),
            _ => out.push(s),
        }
    }
    out
}

/// First, lowest, highest and last point of each half pixel column, in their order.
fn thinned(points: &[[f64; 2]], x: &Range<f64>) -> Vec<[f64; 2]> {
    const COLUMNS: f64 = 1000.0;
    let column = |p: &[f64; 2]| ((p[0] - x.start) / (x.end - x.start) * COLUMNS).floor();
    let mut out = Vec::new();
    for run in points.chunk_by(|a, b| column(a) == column(b)) {
        if run.len() <= 4 {
            out.extend_from_slice(run);
            continue;
        }
        let by_height = |i: &usize, j: &usize| run[*i][1].total_cmp(&run[*j][1]);
        let low = (0..run.len()).min_by(by_height).unwrap_or(0);
        let high = (0..run.len()).max_by(by_height).unwrap_or(0);
        let mut kept = vec![0, low, high, run.len() - 1];
        kept.sort_unstable();
        kept.dedup();
        out.extend(kept.into_iter().map(|i| run[i]));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_every_peak() {
        let mut points: Vec<[f64; 2]> = (0..100_000).map(|i| [f64::from(i) * 0.005, 0.0]).collect();
        points[31_415][1] = 9.0;
        points[27_182][1] = -9.0;
        let thin = thinned(&points, &(0.0..500.0));
        assert!(thin.len() < 4100, "{}", thin.len());
        assert!(thin.contains(&points[31_415]) && thin.contains(&points[27_182]));
        assert_eq!((thin.first(), thin.last()), (points.first(), points.last()));
    }

    #[test]
    fn stretches_that_touch_are_one() {
        let out = merged(vec![[5.0, 6.0], [0.0, 2.0], [1.0, 3.0], [3.0, 4.0]]);
        assert_eq!(out, [[0.0, 4.0], [5.0, 6.0]]);
    }
}
