use foveasim_models::{Nanos, Pose, PosePredictor, Provenance, Sample};

use crate::{Cursor, PoseStamp, Setup};

/// Gives the host its newest head pose, predicted.
#[derive(Debug)]
pub(crate) struct PoseFeed<'a> {
    cursor: Cursor<'a, Pose>,
    delay: Nanos,
    predictor: PosePredictor,
    max_gap: Nanos,
    /// How many samples have been looked at.
    read: usize,
    /// The newest present one, at the time it was so.
    newest: Option<Sample<Pose>>,
    /// The present one before it, if there is no loss and no hole between the two.
    before: Option<Sample<Pose>>,
    /// A sample was missing since the newest present one.
    lost: bool,
}

impl<'a> PoseFeed<'a> {
    pub(crate) fn new(setup: &Setup<'a>) -> Option<Self> {
        let series = setup.pose?;
        let delay = match series.provenance() {
            Provenance::Truth => Nanos::ZERO,
            Provenance::TrackerOutput { delay } => delay,
        };
        let (cursor, predictor) = (Cursor::new(series), setup.predictor);
        Some(Self {
            cursor,
            delay,
            predictor,
            max_gap: setup.max_gap,
            read: 0,
            newest: None,
            before: None,
            lost: false,
        })
    }

    /// The pose that a frame started at `now` is drawn for, if it is to be seen at `shown`. A missing
    /// sample leaves the newest present one in use, but held: across a loss or a hole, and after a
    /// newest pose that is old itself, no velocity is known.
    pub(crate) fn predict(&mut self, now: Nanos, shown: Nanos) -> Option<PoseStamp> {
        self.cursor.seek(now);
        let past = self.cursor.past();
        for sample in &past[self.read.min(past.len())..] {
            self.take(sample);
        }
        self.read = past.len();
        let newest = self.newest?;
        let before = self.before.filter(|_| now - newest.t <= self.max_gap);
        let pose = self.predictor.predict(newest, before, shown)?;
        Some(PoseStamp {
            sampled: newest.t,
            predicted_for: shown,
            pose,
        })
    }

    fn take(&mut self, sample: &Sample<Pose>) {
        if sample.value.is_none() {
            (self.before, self.lost) = (None, true);
            return;
        }
        let sample = Sample {
            t: sample.t - self.delay,
            ..*sample
        };
        match self.newest {
            // Of equal times the later sample counts; what came before both is the same.
            Some(newest) if newest.t == sample.t => {}
            Some(newest) if !self.lost && sample.t - newest.t <= self.max_gap => {
                self.before = Some(newest);
            }
            _ => self.before = None,
        }
        (self.newest, self.lost) = (Some(sample), false);
    }
}
