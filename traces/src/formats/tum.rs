use foveasim_models::{Nanos, Provenance, Sample};

use super::axes::PoseFrame;
use super::number::Row;
use super::rows::{AllRows, RowReader, RowSamples};
use super::{POSE_ASSUMED, count, in_order, no_rows};
use crate::lines::Line;
use crate::{Labels, ReadOptions, TraceError};

/// Fields per row.
pub(super) const FIELDS: usize = 8;

const NAMES: [&str; FIELDS] = ["timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw"];

/// Reads the TUM trajectory format (Sturm et al., IROS 2012): `timestamp tx ty tz qx qy qz qw`, seconds and
/// metres, `#` comments.
///
/// Its poses are those of a camera's optical frame (+X right, +Y down, +Z forward) in a world whose
/// +Z is up. Both frames are turned into ours (+Y up, −Z forward): the head by half a turn about X,
/// which is exact, the world by −90° about X.
pub(super) struct Rows<'a> {
    file: &'a str,
    previous: Option<Nanos>,
    duplicates: usize,
}

impl<'a> Rows<'a> {
    pub(super) fn new(file: &'a str) -> Self {
        Self {
            file,
            previous: None,
            duplicates: 0,
        }
    }
}

impl RowReader for Rows<'_> {
    fn row(&mut self, line: &Line<'_>) -> Result<RowSamples, TraceError> {
        let row = Row::new(self.file, line, false);
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
        in_order(&row, self.previous, t)?;
        self.duplicates += usize::from(self.previous == Some(t));
        self.previous = Some(t);
        let [_, tx, ty, tz, qx, qy, qz, qw] = texts;
        let p = row.vector(["tx", "ty", "tz"], [tx, ty, tz])?;
        let q = row.quaternion(["qx", "qy", "qz", "qw"], [qx, qy, qz, qw])?;
        let value = Some(PoseFrame::CAMERA.pose(p, q));
        Ok(RowSamples {
            pose: Some(Sample { t, value }),
            ..RowSamples::default()
        })
    }

    fn finish(&mut self, _: &ReadOptions) -> Result<AllRows, TraceError> {
        if self.previous.is_none() {
            return Err(no_rows(self.file));
        }
        let mut notes = vec![
            POSE_ASSUMED.to_owned(),
            "camera frame (+Z forward, +Y down) and world (+Z up) turned into head frame (-Z forward, +Y up) and world (+Y up)"
                .to_owned(),
        ];
        if self.duplicates > 0 {
            notes.push(format!(
                "{} with the time of the sample before; the later one counts",
                count(self.duplicates, "sample")
            ));
        }
        Ok(AllRows {
            range: 0..usize::MAX,
            provenance: [Provenance::Truth; 2],
            notes,
            labels: Labels::default(),
        })
    }
}
