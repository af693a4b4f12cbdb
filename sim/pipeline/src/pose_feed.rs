use foveasim_models::{HeadTracker, Nanos, Pose, Provenance, Rate, Sample};

use crate::{Cursor, PoseStamp, Setup};

/// Gives the host its newest head pose, predicted.
#[derive(Debug)]
pub(crate) struct PoseFeed<'a> {
    cursor: Cursor<'a, Pose>,
    arrival: Arrival,
    head: HeadTracker,
    max_gap: Nanos,
    /// The newest sample is missing.
    lost: bool,
}

/// Which samples the host gets, and when.
#[derive(Debug)]
enum Arrival {
    /// Each recorded sample `transit` after its time stamp, at which it was `age` old.
    Recorded {
        age: Nanos,
        transit: Nanos,
        read: usize,
    },
    /// What was recorded, looked up at ticks of a clock, `delay` later; `next` is the next tick.
    Sampled {
        rate: Rate,
        phase: Nanos,
        delay: Nanos,
        next: i64,
    },
}

impl<'a> PoseFeed<'a> {
    pub(crate) fn new(setup: &Setup<'a>) -> Option<Self> {
        let series = setup.pose?;
        let (phase, delay) = (setup.phases.head, setup.head.delay);
        let arrival = match (series.provenance(), setup.head.rate) {
            (Provenance::TrackerOutput { delay }, _) => Arrival::Recorded {
                age: delay,
                transit: Nanos::ZERO,
                read: 0,
            },
            (Provenance::Truth, None) => Arrival::Recorded {
                age: Nanos::ZERO,
                transit: delay,
                read: 0,
            },
            (Provenance::Truth, Some(rate)) => Arrival::Sampled {
                rate,
                phase,
                delay,
                next: rate.first_at_or_after(series.time(0)? - phase),
            },
        };
        Some(Self {
            cursor: Cursor::new(series),
            arrival,
            head: HeadTracker::new(setup.predictor, setup.max_gap)
                .expect("settings are checked by whoever makes the set-up"),
            max_gap: setup.max_gap,
            lost: false,
        })
    }

    /// The pose that a frame started at `now` is drawn for, if it is to be seen at `shown`. A missing
    /// sample leaves the newest estimate in use, but held: while samples are missing, and where the
    /// newest pose is old itself, no velocity is known.
    pub(crate) fn predict(&mut self, now: Nanos, shown: Nanos) -> Option<PoseStamp> {
        self.take_up_to(now);
        let motion = self.head.motion()?;
        let held = self.lost || now - motion.t > self.max_gap;
        Some(PoseStamp {
            sampled: motion.t,
            predicted_for: shown,
            pose: if held { motion.pose } else { motion.at(shown) },
        })
    }

    /// Takes the samples that have arrived by `now`.
    fn take_up_to(&mut self, now: Nanos) {
        let (head, lost) = (&mut self.head, &mut self.lost);
        let mut take = |t: Nanos, value: Option<Pose>| {
            *lost = value.is_none();
            head.observe(Sample { t, value });
        };
        match &mut self.arrival {
            Arrival::Recorded { age, transit, read } => {
                self.cursor.seek(now - *transit);
                let arrived = self.cursor.seen();
                for sample in (*read..arrived).filter_map(|i| self.cursor.get(i)) {
                    take(sample.t - *age, sample.value);
                }
                *read = arrived;
            }
            Arrival::Sampled {
                rate,
                phase,
                delay,
                next,
            } => loop {
                let t = *phase + rate.tick(*next);
                if t + *delay > now {
                    break;
                }
                take(t, self.cursor.at(t, self.max_gap));
                *next += 1;
            },
        }
        self.cursor.release();
    }
}
