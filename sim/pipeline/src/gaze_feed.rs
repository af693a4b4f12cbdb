use std::collections::VecDeque;

use foveasim_models::{
    GazeDirection, Loss, Losses, Nanos, Provenance, Role, Stream, Ticks, Tracker, math,
};

use crate::{Cursor, GazeInput, GazeStamp, Setup};

/// Makes gaze samples: when to measure next, what is measured, and when it is delivered.
#[derive(Debug)]
pub(crate) enum GazeFeed<'a> {
    /// Nobody measures.
    Off,
    /// The simulated tracker.
    Simulated(Box<Simulated<'a>>),
    /// A recorded tracker's own output.
    Recorded {
        samples: Cursor<'a, GazeDirection>,
        /// Number of the sample that is due.
        next: usize,
        delay: Nanos,
    },
}

#[derive(Debug)]
pub(crate) struct Simulated<'a> {
    tracker: &'a Tracker,
    truth: Truth<'a>,
    max_gap: Nanos,
    starts: Ticks,
    phase: Nanos,
    processing: Stream,
    transport: Stream,
    noise: Stream,
    /// The headset's walk on the face, to the right and upwards \[deg\], and what moves it.
    slip: ([f64; 2], Stream),
    /// Dropouts and blinks.
    losses: [Option<Losses>; 2],
    /// Which of them hid the exposure before.
    hidden_by: Option<usize>,
    /// When the sample before is delivered: samples do not overtake.
    delivered: Nanos,
}

#[derive(Debug)]
enum Truth<'a> {
    Constant(GazeDirection),
    Series(Cursor<'a, GazeDirection>),
}

impl<'a> GazeFeed<'a> {
    /// The feed of `setup` from `begin` on.
    pub(crate) fn new(setup: &Setup<'a>, begin: Nanos) -> Self {
        let truth = match setup.gaze {
            GazeInput::None => return Self::Off,
            GazeInput::Constant(value) => Truth::Constant(value),
            GazeInput::Recorded(series) => match series.provenance() {
                Provenance::Truth => Truth::Series(Cursor::new(series)),
                Provenance::TrackerOutput { delay } => {
                    let mut samples = Cursor::new(series);
                    samples.seek(begin - Nanos(1));
                    return Self::Recorded {
                        next: samples.seen(),
                        samples,
                        delay,
                    };
                }
            },
        };
        let rate = setup.tracker.rate;
        let phase = setup.phases.exposure;
        let loss = |loss: &Option<Loss>, role| {
            loss.as_ref()
                .map(|loss| Losses::new(loss, setup.seed, role, setup.run, begin))
        };
        Self::Simulated(Box::new(Simulated {
            tracker: setup.tracker,
            truth,
            max_gap: setup.max_gap,
            starts: rate.ticks(rate.first_at_or_after(begin - phase)),
            phase,
            processing: Stream::new(setup.seed, Role::Tracker, setup.run),
            transport: Stream::new(setup.seed, Role::Transport, setup.run),
            noise: Stream::new(setup.seed, Role::GazeNoise, setup.run),
            slip: ([0.0; 2], Stream::new(setup.seed, Role::Slippage, setup.run)),
            losses: [
                loss(&setup.tracker.dropouts, Role::Dropout),
                loss(&setup.tracker.blinks, Role::Blink),
            ],
            hidden_by: None,
            delivered: begin,
        }))
    }

    /// When the next measurement is made; `None` if there is no more.
    pub(crate) fn next_time(&mut self) -> Option<Nanos> {
        match self {
            Self::Off => None,
            Self::Simulated(s) => s.starts.next().map(|t| s.phase + t),
            Self::Recorded { samples, next, .. } => samples.get(*next).map(|s| s.t),
        }
    }

    /// Makes the measurement due at `now`, if anything is seen.
    pub(crate) fn measure(&mut self, now: Nanos) -> Option<GazeStamp> {
        match self {
            Self::Off => None,
            Self::Simulated(s) => s.expose(now),
            Self::Recorded {
                samples,
                next,
                delay,
            } => {
                let sample = samples.get(*next)?;
                *next += 1;
                samples.seek(now);
                samples.release();
                let so = now - *delay;
                let stamp = |value| GazeStamp {
                    exposure_start: so,
                    exposure_end: so,
                    processed: now,
                    delivered: now,
                    value,
                };
                sample.value.map(stamp)
            }
        }
    }
}

impl Simulated<'_> {
    fn expose(&mut self, start: Nanos) -> Option<GazeStamp> {
        let tracker = self.tracker;
        let end = start + tracker.exposure;
        // Drawn whether or not anything is seen, so that a blink does not change later samples.
        let processing = tracker.processing.draw(&mut self.processing);
        let transport = tracker.transport.draw(&mut self.transport);
        let error = self.error();
        let middle = Nanos(start.0 + tracker.exposure.0 / 2);
        let seen = match &mut self.truth {
            Truth::Constant(value) => *value,
            Truth::Series(cursor) => {
                let seen = cursor.at(middle, self.max_gap);
                cursor.release();
                seen?
            }
        };
        if self.is_hidden(start) {
            return None;
        }
        let [right, up] = tracker.bias_map.as_ref().map_or([0.0; 2], |m| m.at(seen));
        self.delivered = (end + processing + transport).max(self.delivered);
        // A sample that has to wait for the one before waits in the tracker, if that can be.
        let processed = (self.delivered - transport).min(end + tracker.processing.max());
        Some(GazeStamp {
            exposure_start: start,
            exposure_end: end,
            processed,
            delivered: self.delivered,
            value: GazeDirection::new(
                seen.azimuth_deg + right + error.azimuth_deg,
                seen.elevation_deg + up + error.elevation_deg,
            ),
        })
    }

    /// Whether a dropout or a blink hides an exposure that begins at `start`. After each loss one
    /// exposure is seen before the next begins, so that there is a longest time without any.
    fn is_hidden(&mut self, start: Nanos) -> bool {
        let mut hidden = None;
        let recovering = match self.hidden_by {
            None => false,
            Some(i) => self.losses[i].as_ref().is_some_and(|l| l.until() <= start),
        };
        // The one that hid the exposure before goes first: it may go on.
        let order = match self.hidden_by {
            Some(1) => [1, 0],
            _ => [0, 1],
        };
        for i in order {
            if let Some(losses) = &mut self.losses[i] {
                let not_before = match recovering || hidden.is_some() {
                    true => start + Nanos(1),
                    false => Nanos(i64::MIN),
                };
                if losses.hide(start, not_before) {
                    hidden = Some(i);
                }
            }
        }
        self.hidden_by = hidden;
        hidden.is_some()
    }

    /// Bias to the right, normal noise and slippage on both axes.
    fn error(&mut self) -> GazeDirection {
        let tracker = self.tracker;
        let (bias, precision) = (tracker.bias_deg, tracker.precision_deg);
        let mut error = [bias, 0.0];
        if precision != 0.0 {
            error[0] += precision * self.noise.normal();
            error[1] += precision * self.noise.normal();
        }
        let slippage = tracker.slippage_deg_per_sqrt_min;
        if slippage != 0.0 {
            let (slip, stream) = &mut self.slip;
            let step = slippage * math::sqrt(1.0 / (60.0 * tracker.rate.hz()));
            for axis in 0..2 {
                slip[axis] += step * stream.normal();
                error[axis] += slip[axis];
            }
        }
        GazeDirection::new(error[0], error[1])
    }
}

/// Samples on their way to the host.
pub(crate) type InFlight = VecDeque<GazeStamp>;
