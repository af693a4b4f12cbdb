use std::str::FromStr;
use std::sync::Arc;

use crate::error::in_range;
use crate::math::sqrt;
use crate::{ModelError, Nanos, Stream};

/// How long something takes, each time anew: fixed, drawn from a law, or drawn from measured values.
///
/// The support is always bounded, so that worst cases exist.
#[derive(Debug, Clone, PartialEq)]
pub struct Durations(Law);

#[derive(Debug, Clone, PartialEq)]
enum Law {
    Fixed(Nanos),
    Uniform {
        min: Nanos,
        max: Nanos,
    },
    Normal {
        mean: Nanos,
        sd_ns: f64,
        min: Nanos,
        max: Nanos,
    },
    Measured {
        values: Arc<[Nanos]>,
        min: Nanos,
        max: Nanos,
    },
}

/// The longest duration of any kind \[ms\].
const LONGEST_MS: f64 = 10_000.0;
/// A normal law is cut off this many standard deviations from its mean: of 16,000 draws, one is.
const NORMAL_CUT: f64 = 4.0;
/// The most values of a measured law: a day of frames at 120 Hz.
const MOST_VALUES: usize = 10_400_000;

impl Durations {
    /// No time at all.
    pub const ZERO: Self = Self::fixed(Nanos::ZERO);

    /// Always `t`.
    pub const fn fixed(t: Nanos) -> Self {
        Self(Law::Fixed(t))
    }

    /// Uniform over the whole nanoseconds from `min` to `max`, both included.
    ///
    /// # Errors
    /// If they are not from 0 to 10 s, or in the wrong order. `field` names them.
    pub fn uniform(field: &str, [min_ms, max_ms]: [f64; 2]) -> Result<Self, ModelError> {
        let [min, max] = [milliseconds(field, min_ms)?, milliseconds(field, max_ms)?];
        if max < min {
            let value = format!("[{min_ms}, {max_ms}]");
            return Err(ModelError::range(field, value, "[shortest, longest]"));
        }
        Ok(match min == max {
            true => Self::fixed(min),
            false => Self(Law::Uniform { min, max }),
        })
    }

    /// Normal, cut off at four standard deviations and at 0 (what falls outside is put on the cut).
    ///
    /// # Errors
    /// If the mean or the standard deviation is not from 0 to 10 s.
    pub fn normal(field: &str, mean_ms: f64, sd_ms: f64) -> Result<Self, ModelError> {
        let (mean, sd) = (milliseconds(field, mean_ms)?, milliseconds(field, sd_ms)?);
        let reach = Nanos::from_ms(NORMAL_CUT * sd_ms);
        Ok(Self(Law::Normal {
            mean,
            sd_ns: sd.0 as f64,
            min: (mean - reach).max(Nanos::ZERO),
            max: mean + reach,
        }))
    }

    /// Measured values \[ms\]; each draw takes one of them with equal chance.
    ///
    /// # Errors
    /// If there is none, or one is not from 0 to 10 s.
    pub fn measured(field: &str, values_ms: &[f64]) -> Result<Self, ModelError> {
        if values_ms.is_empty() || values_ms.len() > MOST_VALUES {
            let value = format!("{} values", values_ms.len());
            return Err(ModelError::range(
                field,
                value,
                format!("1 to {MOST_VALUES} values"),
            ));
        }
        let values: Arc<[Nanos]> = values_ms
            .iter()
            .map(|ms| milliseconds(field, *ms))
            .collect::<Result<_, _>>()?;
        let min = values.iter().copied().min().unwrap_or(Nanos::ZERO);
        let max = values.iter().copied().max().unwrap_or(Nanos::ZERO);
        Ok(Self(Law::Measured { values, min, max }))
    }

    /// Measured values \[ms\] from CSV text: of the column that is named, or the first whose header ends in `ms`,
    /// or the only one of a file without a header. Lines that begin with `#` are comments. `origin` names the text.
    ///
    /// # Errors
    /// Names the line and the value that is no duration, or says that there is no such column.
    pub fn from_csv(text: &str, origin: &str, named: Option<&str>) -> Result<Self, ModelError> {
        let (mut column, mut width) = (None, 0);
        let mut values = Vec::new();
        let lines = text.trim_start_matches('\u{feff}').lines().enumerate();
        for (number, line) in lines {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let field = || format!("{origin}: line {}", number + 1);
            let cells: Vec<&str> = line
                .split(',')
                .map(|c| c.trim().trim_matches('"'))
                .collect();
            let at = match column {
                Some(at) => at,
                None => {
                    let header = cells.iter().all(|c| c.parse::<f64>().is_err());
                    let found = match (header, named) {
                        (true, Some(name)) => cells.iter().position(|c| *c == name),
                        (true, None) => cells.iter().position(|c| c.to_lowercase().ends_with("ms")),
                        (false, Some(_)) => None,
                        (false, None) => Some(0).filter(|_| cells.len() == 1),
                    };
                    let Some(found) = found else {
                        let valid = match named {
                            Some(name) => format!("a header with a column `{name}`"),
                            None => "a header with a column that ends in `ms` (FILE#COLUMN names another), \
                                     or one column alone"
                                .into(),
                        };
                        let value = line.chars().take(60).collect::<String>();
                        return Err(ModelError::range(field(), value, valid));
                    };
                    column = Some(found);
                    width = cells.len();
                    if header {
                        continue;
                    }
                    found
                }
            };
            if cells.len() != width {
                let valid = format!("{width} fields, as in the first line");
                let value = format!("{} fields", cells.len());
                return Err(ModelError::range(field(), value, valid));
            }
            let value = cells[at];
            let ms = value.parse::<f64>().map_err(|_| {
                ModelError::range(field(), format!("`{value}`"), "a duration in ms")
            })?;
            milliseconds(&field(), ms)?;
            values.push(ms);
        }
        Self::measured(origin, &values)
    }

