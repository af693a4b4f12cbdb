use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use foveasim_models::foveation::Method;
use foveasim_models::math::to_deg;
use foveasim_models::{CostProfile, ModelError, unknown_name};
use foveasim_reports::{Cell, Table};

use super::{Resolution, Sweep, SweepDisplay, SweepRow, Terms};

/// What is to be found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unknown {
    /// The longest latency \[ms\]: the eye goes on for so long, and the margin must cover where it gets to.
    Latency,
    /// The largest error of gaze \[deg\] that the margin covers.
    Accuracy,
    /// Pixels per degree at the centre of a flat display.
    PixelsPerDegree,
    /// How many times as fast as the cost profile's machine another must be.
    Gpu,
}

impl Unknown {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Latency,
        Self::Accuracy,
        Self::PixelsPerDegree,
        Self::Gpu,
    ];

    /// As given to `--solve`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Latency => "latency",
            Self::Accuracy => "accuracy",
            Self::PixelsPerDegree => "ppd",
            Self::Gpu => "gpu",
        }
    }

    /// The unit of its values.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Latency => "ms",
            Self::Accuracy => "deg",
            Self::PixelsPerDegree => "pixels per degree at the centre",
            Self::Gpu => "times as fast",
        }
    }
}

impl FromStr for Unknown {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        let found = Self::ALL.into_iter().find(|u| u.name() == text);
        found.ok_or_else(|| unknown_name("unknown to solve for", text, &Self::ALL.map(Self::name)))
    }
}

/// What is to be met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// At least so many times faster than a sample for each pixel, written `5x`.
    Speedup(f64),
    /// Frames of at most so long on average \[ms\], written `11ms`, or `90hz` for a refresh of so many a second.
    FrameMs(f64),
    /// Frames of at most so much energy on average \[mJ\], written `12mJ`.
    EnergyMj(f64),
    /// At most so much power, a frame at each refresh \[W\], written `1.5W`.
    PowerW(f64),
}

impl Target {
    /// What a row has of it.
    ///
    /// # Errors
    /// If its cost profile states no energy, or its display no refresh rate, and that is what is asked.
    fn of(self, row: &SweepRow) -> Result<f64, ModelError> {
        let needs = row.needs();
        let known = |value: Option<f64>, valid: &str| {
            value.ok_or_else(|| ModelError::range("target", self, valid))
        };
        let energy = known(
            needs.energy_mj,
            "a speedup or a frame time: the cost profile has no [energy]",
        );
        match self {
            Self::Speedup(_) => Ok(needs.speedup()),
            Self::FrameMs(_) => Ok(needs.frame_ms),
            Self::EnergyMj(_) => energy,
            Self::PowerW(_) => {
                energy?;
                let valid = "an energy, as in 12mJ: the display has no refresh rate (--refresh)";
                known(needs.power_w, valid)
            }
        }
    }

    fn value(self) -> f64 {
        match self {
            Self::Speedup(v) | Self::FrameMs(v) | Self::EnergyMj(v) | Self::PowerW(v) => v,
        }
    }

    fn is_met(self, value: f64) -> bool {
        match self {
            Self::Speedup(wanted) => value >= wanted,
            Self::FrameMs(wanted) | Self::EnergyMj(wanted) | Self::PowerW(wanted) => {
                value <= wanted
            }
        }
    }
}

impl FromStr for Target {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        let number = |suffix: &str| {
            let value: f64 = text.strip_suffix(suffix)?.trim().parse().ok()?;
            (1e-6..=1e9).contains(&value).then_some(value)
        };
        let hz = |hz: f64| Self::FrameMs(1000.0 / hz);
        let found = (number("ms").map(Self::FrameMs))
            .or(number("hz").or(number("Hz")).map(hz))
            .or(number("mJ").or(number("mj")).map(Self::EnergyMj))
            .or(number("W").or(number("w")).map(Self::PowerW))
            .or(number("x").map(Self::Speedup));
        found.ok_or_else(|| {
            let valid = "a number above 0 with its unit: 5x, 11ms, 90hz, 12mJ or 1.5W";
            ModelError::range("target", text, valid)
        })
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Speedup(v) => write!(f, "{v}x"),
            Self::FrameMs(v) => write!(f, "{v}ms"),
            Self::EnergyMj(v) => write!(f, "{v}mJ"),
            Self::PowerW(v) => write!(f, "{v}W"),
        }
    }
}

