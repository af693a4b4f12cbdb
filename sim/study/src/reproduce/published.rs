use foveasim_models::math::log10;
use foveasim_reports::{Cell, Table};

use super::Paper;

/// A number that a paper prints, or states in its text, beside ours.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// Who prints it.
    pub paper: Paper,
    /// Where: section, figure, table.
    pub place: &'static str,
    /// What it is, with its unit.
    pub quantity: String,
    /// As printed.
    pub printed: Printed,
    /// What ours rests on.
    pub footing: Footing,
    /// Ours.
    pub ours: f64,
    claim: Claim,
}

/// A printed number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Printed {
    /// As it stands there.
    Number(f64),
    /// A number that ours is not to exceed.
    AtMost(f64),
    /// A number that ours is not to fall short of.
    AtLeast(f64),
    /// Not printed: from an independent solution of the paper's equations, in more digits than f64 has
    /// (docs/reproduce.md).
    Independent(f64),
}

/// What our number rests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Footing {
    /// Computed or counted: the same on every machine, for any seed.
    Computed,
    /// Simulated, or of generated content, from a seed: the same on every machine.
    Simulated,
    /// A time measured on this machine.
    Measured,
}

/// How far the two numbers may be apart, and why.
#[derive(Debug, Clone, PartialEq)]
enum Claim {
    /// No more than this.
    Agrees(f64),
    /// They differ, for this reason; it accounts for so much.
    Differs(f64, String),
}

/// What comes of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Both are the same, to the tolerance stated.
    Agreed,
    /// They differ, it is said why, and by no more than that accounts for. Times measured here are always this: they are
    /// of another machine than the paper's, and cannot agree but by accident.
    Explained,
    /// They differ by more than is accounted for.
    Differs,
}

impl Published {
    /// A number that is computed, and must be the printed one within `tolerance`.
    pub(super) fn new(
        paper: Paper,
        place: &'static str,
        quantity: impl Into<String>,
        printed: Printed,
        ours: f64,
        tolerance: f64,
    ) -> Self {
        Self {
            paper,
            place,
            quantity: quantity.into(),
            printed,
            footing: Footing::Computed,
            ours,
            claim: Claim::Agrees(tolerance),
        }
    }

    /// The same number, drawn from a seed.
    pub(super) fn simulated(self) -> Self {
        Self {
            footing: Footing::Simulated,
            ..self
        }
    }

    /// The same number, which differs from the printed one for a reason that accounts for `reach`.
    pub(super) fn explained(self, reach: f64, why: impl Into<String>) -> Self {
        Self {
            claim: Claim::Differs(reach, why.into()),
            ..self
        }
    }

    /// A time, or a ratio of times, of this machine: it may be any.
    pub(super) fn measured(
        paper: Paper,
        place: &'static str,
        quantity: impl Into<String>,
        printed: f64,
        ours: f64,
        why: &str,
    ) -> Self {
        let number = Self::new(paper, place, quantity, Printed::Number(printed), ours, 0.0);
        Self {
            footing: Footing::Measured,
            ..number.explained(f64::INFINITY, why)
        }
    }

    /// The printed number by itself.
    pub fn printed_value(&self) -> f64 {
        let (Printed::Number(v)
        | Printed::AtMost(v)
        | Printed::AtLeast(v)
        | Printed::Independent(v)) = self.printed;
        v
    }

    /// Ours over the printed one; none of what is printed as 0.
    pub fn ratio(&self) -> Option<f64> {
        let printed = self.printed_value();
        (printed != 0.0).then(|| self.ours / printed)
    }

    /// How far ours is from what is printed; 0 on the right side of a bound.
    fn apart(&self) -> f64 {
        let more = self.ours - self.printed_value();
        match self.printed {
            Printed::Number(_) | Printed::Independent(_) => more.abs(),
            Printed::AtMost(_) => more.max(0.0),
            Printed::AtLeast(_) => (-more).max(0.0),
        }
    }

    /// By how much the two may differ.
    pub fn tolerance(&self) -> f64 {
        let (Claim::Agrees(tolerance) | Claim::Differs(tolerance, _)) = self.claim;
        tolerance
    }

    /// Whether it is a time of this machine.
    pub fn is_measured(&self) -> bool {
        self.footing == Footing::Measured
    }

    /// Whether the two are as near to each other as they must be to agree.
    pub(super) fn holds(&self) -> bool {
        self.ours.is_finite() && self.apart() <= self.tolerance()
    }

    /// Why they differ, where they do.
    pub fn why(&self) -> Option<&str> {
        match &self.claim {
            Claim::Agrees(_) => None,
            Claim::Differs(_, why) => Some(why),
        }
    }

    /// What comes of the comparison. A number that is not one differs.
    pub fn verdict(&self) -> Verdict {
        match self.claim {
            _ if !self.ours.is_finite() => Verdict::Differs,
            Claim::Agrees(tolerance) if self.apart() <= tolerance => Verdict::Agreed,
            Claim::Differs(reach, _) if self.apart() <= reach => Verdict::Explained,
            _ => Verdict::Differs,
        }
    }

    /// One row per number, with everything.
    pub fn table(all: &[Self]) -> Table {
        let mut table = Table::new([
            "paper",
            "place",
            "quantity",
            "relation",
            "printed",
            "ours",
            "ratio",
            "tolerance",
            "basis",
            "verdict",
            "why",
        ]);
        for p in all {
            let mut row: Vec<Cell> = vec![p.paper.name().into()];
            row.extend(p.cells());
            table.push(row);
        }
        table
    }

