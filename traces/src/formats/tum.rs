use std::io::BufRead;

use foveasim_models::{Pose, Provenance, Recording, Sample};

use super::axes::PoseFrame;
use super::number::Row;
use super::{POSE_ASSUMED, count, in_order, no_rows, series};
use crate::TraceError;
use crate::lines::Lines;

/// Fields per row.
pub(super) const FIELDS: usize = 8;

const NAMES: [&str; FIELDS] = ["timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw"];

/// The TUM trajectory format (Sturm et al., IROS 2012): `timestamp tx ty tz qx qy qz qw`, seconds and
/// metres, `#` comments.
///
/// Its poses are those of a camera's optical frame (+X right, +Y down, +Z forward) in a world whose
/// +Z is up. Both frames are turned into ours (+Y up, −Z forward): the head by half a turn about X,
/// which is exact, the world by −90° about X.
pub(super) fn parse<R: BufRead>(lines: &mut Lines<'_, R>) -> Result<Recording, TraceError> {
    let file = lines.file();
    let mut samples: Vec<Sample<Pose>> = Vec::new();
    let mut duplicates = 0;
    while let Some(line) = lines.next()? {
        if line.text.starts_with('#') {
            continue;
        }
        let row = Row::new(file, &line, false);
        let mut texts = [""; FIELDS];
        let mut found = 0;
        for field in line.text.split_ascii_whitespace() {
            if let Some(text) = texts.get_mut(found) {
                *text = field;
            }
            found += 1;
        }
        if found != FIELDS {
            return Err(row.field_count(found, FIELDS));
        }
        let t = row.time(NAMES[0], texts[0], 0)?;
        let previous = samples.last().map(|s| s.t);
        in_order(&row, previous, t)?;
        duplicates += usize::from(previous == Some(t));
        let [_, tx, ty, tz, qx, qy, qz, qw] = texts;
        let p = row.vector(["tx", "ty", "tz"], [tx, ty, tz])?;
        let q = row.quaternion(["qx", "qy", "qz", "qw"], [qx, qy, qz, qw])?;
        samples.push(Sample {
            t,
            value: Some(PoseFrame::CAMERA.pose(p, q)),
        });
    }
    if samples.is_empty() {
        return Err(no_rows(file));
    }
    let mut notes = vec![
        POSE_ASSUMED.to_owned(),
        "camera frame (+Z forward, +Y down) and world (+Z up) turned into head frame (-Z forward, +Y up) and world (+Y up)"
            .to_owned(),
    ];
    if duplicates > 0 {
        notes.push(format!(
            "{} with the time of the sample before; the later one counts",
            count(duplicates, "sample")
        ));
    }
    Ok(Recording {
        pose: series(samples, Provenance::Truth),
        notes,
        ..Recording::default()
    })
}