/// Whether a target can be met.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The value just meets it.
    Met,
    /// Every value in range meets it: this is the last.
    Always,
    /// No value in range does: this comes nearest.
    Never,
}

impl Outcome {
    /// As in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Met => "yes",
            Self::Always => "by any value up to this",
            Self::Never => "no: this comes nearest",
        }
    }
}

/// What was found for one row of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// The value of the unknown, in [`Unknown::unit`].
    pub value: f64,
    /// What the forward model says there.
    pub row: SweepRow,
    /// Whether it meets the target.
    pub outcome: Outcome,
}

/// An inverse question to the forward model of a [`Sweep`].
#[derive(Debug, Clone, PartialEq)]
pub struct Solve {
    /// What is to be found.
    pub unknown: Unknown,
    /// What is to be met.
    pub target: Target,
    /// How fast the eye moves while the picture is late \[deg/s\] ([`Unknown::Latency`]): the margin is the
    /// sweep's and what the eye goes on in the latency.
    pub eye_deg_per_s: f64,
}

/// Margins that are tried \[deg\].
const MARGINS_DEG: [f64; 2] = [0.0, 89.0];

/// Sharpness at the centre that is tried, of the fovea's.
const SHARPNESS: [f64; 2] = [0.01, 4.0];

/// Halvings: what is left of a range is below its rounding.
const HALVINGS: u32 = 60;

impl Solve {
    /// Answers for every row of `sweep`, in its order. What the unknown stands for is taken from the sweep only
    /// where it adds to it: its margins are the tracker's own error when a latency is to be found.
    ///
    /// Frame times rise with the margin and with the resolution, and savings fall with the one and rise with the
    /// other, so that halving the range finds the value. Where a method's samples jump (tiles), the value is the
    /// last that meets the target.
    ///
    /// # Errors
    /// As [`Sweep::rows`]; if pixels per degree are asked of a display that has its own, a faster machine to
    /// change a ratio, or the eye's speed is not above 0 and up to 1000 deg/s.
    pub fn run(&self, sweep: &Sweep) -> Result<Vec<Solution>, ModelError> {
        if !(self.eye_deg_per_s > 0.0 && self.eye_deg_per_s <= 1000.0) {
            let valid = "above 0 and up to 1000";
            return Err(ModelError::range(
                "eye speed [deg/s]",
                self.eye_deg_per_s,
                valid,
            ));
        }
        if self.unknown == Unknown::Gpu && !matches!(self.target, Target::FrameMs(_)) {
            let valid = "a frame time, as in 11ms or 90hz: a faster machine draws full resolution faster, too, \
                         and what it takes of energy is another matter";
            return Err(ModelError::range("target", self.target, valid));
        }
        if self.unknown == Unknown::PixelsPerDegree
            && let Some(display) = sweep.displays.iter().find(|d| d.name != "planar")
        {
            let valid = "flat displays (--fov): this one has its own pixels";
            return Err(ModelError::range("display", &display.name, valid));
        }
        let mut found = Vec::with_capacity(sweep.len());
        for group in 0..sweep.groups() {
            let one = sweep.one(group);
            for &method in &sweep.methods {
                found.push(self.solve(&one, method)?);
            }
        }
        Ok(found)
    }

    fn solve(&self, one: &Sweep, method: Method) -> Result<Solution, ModelError> {
        let base = Sweep {
            methods: vec![method],
            ..one.clone()
        };
        let own_margin = base.margins_deg[0];
        let row = |sweep: &Sweep| Ok(sweep.rows(0)?.remove(0));
        match self.unknown {
            Unknown::Gpu => {
                let value = row(&base)?.needs().frame_ms / self.target.value();
                let terms = Arc::new(base.terms.faster(value));
                let row = row(&Sweep { terms, ..base })?;
                let outcome = Outcome::Met;
                Ok(Solution {
                    value,
                    row,
                    outcome,
                })
            }
            Unknown::Accuracy => {
                let at = |margin: f64| {
                    row(&Sweep {
                        margins_deg: vec![margin],
                        ..base.clone()
                    })
                };
                self.halve(MARGINS_DEG, at)
            }
            Unknown::Latency => {
                let longest = (MARGINS_DEG[1] - own_margin).max(0.0) / self.eye_deg_per_s * 1e3;
                let at = |ms: f64| {
                    row(&Sweep {
                        margins_deg: vec![own_margin + ms * 1e-3 * self.eye_deg_per_s],
                        ..base.clone()
                    })
                };
                self.halve([0.0, longest], at)
            }
            Unknown::PixelsPerDegree => {
                let display = &base.displays[0];
                let size = display.eyes[0].screen.size_px();
                let at = |sharpness: f64| {
                    let made = Resolution::Sharpness(sharpness);
                    let made = made.display(display.fov_h_deg, size.y / size.x)?;
                    let made = match display.eyes.len() {
                        1 => made,
                        _ => made.for_both_eyes(),
                    };
                    let refresh = display.refresh;
                    row(&Sweep {
                        displays: vec![SweepDisplay { refresh, ..made }],
                        ..base.clone()
                    })
                };
                let found = self.halve(SHARPNESS, at)?;
                let pixel = found.row.display.eyes[0].screen.pixel_tan().x;
                Ok(Solution {
                    value: 1.0 / to_deg(pixel),
                    ..found
                })
            }
        }
    }

