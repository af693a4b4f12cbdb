use std::cmp::Ordering;
use std::collections::BinaryHeap;

use foveasim_models::Nanos;

/// Events to come, in order: by time, then by stage, then in the order they were scheduled.
///
/// Stages order what happens at the same nanosecond by meaning (a frame finished exactly at the
/// vertical blank is on time for it); the sequence number makes the rest first-in, first-out, so
/// that the order never depends on the heap.
#[derive(Debug)]
pub struct Calendar<E> {
    heap: BinaryHeap<Entry<E>>,
    now: Nanos,
    sequence: u64,
    happened: u64,
}

#[derive(Debug)]
struct Entry<E> {
    at: Nanos,
    /// Stage in the top byte, sequence below.
    order: u64,
    event: E,
}

/// Sequence numbers beyond this would run into the stage.
const SEQUENCES: u64 = 1 << 56;

impl<E> Calendar<E> {
    /// An empty calendar whose time is `now`.
    pub fn new(now: Nanos) -> Self {
        Self {
            heap: BinaryHeap::new(),
            now,
            sequence: 0,
            happened: 0,
        }
    }

    /// Forgets everything and sets the time; keeps the memory.
    pub fn reset(&mut self, now: Nanos) {
        self.heap.clear();
        (self.now, self.sequence, self.happened) = (now, 0, 0);
    }

    /// Plans `event`.
    ///
    /// # Panics
    /// If `at` is in the past, or after 2⁵⁶ events.
    pub fn schedule(&mut self, at: Nanos, stage: u8, event: E) {
        assert!(at >= self.now, "an event at {at} scheduled at {}", self.now);
        assert!(self.sequence < SEQUENCES, "more than 2^56 events");
        let order = (u64::from(stage) << 56) | self.sequence;
        self.sequence += 1;
        self.heap.push(Entry { at, order, event });
    }

    /// Takes the next event and moves the time to it: the only way time passes.
    #[expect(
        clippy::should_implement_trait,
        reason = "it is not an iterator: handlers schedule"
    )]
    pub fn next(&mut self) -> Option<E> {
        let Entry { at, event, .. } = self.heap.pop()?;
        self.now = at;
        self.happened += 1;
        Some(event)
    }

    /// The time of the event taken last.
    pub fn now(&self) -> Nanos {
        self.now
    }

    /// The time of the event that comes next.
    pub fn peek(&self) -> Option<Nanos> {
        self.heap.peek().map(|e| e.at)
    }

    /// How many events have been taken.
    pub fn happened(&self) -> u64 {
        self.happened
    }
}

impl<E> Entry<E> {
    /// One comparison instead of two: the sign bit is flipped so that negative times come first.
    fn key(&self) -> u128 {
        (u128::from(self.at.0 as u64 ^ (1 << 63)) << 64) | u128::from(self.order)
    }
}

impl<E> Ord for Entry<E> {
    /// Reversed: the standard heap gives its greatest item first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.key().cmp(&self.key())
    }
}

impl<E> PartialOrd for Entry<E> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<E> PartialEq for Entry<E> {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl<E> Eq for Entry<E> {}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn order_is_time_then_stage_then_first_in(
            events in prop::collection::vec((-20i64..20, 0u8..4), 0..200),
        ) {
            let mut calendar = Calendar::new(Nanos(-20));
            for (i, (t, stage)) in events.iter().enumerate() {
                calendar.schedule(Nanos(*t), *stage, (*t, *stage, i));
            }
            let mut want: Vec<_> =
                events.iter().enumerate().map(|(i, (t, stage))| (*t, *stage, i)).collect();
            want.sort_unstable();
            let mut got = Vec::new();
            while let Some(event) = calendar.next() {
                prop_assert_eq!(calendar.now(), Nanos(event.0));
                got.push(event);
            }
            prop_assert_eq!(got, want);
            prop_assert_eq!(calendar.happened(), events.len() as u64);
        }
    }

    #[test]
    #[should_panic(expected = "scheduled at")]
    fn the_past_cannot_be_scheduled() {
        let mut calendar = Calendar::new(Nanos(5));
        calendar.schedule(Nanos(4), 0, ());
    }
}
