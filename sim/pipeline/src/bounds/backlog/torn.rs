//! Frames that tear.

use foveasim_models::Nanos;

use super::{BEFORE, Backlog, END, START, join};
use crate::Interval;
use crate::bounds::zone::Zone;

/// A part of what frames may do in which what follows their end is steady, or falls by as much as the beam goes on.
struct Piece {
    zone: Zone,
    /// Least and most of what follows.
    after: [i128; 2],
    /// If it falls, when it ends.
    until: Option<[i128; 2]>,
}

impl Backlog {
    /// Least and most of a time that follows the end of a frame: `after`, as of [`Backlog::way`].
    pub(in crate::bounds) fn after_end(
        &self,
        edges: &[Nanos],
        after: impl Fn(Nanos) -> Nanos,
    ) -> Interval {
        let mut all = [i128::MAX, i128::MIN];
        self.each_piece(edges, after, |piece| all = join(all, piece.after));
        self.in_nanos(all)
    }

    /// Least of a frame's start to its end and what follows, and most of that from the start of the frame before.
    /// What follows, `after`, is told how far the beam has come at the end; it may jump where the beam passes one
    /// of `edges`, and is steady or falls by as much as the beam goes on in between.
    pub(in crate::bounds) fn way(
        &self,
        edges: &[Nanos],
        after: impl Fn(Nanos) -> Nanos,
    ) -> Interval {
        let mut all = [i128::MAX, i128::MIN];
        self.each_piece(edges, after, |Piece { zone, after, until }| {
            let way = match until {
                None => [
                    zone.range(END, START)[0] + after[0],
                    zone.range(END, BEFORE)[1] + after[1],
                ],
                Some(until) => [
                    until[0] - zone.range(START, 0)[1],
                    until[1] - zone.range(BEFORE, 0)[0],
                ],
            };
            all = join(all, way);
        });
        self.in_nanos(all)
    }

    fn each_piece(
        &self,
        edges: &[Nanos],
        after: impl Fn(Nanos) -> Nanos,
        mut see: impl FnMut(Piece),
    ) {
        let (unit, refresh) = (self.unit, self.unit.refresh);
        let places = self.places.iter().flatten();
        for (place, zone) in places.flat_map(|p| self.frames.iter().map(move |z| (*p, z))) {
            // Rounded ticks may be a nanosecond to either side.
            let slack = i128::from(!unit.is_whole()) * unit.ns;
            let [first, last] = zone.range(END, 0);
            let [first, last] = [first - slack, last + slack];
            let mut cuts = vec![first, last];
            // The beam is at the top once a refresh, and at each edge.
            for edge in edges.iter().chain([&Nanos::ZERO]) {
                let mut at = first + (unit.of_nanos(*edge) - place - first).rem_euclid(refresh);
                while at <= last {
                    cuts.extend([-2, -1, 0, 1, 2].map(|ns| at + ns * unit.ns));
                    at += refresh;
                }
            }
            cuts.retain(|t| (first..=last).contains(t));
            cuts.sort_unstable();
            cuts.dedup();
            let followed = |t: i128| {
                let beam = unit.down((place + t).rem_euclid(refresh));
                unit.of_nanos(after(beam))
            };
            // A zone of one moment has one piece.
            let pairs = cuts.windows(2).map(|pair| [pair[0], pair[1]]);
            for [from, to] in pairs.chain((first == last).then_some([first; 2])) {
                let Some(zone) = zone.where_within(END, [from, to]) else {
                    continue;
                };
                let [a, b] = [from, to].map(followed);
                see(Piece {
                    zone,
                    after: [a.min(b), a.max(b)],
                    until: (a > b).then(|| [(from + a).min(to + b), (from + a).max(to + b)]),
                });
            }
        }
    }
}
