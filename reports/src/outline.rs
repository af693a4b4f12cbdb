use std::fmt::Write;

use foveasim_models::{Image, Rect, Viewport, math};
use glam::{DVec2, DVec3};

use crate::ReportError;
use crate::picture::data_uri;
use crate::svg::{escape, number};
use crate::theme;

/// A line to draw over an image: the edge of a layer, a circle of eccentricity, the gaze.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// What it is; drawn beside it by [`annotated`], may be empty.
    pub label: String,
    /// Corners in pixels from the image's top-left corner; they may lie outside the image.
    pub points: Vec<DVec2>,
    /// Whether the last point is joined to the first.
    pub closed: bool,
}

impl Outline {
    /// The edge of a rectangle.
    pub fn rect(label: impl Into<String>, rect: Rect) -> Self {
        let Rect { min, max } = rect;
        let points = vec![min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
        Self {
            label: label.into(),
            points,
            closed: true,
        }
    }

    /// An ellipse with its axes along the image's.
    pub fn ellipse(label: impl Into<String>, centre: DVec2, radii: DVec2) -> Self {
        let point = |k: i32| {
            let angle = math::to_rad(f64::from(k) * 3.0);
            centre + radii * DVec2::new(math::cos(angle), math::sin(angle))
        };
        Self {
            label: label.into(),
            points: (0..120).map(point).collect(),
            closed: true,
        }
    }

    /// All that lies `eccentricity_deg` from the unit direction `gaze` (eye frame): an ellipse,
    /// parabola or hyperbola on the image plane, of which the part before the eye is drawn.
    pub fn eccentricity(
        label: impl Into<String>,
        viewport: &Viewport,
        gaze: DVec3,
        eccentricity_deg: f64,
    ) -> Self {
        let across = gaze.any_orthonormal_vector();
        let up = gaze.cross(across);
        let e = math::to_rad(eccentricity_deg);
        let point = |k: i32| {
            let angle = math::to_rad(f64::from(k) * 2.0);
            let sideways = across * math::cos(angle) + up * math::sin(angle);
            viewport.project(gaze * math::cos(e) + sideways * math::sin(e))
        };
        let all: Vec<Option<DVec2>> = (0..180).map(point).collect();
        // Begin where the curve comes back from behind the eye, if it goes there at all.
        let start = (0..180).find(|&k| all[k].is_some() && all[(k + 179) % 180].is_none());
        let points = (0..180)
            .filter_map(|k| all[(k + start.unwrap_or(0)) % 180])
            .collect();
        Self {
            label: label.into(),
            points,
            closed: start.is_none(),
        }
    }

    /// A cross where the gaze meets the image, `arm` px to each side.
    pub fn cross(label: impl Into<String>, centre: DVec2, arm: f64) -> Self {
        let (x, y) = (DVec2::new(arm, 0.0), DVec2::new(0.0, arm));
        let points = vec![centre - x, centre + x, centre, centre - y, centre + y];
        Self {
            label: label.into(),
            points,
            closed: false,
        }
    }

    /// Its straight pieces.
    fn segments(&self) -> impl Iterator<Item = [DVec2; 2]> {
        let n = self.points.len();
        let pieces = if self.closed { n } else { n.saturating_sub(1) };
        (0..pieces).map(move |k| [self.points[k], self.points[(k + 1) % n]])
    }
}

/// The image with outlines drawn into its pixels: white with a dark rim, so that they are seen on
/// anything. Labels are not drawn.
pub fn overlay(image: &Image, outlines: &[Outline]) -> Image {
    let mut out = image.clone();
    let half = line_width(image) / 2.0;
    for (radius, colour) in [(half * 2.0, [0.0; 3]), (half, [1.0; 3])] {
        for [a, b] in outlines.iter().flat_map(Outline::segments) {
            draw(&mut out, a, b, radius, colour);
        }
    }
    out
}

/// The image inside an SVG, with outlines and their labels as sharp lines and text over it.
///
/// # Errors
/// If the image cannot be encoded.
pub fn annotated(title: &str, image: &Image, outlines: &[Outline]) -> Result<String, ReportError> {
    let size = image.size.as_dvec2();
    let (w, h) = (number(size.x), number(size.y));
    let mut elements = format!(
        "<image width=\"{w}\" height=\"{h}\" href=\"{}\"/>\n",
        data_uri(image)?
    );
    let width = line_width(image);
    for outline in outlines {
        // White on a wider dark line is seen on any picture.
        for (colour, width) in [("#000", width * 2.2), ("#fff", width)] {
            let (path, width) = (path(outline), number(width));
            let opacity = if colour == "#000" { ".55" } else { "1" };
            let _ = writeln!(
                elements,
                "<path fill=\"none\" stroke=\"{colour}\" stroke-opacity=\"{opacity}\" \
                 stroke-width=\"{width}\" stroke-linejoin=\"round\" d=\"{path}\"/>"
            );
        }
    }
    // A picture of any size is shown some hundred pixels wide: letters grow with it.
    let font = (size.x / 40.0).max(9.0);
    let mut taken: Vec<DVec2> = Vec::new();
    for outline in outlines.iter().filter(|o| !o.label.is_empty()) {
        if let Some(at) = label_place(outline, size, font, &mut taken) {
            let _ = writeln!(
                elements,
                "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\" style=\"font-size:{}px;fill:#fff;stroke:#000;\
                 stroke-width:{}px;stroke-opacity:.8;paint-order:stroke;stroke-linejoin:round\">{}</text>",
                number(at.x),
                number(at.y),
                number(font),
                number(font / 4.0),
                escape(&outline.label)
            );
        }
    }
    Ok(theme::file(title, size.to_array(), 1.0, &elements))
}

/// The outline as SVG path data.
fn path(outline: &Outline) -> String {
    let mut data = String::new();
    for (i, p) in outline.points.iter().enumerate() {
        let (command, x, y) = (if i == 0 { 'M' } else { 'L' }, number(p.x), number(p.y));
        // Writing to a string cannot fail.
        let _ = write!(data, "{command}{x} {y}");
    }
    if outline.closed {
        data.push('Z');
    }
    data
}

/// Under the highest visible point of an outline, lower where another label is already.
fn label_place(outline: &Outline, size: DVec2, font: f64, taken: &mut Vec<DVec2>) -> Option<DVec2> {
    // Pieces are long: a rectangle that reaches out of the image may have no corner in it.
    let fine = outline
        .segments()
        .flat_map(|[a, b]| (0..=64).map(move |k| a.lerp(b, f64::from(k) / 64.0)));
    let seen: Vec<DVec2> = fine
        .filter(|p| p.cmpge(DVec2::ZERO).all() && p.cmple(size).all())
        .collect();
    let top = seen.iter().map(|p| p.y).reduce(f64::min)?;
    let highest: Vec<&DVec2> = seen.iter().filter(|p| p.y - top < size.y / 64.0).collect();
    let x = highest.iter().map(|p| p.x).sum::<f64>() / highest.len() as f64;
    let half = crate::svg::text_width(&outline.label, font) / 2.0;
    let x = x.clamp(half.min(size.x / 2.0), (size.x - half).max(size.x / 2.0));
    let mut at = DVec2::new(x, (top + font * 1.35).min(size.y - font * 0.3));
    let overlaps =
        |at: DVec2, t: &DVec2| (t.y - at.y).abs() < font * 1.05 && (t.x - at.x).abs() < 4.0 * half;
    while taken.iter().any(|t| overlaps(at, t)) {
        at.y += font * 1.1;
    }
    taken.push(at);
    Some(at)
}

/// Two pixels on a small image; more on one that will be shown smaller than it is.
fn line_width(image: &Image) -> f64 {
    (f64::from(image.size.x) / 640.0).max(1.5)
}

/// Colours every pixel whose centre is within `radius` of the segment.
fn draw(image: &mut Image, a: DVec2, b: DVec2, radius: f64, colour: [f32; 3]) {
    if !(a.is_finite() && b.is_finite()) {
        return;
    }
    let limit = image.size.as_dvec2();
    let low = (a.min(b) - radius).floor().clamp(DVec2::ZERO, limit);
    let high = (a.max(b) + radius).ceil().clamp(DVec2::ZERO, limit);
    let along = b - a;
    let length = along.length_squared();
    for y in low.y as u32..high.y as u32 {
        for x in low.x as u32..high.x as u32 {
            let p = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let t = if length > 0.0 {
                ((p - a).dot(along) / length).clamp(0.0, 1.0)
            } else {
                0.0
            };
            if (p - a - along * t).length_squared() <= radius * radius {
                image.rgb[(y * image.size.x + x) as usize] = colour;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    #[test]
    fn every_point_has_the_eccentricity_it_says() {
        let viewport = Viewport::symmetric(UVec2::new(800, 600), 1.2).unwrap();
        let gaze = DVec3::new(0.3, -0.2, -1.0).normalize();
        let outline = Outline::eccentricity("10°", &viewport, gaze, 10.0);
        assert!(outline.closed && outline.points.len() == 180);
        for p in outline.points {
            assert!((viewport.eccentricity_deg(p, gaze) - 10.0).abs() < 1e-9);
        }
        // 60° from a gaze 45° to the right reaches behind the image plane: an open curve in order.
        let gaze = DVec3::new(1.0, 0.0, -1.0).normalize();
        let outline = Outline::eccentricity("", &viewport, gaze, 60.0);
        assert!(!outline.closed && outline.points.len() < 180 && outline.points.len() > 20);
        assert!(
            outline
                .points
                .iter()
                .all(|p| (viewport.eccentricity_deg(*p, gaze) - 60.0).abs() < 1e-7)
        );
    }

    #[test]
    fn overlay_draws_the_edge_and_nothing_else() {
        let image = Image::filled(UVec2::new(60, 40), [0.2; 3]);
        let rect = Rect {
            min: DVec2::new(10.0, 10.0),
            max: DVec2::new(50.0, 900.0),
        };
        let out = overlay(&image, &[Outline::rect("", rect)]);
        assert_eq!(out.at(30, 10), [1.0; 3]);
        assert_eq!(out.at(10, 39), [1.0; 3]);
        assert_eq!(out.at(30, 25), [0.2; 3]);
        let nowhere = Outline {
            label: String::new(),
            points: vec![DVec2::NAN; 3],
            closed: true,
        };
        assert_eq!(overlay(&image, &[nowhere]), image);
    }
}
