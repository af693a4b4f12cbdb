use std::sync::Arc;

use thiserror::Error;

use crate::Similarity;

/// A placement at a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Key {
    /// When \[s\].
    pub seconds: f64,
    /// Where.
    pub placement: Similarity,
}

/// What happens after the last key of a [`Track`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Repeat {
    /// Nothing any more.
    Hold,
    /// It begins again each so many seconds, counted from time 0; above zero.
    Every(f64),
}

/// Rigid movement with even scale: linear between keys in position and scale, along the shorter great
/// arc in rotation. Two keys at one time are a jump. Before the first key and after the last it rests.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Shared: frames of many objects may move alike.
    keys: Arc<[Key]>,
    repeat: Repeat,
}

/// Moves one instance: each track places the next one's frame within its own, the last one places
/// the object. A chain, because the product of two moving frames is not linear between keys.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Index of the instance.
    pub instance: usize,
    /// From the world inwards; at least one.
    pub chain: Vec<Track>,
}

/// Why keys are not a track.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TrackError {
    /// Nothing says where the object is.
    #[error("a track needs at least one key")]
    Empty,
    /// Keys are not in order of time, or a time is not finite.
    #[error(
        "key {key} is at {seconds} s: keys must be at finite times, none before its predecessor"
    )]
    Order {
        /// Which key, from 0.
        key: usize,
        /// Its time.
        seconds: f64,
    },
    /// A key places by numbers that are not usable.
    #[error("key {key} has no usable placement: {}", Similarity::VALID)]
    Placement {
        /// Which key, from 0.
        key: usize,
    },
    /// The period is not above zero.
    #[error("a period of {0} s: must be finite and above 0")]
    Period(f64),
}

impl Track {
    /// Movement through `keys`.
    ///
    /// # Errors
    /// If there is no key, times decrease or are not finite, or a placement or the period is unusable.
    pub fn new(keys: Vec<Key>, repeat: Repeat) -> Result<Self, TrackError> {
        if keys.is_empty() {
            return Err(TrackError::Empty);
        }
        let mut before = f64::NEG_INFINITY;
        for (key, &Key { seconds, placement }) in keys.iter().enumerate() {
            if !(seconds.is_finite() && seconds >= before) {
                return Err(TrackError::Order { key, seconds });
            }
            if !placement.is_valid() {
                return Err(TrackError::Placement { key });
            }
            before = seconds;
        }
        match repeat {
            Repeat::Every(period) if !(period.is_finite() && period > 0.0) => {
                Err(TrackError::Period(period))
            }
            _ => Ok(Self {
                keys: keys.into(),
                repeat,
            }),
        }
    }

    /// No movement.
    ///
    /// # Errors
    /// If `placement` is unusable.
    pub fn still(placement: Similarity) -> Result<Self, TrackError> {
        let key = Key {
            seconds: 0.0,
            placement,
        };
        Self::new(vec![key], Repeat::Hold)
    }

    /// Where the object is at `seconds`; NaN is taken as the time of the first key.
    pub fn at(&self, seconds: f64) -> Similarity {
        let time = match self.repeat {
            Repeat::Hold => seconds,
            Repeat::Every(period) => seconds - period * (seconds / period).floor(),
        };
        // The first key after `time`: at a jump, the later placement holds.
        let after = self.keys.partition_point(|key| key.seconds <= time);
        match (
            after.checked_sub(1).map(|i| &self.keys[i]),
            self.keys.get(after),
        ) {
            (None, _) => self.keys[0].placement,
            (Some(last), None) => last.placement,
            (Some(a), Some(b)) => {
                let f = (time - a.seconds) / (b.seconds - a.seconds);
                a.placement.interpolate(b.placement, f)
            }
        }
    }

    /// Time of the last key \[s\].
    pub fn end(&self) -> f64 {
        self.keys[self.keys.len() - 1].seconds
    }

    /// Farthest any key moves the origin \[m\], and the least and greatest scale.
    fn reach(&self) -> (f64, [f64; 2]) {
        let far = |far: f64, key: &Key| far.max(key.placement.pose.position.length());
        let scale = |s: [f64; 2], key: &Key| {
            let scale = key.placement.scale;
            [s[0].min(scale), s[1].max(scale)]
        };
        (
            self.keys.iter().fold(0.0, far),
            self.keys.iter().fold([f64::INFINITY, 0.0], scale),
        )
    }
}