    /// The value of a range at which the target is just met, of a row that changes steadily over it.
    fn halve(
        &self,
        [from, to]: [f64; 2],
        at: impl Fn(f64) -> Result<SweepRow, ModelError>,
    ) -> Result<Solution, ModelError> {
        let met = |row: &SweepRow| Ok::<_, ModelError>(self.target.is_met(self.target.of(row)?));
        let (first, last) = (at(from)?, at(to)?);
        let distance = |row: &SweepRow| {
            let there = self.target.of(row)?;
            Ok::<_, ModelError>((there - self.target.value()).abs())
        };
        let (value, row, outcome) = match (met(&first)?, met(&last)?) {
            (true, true) => (to, last, Outcome::Always),
            (false, false) => {
                let nearer = distance(&first)? <= distance(&last)?;
                let (value, row) = if nearer { (from, first) } else { (to, last) };
                (value, row, Outcome::Never)
            }
            (first_meets, _) => {
                let (mut good, mut bad) = if first_meets { (from, to) } else { (to, from) };
                for _ in 0..HALVINGS {
                    let middle = good + (bad - good) / 2.0;
                    match met(&at(middle)?)? {
                        true => good = middle,
                        false => bad = middle,
                    }
                }
                (good, at(good)?, Outcome::Met)
            }
        };
        Ok(Solution {
            value,
            row,
            outcome,
        })
    }

    /// One row per solution.
    pub fn table(&self, solutions: &[Solution]) -> Table {
        let mut table = Table::new([
            "method",
            "display",
            "fov_h_deg",
            "ppd_centre",
            "slope",
            "solve",
            "value",
            "unit",
            "target",
            "there",
            "met",
            "margin_deg",
            "frame_ms",
            "predicted_speedup",
            "beyond_fit",
        ]);
        for Solution {
            value,
            row,
            outcome,
        } in solutions
        {
            let needs = row.needs();
            table.push(vec![
                row.method.to_string().into(),
                row.display.name.as_str().into(),
                row.display.fov_h_deg.into(),
                (1.0 / to_deg(row.display.eyes[0].screen.pixel_tan().x)).into(),
                row.acuity.slope().into(),
                self.unknown.name().into(),
                Cell::Float(*value),
                self.unknown.unit().into(),
                self.target.to_string().into(),
                self.target.of(row).ok().into(),
                outcome.name().into(),
                row.margin_deg.into(),
                needs.frame_ms.into(),
                needs.speedup().into(),
                needs.beyond_fit.into(),
            ]);
        }
        table
    }
}

