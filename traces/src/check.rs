use foveasim_models::{GazeSeries, Interpolate, PoseSeries, Recording, Series};

use crate::TraceError;

/// The gaze of a recording, for those who cannot do without.
///
/// # Errors
/// If it has no gaze, or every sample is missing.
pub fn require_gaze(recording: &Recording) -> Result<&GazeSeries, TraceError> {
    let error = |why| TraceError::NoGaze {
        source_name: recording.source.clone(),
        why,
    };
    present(recording.gaze.as_ref()).map_err(error)
}

/// The head pose of a recording, for those who cannot do without.
///
/// # Errors
/// If it has no head pose, or every sample is missing.
pub fn require_pose(recording: &Recording) -> Result<&PoseSeries, TraceError> {
    let error = |why| TraceError::NoPose {
        source_name: recording.source.clone(),
        why,
    };
    present(recording.pose.as_ref()).map_err(error)
}

fn present<T: Interpolate>(series: Option<&Series<T>>) -> Result<&Series<T>, String> {
    let series = series.ok_or("the recording has none")?;
    if series.samples().iter().all(|s| s.value.is_none()) {
        return Err(format!("all {} samples are lost", series.samples().len()));
    }
    Ok(series)
}
