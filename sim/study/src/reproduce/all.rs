use foveasim_reports::Page;

use super::{Paper, Published, Verdict};

/// Every printed number that is reproduced, of all papers.
#[derive(Debug, Clone, PartialEq)]
pub struct AllPublished {
    /// Paper by paper.
    pub numbers: Vec<Published>,
    /// Whether measurements were small ones, whose times mean little.
    pub quick: bool,
}

impl AllPublished {
    /// How many numbers have this verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.of(verdict).count()
    }

    /// The numbers with this verdict.
    pub fn of(&self, verdict: Verdict) -> impl Iterator<Item = &Published> {
        self.numbers.iter().filter(move |p| p.verdict() == verdict)
    }

    /// The outcome in one sentence.
    pub fn sentence(&self) -> String {
        let [agreed, explained, differing] =
            [Verdict::Agreed, Verdict::Explained, Verdict::Differs].map(|v| self.count(v));
        let times = self.of(Verdict::Explained).filter(|p| p.is_measured());
        format!(
            "Of {} numbers that {} papers print or that follow from their equations, {agreed} agree, {explained} differ for a \
             stated reason ({} of these are times of this machine), and {differing} differ without one.",
            self.numbers.len(),
            Paper::ALL.len(),
            times.count(),
        )
    }

    /// All of it in one page.
    pub fn page(&self) -> String {
        let mut page = Page::new("Published numbers, reproduced");
        page.paragraph(&self.sentence());
        let cards = [
            (Verdict::Agreed, "agreed: the same to the tolerance stated"),
            (
                Verdict::Explained,
                "explained: they differ, and it is said why",
            ),
            (Verdict::Differs, "differ without an explanation"),
        ]
        .map(|(verdict, label)| (self.count(verdict).to_string(), label));
        page.key_numbers(&cards.each_ref().map(|(n, label)| (n.as_str(), *label)));
        if self.quick {
            page.note(
                "Measured with small pictures of few moments (--quick): times of this machine mean little here.",
            );
        }
        page.paragraph(
            "Printed numbers agree if they are the same to half of their last digit, or to the tolerance in the table. Explained \
             ones may differ by no more than the explanation accounts for, which is their tolerance. Times measured on this \
             machine never agree: they are of another machine than the paper's. What is not printed but follows from a \
             paper's equations is held against an independent solution of them.",
        );
        let differing: Vec<&Published> = self.of(Verdict::Differs).collect();
        if !differing.is_empty() {
            page.heading("What differs");
            add_table(&mut page, "", &differing);
        }
        for paper in Paper::ALL {
            let of_paper = self.numbers.iter().filter(|p| p.paper == paper);
            let (times, others): (Vec<_>, Vec<_>) = of_paper.partition(|p| p.is_measured());
            if times.is_empty() && others.is_empty() {
                continue;
            }
            page.heading(paper.title());
            if !others.is_empty() {
                add_table(&mut page, "Computed, counted and simulated", &others);
            }
            if !times.is_empty() {
                add_table(
                    &mut page,
                    "Times of this machine beside the paper's",
                    &times,
                );
            }
        }
        page.heading("How to reproduce it");
        page.preformatted(if self.quick {
            "foveasim reproduce all --quick"
        } else {
            "foveasim reproduce all"
        });
        page.paragraph(
            "Each paper's folder beside this page holds what its own reproduction shows: tables as CSV, charts, pictures and a page.",
        );
        page.html()
    }
}

/// A table of numbers, and below it why some differ.
fn add_table(page: &mut Page, caption: &str, numbers: &[&Published]) {
    let (table, reasons) = Published::page_table(numbers);
    page.table(caption, &table);
    if !reasons.is_empty() {
        let numbered = reasons.iter().zip(1..);
        page.list(numbered.map(|(why, k)| format!("[{k}] {why}.")));
    }
}
