use std::sync::Arc;

use foveasim_models::Nanos;

use super::backlog::Backlog;
use super::locked::{Beat, LockedFlip, overruns};
use super::unit::Unit;
use crate::{Interval, Setup};

/// How frames of a host that runs freely meet the display.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Meeting {
    /// They begin in these places of the refresh only.
    Places(LockedFlip),
    /// They begin anywhere in it (nowhere is further than [`DENSE`] from a place where they do), whatever
    /// was before.
    Anywhere,
    /// Some begin at ticks of the host's clock and some anywhere, by how many wait for them.
    Mixed(Arc<Backlog>),
    /// So they do, in more ways than can be followed.
    Unfollowed,
}

/// Places of a refresh this close to each other are as good as all of it.
const DENSE: Nanos = Nanos(1000);

impl Meeting {
    /// Of `setup`, whose frames render for a time within `render`.
    ///
    /// Frames of uneven times, some of them longer than the host's period, begin anywhere if only one is in
    /// flight or none is shorter than a period: one that begins at a time within \[s, s + w\] after a tick
    /// and takes up to b is followed by one that begins within \[s, s + w + b − period\] after a tick, and so on
    /// until that is all of the period. What comes next does not depend on what was. Else it does:
    /// see [`Backlog`].
    pub(super) fn of(setup: &Setup<'_>, render: Interval) -> Self {
        let Some(lock) = setup.runtime.host_lock else {
            return Self::Anywhere;
        };
        let Beat { places, .. } = Beat::of(setup, render);
        let dense = places > 1 && setup.scan.rate.period().0 / DENSE.0 <= places;
        if overruns(setup, render) && render.width() > Nanos::ZERO {
            if setup.runtime.in_flight == 1 || render.min > setup.host_rate.period() {
                return Self::Anywhere;
            }
            let unit = Unit::of(setup);
            let step = unit.refresh / i128::from(places);
            let place = |k: i64| unit.of_nanos(lock) + i128::from(k) * step;
            let places = (!dense).then(|| (0..places).map(place).collect());
            return match Backlog::follow(setup, render, places) {
                Some(backlog) => Self::Mixed(Arc::new(backlog)),
                None => Self::Unfollowed,
            };
        }
        match dense {
            true => Self::Anywhere,
            false => Self::Places(LockedFlip::new(setup, render, lock, places)),
        }
    }
}

/// How a frame that tears meets the beam, if that depends on when it is ready.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Torn {
    /// On how long it renders.
    Places(LockedFlip),
    /// On that and on the frames before it.
    Backlog(Arc<Backlog>),
}

impl Torn {
    pub(super) fn of(meeting: &Meeting) -> Option<Self> {
        match meeting {
            Meeting::Places(flip) => Some(Self::Places(*flip)),
            Meeting::Mixed(backlog) if backlog.meets_in_places() => {
                Some(Self::Backlog(Arc::clone(backlog)))
            }
            _ => None,
        }
    }

    /// What it depends on.
    pub(super) fn to_flip(&self) -> Interval {
        match self {
            Self::Places(flip) => flip.render,
            Self::Backlog(backlog) => backlog.to_end(),
        }
    }

    /// Whether what happens is up to rounding where the beam may jump at `edges`.
    pub(super) fn is_open(&self, edges: &[Nanos]) -> bool {
        match self {
            Self::Places(flip) => flip.is_open(edges),
            // Frames of uneven times end on both sides.
            Self::Backlog(_) => false,
        }
    }

    /// From the flip until the beam reaches `row`.
    pub(super) fn wait(&self, refresh: Nanos, row: Nanos) -> Interval {
        match self {
            Self::Places(flip) => flip.wait(refresh, row),
            Self::Backlog(backlog) => {
                backlog.after_end(&[row], |beam| super::until(row, beam, refresh))
            }
        }
    }

    /// Least and most of that, and of what follows: `after`, told how far the beam has come at the flip, may
    /// jump where the beam passes one of `edges`, and is steady or falls by as much as the beam goes on in between.
    pub(super) fn way(
        &self,
        refresh: Nanos,
        edges: &[Nanos],
        after: impl Fn(Nanos) -> Nanos,
    ) -> Interval {
        match self {
            Self::Places(flip) => flip.way(refresh, edges, after),
            Self::Backlog(backlog) => backlog.way(edges, after),
        }
    }
}
