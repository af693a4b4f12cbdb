use std::io::BufRead;

use foveasim_models::{GazeDirection, Provenance, Recording, Sample};
use glam::DVec3;

use super::columns::Columns;
use super::number::Row;
use super::{GAZE_ASSUMED, Head, count, in_order, no_rows, series};
use crate::lines::Lines;
use crate::{ReadOptions, TraceError};

const COLUMNS: [&str; 5] = ["timestamp", "left_x", "left_y", "right_x", "right_y"];

/// Farthest gaze from the centre \[px\]; trackers extrapolate beyond the screen, but not this far.
const MAX_PX: f64 = 1e6;

/// Tab-separated gaze on a screen: `timestamp` in milliseconds, and for one or both eyes x and y in
/// pixels from the screen's centre, y down; `nan` where an eye was lost.
///
/// The viewer looks at the centre along the screen's normal: pixels become millimetres, millimetres at
/// the viewing distance a direction, and that azimuth and elevation. Both eyes are averaged on the
/// screen; where one is lost the other counts alone, which may step gaze by half their disagreement.
pub(super) fn parse<R: BufRead>(
    head: &Head,
    lines: &mut Lines<'_, R>,
    options: &ReadOptions,
) -> Result<Recording, TraceError> {
    let file = lines.file();
    let columns = Columns::new(file, &head.columns, COLUMNS)?;
    let eyes = [(1, 2), (3, 4)].map(|(x, y)| columns.has(x) && columns.has(y));
    if eyes == [false, false] {
        let what =
            "one coordinate of each eye alone; want left_x and left_y, or right_x and right_y";
        return Err(TraceError::Header {
            file: file.to_owned(),
            line: head.columns.0,
            what: what.into(),
        });
    }
    let screen = &options.screen;
    let mm_per_px = [0, 1].map(|i| screen.size_mm[i] / screen.size_px[i]);
    let mut samples = Vec::new();
    let mut previous = None;
    let mut alone = 0;
    let mut duplicates = 0;
    while let Some(line) = lines.next()? {
        let row = Row::new(file, &line, columns.decimal_comma());
        let texts = row.pick(&columns, line.text)?;
        let t = row.time(COLUMNS[0], texts[0], -3)?;
        in_order(&row, previous, t)?;
        duplicates += usize::from(previous == Some(t));
        previous = Some(t);
        let eye = |present: bool, i: usize| -> Result<Option<[f64; 2]>, TraceError> {
            if !present {
                return Ok(None);
            }
            let x = row.optional(COLUMNS[i], texts[i], -MAX_PX..=MAX_PX)?;
            let y = row.optional(COLUMNS[i + 1], texts[i + 1], -MAX_PX..=MAX_PX)?;
            Ok(x.zip(y).map(|(x, y)| [x, y]))
        };
        let place = match (eye(eyes[0], 1)?, eye(eyes[1], 3)?) {
            (Some(l), Some(r)) => Some([0.5 * (l[0] + r[0]), 0.5 * (l[1] + r[1])]),
            (one, other) => {
                let one = one.or(other);
                alone += usize::from(one.is_some() && eyes == [true, true]);
                one
            }
        };
        let value = place.map(|[x, y]| {
            let (x, y) = (x * mm_per_px[0], y * mm_per_px[1]);
            GazeDirection::from_vector(DVec3::new(x, -y, -screen.distance_mm))
        });
        samples.push(Sample { t, value });
    }
    if samples.is_empty() {
        return Err(no_rows(file));
    }
    let mut notes = vec![
        GAZE_ASSUMED.to_owned(),
        format!(
            "pixels turned into degrees for a screen of {}x{} px, {}x{} mm at {} mm",
            screen.size_px[0],
            screen.size_px[1],
            screen.size_mm[0],
            screen.size_mm[1],
            screen.distance_mm
        ),
    ];
    notes.push(match eyes {
        [true, true] => "gaze is the mean of both eyes on the screen".into(),
        [true, false] => "gaze of the left eye alone".into(),
        _ => "gaze of the right eye alone".to_owned(),
    });
    if alone > 0 {
        notes.push(format!(
            "{} of one eye alone, where the other was lost",
            count(alone, "sample")
        ));
    }
    if duplicates > 0 {
        notes.push(format!(
            "{} with the time of the sample before; the later one counts",
            count(duplicates, "sample")
        ));
    }
    if !columns.extra().is_empty() {
        notes.push(format!("columns not used: {}", columns.extra().join(", ")));
    }
    Ok(Recording {
        gaze: series(samples, Provenance::Truth),
        notes,
        ..Recording::default()
    })
}
