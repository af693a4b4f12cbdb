use plotters::coord::{CoordTranslate, Shift};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::svg::{text_width, wrap};
use crate::theme::{self, INK};

/// Width of every chart \[px\]: narrow, so that its letters stay legible when a phone shrinks it.
pub(crate) const WIDTH: f64 = 560.0;
/// Height of the plotting area of charts that have no rows \[px\].
pub(crate) const PLOT: f64 = 230.0;
/// Height that the horizontal axis needs below the plotting area \[px\].
pub(crate) const FOOT: f64 = 50.0;
/// Size of letters and numbers \[px\].
pub(crate) const FONT: f64 = 14.0;
/// Size of what is said in passing \[px\].
pub(crate) const SMALL: f64 = 12.0;
/// Titles are 16 px, but bold and so wider.
const BOLD: f64 = 18.5;
const LINE: f64 = 20.0;

/// Plotters counts in whole units; quarters of a pixel keep curves smooth and places exact.
const UNITS: f64 = 4.0;

pub(crate) type Backend<'a> = SVGBackend<'a>;
pub(crate) type Area<'a> = DrawingArea<Backend<'a>, Shift>;
/// What drawing could fail with; drawing into memory never does.
pub(crate) type DrawError = DrawingAreaErrorKind<std::io::Error>;
pub(crate) type Drawn = Result<(), DrawError>;

/// Pixels in plotters' units.
pub(crate) fn px(v: f64) -> i32 {
    (v * UNITS).round() as i32
}

/// Where a chart puts a value \[px of the picture\].
pub(crate) fn place<C>(plot: &DrawingArea<Backend<'_>, C>, value: (f64, f64)) -> [f64; 2]
where
    C: CoordTranslate<From = (f64, f64)>,
{
    let (x, y) = plot.map_coordinate(&value);
    [x, y].map(|v| f64::from(v) / UNITS)
}

/// Upper edge of an area \[px of the picture\].
pub(crate) fn top(area: &Area<'_>) -> f64 {
    f64::from(area.get_pixel_range().1.start) / UNITS
}

/// A line from and to \[px of the picture\].
pub(crate) fn ends(from: [f64; 2], to: [f64; 2]) -> [(i32, i32); 2] {
    [from, to].map(|[x, y]| (px(x), px(y)))
}

/// A rectangle between two corners \[px of the picture\].
pub(crate) fn block(root: &Area<'_>, from: [f64; 2], to: [f64; 2], colour: impl Color) -> Drawn {
    root.draw(&Rectangle::new(ends(from, to), colour.filled()))
}

/// A stroke of the colour, `width` px wide.
pub(crate) fn stroke(colour: impl Color, width: f64) -> ShapeStyle {
    colour.stroke_width(px(width) as u32)
}

/// Ground that means something: gaps, bounds.
pub(crate) fn shade() -> RGBAColor {
    INK.mix(0.1)
}

/// Edges of such ground, and levels.
pub(crate) fn edge() -> RGBAColor {
    INK.mix(0.6)
}

/// How a legend shows a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sample {
    Line,
    Dashes,
    Block,
    Dot,
    Ring,
}

/// A named colour in a legend.
#[derive(Debug, Clone)]
pub(crate) struct Key {
    pub(crate) colour: RGBAColor,
    pub(crate) sample: Sample,
    pub(crate) label: String,
}

impl Key {
    pub(crate) fn new(colour: impl Color, sample: Sample, label: &str) -> Self {
        let colour = colour.to_rgba();
        Self {
            colour,
            sample,
            label: label.to_owned(),
        }
    }

    fn width(&self) -> f64 {
        22.0 + text_width(&self.label, FONT) + 14.0
    }
}

/// A picture: title, legend, and below them `height` px that `body` draws. `body` is given the whole
/// picture and the part that is its own.
pub(crate) fn picture(
    title: &str,
    keys: &[Key],
    height: f64,
    body: impl for<'a> FnOnce(&Area<'a>, &Area<'a>) -> Drawn,
) -> String {
    let lines = wrap(title, BOLD, WIDTH - 8.0);
    drawing(title, &lines, keys, height, body)
}

/// A [`picture`] whose name is not written over it.
pub(crate) fn untitled(
    name: &str,
    height: f64,
    body: impl for<'a> FnOnce(&Area<'a>, &Area<'a>) -> Drawn,
) -> String {
    drawing(name, &[], &[], height, body)
}