impl Motion {
    /// Where the object is in the world at `seconds`.
    pub fn at(&self, seconds: f64) -> Similarity {
        let mut placed = self.chain.iter().map(|track| track.at(seconds));
        let first = placed.next().unwrap_or(Similarity::IDENTITY);
        placed.fold(first, Similarity::then)
    }

    /// Whether all placements it can give are usable.
    pub(crate) fn is_valid(&self) -> bool {
        let (mut far, mut low, mut high) = (0.0, 1.0, 1.0);
        for track in &self.chain {
            let (reach, scale) = track.reach();
            far += high * reach;
            low *= scale[0];
            high *= scale[1];
        }
        !self.chain.is_empty() && Similarity::in_range(far, low) && Similarity::in_range(far, high)
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::Pose;
    use glam::{DQuat, DVec3};

    use super::*;

    fn key(seconds: f64, x: f64, turn: f64, scale: f64) -> Key {
        let pose = Pose::new(DVec3::new(x, 0.0, 0.0), DQuat::from_rotation_y(turn));
        Key {
            seconds,
            placement: Similarity { pose, scale },
        }
    }

    #[test]
    fn between_keys_it_moves_evenly_and_beyond_them_it_rests() {
        let keys = vec![key(1.0, 0.0, 0.0, 1.0), key(3.0, 4.0, 1.0, 2.0)];
        let track = Track::new(keys.clone(), Repeat::Hold).unwrap();
        assert_eq!(track.at(0.0), keys[0].placement);
        assert_eq!(track.at(9.0), keys[1].placement);
        assert_eq!(track.at(f64::NAN), keys[0].placement);
        let half = track.at(2.0);
        assert!((half.pose.position.x - 2.0).abs() < 1e-15 && (half.scale - 1.5).abs() < 1e-15);
        assert!(
            half.pose
                .orientation
                .angle_between(DQuat::from_rotation_y(0.5))
                < 1e-7
        );
    }

    #[test]
    fn it_begins_again_and_jumps() {
        let keys = vec![
            key(0.0, 0.0, 0.0, 1.0),
            key(1.0, 1.0, 0.0, 1.0),
            key(1.0, 5.0, 0.0, 1.0),
            key(2.0, 6.0, 0.0, 1.0),
        ];
        let track = Track::new(keys, Repeat::Every(2.0)).unwrap();
        let x = |t| track.at(t).pose.position.x;
        assert_eq!(
            [x(0.5), x(1.0), x(1.5), x(2.5), x(-1.5)],
            [0.5, 5.0, 5.5, 0.5, 0.5]
        );
    }

    #[test]
    fn a_chain_turns_what_its_inner_tracks_moved() {
        // A wheel's hub turns; its rim stays at its distance, which a line between keys would not.
        let turning = vec![key(0.0, 0.0, 0.0, 2.0), key(1.0, 0.0, 2.0, 2.0)];
        let motion = Motion {
            instance: 0,
            chain: vec![
                Track::new(turning, Repeat::Hold).unwrap(),
                Track::still(Similarity::at(DVec3::X)).unwrap(),
            ],
        };
        assert!(motion.is_valid());
        for t in [0.0, 0.3, 0.5, 1.0] {
            let p = motion.at(t).point(DVec3::ZERO);
            let want = DQuat::from_rotation_y(2.0 * t) * DVec3::X * 2.0;
            assert!(p.distance(want) < 1e-12, "{t}: {p}");
        }
    }

    #[test]
    fn wrong_keys_are_refused() {
        assert_eq!(Track::new(vec![], Repeat::Hold), Err(TrackError::Empty));
        let keys = vec![key(1.0, 0.0, 0.0, 1.0), key(0.5, 0.0, 0.0, 1.0)];
        let error = Track::new(keys, Repeat::Hold);
        assert!(matches!(error, Err(TrackError::Order { key: 1, .. })));
        let keys = vec![key(0.0, 0.0, 0.0, 0.0)];
        assert_eq!(
            Track::new(keys, Repeat::Hold),
            Err(TrackError::Placement { key: 0 })
        );
        let keys = vec![key(0.0, 0.0, 0.0, 1.0)];
        assert_eq!(
            Track::new(keys, Repeat::Every(0.0)),
            Err(TrackError::Period(0.0))
        );
    }
}
