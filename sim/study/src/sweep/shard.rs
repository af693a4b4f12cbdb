use std::fmt;
use std::str::FromStr;

use foveasim_models::ModelError;

/// A part of a sweep: every so manyth group of rows, so that parts take about as long as each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Which, from 1.
    number: usize,
    /// Of how many.
    of: usize,
}

/// The most parts.
const MOST: usize = 100_000;

impl Shard {
    /// All of it.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// How many parts there are.
    pub fn of(self) -> usize {
        self.of
    }

    /// Its groups out of so many, in order.
    pub fn groups(self, all: usize) -> impl Iterator<Item = usize> {
        (self.number - 1..all).step_by(self.of)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        let parts = text.split_once('/');
        let parts = parts.and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
        match parts {
            Some((number, of)) if (1..=of).contains(&number) && of <= MOST => {
                Ok(Self { number, of })
            }
            _ => {
                let valid = format!("K/N with 1 ≤ K ≤ N ≤ {MOST}, as in 3/16");
                Err(ModelError::range("shard", text, valid))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_all_of_it_once() {
        let mut all: Vec<usize> = (1..=4)
            .flat_map(|k| format!("{k}/4").parse::<Shard>().unwrap().groups(10))
            .collect();
        all.sort_unstable();
        assert_eq!(all, (0..10).collect::<Vec<_>>());
        for bad in [
            "", "1", "0/4", "5/4", "1/0", "a/4", "1/4/2", "-1/4", "1/100001",
        ] {
            assert!(bad.parse::<Shard>().is_err(), "{bad}");
        }
        assert_eq!(Shard::WHOLE.groups(3).count(), 3);
    }
}
