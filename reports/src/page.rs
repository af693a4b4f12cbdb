use std::fmt::Write;

use foveasim_models::Image;

use crate::picture::data_uri;
use crate::svg::escape;
use crate::table::readable;
use crate::{Cell, ReportError, Table};

/// Significant digits of numbers in tables; the CSV files have all.
const PAGE_DIGITS: usize = 5;

/// Longer text in a table wraps.
const PROSE_CHARS: usize = 48;

const CSS: &str = include_str!("page.css");

/// One HTML page in the making, with everything it shows inside it: it needs no network, no script
/// and no other file, suits light and dark, wide and narrow, and is written top to bottom.
///
/// All text given to it is shown as it is; markup in it has no effect.
#[derive(Debug, Clone)]
pub struct Page {
    title: String,
    sections: Vec<String>,
    body: String,
}

impl Page {
    /// An empty page.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            sections: Vec::new(),
            body: String::new(),
        }
    }

    /// Begins a section; the list of sections stands at the top of the page.
    pub fn heading(&mut self, text: &str) {
        self.sections.push(text.to_owned());
        let (n, text) = (self.sections.len(), escape(text));
        self.push(format_args!("<h2 id=\"section-{n}\">{text}</h2>"));
    }

    /// Begins a part of a section.
    pub fn subheading(&mut self, text: &str) {
        self.element("h3", text);
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.element("p", text);
    }

    /// A paragraph that stands out: an assumption, a warning.
    pub fn note(&mut self, text: &str) {
        self.push(format_args!("<p class=\"note\">{}</p>", escape(text)));
    }

    /// Points below each other.
    pub fn list<S: AsRef<str>>(&mut self, items: impl IntoIterator<Item = S>) {
        self.push(format_args!("<ul>"));
        for item in items {
            self.element("li", item.as_ref());
        }
        self.push(format_args!("</ul>"));
    }

    /// Text in its own lines and a fixed-width face: a command, a scenario file.
    pub fn preformatted(&mut self, text: &str) {
        self.element("pre", text);
    }

    /// The numbers that matter most, large: (value with unit, what it is).
    pub fn key_numbers(&mut self, numbers: &[(&str, &str)]) {
        self.push(format_args!("<div class=\"cards\">"));
        for (value, label) in numbers {
            let (value, label) = (escape(value), escape(label));
            self.push(format_args!(
                "<div class=\"card\"><b>{value}</b><span>{label}</span></div>"
            ));
        }
        self.push(format_args!("</div>"));
    }

    /// A table; a wide one scrolls sideways.
    pub fn table(&mut self, caption: &str, table: &Table) {
        let numeric: Vec<bool> = (0..table.columns().len())
            .map(|c| !table.rows().iter().any(|r| matches!(r[c], Cell::Text(_))))
            .collect();
        // Sentences wrap, names and numbers do not.
        let prose: Vec<bool> = (0..table.columns().len())
            .map(|c| table.rows().iter().any(|r| is_prose(&r[c])))
            .collect();
        let class = |c: usize| match (numeric[c], prose[c]) {
            (true, _) => " class=\"n\"",
            (false, true) => " class=\"t\"",
            (false, false) => "",
        };
        let mut out = format!(
            "<div class=\"wide\"><table><caption>{}</caption><thead><tr>",
            escape(caption)
        );
        for (c, name) in table.columns().iter().enumerate() {
            // Long names may break after an underscore, so that wide tables fit.
            let name = escape(name).replace('_', "_<wbr>");
            let _ = write!(out, "<th scope=\"col\"{}>{name}</th>", class(c));
        }
        out.push_str("</tr></thead><tbody>\n");
        for row in table.rows() {
            out.push_str("<tr>");
            for (c, cell) in row.iter().enumerate() {
                let _ = write!(
                    out,
                    "<td{}>{}</td>",
                    class(c),
                    escape(&readable(cell, PAGE_DIGITS))
                );
            }
            out.push_str("</tr>\n");
        }
        out.push_str("</tbody></table></div>");
        self.push(format_args!("{out}"));
    }

    /// A chart or annotated picture made by this crate.
    pub fn svg(&mut self, caption: &str, svg: &str) {
        let class = if svg.contains("<image ") {
            "fv picture"
        } else {
            "fv"
        };
        let svg = svg.replacen("class=\"fv\"", &format!("class=\"{class}\""), 1);
        self.push(format_args!(
            "<figure>{svg}{}</figure>",
            figcaption(caption)
        ));
    }

    /// An image.
    ///
    /// # Errors
    /// If it cannot be encoded.
    pub fn picture(&mut self, caption: &str, image: &Image) -> Result<(), ReportError> {
        let (uri, alt, size) = (data_uri(image)?, escape(caption), image.size);
        self.push(format_args!(
            "<figure><img alt=\"{alt}\" width=\"{}\" height=\"{}\" src=\"{uri}\">{}</figure>",
            size.x,
            size.y,
            figcaption(caption)
        ));
        Ok(())
    }

    /// What `build` adds stands side by side where there is room, below each other where not.
    ///
    /// # Errors
    /// Those of `build`.
    pub fn row<E>(&mut self, build: impl FnOnce(&mut Self) -> Result<(), E>) -> Result<(), E> {
        self.push(format_args!("<div class=\"row\">"));
        build(self)?;
        self.push(format_args!("</div>"));
        Ok(())
    }

    /// What `build` adds is folded away under `summary` until somebody opens it.
    ///
    /// # Errors
    /// Those of `build`.
    pub fn details<E>(
        &mut self,
        summary: &str,
        build: impl FnOnce(&mut Self) -> Result<(), E>,
    ) -> Result<(), E> {
        self.push(format_args!(
            "<details><summary>{}</summary>",
            escape(summary)
        ));
        build(self)?;
        self.push(format_args!("</details>"));
        Ok(())
    }

    /// The whole file.
    pub fn html(&self) -> String {
        let title = escape(&self.title);
        let mut out = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}</title>\n<style>\n{CSS}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n"
        );
        if self.sections.len() > 2 {
            out.push_str("<nav aria-label=\"Sections\"><ul>\n");
            for (k, section) in self.sections.iter().enumerate() {
                let _ = writeln!(
                    out,
                    "<li><a href=\"#section-{}\">{}</a></li>",
                    k + 1,
                    escape(section)
                );
            }
            out.push_str("</ul></nav>\n");
        }
        out.push_str(&self.body);
        out.push_str("</main>\n</body>\n</html>\n");
        out
    }

    fn element(&mut self, tag: &str, text: &str) {
        self.push(format_args!("<{tag}>{}</{tag}>", escape(text)));
    }

    fn push(&mut self, markup: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.body, "{markup}");
    }
}

/// Whether a cell is a sentence rather than a name.
fn is_prose(cell: &Cell) -> bool {
    matches!(cell, Cell::Text(text) if text.chars().count() > PROSE_CHARS && text.contains(' '))
}

fn figcaption(caption: &str) -> String {
    if caption.is_empty() {
        String::new()
    } else {
        format!("<figcaption>{}</figcaption>", escape(caption))
    }
}
