use plotters::prelude::{Color, PathElement};
use plotters::style::text_anchor::HPos;

use crate::axes::{drawable, exactly};
use crate::frame::{
    Area, Drawn, Key, SMALL, Sample, WIDTH, block, dashes, edge, ends, nothing, picture, place,
    shade, stroke, text, top,
};
use crate::rows::Rows;
use crate::theme::{self, INK};

/// One stage of a [`Waterfall`], in milliseconds.
#[derive(Debug, Clone, PartialEq)]
pub struct WaterfallStage {
    /// Its name.
    pub name: String,
    /// Shortest seen \[ms\].
    pub best_ms: f64,
    /// Mean \[ms\].
    pub mean_ms: f64,
    /// Longest seen \[ms\].
    pub worst_ms: f64,
    /// Shortest and longest possible by analysis \[ms\].
    pub bounds_ms: Option<[f64; 2]>,
}

/// Where the time goes: stages one after the other, each beginning where the one before ended in its
/// best, mean and worst case.
#[derive(Debug, Clone, PartialEq)]
pub struct Waterfall {
    /// What is shown.
    pub title: String,
    /// The stages in the order they happen.
    pub stages: Vec<WaterfallStage>,
    /// All together as it was seen: the worst of the whole is rarely the sum of the worst parts.
    pub total: Option<WaterfallStage>,
}

const BAR: f64 = 9.0;
const ROW: f64 = 3.0 * BAR + 13.0;

impl Waterfall {
    /// The picture.
    pub fn svg(&self) -> String {
        let stages: Vec<&WaterfallStage> = self.stages.iter().chain(&self.total).collect();
        if stages.is_empty() || !stages.iter().flat_map(|s| s.numbers()).all(drawable) {
            return nothing(&self.title);
        }
        let (low, high) = self.extent();
        let x = exactly(low, high);
        let mut keys: Vec<Key> = ["best", "mean", "worst"]
            .iter()
            .enumerate()
            .map(|(i, l)| Key::new(theme::series(i), Sample::Block, l))
            .collect();
        if stages.iter().any(|s| s.bounds_ms.is_some()) {
            keys.push(Key::new(
                shade(),
                Sample::Block,
                "longest possible by analysis",
            ));
        }
        let rows = Rows {
            names: stages.iter().map(|s| s.name.as_str()).collect(),
            names_at_most: 150.0,
            height: ROW,
            above: 20.0,
            right: 144.0,
        };
        picture(&self.title, &keys, rows.total_height(), |root, body| {
            let chart = rows.chart(root, body, &x, "time since the eye moved [ms]")?;
            let legend = "best / mean / worst ms";
            text(
                root,
                legend,
                [WIDTH - 4.0, top(body) + 18.0],
                HPos::Right,
                SMALL,
                &INK,
            )?;
            let mut from = [0.0; 4];
            for (k, stage) in stages.iter().enumerate() {
                let at = |ms: f64| place(chart.plotting_area(), (ms, k as f64));
                let [_, y] = at(0.0);
                if k == self.stages.len() {
                    from = [0.0; 4];
                    let line = ends([4.0, y], [WIDTH - 4.0, y]);
                    root.draw(&PathElement::new(line, stroke(INK.mix(0.65), 1.0)))?;
                }
                stage.draw(root, y, |ms| at(ms)[0], &mut from)?;
            }
            Ok(())
        })
    }

    /// From the least to the greatest place that is drawn \[ms\].
    fn extent(&self) -> (f64, f64) {
        let mut from = [0.0; 4];
        let (mut low, mut high) = (0.0f64, 0.0f64);
        let mut see = |v: f64| (low, high) = (low.min(v), high.max(v));
        for stage in &self.stages {
            for (from, length) in from.iter_mut().zip(stage.lengths()) {
                *from += length;
                see(*from);
            }
        }
        self.total
            .iter()
            .flat_map(WaterfallStage::lengths)
            .for_each(see);
        (low, high)
    }
}

impl WaterfallStage {
    fn numbers(&self) -> [f64; 5] {
        let [low, high] = self.bounds_ms.unwrap_or([0.0; 2]);
        [self.best_ms, self.mean_ms, self.worst_ms, low, high]
    }

    /// Best, mean, worst, longest possible.
    fn lengths(&self) -> [f64; 4] {
        let [best, mean, worst, _, longest] = self.numbers();
        [best, mean, worst, longest]
    }

    /// Draws the stage in the row at `y`; it begins at `from`, which it moves to its ends.
    fn draw(&self, root: &Area<'_>, y: f64, px: impl Fn(f64) -> f64, from: &mut [f64; 4]) -> Drawn {
        if let Some([_, longest]) = self.bounds_ms {
            let (a, b) = (px(from[3]), px(from[3] + longest));
            block(root, [a, y + 2.0], [b, y + ROW - 2.0], shade())?;
            let end = ends([b, y + 2.0], [b, y + ROW - 2.0]);
            root.draw(&dashes(end, stroke(edge(), 1.0)))?;
            from[3] += longest;
        }
        let lengths = [self.best_ms, self.mean_ms, self.worst_ms];
        for (i, (from, ms)) in from.iter_mut().zip(lengths).enumerate() {
            let (a, b) = (px(*from), px(*from + ms));
            let y = y + 6.5 + BAR * i as f64;
            // A stage that takes no time is still seen to be there.
            let right = a.max(b).max(a.min(b) + 1.0);
            block(
                root,
                [a.min(b), y],
                [right, y + BAR - 1.0],
                theme::series(i),
            )?;
            *from += ms;
        }
        let numbers = lengths.map(|ms| format!("{ms:.2}")).join(" / ");
        let at = [WIDTH - 4.0, y + ROW / 2.0 + 7.5];
        text(root, &numbers, at, HPos::Right, SMALL, &INK)
    }
}
