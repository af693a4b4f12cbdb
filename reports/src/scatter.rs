use plotters::prelude::{ChartBuilder, Circle, PathElement};
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use crate::axes::{Axes, drawable};
use crate::decades::Scale;
use crate::frame::{
    FONT, FOOT, Key, Sample, dashes, edge, ends, nothing, picture, place, px, stroke, text, top,
};
use crate::svg::text_width;
use crate::theme::{self, INK};

/// Dots of one kind in a [`ScatterChart`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScatterSeries {
    /// Its name.
    pub label: String,
    /// Where dots are (x, y).
    pub points: Vec<[f64; 2]>,
    /// What stands beside each dot; may be shorter than `points`, and empty where nothing should.
    pub names: Vec<String>,
    /// Whether dots are rings.
    pub hollow: bool,
}

/// Quantities over another, as dots: predicted over measured, error over time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScatterChart {
    /// What is shown.
    pub title: String,
    /// Name and unit of the horizontal quantity.
    pub x_label: String,
    /// Name and unit of the vertical quantity.
    pub y_label: String,
    /// Whether an axis is logarithmic: the horizontal, the vertical one. Values of 0 and less are not drawn there.
    pub logarithmic: [bool; 2],
    /// The dots.
    pub series: Vec<ScatterSeries>,
    /// A line through these places, and what it is: a front.
    pub line: Option<(String, Vec<[f64; 2]>)>,
    /// What it means to lie where both quantities are the same: that line is drawn.
    pub identity: Option<String>,
}

/// Height of the plotting area \[px\].
const HEIGHT: f64 = 340.0;
/// Numbers along the axes, at most.
const COUNT: [usize; 2] = [8, 8];
/// Size of names beside dots \[px\].
const NAME: f64 = 11.5;
const RADIUS: f64 = 3.2;

impl ScatterChart {
    /// The picture. A name that finds no room beside its dot is left out.
    pub fn svg(&self) -> String {
        let fits = |p: &[f64; 2]| {
            let fits = |k: usize| drawable(p[k]) && (!self.logarithmic[k] || p[k] > 0.0);
            fits(0) && fits(1)
        };
        let line = self.line.iter().flat_map(|(_, points)| points);
        let dots = self.series.iter().flat_map(|s| &s.points);
        let all: Vec<[f64; 2]> = line.chain(dots).copied().filter(fits).collect();
        if all.is_empty() {
            return nothing(&self.title);
        }
        let mut spans = [0, 1].map(|k| {
            let ends = [f64::INFINITY, f64::NEG_INFINITY];
            all.iter()
                .fold(ends, |[a, b], p| [a.min(p[k]), b.max(p[k])])
        });
        if self.identity.is_some() {
            let both = [spans[0][0].min(spans[1][0]), spans[0][1].max(spans[1][1])];
            spans = [both; 2];
        }
        let [x, y] = [0, 1].map(|k| Scale::over(spans[k], self.logarithmic[k], COUNT[k]));
        let y_numbers = y.texts();
        let widest = y_numbers.iter().map(|t| text_width(t, FONT));
        let left = widest.fold(0.0, f64::max) + 12.0;
        picture(
            &self.title,
            &self.keys(),
            28.0 + HEIGHT + FOOT,
            |root, body| {
                let at = [6.0, top(body) + 18.0];
                text(root, &self.y_label, at, HPos::Left, FONT, &INK)?;
                let mut chart = ChartBuilder::on(body)
                    .margin_top(px(28.0))
                    .margin_left(px(2.0))
                    .margin_right(px(26.0))
                    .x_label_area_size(px(FOOT))
                    .y_label_area_size(px(left))
                    .build_cartesian_2d(x.ticked(), y.ticked())?;
                Axes {
                    x_label: &self.x_label,
                    count: COUNT,
                    grid: [true, true],
                    x_text: &|v| x.text(*v),
                    y_text: &|v| y.text(*v),
                }
                .draw(&mut chart)?;
                let plot = chart.plotting_area();
                let at = |p: &[f64; 2]| place(plot, (x.place(p[0]), y.place(p[1])));
                if self.identity.is_some() {
                    // Both axes run over the same places.
                    let corner = |v| place(plot, (v, v));
                    let line = ends(corner(x.start()), corner(x.end()));
                    root.draw(&dashes(line, stroke(edge(), 1.0)))?;
                }
                if let Some((_, points)) = &self.line {
                    let points = points.iter().filter(|p| fits(p)).map(at);
                    let points: Vec<_> = points.map(|[x, y]| (px(x), px(y))).collect();
                    root.draw(&PathElement::new(points, stroke(INK.mix(0.55), 1.4)))?;
                }
                let mut room = Room::default();
                for (i, series) in self.series.iter().enumerate() {
                    let colour = theme::series(i);
                    for p in series.points.iter().filter(|p| fits(p)) {
                        let [x, y] = at(p);
                        room.taken
                            .push([x - RADIUS, y - RADIUS, x + RADIUS, y + RADIUS]);
                        let style = match series.hollow {
                            true => stroke(colour, 1.4),
                            false => colour.mix(0.85).filled(),
                        };
                        root.draw(&Circle::new((px(x), px(y)), px(RADIUS), style))?;
                    }
                }
                let [left, top] = place(plot, (x.start(), y.end()));
                let [right, bottom] = place(plot, (x.end(), y.start()));
                for series in &self.series {
                    let named = series.points.iter().zip(&series.names);
                    for (p, name) in named.filter(|(p, name)| fits(p) && !name.is_empty()) {
                        if let Some(at) = room.beside(at(p), name, [left, top, right, bottom]) {
                            text(root, name, at, HPos::Left, NAME, &INK)?;
                        }
                    }
                }
                Ok(())
            },
        )
    }

