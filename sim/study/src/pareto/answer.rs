use std::fmt;

use foveasim_models::foveation::Method;

use super::{ErrorMeasure, ParetoOutcome};

/// Which method takes least time within an error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// The measure.
    pub measure: ErrorMeasure,
    /// The most that is allowed of it.
    pub most: f64,
    /// The method, if any is within it.
    pub method: Option<Method>,
    /// Its error.
    pub error: f64,
    /// Its time \[ms\].
    pub time_ms: f64,
    /// How many times faster it is than full resolution.
    pub speedup: f64,
    /// The next one, and by what part of its time the first is faster.
    pub next: Option<(Method, f64)>,
    /// The least error there is, and whose: the answer where no method is within.
    pub least: Option<(Method, f64)>,
    /// How far equal draws were apart, where times were measured.
    pub noise: Option<f64>,
}

impl ParetoOutcome {
    /// The method of least time among those whose error, over all clips, is at most `most`.
    pub fn cheapest(&self, measure: ErrorMeasure, most: f64) -> Answer {
        let known: Vec<_> = self
            .overall()
            .filter_map(|row| Some((row, measure.of(row)?)))
            .collect();
        let mut within: Vec<_> = known.iter().filter(|(_, e)| *e <= most).collect();
        within.sort_by(|a, b| a.0.time_ms.total_cmp(&b.0.time_ms));
        let first = within.first();
        let next = within.get(1).zip(first);
        let least = known.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        Answer {
            measure,
            most,
            method: first.map(|(row, _)| row.method),
            error: first.map_or(f64::NAN, |(_, e)| *e),
            time_ms: first.map_or(f64::NAN, |(row, _)| row.time_ms),
            speedup: first.map_or(f64::NAN, |(row, _)| self.full_ms("all") / row.time_ms),
            next: next.map(|(n, f)| (n.0.method, 1.0 - f.0.time_ms / n.0.time_ms)),
            least: least.map(|(row, e)| (row.method, *e)),
            noise: self.noise,
        }
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.measure.name();
        let Some(method) = self.method else {
            write!(f, "No method is within {name} {}", self.most)?;
            return match self.least {
                Some((method, error)) => write!(f, ": the least is {error:.4}, of {method}."),
                None => write!(f, ": {name} is not known of any."),
            };
        };
        write!(
            f,
            "Within {name} {}, {method} takes least: {:.2} ms a frame, {:.2} times as fast as full, at {name} {:.4}.",
            self.most, self.time_ms, self.speedup, self.error
        )?;
        let Some((next, gain)) = self.next else {
            return write!(f, " No other method is within it.");
        };
        match self.noise {
            Some(noise) if gain <= noise => write!(
                f,
                " {next} cannot be told from it: {:.1} % apart, and equal draws differ by {:.1} %.",
                100.0 * gain,
                100.0 * noise
            ),
            _ => write!(
                f,
                " {next} comes next; it saves {:.1} % of that one's time.",
                100.0 * gain
            ),
        }
    }
}
