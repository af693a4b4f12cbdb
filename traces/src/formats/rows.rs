use std::io::BufRead;
use std::ops::Range;

use foveasim_models::{GazeDirection, Pose, Provenance, Recording, Sample};

use super::{Parsed, series};
use crate::lines::{Line, Lines};
use crate::{Labels, ReadOptions, TraceError};

/// What one row of a file says of each series.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RowSamples {
    /// Its sample of gaze, if it has one.
    pub gaze: Option<Sample<GazeDirection>>,
    /// Its sample of head pose, if it has one.
    pub pose: Option<Sample<Pose>>,
}

impl RowSamples {
    pub(crate) fn is_empty(&self) -> bool {
        self.gaze.is_none() && self.pose.is_none()
    }
}

/// Reads a format whose rows are understood one by one, each by what stands before it: such files need not
/// be held in memory.
pub(crate) trait RowReader {
    /// What a line says that is no comment.
    fn row(&mut self, line: &Line<'_>) -> Result<RowSamples, TraceError>;

    /// After the last row.
    fn finish(&mut self, options: &ReadOptions) -> Result<AllRows, TraceError>;
}

/// What is known of a file when all its rows have been read.
pub(crate) struct AllRows {
    /// Which of the rows that have samples are the session that is read.
    pub(crate) range: Range<usize>,
    /// What the gaze is, and what the pose is.
    pub(crate) provenance: [Provenance; 2],
    pub(crate) notes: Vec<String>,
    pub(crate) labels: Labels,
}

/// The samples of the next row that has any; `None` at the end.
pub(crate) fn next_row<R: BufRead>(
    rows: &mut dyn RowReader,
    lines: &mut Lines<'_, R>,
) -> Result<Option<RowSamples>, TraceError> {
    while let Some(line) = lines.next()? {
        if line.text.starts_with('#') {
            continue;
        }
        let samples = rows.row(&line)?;
        if !samples.is_empty() {
            return Ok(Some(samples));
        }
    }
    Ok(None)
}

/// All rows in memory.
pub(super) fn collect<R: BufRead>(
    rows: &mut dyn RowReader,
    lines: &mut Lines<'_, R>,
    options: &ReadOptions,
) -> Result<Parsed, TraceError> {
    let (mut gaze, mut poses) = (Vec::new(), Vec::new());
    while let Some(samples) = next_row(rows, lines)? {
        gaze.extend(samples.gaze);
        poses.extend(samples.pose);
    }
    let all = rows.finish(options)?;
    // Formats with sessions have one sample of each of their series in every row.
    let part = |n: usize| all.range.start.min(n)..all.range.end.min(n);
    let gaze = gaze.drain(part(gaze.len())).collect();
    let poses = poses.drain(part(poses.len())).collect();
    Ok(Parsed {
        recording: Recording {
            gaze: series(gaze, all.provenance[0]),
            pose: series(poses, all.provenance[1]),
            notes: all.notes,
            ..Recording::default()
        },
        labels: all.labels,
    })
}
