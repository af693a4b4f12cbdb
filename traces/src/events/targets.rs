use foveasim_models::math::{cos, quantile_sorted, to_rad};
use foveasim_models::{GazeDirection, GazeSeries, Nanos};

use super::{Agreement, GazeEvents, OnsetError, agreement};
use crate::{EventKind, TargetStep};

/// Gaze on a target is its median over this time before the target goes \[ms\].
const SETTLED_MS: f64 = 300.0;
/// The shares of the way at which a saccade counts as begun and as under way.
const BEGUN: f64 = 0.05;
const UNDER_WAY: f64 = 0.5;
/// A way that takes longer to its middle is made in steps, whose onsets are not known \[ms\].
const STEPWISE_MS: f64 = 60.0;
/// On a target, saccades below this are fixational \[deg\].
const FIXATIONAL_DEG: f64 = 1.0;

/// Agreement of saccades with the jumps of a target, by where gaze is and not by how fast it moves.
///
/// Between two known targets gaze must go from one place to the other. The reference begins where it has
/// gone 5 % of the way (so a little after the eye started) and ends in the middle, places being medians of
/// gaze itself, so that an offset does not matter; ways made in steps are left out. Counted against it are
/// the saccades that overlap these and, as false ones, those of 1° and more while a target stands (which a
/// viewer may really make); corrections are not judged. Ends are not compared. `None` without two targets.
pub fn target_agreement(
    gaze: &GazeSeries,
    events: &GazeEvents,
    targets: &[TargetStep],
) -> Option<Agreement> {
    let windows = windows(gaze, targets);
    let places: Vec<_> = windows.iter().map(|w| settled(gaze, w.1)).collect();
    let mut reference = Vec::new();
    for (w, p) in windows.windows(2).zip(places.windows(2)) {
        if let (Some(a), Some(b)) = (p[0], p[1]) {
            reference.extend(jump(gaze, (w[0].1, w[1].1), a, b));
        }
    }
    if reference.is_empty() {
        return None;
    }
    let judged = |start: Nanos, end: Nanos, amplitude: f64| {
        let overlaps = reference
            .iter()
            .any(|r: &(Nanos, Nanos)| start <= r.1 && end >= r.0);
        let standing = windows.iter().any(|w| start >= w.0 && end <= w.1);
        overlaps || (standing && amplitude >= FIXATIONAL_DEG)
    };
    let found: Vec<_> = events
        .of(EventKind::Saccade)
        .filter(|e| judged(e.start, e.end, e.amplitude_deg))
        .map(|e| (e.start, e.end))
        .collect();
    let compared = agreement(EventKind::Saccade, "targets", &found, &reference);
    Some(Agreement {
        offset: OnsetError::NONE,
        ..compared
    })
}

/// First and last time of each target.
fn windows(gaze: &GazeSeries, targets: &[TargetStep]) -> Vec<(Nanos, Nanos)> {
    let ends = targets.iter().skip(1).map(|s| s.t).chain([gaze.end()]);
    targets
        .iter()
        .zip(ends)
        .filter(|(step, _)| step.target.is_some())
        .map(|(step, end)| (step.t, end))
        .collect()
}

/// Where gaze rests before `end`.
fn settled(gaze: &GazeSeries, end: Nanos) -> Option<GazeDirection> {
    let from = end - Nanos::from_ms(SETTLED_MS);
    let samples = gaze.samples();
    let first = samples.partition_point(|s| s.t < from);
    let last = samples.partition_point(|s| s.t < end);
    let values: Vec<_> = samples[first..last]
        .iter()
        .filter_map(|s| s.value)
        .collect();
    let median = |pick: fn(&GazeDirection) -> f64| {
        let mut sorted: Vec<f64> = values.iter().map(pick).collect();
        sorted.sort_by(f64::total_cmp);
        quantile_sorted(&sorted, 0.5)
    };
    (!values.is_empty())
        .then(|| GazeDirection::new(median(|g| g.azimuth_deg), median(|g| g.elevation_deg)))
}

/// When gaze goes from `a` to `b` inside a span: from 5 % of the way to the middle, in one go.
fn jump(
    gaze: &GazeSeries,
    (from, to): (Nanos, Nanos),
    a: GazeDirection,
    b: GazeDirection,
) -> Option<(Nanos, Nanos)> {
    let squeeze = cos(to_rad(a.elevation_deg));
    let flat = |g: GazeDirection| [g.azimuth_deg * squeeze, g.elevation_deg];
    let (a, b) = (flat(a), flat(b));
    let way = [b[0] - a[0], b[1] - a[1]];
    let length = way[0] * way[0] + way[1] * way[1];
    if length < FIXATIONAL_DEG * FIXATIONAL_DEG {
        return None;
    }
    let samples = gaze.samples();
    let first = samples.partition_point(|s| s.t < from);
    let last = samples.partition_point(|s| s.t < to);
    let mut begun = None;
    for sample in &samples[first..last] {
        let Some(value) = sample.value else { continue };
        let at = flat(value);
        let share = ((at[0] - a[0]) * way[0] + (at[1] - a[1]) * way[1]) / length;
        if share < BEGUN {
            begun = None;
            continue;
        }
        let start = *begun.get_or_insert(sample.t);
        if share >= UNDER_WAY {
            let whole = (sample.t - start).as_ms() <= STEPWISE_MS;
            return whole.then_some((start, sample.t));
        }
    }
    None
}
