//! Frames that wait for a vertical blank.

use foveasim_models::Nanos;

use super::{BEFORE, BEFORE_ENDED, Backlog, END, START, join};
use crate::Interval;
use crate::bounds::zone::Zone;

/// From starts to flips, where frames wait for a vertical blank.
#[derive(Debug, Clone, Copy)]
pub(in crate::bounds) struct BacklogFlips {
    /// From the end of rendering until the compositor takes the frame.
    pub(in crate::bounds) flip_wait: Interval,
    /// From a frame's start to its flip.
    pub(in crate::bounds) start_to_flip: Interval,
    /// Longest time from the start of a frame to the flip of the next.
    pub(in crate::bounds) wait_to_flip: Nanos,
    /// Longest time between flips.
    pub(in crate::bounds) flips: Nanos,
}

impl Backlog {
    /// How frames flip that wait for a vertical blank.
    pub(in crate::bounds) fn flips(&self) -> BacklogFlips {
        let refresh = self.unit.refresh;
        let Some(places) = &self.places else {
            let anywhere = Interval::new(Nanos::ZERO, self.in_nanos([0, refresh]).max);
            let lead = Interval::exactly(self.unit.down(self.lead));
            let whole = self.interval(|z| z.range(END, START)) + anywhere + lead;
            let apart = self.interval(|z| z.range(END, BEFORE_ENDED)).max;
            let refreshes = -(-self.unit.of_nanos(apart)).div_euclid(refresh);
            return BacklogFlips {
                flip_wait: anywhere,
                start_to_flip: whole,
                wait_to_flip: self.to_end().max + anywhere.max + lead.max,
                flips: self.in_nanos([0, refreshes.max(1) * refresh]).max,
            };
        };
        let none = [i128::MAX, i128::MIN];
        let (mut flip_wait, mut start_to_flip, mut wait_to_flip) = (none, none, none);
        let mut flips = 1;
        for (place, zone) in places
            .iter()
            .flat_map(|p| self.frames.iter().map(move |z| (*p, z)))
        {
            for (blank, zone) in self.by_blank(zone, END, place) {
                let [first, last] = zone.range(END, 0);
                let deadline = blank - self.lead;
                flip_wait = join(flip_wait, [deadline - last, deadline - first]);
                let [first, last] = zone.range(START, 0);
                start_to_flip = join(start_to_flip, [blank - last, blank - first]);
                let [first, last] = zone.range(BEFORE, 0);
                wait_to_flip = join(wait_to_flip, [blank - last, blank - first]);
                for (before, _) in self.by_blank(&zone, BEFORE_ENDED, place) {
                    flips = flips.max((blank - before) / refresh);
                }
            }
        }
        BacklogFlips {
            flip_wait: self.in_nanos(flip_wait),
            start_to_flip: self.in_nanos(start_to_flip),
            wait_to_flip: self.in_nanos(wait_to_flip).max,
            flips: self.in_nanos([0, flips * refresh]).max,
        }
    }

    /// The parts of `zone` by the vertical blank before which the compositor takes what ends at coordinate
    /// `end`, if the beam has come as far as `place` at the origin.
    fn by_blank(
        &self,
        zone: &Zone,
        end: usize,
        place: i128,
    ) -> impl Iterator<Item = (i128, Zone)> + use<> {
        let Self { unit, lead, .. } = self;
        let (refresh, zone) = (unit.refresh, *zone);
        // From just after a deadline to the next; rounded ticks may be a nanosecond to either side of both.
        let [after, slack] = match unit.is_whole() {
            true => [unit.ns, 0],
            false => [-unit.ns, unit.ns],
        };
        let offset = place + lead;
        let [first, last] = zone.range(end, 0);
        let [first, last] =
            [first - slack, last + slack].map(|t| -(-(t + offset)).div_euclid(refresh));
        (first..=last).filter_map(move |k| {
            let deadline = k * refresh - offset;
            let part = zone.where_within(end, [deadline - refresh + after, deadline + slack])?;
            Some((k * refresh - place, part))
        })
    }
}