    fn keys(&self) -> Vec<Key> {
        let named = self.series.iter().enumerate();
        let named = named.filter(|(_, s)| !s.label.is_empty());
        let mut keys: Vec<Key> = named
            .map(|(i, s)| {
                let sample = if s.hollow { Sample::Ring } else { Sample::Dot };
                Key::new(theme::series(i), sample, &s.label)
            })
            .collect();
        if let Some((label, _)) = &self.line {
            keys.push(Key::new(INK.mix(0.55), Sample::Line, label));
        }
        if let Some(label) = &self.identity {
            keys.push(Key::new(edge(), Sample::Dashes, label));
        }
        keys
    }
}

/// Which rectangles of a picture are taken: left, upper, right and lower edge \[px\].
#[derive(Debug, Default)]
struct Room {
    taken: Vec<[f64; 4]>,
}

impl Room {
    /// Where a name beside a dot begins and stands \[px\], if there is room within `bounds`.
    fn beside(&mut self, [x, y]: [f64; 2], name: &str, bounds: [f64; 4]) -> Option<[f64; 2]> {
        let (width, height) = (text_width(name, NAME), NAME);
        let near = RADIUS + 2.5;
        let rows = [0.0, -0.7, 0.7, -1.2, 1.2, -1.9, 1.9];
        let sides = [near, -near - width];
        let beside = sides
            .into_iter()
            .flat_map(|side| rows.map(|row| [side, row]));
        let over = [[-0.5 * width, -1.15], [-0.5 * width, 1.15]];
        let mut found = beside.chain(over).map(|[side, row]| {
            let (left, upper) = (x + side, y + (row - 0.5) * height);
            [left, upper, left + width, upper + height]
        });
        let apart = |a: &[f64; 4], b: &[f64; 4]| {
            a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1]
        };
        let free = found.find(|r| {
            let within = r[0] >= bounds[0] && r[1] >= bounds[1] && r[2] <= bounds[2] + 20.0;
            within && r[3] <= bounds[3] && self.taken.iter().all(|t| apart(r, t))
        })?;
        self.taken.push(free);
        Some([free[0], free[3] - 1.0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: Vec<[f64; 2]>) -> ScatterChart {
        let names = (0..points.len()).map(|k| format!("dot {k}")).collect();
        ScatterChart {
            title: "Dots".into(),
            x_label: "measured [ms]".into(),
            y_label: "predicted [ms]".into(),
            logarithmic: [true, true],
            series: vec![ScatterSeries {
                label: "all".into(),
                points,
                names,
                hollow: false,
            }],
            identity: Some("as measured".into()),
            ..ScatterChart::default()
        }
    }

    #[test]
    fn dots_names_and_lines_are_there() {
        let svg = chart(vec![[1.0, 2.0], [300.0, 280.0]]).svg();
        // Two dots and the legend's.
        assert_eq!(svg.matches("<circle").count(), 3, "{svg}");
        for words in ["dot 0", "dot 1", "as measured", "measured [ms]", "100\n"] {
            assert!(svg.contains(words), "{words}");
        }
    }

    #[test]
    fn what_cannot_be_placed_is_left_out() {
        let svg = chart(vec![[0.0, 2.0], [f64::NAN, 1.0], [-1.0, 1.0], [1.0, 1e200]]).svg();
        assert!(svg.contains("nothing to show"));
        // Names on one place: as many as find room beside it, none over another.
        let svg = chart(vec![[1.0, 1.0]; 60]).svg();
        let names = svg.matches("dot ").count();
        assert!((4..60).contains(&names), "{names}");
        let mut room = Room::default();
        for _ in 0..60 {
            room.beside([100.0, 100.0], "name", [0.0, 0.0, 200.0, 200.0]);
        }
        for (i, a) in room.taken.iter().enumerate() {
            for b in &room.taken[..i] {
                assert!(a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1]);
            }
        }
    }
}
