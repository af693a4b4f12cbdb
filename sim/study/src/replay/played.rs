use foveasim_models::{
    GazeDirection, Interpolate, Nanos, Pose, Provenance, Recording, Series, SeriesOutline,
};
use foveasim_pipeline::Samples;

/// What is replayed, in memory or passing by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Played<'a> {
    /// Where it comes from, for errors.
    pub(super) origin: &'a str,
    pub(super) gaze: Option<Track<'a, GazeDirection>>,
    pub(super) pose: Option<Track<'a, Pose>>,
}

/// One series of it, and what is known of the whole.
#[derive(Debug)]
pub(super) struct Track<'a, T> {
    pub(super) samples: Samples<'a, T>,
    pub(super) outline: SeriesOutline,
}

impl<T> Clone for Track<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Track<'_, T> {}

impl<T> Track<'_, T> {
    /// How old samples are at their time stamps.
    pub(super) fn delay(&self) -> Nanos {
        match self.outline.provenance {
            Provenance::Truth => Nanos::ZERO,
            Provenance::TrackerOutput { delay } => delay,
        }
    }
}

impl<'a, T: Interpolate> From<&'a Series<T>> for Track<'a, T> {
    fn from(series: &'a Series<T>) -> Self {
        Self {
            samples: series.into(),
            outline: series.into(),
        }
    }
}

impl<'a> From<&'a Recording> for Played<'a> {
    fn from(recording: &'a Recording) -> Self {
        Self {
            origin: &recording.source,
            gaze: recording.gaze.as_ref().map(Track::from),
            pose: recording.pose.as_ref().map(Track::from),
        }
    }
}

impl Played<'_> {
    /// First and last time of any sample; `None` where there is none.
    pub(super) fn span(&self) -> Option<(Nanos, Nanos)> {
        let ends = |o: SeriesOutline| (o.start, o.end);
        let gaze = self.gaze.map(|t| ends(t.outline));
        let pose = self.pose.map(|t| ends(t.outline));
        match (gaze, pose) {
            (Some(a), Some(b)) => Some((a.0.min(b.0), Ord::max(a.1, b.1))),
            (a, b) => a.or(b),
        }
    }
}