    /// One row per number, for a page: reasons are numbered, and come beside the table, each once.
    pub(super) fn page_table(all: &[&Self]) -> (Table, Vec<String>) {
        let mut table = Table::new([
            "place",
            "quantity",
            "printed",
            "ours",
            "ratio",
            "tolerance",
            "verdict",
        ]);
        let mut reasons: Vec<String> = Vec::new();
        for p in all {
            let mut verdict = p.verdict_text().to_owned();
            if let Some(why) = p.why() {
                let known = reasons.iter().position(|r| r == why);
                let number = known.unwrap_or_else(|| {
                    reasons.push(why.to_owned());
                    reasons.len() - 1
                });
                verdict = format!("{verdict} [{}]", number + 1);
            }
            let tolerance = p.tolerance();
            table.push(vec![
                p.place.into(),
                p.quantity.as_str().into(),
                p.printed.cell(),
                p.ours.into(),
                p.ratio().into(),
                tolerance.is_finite().then_some(tolerance).into(),
                verdict.into(),
            ]);
        }
        (table, reasons)
    }

    /// One row per number in few columns, for a terminal.
    pub fn short_table(all: &[Self]) -> Table {
        let columns = [
            "paper", "place", "quantity", "printed", "ours", "ratio", "verdict",
        ];
        let mut table = Table::new(columns);
        for p in all {
            table.push(vec![
                p.paper.name().into(),
                p.place.into(),
                p.quantity.as_str().into(),
                p.printed_value().into(),
                round4(p.ours).into(),
                p.ratio().map(round4).into(),
                p.verdict_text().into(),
            ]);
        }
        table
    }

    /// All of it but the paper.
    fn cells(&self) -> Vec<Cell> {
        let tolerance = self.tolerance();
        vec![
            self.place.into(),
            self.quantity.as_str().into(),
            self.printed.relation().into(),
            self.printed_value().into(),
            self.ours.into(),
            self.ratio().into(),
            tolerance.is_finite().then_some(tolerance).into(),
            self.footing.name().into(),
            self.verdict_text().into(),
            self.why().unwrap_or_default().into(),
        ]
    }

    fn verdict_text(&self) -> &'static str {
        self.verdict().name()
    }
}

/// Four significant digits: a terminal has little room.
fn round4(v: f64) -> f64 {
    if v == 0.0 || !v.is_finite() {
        return v;
    }
    let digits = 3.0 - log10(v.abs()).floor();
    let scale = foveasim_models::math::pow(10.0, digits);
    (v * scale).round() / scale
}

impl Printed {
    /// How ours should relate to it.
    pub fn relation(self) -> &'static str {
        match self {
            Self::Number(_) => "equals",
            Self::AtMost(_) => "at most",
            Self::AtLeast(_) => "at least",
            Self::Independent(_) => "equals (solved independently)",
        }
    }
}

impl Printed {
    /// Bounds say that they are.
    fn cell(self) -> Cell {
        match self {
            Self::Number(v) | Self::Independent(v) => v.into(),
            Self::AtMost(v) => format!("≤ {v}").into(),
            Self::AtLeast(v) => format!("≥ {v}").into(),
        }
    }
}

impl Footing {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Computed => "computed",
            Self::Simulated => "simulated",
            Self::Measured => "measured on this machine",
        }
    }
}

impl Verdict {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Agreed => "agreed",
            Self::Explained => "explained",
            Self::Differs => "DIFFERS",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(printed: Printed, ours: f64, tolerance: f64) -> Published {
        let paper = Paper::Guenter2012;
        Published::new(paper, "§1", "x", printed, ours, tolerance)
    }

    #[test]
    fn verdicts_follow_what_is_claimed() {
        use Printed::{AtLeast, AtMost, Number};
        for (printed, ours, verdict) in [
            (Number(13.3), 13.292, Verdict::Agreed),
            (Number(13.3), 13.40, Verdict::Differs),
            (Number(13.3), f64::NAN, Verdict::Differs),
            (Number(13.3), f64::INFINITY, Verdict::Differs),
            (AtMost(0.08), 0.07, Verdict::Agreed),
            (AtMost(0.08), 0.2, Verdict::Differs),
            (AtLeast(1.0), 7.0, Verdict::Agreed),
            (AtLeast(1.0), 0.9, Verdict::Differs),
        ] {
            let found = number(printed, ours, 0.05);
            assert_eq!(found.verdict(), verdict, "{found:?}");
        }
        // An explanation reaches so far and no farther, and makes nothing agree.
        let why = |ours| number(Number(9.8), ours, 0.05).explained(0.4, "rounding");
        assert_eq!(why(10.1).verdict(), Verdict::Explained);
        assert_eq!(why(9.8).verdict(), Verdict::Explained);
        assert_eq!(why(10.3).verdict(), Verdict::Differs);
    }

    #[test]
    fn times_of_this_machine_never_agree() {
        let time =
            |ours| Published::measured(Paper::Meng2020, "Fig. 7", "x", 2.0, ours, "a processor");
        assert_eq!(time(2.0).verdict(), Verdict::Explained);
        assert_eq!(time(400.0).verdict(), Verdict::Explained);
        assert_eq!(time(f64::NAN).verdict(), Verdict::Differs);
        let table = Published::table(&[time(2.0)]);
        assert!(table.csv().contains("measured on this machine,explained"));
    }

    #[test]
    fn numbers_for_terminals_are_short() {
        assert_eq!(
            (round4(13.291_66), round4(0.0), round4(-0.051_59)),
            (13.29, 0.0, -0.051_59)
        );
        assert!(round4(f64::NAN).is_nan());
    }
}
