use foveasim_models::{Interpolate, Nanos, Rate, Recording, Sample, Series};

use crate::interval::usual_interval_ms;
use crate::synth::MAX_SAMPLES;
use crate::{TraceError, require_gaze};

/// The series at the ticks of `rate`, counted from its first sample and no further than its last.
///
/// Between samples it is linear ([`Series::at`]); next to a missing sample and inside holes longer
/// than `max_gap` the result is missing. It is no low-pass filter: a lower rate aliases what is faster
/// than half of it.
///
/// # Errors
/// If that would be more than 20 million samples.
pub fn resample<T: Interpolate>(
    series: &Series<T>,
    rate: Rate,
    max_gap: Nanos,
) -> Result<Series<T>, TraceError> {
    let (start, span) = (series.start(), series.end() - series.start());
    if span.as_secs() * rate.hz() > MAX_SAMPLES {
        let valid = format!(
            "at most {} Hz for {} s",
            MAX_SAMPLES / span.as_secs(),
            span.as_secs()
        );
        return Err(TraceError::option("resample", rate.hz(), valid));
    }
    let ticks = (0..)
        .map(|k| start + rate.tick(k))
        .take_while(|t| *t <= series.end());
    let samples = ticks
        .map(|t| Sample {
            t,
            value: series.at(t, max_gap),
        })
        .collect();
    Ok(rebuilt(samples, series).expect("the first sample is always kept"))
}

/// As [`resample`], both series of a recording.
///
/// # Errors
/// As [`resample`].
pub fn resample_recording(
    recording: &Recording,
    rate: Rate,
    max_gap: Nanos,
) -> Result<Recording, TraceError> {
    let gaze = recording
        .gaze
        .as_ref()
        .map(|s| resample(s, rate, max_gap))
        .transpose()?;
    let pose = recording
        .pose
        .as_ref()
        .map(|s| resample(s, rate, max_gap))
        .transpose()?;
    let mut notes = recording.notes.clone();
    notes.push(format!(
        "resampled to {} Hz, holes over {max_gap} left missing",
        rate.hz()
    ));
    Ok(Recording {
        gaze,
        pose,
        notes,
        ..recording.clone()
    })
}

/// The recording with its gaze as a slower tracker would have sampled it, at the ticks of `rate`; as
/// [`resample`], and the head as it was.
///
/// # Errors
/// If it has no gaze, or `rate` is not below that of the recording (as stated, or by its median interval).
pub fn decimate_gaze(
    recording: &Recording,
    rate: Rate,
    max_gap: Nanos,
) -> Result<Recording, TraceError> {
    let gaze = require_gaze(recording)?;
    let usual = usual_interval_ms(gaze, recording.gaze_rate);
    if rate.period().as_ms() <= usual {
        let valid = format!("below the {:.1} Hz of the recording", 1e3 / usual);
        return Err(TraceError::option("decimate", rate.hz(), valid));
    }
    Ok(Recording {
        gaze: Some(resample(gaze, rate, max_gap)?),
        gaze_rate: None,
        ..recording.clone()
    })
}

/// The samples in `from..to`, counted from the first sample of the recording; times stay as they are.
///
/// # Errors
/// If no sample lies there; the error says how long the recording is.
pub fn slice(recording: &Recording, from: Nanos, to: Nanos) -> Result<Recording, TraceError> {
    let (start, end) = recording.span().unwrap_or_default();
    let keep = start.0.saturating_add(from.0)..start.0.saturating_add(to.0);
    let gaze = recording.gaze.as_ref().and_then(|s| cut(s, &keep));
    let pose = recording.pose.as_ref().and_then(|s| cut(s, &keep));
    if gaze.is_none() && pose.is_none() {
        let value = format!("{}..{} s", from.as_secs(), to.as_secs());
        let valid = format!("start..end inside 0..{} s", (end - start).as_secs());
        return Err(TraceError::option("slice", value, valid));
    }
    let mut notes = recording.notes.clone();
    notes.push(format!(
        "cut to {}..{} s of the recording",
        from.as_secs(),
        to.as_secs()
    ));
    Ok(Recording {
        gaze,
        pose,
        notes,
        ..recording.clone()
    })
}

fn cut<T: Interpolate>(series: &Series<T>, keep: &std::ops::Range<i64>) -> Option<Series<T>> {
    let samples = series
        .samples()
        .iter()
        .filter(|s| keep.contains(&s.t.0))
        .copied()
        .collect();
    rebuilt(samples, series)
}

/// The recording with its first sample at time zero.
#[must_use]
pub fn rebase(recording: &Recording) -> Recording {
    let start = recording.span().unwrap_or_default().0;
    Recording {
        gaze: recording.gaze.as_ref().and_then(|s| moved(s, start)),
        pose: recording.pose.as_ref().and_then(|s| moved(s, start)),
        ..recording.clone()
    }
}

fn moved<T: Interpolate>(series: &Series<T>, start: Nanos) -> Option<Series<T>> {
    let samples = series
        .samples()
        .iter()
        .map(|s| Sample {
            t: s.t - start,
            value: s.value,
        })
        .collect();
    rebuilt(samples, series)
}

/// A series of `samples`, in the order that `like` had; `None` where there are none left.
fn rebuilt<T: Interpolate>(samples: Vec<Sample<T>>, like: &Series<T>) -> Option<Series<T>> {
    Series::new(samples, like.provenance()).ok()
}
