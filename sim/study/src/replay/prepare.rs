use foveasim_models::{
    Display, GazeDirection, GazeMode, Geometry, ModelError, Nanos, Pose, Provenance, Role,
    SeriesOutline, Stream,
};
use foveasim_pipeline::{Phases, Setup};
use glam::DVec2;

use super::played::{Played, Track};
use super::{ReplayError, ReplayOptions};

/// The most scans a replay keeps: 23 hours at 120 Hz, about 4 GB.
const MAX_SCANS: i64 = 10_000_000;

/// Time stamps beyond this leave no room for delays \[ns\].
const MAX_TIME: u64 = 4_000_000_000_000_000_000;

/// The longest delay that a tracker can have had.
const MAX_DELAY: Nanos = Nanos(10_000_000_000);

/// Whether a gaze meets the first eye's image.
pub(super) fn on_display(display: &Display, gaze: GazeDirection) -> bool {
    let panel = display.primary();
    let size = panel.viewport.size.as_dvec2();
    panel
        .viewport
        .project(panel.in_eye(gaze).vector())
        .is_some_and(|px| px.cmpge(DVec2::ZERO).all() && px.cmple(size).all())
}

/// First and last time, if they can be computed with.
pub(super) fn span(played: &Played<'_>, display: &Display) -> Result<(Nanos, Nanos), ReplayError> {
    let origin = || played.origin.to_owned();
    let (start, end) = played
        .span()
        .ok_or_else(|| ReplayError::Empty { origin: origin() })?;
    if start.0.unsigned_abs() > MAX_TIME || end.0.unsigned_abs() > MAX_TIME {
        return Err(ReplayError::Time {
            origin: origin(),
            first: start.0,
            last: end.0,
        });
    }
    let delays = [
        played.gaze.map(|t| t.delay()),
        played.pose.map(|t| t.delay()),
    ];
    for delay in delays.into_iter().flatten() {
        if !(Nanos::ZERO..=MAX_DELAY).contains(&delay) {
            return Err(ReplayError::Delay {
                origin: origin(),
                delay,
            });
        }
    }
    let longest = display.scan.rate.tick(MAX_SCANS);
    if end - start > longest {
        return Err(ReplayError::Duration {
            origin: origin(),
            seconds: (end - start).as_secs(),
            valid: format!("at most {} s on this display", longest.as_secs()),
        });
    }
    Ok((start, end))
}

/// The gaze. A fixed fovea can do without; so can a moving head, whose frames are then all drawn as
/// after a loss.
pub(super) fn gaze_of<'a>(
    played: &Played<'a>,
    mode: GazeMode,
    head_moves: bool,
    notes: &mut Vec<String>,
) -> Result<Option<Track<'a, GazeDirection>>, ReplayError> {
    let what = match played.gaze {
        Some(track) if track.outline.present > 0 => return Ok(Some(track)),
        Some(_) => "the gaze is lost in every sample",
        None => "no gaze was recorded",
    };
    match mode {
        GazeMode::Fixed => Ok(None),
        GazeMode::Tracked if head_moves => {
            notes.push(format!(
                "{what}: the fovea stays at the centre in every frame, and no gaze error is known"
            ));
            Ok(None)
        }
        GazeMode::Tracked => Err(ReplayError::NoGaze {
            origin: played.origin.to_owned(),
            what,
        }),
    }
}

/// Head poses, where the display moves with the head.
pub(super) fn pose_of<'a>(
    played: &Played<'a>,
    display: &Display,
    notes: &mut Vec<String>,
) -> Option<Track<'a, Pose>> {
    let head_mounted = display.geometry == Geometry::HeadMounted;
    match played.pose {
        Some(_) if !head_mounted => {
            notes.push(
                "the display does not move with the head: recorded head motion is not used".into(),
            );
            None
        }
        None if head_mounted => {
            notes.push("no head motion was recorded: the head is still".into());
            None
        }
        pose => pose,
    }
}

/// Draws where the clocks stand when the recording starts.
pub(super) fn phases(setup: &Setup<'_>, seed: u64, start: Nanos) -> Phases {
    let mut stream = Stream::new(seed, Role::Phase, 0);
    let mut within = |period: Nanos| start + Nanos(stream.below(period.0 as u64) as i64);
    Phases {
        exposure: within(setup.tracker.rate.period()),
        host: within(setup.host_rate.period()),
        vblank: within(setup.scan.rate.period()),
        // Drawn last, and only if used: the other clocks stand where they did without it.
        head: match setup.head.rate {
            Some(rate) => within(rate.period()),
            None => start,
        },
    }
}

/// Checks how the head is sampled and predicted.
pub(super) fn check_head(options: &ReplayOptions) -> Result<(), ReplayError> {
    options.predictor.validate().map_err(ReplayError::Head)?;
    let delay = options.head.delay;
    if (Nanos::ZERO..=MAX_DELAY).contains(&delay) {
        return Ok(());
    }
    let valid = format!("0 to {}", MAX_DELAY.as_ms());
    let error = ModelError::range("head delay [ms]", delay.as_ms(), valid);
    Err(ReplayError::Head(error))
}

/// How old the newest gaze may be when a frame starts, if no sample is missing; with two periods, so
/// that jitter does not count as a loss.
pub(super) fn fresh_age(setup: &Setup<'_>, mode: GazeMode, gaze: Option<&SeriesOutline>) -> Nanos {
    let tracker = setup.tracker;
    match (mode, gaze) {
        (
            GazeMode::Tracked,
            Some(&SeriesOutline {
                provenance: Provenance::TrackerOutput { delay },
                median_step,
                ..
            }),
        ) => delay + median_step * 2,
        _ => {
            let longest = tracker.exposure + tracker.processing.max() + tracker.transport.max();
            longest + tracker.rate.period() * 2
        }
    }
}