fn drawing(
    name: &str,
    titles: &[String],
    keys: &[Key],
    height: f64,
    body: impl for<'a> FnOnce(&Area<'a>, &Area<'a>) -> Drawn,
) -> String {
    let places = legend_places(keys);
    let rows = places.last().map_or(0, |(row, _)| row + 1);
    let legend = 8.0 + LINE * titles.len() as f64;
    let top = legend + LINE * rows as f64 + if rows > 0 { 4.0 } else { 0.0 };
    let size = [WIDTH, (top + height).ceil()];
    let mut svg = String::new();
    {
        let units = size.map(|v| (v * UNITS) as u32);
        let root = SVGBackend::with_string(&mut svg, units.into()).into_drawing_area();
        let draw = || -> Drawn {
            for (k, line) in titles.iter().enumerate() {
                let style = style(16.0).font.style(FontStyle::Bold).color(&INK);
                let at = (px(6.0), px(LINE * (k + 1) as f64));
                root.draw_text(&clean(line), &style.pos(anchor(HPos::Left)), at)?;
            }
            for (key, (row, left)) in keys.iter().zip(&places) {
                draw_key(&root, key, [*left, legend + LINE * (row + 1) as f64 - 4.0])?;
            }
            body(&root, &root.margin(px(top), 0, 0, 0))?;
            root.present()
        };
        draw().expect("drawing into memory cannot fail");
    }
    // The file has an opening tag of its own, with the style and the name.
    let elements = svg
        .split_once(">\n")
        .map_or("", |(_, elements)| elements)
        .trim_end()
        .trim_end_matches("</svg>");
    theme::file(name, size, UNITS, elements)
}

/// Row and left end \[px\] of each key.
fn legend_places(keys: &[Key]) -> Vec<(usize, f64)> {
    let (mut row, mut x) = (0, 8.0);
    keys.iter()
        .map(|key| {
            if x > 8.0 && x + key.width() > WIDTH {
                (row, x) = (row + 1, 8.0);
            }
            let place = (row, x);
            x += key.width();
            place
        })
        .collect()
}

fn draw_key(root: &Area<'_>, key: &Key, [x, y]: [f64; 2]) -> Drawn {
    let line = ends([x, y - 8.5], [x + 16.0, y - 8.5]);
    match key.sample {
        Sample::Block => {
            block(root, [x, y - 13.5], [x + 16.0, y - 3.5], key.colour)?;
            outline(root, [x, y - 13.5], [x + 16.0, y - 3.5])?;
        }
        Sample::Line => root.draw(&PathElement::new(line, stroke(key.colour, 1.8)))?,
        Sample::Dashes => root.draw(&dashes(line, stroke(key.colour, 1.6)))?,
        Sample::Dot | Sample::Ring => {
            let style = match key.sample {
                Sample::Ring => stroke(key.colour, 1.4),
                _ => key.colour.filled(),
            };
            root.draw(&Circle::new((px(x + 8.0), px(y - 8.5)), px(3.2), style))?;
        }
    }
    text(root, &key.label, [x + 22.0, y], HPos::Left, FONT, &INK)
}

/// The edge of a rectangle. Plotters gives a rectangle's outline no width in SVG; a path has one.
pub(crate) fn outline(root: &Area<'_>, [l, t]: [f64; 2], [r, b]: [f64; 2]) -> Drawn {
    let corners = [(l, t), (r, t), (r, b), (l, b), (l, t)].map(|(x, y)| (px(x), px(y)));
    root.draw(&PathElement::new(corners, stroke(INK.mix(0.65), 1.0)))
}

/// A broken line.
pub(crate) fn dashes<L>(line: L, style: ShapeStyle) -> DashedPathElement<L::IntoIter, i32>
where
    L: IntoIterator<Item = (i32, i32), IntoIter: Clone>,
{
    DashedPathElement::new(line, px(4.0), px(3.0), style)
}

/// Letters of `font` px in the colour of ink.
pub(crate) fn style(font: f64) -> TextStyle<'static> {
    // Plotters writes the size of letters in SVG as this part of what it is asked for.
    const PLOTTERS: f64 = 1.24;
    ("sans-serif", font * UNITS * PLOTTERS)
        .into_font()
        .color(&INK)
}

fn anchor(h: HPos) -> Pos {
    Pos::new(h, VPos::Bottom)
}

/// Writes at `at` \[px of the picture\], which is on the line below the letters.
pub(crate) fn text(
    root: &Area<'_>,
    text: &str,
    at: [f64; 2],
    h: HPos,
    font: f64,
    colour: &impl Color,
) -> Drawn {
    let style = style(font).color(colour).pos(anchor(h));
    root.draw_text(&clean(text), &style, (px(at[0]), px(at[1])))
}

/// Control characters, which XML 1.0 forbids, become spaces; plotters escapes all else.
pub(crate) fn clean(text: &str) -> String {
    let forbidden = |c: char| c.is_control() || c == '\u{fffe}' || c == '\u{ffff}';
    text.replace(forbidden, " ")
}

/// A picture that says it has nothing to show.
pub(crate) fn nothing(title: &str) -> String {
    picture(title, &[], 40.0, |root, _| {
        let bottom = f64::from(root.dim_in_pixel().1) / UNITS;
        let words = "nothing to show: no values";
        text(root, words, [8.0, bottom - 14.0], HPos::Left, FONT, &INK)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn legends_wrap() {
        let key = Key::new(INK, Sample::Line, "a rather long label of a series");
        let places = legend_places(&[key.clone(), key.clone(), key]);
        assert_eq!(places.iter().map(|p| p.0).collect::<Vec<_>>(), [0, 1, 2]);
    }
}