impl Terms {
    /// The same with a machine so many times as fast.
    #[must_use]
    pub fn faster(&self, times: f64) -> Self {
        let cost = CostProfile {
            fixed_ms: self.cost.fixed_ms / times,
            per_sample_ns: self.cost.per_sample_ns / times,
            per_pixel_ns: self.cost.per_pixel_ns / times,
            per_visible_sample_ns: self.cost.per_visible_sample_ns / times,
            per_pass_ms: self.cost.per_pass_ms / times,
            ..self.cost.clone()
        };
        Self {
            cost,
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::{Acuity, EnergyProfile, GazeMode, Rate};

    use super::super::GazeAt;
    use super::*;

    fn sweep(methods: &str, display: SweepDisplay) -> Sweep {
        let mut terms = Terms::default();
        terms.cost.energy = Some(EnergyProfile {
            fixed_mj: 2.0,
            per_sample_nj: 10.0,
            per_gbit_mj: 5.0,
            ..EnergyProfile::default()
        });
        Sweep {
            displays: vec![display],
            acuities: vec![Acuity::default()],
            gazes: vec![GazeAt::Centre],
            gaze_mode: GazeMode::Tracked,
            margins_deg: vec![0.5],
            methods: Method::parse_list(methods).unwrap(),
            terms: Arc::new(terms),
        }
    }

    fn planar() -> SweepDisplay {
        let display = Resolution::Sharpness(0.4).display(90.0, 0.6).unwrap();
        display.at(Rate::from_hz("refresh", 72.0).unwrap())
    }

    fn solve(unknown: &str, target: &str, methods: &str) -> Vec<Solution> {
        let solve = Solve {
            unknown: unknown.parse().unwrap(),
            target: target.parse().unwrap(),
            eye_deg_per_s: 40.0,
        };
        let solutions = solve.run(&sweep(methods, planar())).unwrap();
        assert_eq!(solve.table(&solutions).rows().len(), solutions.len());
        solutions
    }

    /// What was found, put back into the forward model, meets the target to a thousandth.
    #[test]
    fn what_is_found_meets_the_target() {
        for (unknown, target) in [
            ("accuracy", "8ms"),
            ("accuracy", "6x"),
            ("latency", "8ms"),
            ("ppd", "100hz"),
            ("ppd", "4x"),
            ("gpu", "90hz"),
            ("accuracy", "30mJ"),
            ("ppd", "2W"),
        ] {
            let mut met = 0;
            for found in solve(
                unknown,
                target,
                "layers:3,layers:4,layers:2:strict,quad:auto,kfr:2:4",
            ) {
                let wanted: Target = target.parse().unwrap();
                if found.row.method.is_given() && matches!(unknown, "accuracy" | "latency") {
                    // Its samples are given: no margin changes them.
                    assert_ne!(found.outcome, Outcome::Met);
                }
                if found.outcome != Outcome::Met {
                    continue;
                }
                met += 1;
                let mut back = sweep(&found.row.method.to_string(), found.row.display.clone());
                match unknown {
                    "accuracy" => back.margins_deg = vec![found.value],
                    "latency" => back.margins_deg = vec![0.5 + found.value * 0.04],
                    "gpu" => back.terms = Arc::new(back.terms.faster(found.value)),
                    _ => {}
                }
                let there = wanted.of(&back.rows(0).unwrap()[0]).unwrap();
                assert!(
                    (there / wanted.value() - 1.0).abs() <= 1e-3,
                    "{unknown} {target} {}: {there}",
                    found.row.method
                );
            }
            assert!(met >= 1, "{unknown} {target}: {met}");
        }
    }

    #[test]
    fn what_cannot_be_met_says_what_is_nearest() {
        let [never] = &solve("accuracy", "1000x", "layers:3")[..] else {
            panic!()
        };
        assert_eq!((never.outcome, never.value), (Outcome::Never, 0.0));
        let [always] = &solve("accuracy", "1000ms", "layers:3")[..] else {
            panic!()
        };
        assert_eq!((always.outcome, always.value), (Outcome::Always, 89.0));
        let ask = |unknown: &str, target: &str, display| {
            let (unknown, target) = (unknown.parse().unwrap(), target.parse().unwrap());
            let solve = Solve {
                unknown,
                target,
                eye_deg_per_s: 40.0,
            };
            solve.run(&sweep("layers:3", display)).is_err()
        };
        assert!(ask("gpu", "5x", planar()));
        let preset = foveasim_models::presets::display("quest-pro").unwrap();
        assert!(ask("ppd", "90hz", SweepDisplay::from(&preset)));
        // A faster machine is no more frugal; what is not stated cannot be met.
        assert!(ask("gpu", "12mJ", planar()));
        let mut unknown = sweep("layers:3", planar());
        unknown.terms = Arc::default();
        let silent = Solve {
            unknown: Unknown::Accuracy,
            target: "12mJ".parse().unwrap(),
            eye_deg_per_s: 40.0,
        };
        let error = silent.run(&unknown).unwrap_err().to_string();
        assert!(error.contains("no [energy]"), "{error}");
        let mut dark = sweep("layers:3", planar());
        dark.displays[0].refresh = None;
        let target = "1.5W".parse().unwrap();
        let error = Solve { target, ..silent }.run(&dark).unwrap_err();
        assert!(error.to_string().contains("no refresh rate"), "{error}");
        for bad in ["", "5", "x", "5J", "-3mJ", "-1x", "nanx", "0ms", "5 kg"] {
            assert!(bad.parse::<Target>().is_err(), "{bad}");
        }
    }
}
