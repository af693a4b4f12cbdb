use serde::{Deserialize, Serialize};

use crate::error::in_range;
use crate::{Durations, ModelError, Nanos, Role, Stream, math};

/// Times in which a tracker sees no eye, as people write them (TOML): how often they begin, and how
/// long they last.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LossSpec {
    /// How often one begins \[1/min\], from 0 (never) to 100,000.
    pub per_minute: f64,
    /// Shortest and longest \[ms\].
    pub lasts_ms: [f64; 2],
}

/// A valid [`LossSpec`].
#[derive(Debug, Clone, PartialEq)]
pub struct Loss {
    /// Mean time from the end of one to the beginning of the next \[ns\].
    mean_gap_ns: f64,
    /// How long one lasts.
    pub lasts: Durations,
}

/// The rarest losses \[1/min\]: once in 16 hours. Times between still rarer ones leave the clock's range.
const RAREST: f64 = 0.001;

impl LossSpec {
    /// The valid loss; `None` if it never happens.
    pub(super) fn build(&self, field: &str) -> Result<Option<Loss>, ModelError> {
        in_range(&format!("{field}.per_minute"), self.per_minute, 0.0..=1e5)?;
        if self.per_minute > 0.0 && self.per_minute < RAREST {
            let valid = format!("0 (never), or at least {RAREST}");
            let field = format!("{field}.per_minute");
            return Err(ModelError::range(field, self.per_minute, valid));
        }
        let lasts = Durations::uniform(&format!("{field}.lasts_ms"), self.lasts_ms)?;
        Ok((self.per_minute > 0.0).then(|| Loss {
            mean_gap_ns: 6e10 / self.per_minute,
            lasts,
        }))
    }
}

/// When the next losses of one kind are: a renewal process, already going on when it is first looked
/// at. Its stream is its own, so that switching it off leaves all else as it was.
#[derive(Debug, Clone)]
pub struct Losses {
    loss: Loss,
    stream: Stream,
    from: Nanos,
    until: Nanos,
}

impl Losses {
    /// The losses of run `run`, from `begin` on. The chance that one is going on then is that of any
    /// other time.
    pub fn new(loss: &Loss, seed: u64, role: Role, run: u64, begin: Nanos) -> Self {
        let mut stream = Stream::new(seed, role, run);
        let mean = loss.lasts.mean_ns();
        let going_on = stream.uniform() * (mean + loss.mean_gap_ns) < mean;
        let (from, until) = match going_on {
            true => (begin, begin + loss.lasts.draw_remaining(&mut stream)),
            false => {
                let from = begin + gap(loss, &mut stream);
                (from, from + loss.lasts.draw(&mut stream))
            }
        };
        let loss = loss.clone();
        Self {
            loss,
            stream,
            from,
            until,
        }
    }

    /// Whether nothing is seen at `t`; asked at growing times. `after` is when a loss may begin at the
    /// earliest: one that would have begun before waits until then, so that losses of two kinds never
    /// hide everything between them.
    pub fn hide(&mut self, t: Nanos, after: Nanos) -> bool {
        while self.until <= t {
            self.from = self.until + gap(&self.loss, &mut self.stream);
            self.until = self.from + self.loss.lasts.draw(&mut self.stream);
        }
        if self.from <= t && self.from < after {
            let late = after - self.from;
            self.from += late;
            self.until += late;
        }
        (self.from..self.until).contains(&t)
    }

    /// The end of the loss that is going on, or comes next.
    pub fn until(&self) -> Nanos {
        self.until
    }
}

/// Times between losses are exponential: they begin without memory.
fn gap(loss: &Loss, stream: &mut Stream) -> Nanos {
    // 1 − u is above 0, and its logarithm above −37: at most 37 mean times, which fits.
    Nanos(libm::round(-math::log(1.0 - stream.uniform()) * loss.mean_gap_ns) as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_often_and_as_long_as_asked_from_the_start() {
        let spec = LossSpec {
            per_minute: 20.0,
            lasts_ms: [100.0, 300.0],
        };
        let loss = spec.build("blinks").unwrap().unwrap();
        // 200 ms of every 3.2 s.
        let want = 0.2 / 3.2;
        let hidden = |at_ms: i64| {
            let n = 20_000;
            let hidden = |run| {
                let mut losses = Losses::new(&loss, 1, Role::Blink, run, Nanos::ZERO);
                losses.hide(Nanos(at_ms * 1_000_000), Nanos(i64::MIN))
            };
            (0..n).filter(|run| hidden(*run)).count() as f64 / n as f64
        };
        for at_ms in [0, 50, 2000] {
            // Five standard errors of 0.0017.
            assert!(
                (hidden(at_ms) - want).abs() < 0.0086,
                "{at_ms} {}",
                hidden(at_ms)
            );
        }
        assert!(spec.build("x").is_ok());
        let never = LossSpec {
            per_minute: 0.0,
            ..spec
        };
        assert_eq!(never.build("x").unwrap(), None);
        let rare = LossSpec {
            per_minute: 1e-300,
            ..never.clone()
        };
        assert!(rare.build("x").is_err());
        let wrong = LossSpec {
            per_minute: f64::NAN,
            ..never
        };
        assert!(
            wrong
                .build("x")
                .unwrap_err()
                .to_string()
                .contains("x.per_minute")
        );
    }
}