    /// Draws one. A law that does not vary draws nothing from the stream.
    pub fn draw(&self, stream: &mut Stream) -> Nanos {
        match &self.0 {
            Law::Fixed(t) => *t,
            Law::Uniform { min, max } => {
                *min + Nanos(stream.below((*max - *min).0 as u64 + 1) as i64)
            }
            Law::Normal {
                mean,
                sd_ns,
                min,
                max,
            } => {
                let t = mean.0 as f64 + sd_ns * stream.normal();
                Nanos((libm::round(t) as i64).clamp(min.0, max.0))
            }
            Law::Measured { values, .. } => values[stream.below(values.len() as u64) as usize],
        }
    }

    /// The shortest there is.
    pub fn min(&self) -> Nanos {
        match &self.0 {
            Law::Fixed(t) => *t,
            Law::Uniform { min, .. } | Law::Normal { min, .. } | Law::Measured { min, .. } => *min,
        }
    }

    /// The longest there is.
    pub fn max(&self) -> Nanos {
        match &self.0 {
            Law::Fixed(t) => *t,
            Law::Uniform { max, .. } | Law::Normal { max, .. } | Law::Measured { max, .. } => *max,
        }
    }

    /// The values in the order they were measured, where they were.
    pub fn in_order(&self) -> Option<&[Nanos]> {
        match &self.0 {
            Law::Measured { values, .. } => Some(values),
            _ => None,
        }
    }

    /// All of it `by` later, or earlier, but never below 0.
    #[must_use]
    pub fn shifted(&self, by: Nanos) -> Self {
        let at = |t: Nanos| (t + by).max(Nanos::ZERO);
        Self(match &self.0 {
            Law::Fixed(t) => Law::Fixed(at(*t)),
            Law::Uniform { min, max } => Law::Uniform {
                min: at(*min),
                max: at(*max),
            },
            Law::Normal {
                mean,
                sd_ns,
                min,
                max,
            } => Law::Normal {
                mean: *mean + by,
                sd_ns: *sd_ns,
                min: at(*min),
                max: at(*max),
            },
            Law::Measured { values, min, max } => Law::Measured {
                values: values.iter().map(|t| at(*t)).collect(),
                min: at(*min),
                max: at(*max),
            },
        })
    }

    /// How much longer than [`Durations::min`] a duration still is that began long ago, seen at a
    /// random time; drawn exactly for fixed and uniform laws (length-biased, then a uniform part of
    /// it), and from one length-biased choice of two draws for the others.
    pub(crate) fn draw_remaining(&self, stream: &mut Stream) -> Nanos {
        let whole = match &self.0 {
            Law::Uniform { min, max } => {
                let (a, b) = (min.0 as f64, max.0 as f64);
                sqrt(a * a + stream.uniform() * (b * b - a * a))
            }
            _ => {
                let (a, b) = (self.draw(stream).0 as f64, self.draw(stream).0 as f64);
                match stream.uniform() * (a + b) < a {
                    true => a,
                    false => b,
                }
            }
        };
        Nanos(libm::round(whole * stream.uniform()) as i64)
    }

    /// The mean \[ns\]: of a normal law, before it is cut off.
    pub(crate) fn mean_ns(&self) -> f64 {
        match &self.0 {
            Law::Fixed(t) => t.0 as f64,
            Law::Uniform { min, max } => (min.0 as f64 + max.0 as f64) / 2.0,
            Law::Normal { mean, .. } => mean.0 as f64,
            Law::Measured { values, .. } => {
                let sum: i128 = values.iter().map(|t| i128::from(t.0)).sum();
                sum as f64 / values.len() as f64
            }
        }
    }
}

impl FromStr for Durations {
    type Err = ModelError;

    /// Reads milliseconds: `8`, `uniform:7..9`, or `normal:8,0.5` (mean, standard deviation).
    fn from_str(text: &str) -> Result<Self, ModelError> {
        let wrong = || {
            let valid = "milliseconds from 0 to 10000, `uniform:MIN..MAX` or `normal:MEAN,SD`";
            ModelError::range("duration", format!("`{text}`"), valid)
        };
        let pair = |rest: &str, between: &str| {
            let (a, b) = rest.split_once(between)?;
            Some([a.trim().parse().ok()?, b.trim().parse().ok()?])
        };
        match text.split_once(':') {
            None => {
                let ms = text.trim().parse().map_err(|_| wrong())?;
                Ok(Self::fixed(milliseconds("duration", ms)?))
            }
            Some(("uniform", rest)) => {
                Self::uniform("duration", pair(rest, "..").ok_or_else(wrong)?)
            }
            Some(("normal", rest)) => {
                let [mean, sd] = pair(rest, ",").ok_or_else(wrong)?;
                Self::normal("duration", mean, sd)
            }
            Some(_) => Err(wrong()),
        }
    }
}

fn milliseconds(field: &str, ms: f64) -> Result<Nanos, ModelError> {
    in_range(field, ms, 0.0..=LONGEST_MS).map(Nanos::from_ms)
}

#[cfg(test)]
mod tests;
