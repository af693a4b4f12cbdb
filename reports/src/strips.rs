use plotters::prelude::Color;
use plotters::style::text_anchor::HPos;

use crate::axes::{drawable, exactly};
use crate::frame::{Key, SMALL, Sample, WIDTH, block, nothing, outline, picture, place, text};
use crate::rows::Rows;
use crate::svg::text_width;
use crate::theme::{self, INK};

/// One line of [`Strips`]: what happened one after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// Which case it is.
    pub name: String,
    /// How long each of [`Strips::stages`] took \[ms\], in their order.
    pub lengths_ms: Vec<f64>,
}

/// Cases beside each other, each a row of stages along time: Guenter 2012, Fig. 5, for any set-up.
#[derive(Debug, Clone, PartialEq)]
pub struct Strips {
    /// What is shown.
    pub title: String,
    /// The stages in the order they happen; a stage that takes no time in any case is left out.
    pub stages: Vec<String>,
    /// The cases, top to bottom.
    pub strips: Vec<Strip>,
}

/// Height of a row and of its bar \[px\].
const ROW: f64 = 52.0;
const BAR: f64 = 28.0;

impl Strips {
    /// The picture.
    ///
    /// # Panics
    /// If a strip does not have one length per stage.
    pub fn svg(&self) -> String {
        for strip in &self.strips {
            let lengths = strip.lengths_ms.len();
            assert_eq!(lengths, self.stages.len(), "stages of {}", strip.name);
        }
        let lengths = || self.strips.iter().flat_map(|s| &s.lengths_ms);
        if self.strips.is_empty() || !lengths().copied().all(|ms| drawable(ms) && ms >= 0.0) {
            return nothing(&self.title);
        }
        let totals = self.strips.iter().map(|s| s.lengths_ms.iter().sum::<f64>());
        let x = exactly(0.0, totals.fold(0.0, f64::max));
        let shown: Vec<usize> = (0..self.stages.len())
            .filter(|i| self.strips.iter().any(|s| s.lengths_ms[*i] > 0.0))
            .collect();
        // By its place among all stages: the same in every picture, whatever others there are.
        let colour = |k: usize| theme::series(k).mix(if k < theme::COLOURS { 0.5 } else { 0.2 });
        let keys: Vec<Key> = shown
            .iter()
            .map(|i| Key::new(colour(*i), Sample::Block, &self.stages[*i]))
            .collect();
        let rows = Rows {
            names: self.strips.iter().map(|s| s.name.as_str()).collect(),
            names_at_most: 110.0,
            height: ROW,
            above: 8.0,
            right: 78.0,
        };
        picture(&self.title, &keys, rows.total_height(), |root, body| {
            let chart = rows.chart(root, body, &x, "time since the movement [ms]")?;
            for (row, strip) in self.strips.iter().enumerate() {
                let at = |ms: f64| place(chart.plotting_area(), (ms, row as f64));
                let top = at(0.0)[1] + (ROW - BAR) / 2.0;
                let mut from = 0.0;
                for i in &shown {
                    let ms = strip.lengths_ms[*i];
                    let (left, right) = (at(from)[0], at(from + ms)[0]);
                    if ms > 0.0 {
                        block(root, [left, top], [right, top + BAR], colour(*i))?;
                        outline(root, [left, top], [right, top + BAR])?;
                    }
                    let number = format!("{ms:.1}");
                    if right - left > text_width(&number, SMALL) + 4.0 {
                        let middle = (left + right) / 2.0 + text_width(&number, SMALL) / 2.0;
                        let line = [middle, top + BAR / 2.0 + 7.5];
                        text(root, &number, line, HPos::Right, SMALL, &INK)?;
                    }
                    from += ms;
                }
                let total = format!("{from:.2} ms");
                let line = [WIDTH - 4.0, top + BAR / 2.0 + 7.5];
                text(root, &total, line, HPos::Right, SMALL, &INK)?;
            }
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_that_take_no_time_are_left_out() {
        let strips = Strips {
            title: "cases".into(),
            stages: ["tracker", "nothing", "render"].map(str::to_owned).into(),
            strips: vec![
                Strip {
                    name: "best".into(),
                    lengths_ms: vec![7.0, 0.0, 8.0],
                },
                Strip {
                    name: "worst".into(),
                    lengths_ms: vec![10.0, 0.0, 16.0],
                },
            ],
        };
        let svg = strips.svg();
        for word in ["tracker", "render", "best", "worst", "15.00 ms", "26.00 ms"] {
            assert!(svg.contains(word), "{word}");
        }
        assert!(!svg.contains("nothing"));
        let wrong = |ms| {
            let mut strips = strips.clone();
            strips.strips[0].lengths_ms[0] = ms;
            strips.svg()
        };
        assert!(wrong(f64::NAN).contains("nothing to show"));
        assert!(wrong(-1.0).contains("nothing to show"));
    }
}
