use std::fmt::Write;

use plotters::style::{Color, RGBColor};

use crate::svg::{escape, number};

/// Lines, letters and all else that is neither data nor background.
pub(crate) const INK: RGBColor = RGBColor(0x1b, 0x1f, 0x24);

/// Colours of the series: Okabe and Ito's, told apart by colour-blind viewers, darkened for white.
const SERIES: [RGBColor; 8] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xc9, 0x51, 0x0c),
    RGBColor(0x00, 0x83, 0x5f),
    RGBColor(0xa0, 0x3a, 0x8c),
    RGBColor(0x8f, 0x64, 0x10),
    RGBColor(0x5d, 0x5d, 0x5d),
    RGBColor(0x5e, 0x3c, 0x99),
    RGBColor(0x8c, 0x2d, 0x04),
];

const INK_ON_DARK: RGBColor = RGBColor(0xe4, 0xe7, 0xeb);

/// [`SERIES`], lightened for black.
const SERIES_ON_DARK: [RGBColor; 8] = [
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0xff, 0x92, 0x48),
    RGBColor(0x2f, 0xd0, 0xa0),
    RGBColor(0xe5, 0x8a, 0xd4),
    RGBColor(0xe6, 0xb4, 0x50),
    RGBColor(0xb5, 0xb5, 0xb5),
    RGBColor(0xb9, 0xa3, 0xe3),
    RGBColor(0xff, 0xb1, 0x99),
];

/// How many colours of series there are.
pub(crate) const COLOURS: usize = SERIES.len();

/// Colour of series `i`; eight colours, then again from the first.
pub(crate) fn series(i: usize) -> RGBColor {
    SERIES[i % SERIES.len()]
}

/// A drawing as one SVG file that suits light and dark surroundings.
///
/// `elements` carry the colours for light surroundings as attributes, which every viewer shows; the
/// style sheet exchanges exactly these where the reader prefers dark. All other colours (of a colour
/// map, say) mean the same in both and stay. It has no ids, so that many files can stand in one page.
///
/// `size` is the picture's \[px\]; the elements count in units of which `units` are one pixel.
pub(crate) fn file(title: &str, size: [f64; 2], units: f64, elements: &str) -> String {
    let ([w, h], title) = (size.map(number), escape(title));
    let [view_w, view_h] = size.map(|v| number(v * units));
    let style = style();
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"fv\" viewBox=\"0 0 {view_w} {view_h}\" \
         width=\"{w}\" height=\"{h}\" role=\"img\" aria-label=\"{title}\">\n\
         <style>{style}</style>\n{elements}</svg>\n"
    )
}

fn style() -> String {
    // A style beats attributes: text has the reader's own face, whichever the drawing asks for.
    let mut out = String::from(
        ".fv text{font-family:system-ui,'Segoe UI',Roboto,sans-serif}\
         .fv polyline{stroke-linejoin:round}.fv rect{shape-rendering:crispEdges}\
         @media (prefers-color-scheme:dark){",
    );
    let pairs = SERIES.into_iter().zip(SERIES_ON_DARK);
    for (light, dark) in pairs.chain([(INK, INK_ON_DARK)]) {
        let (light, dark) = (hex(light), hex(dark));
        for property in ["fill", "stroke"] {
            // Writing to a string cannot fail.
            let _ = write!(out, ".fv [{property}=\"{light}\"]{{{property}:{dark}}}");
        }
    }
    out.push('}');
    out
}

/// A colour as plotters writes it: attribute selectors tell upper from lower case.
pub(crate) fn hex(colour: RGBColor) -> String {
    let (r, g, b) = colour.rgb();
    format!("#{r:02X}{g:02X}{b:02X}")
}

#[cfg(test)]
mod tests {
    use plotters::prelude::{DrawingBackend, SVGBackend};

    use super::*;
    use crate::ColourMap;

    #[test]
    fn the_style_finds_what_plotters_writes() {
        for colour in SERIES.into_iter().chain([INK]) {
            let mut drawing = String::new();
            {
                let mut backend = SVGBackend::with_string(&mut drawing, (9, 9));
                backend.draw_rect((0, 0), (5, 5), &colour, true).unwrap();
                backend.draw_line((0, 0), (5, 5), &colour).unwrap();
            }
            for property in ["fill", "stroke"] {
                let attribute = format!("{property}=\"{}\"", hex(colour));
                assert!(drawing.contains(&attribute), "{drawing}");
                assert!(style().contains(&format!("[{attribute}]")));
            }
        }
    }

    #[test]
    fn colour_maps_keep_their_colours() {
        for map in [ColourMap::Viridis, ColourMap::Inferno] {
            for k in 0..=4096 {
                let [r, g, b] = map.at(f64::from(k) / 4096.0);
                let colour = RGBColor(r, g, b);
                assert!(colour != INK && !SERIES.contains(&colour), "{map:?} {k}");
            }
        }
    }
}
